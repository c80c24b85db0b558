"""hv-train-odometry: teaches the student's odometry how far it turned, from what robots feel as they work and walk."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, required=True, help="file of the weights (safetensors)")
    parser.add_argument("--tasks", nargs="+", default=["seen"], help="names, prefixes or files of tasks")
    parser.add_argument("--num-envs", type=int, default=128, help="robots, each with a task of its own")
    parser.add_argument("--control-steps", type=int, default=1500, help="that they walk, 30 a second")
    parser.add_argument("--training-steps", type=int, default=8000)
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    if args.num_envs < 8 or args.control_steps < 60 or args.training_steps < 1:
        print("error: --num-envs, --control-steps, --training-steps: valid: at least 8, 60, 1", file=sys.stderr)
        return 2
    from hv_policy.belief.odometry import save_odometry
    from hv_sim.task import TaskError, resolve_tasks
    from hv_teachers.odometry_training import feel, train_odometry

    try:
        tasks = [task for name in args.tasks for task in resolve_tasks(name)]
    except TaskError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    stride = max(1, len(tasks) // args.num_envs)
    chosen = [tasks[i * stride % len(tasks)] for i in range(args.num_envs)]
    network, figures = train_odometry(feel(chosen, args.seed, args.control_steps), args.seed, args.training_steps)
    save_odometry(network, args.output, {k: f"{v:.4f}" for k, v in figures.items()})
    print(f"weights: {args.output}")
    print("error that a second adds, of robots kept aside: {deg:.3f} deg ({rate_deg:.3f} by rates)".format(**figures))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
