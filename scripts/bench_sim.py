"""hv-bench-sim: how fast the simulator and the head camera are on this machine."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path


def main(argv: list[str] | None = None) -> int:
    """Parses the command line, runs the benchmark and prints the figures."""
    parser = argparse.ArgumentParser(prog="hv-bench-sim", description=__doc__)
    parser.add_argument("--task", default="living_room", help="task, prefix of tasks, or task file")
    parser.add_argument("--num-envs", type=int, default=256)
    parser.add_argument("--num-steps", type=int, default=150, help="control steps of each round")
    parser.add_argument("--num-threads", type=int, default=0, help="physics threads; 0: one per core")
    parser.add_argument("--size-px", type=int, default=128, help="side of the head camera's picture")
    parser.add_argument("--output", type=Path, help="also write the figures to this JSON file")
    args = parser.parse_args(argv)
    from hv_sim.benchmark import benchmark_rendering, benchmark_simulation
    from hv_sim.gl_backend import GLError
    from hv_sim.task import TaskError, resolve_tasks
    from hv_teachers.whole_files import write_whole

    try:
        tasks = resolve_tasks(args.task)
        figures = benchmark_simulation(
            tasks, num_envs=args.num_envs, num_steps=args.num_steps, num_threads=args.num_threads
        )
        figures |= {f"rendering_{k}": v for k, v in benchmark_rendering(tasks, size_px=args.size_px).items()}
    except (TaskError, GLError, ValueError) as error:
        print(f"hv-bench-sim: {error}", file=sys.stderr)
        return 1
    print(
        f"{figures['world_steps_per_s']:,.0f} control steps/s with observations "
        f"({figures['share_of_bare']:.0%} of bare mujoco.batch, {figures['bare_steps_per_s']:,.0f}), "
        f"{args.num_envs} environments, {figures['num_threads']} threads\n"
        f"{figures['scene_share_of_lone']:.0%} is what bare scenes reach of the humanoid alone on a plane "
        f"({figures['lone_steps_per_s']:,.0f})\n"
        f"{figures['rendering_frames_per_s']:,.0f} frames/s of the head camera at {args.size_px} px "
        f"(bare mujoco.Renderer: {figures['rendering_bare_frames_per_s']:,.0f})"
    )
    if args.output:
        write_whole(args.output, json.dumps(figures, indent=2) + "\n")
        print(f"figures: {args.output}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
