"""Records an expert's attempts at tasks as a LeRobot dataset.

    hv-record --root outputs/datasets/living_room --tasks living_room --repeats 3

Tasks are names of packaged ones, prefixes of such names, or task files. A folder that exists is left alone unless
--resume is given, which adds the attempts that it does not hold yet. A recording that was interrupted, even by
kill -9, goes on where it was when the same command is given again.

On many machines that share a file system, give each the same command and its own slice, --shard 0/16 to 15/16
(configs/slurm/record.sbatch). The same command without --shard then checks the shards, records what is missing or
damaged, and joins them.
"""

import argparse
import os
import signal
import sys
import time
from pathlib import Path


def main(arguments: list[str] | None = None) -> int:
    options = _parse(arguments)
    _fix_hash_seed()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # so that a half-written dataset is cleaned away

    from hv_sim.gl_backend import GLError
    from hv_sim.looks import NO_LOOKS, read_look_ranges
    from hv_sim.task import TaskError, resolve_tasks
    from hv_teachers.dataset_format import RecordingError
    from hv_teachers.engines import Slice
    from hv_teachers.expert import expert_maker
    from hv_teachers.recording import RecordingConfig
    from hv_teachers.sharded_recording import record_shards

    try:
        config = RecordingConfig(
            seed=options.seed,
            image_size_px=options.image_size,
            max_episode_steps=options.max_episode_steps,
            frame_stride=options.frame_stride,
            glances=options.glances,
            beta=options.beta,
            end_when_fallen=options.end_when_fallen,
            drop_failed=options.drop_failed,
            physics=options.physics,
            looks=read_look_ranges(options.looks) if options.looks else NO_LOOKS,
        )
        only = Slice.parse(options.shard) if options.shard else None
        started = time.perf_counter()
        tasks = [task for name in options.tasks for task in resolve_tasks(name)]
        report = record_shards(
            options.root,
            tasks,
            expert_maker(options.policy, options.beta),
            config,
            repeats=options.repeats,
            num_envs=options.num_envs,
            workers=options.workers,
            engine=options.engine,
            resume=options.resume,
            only=only,
        )
    except (RecordingError, TaskError, GLError, ValueError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("error: interrupted; the same command goes on with it", file=sys.stderr)
        return 130
    if report.damaged or report.doubled:
        print(f"shards thrown away: {report.damaged} damaged, {report.doubled} doubled; what they held is there again")
    if only is not None:
        print(
            f"slice {options.shard}: {len(report.attempts)} attempts are recorded; when every slice is, join them with"
            " the same command without --shard"
        )
        return 0
    dropped = len(report.attempts) - report.num_episodes
    speed = report.frames_recorded / (time.perf_counter() - started)
    rate = f", {speed:.0f} frames/s" if speed else ""
    print(
        f"{options.root}: {report.num_episodes} episodes of {len(report.attempts)} attempts"
        f" ({report.num_failed} failed, {dropped} dropped{rate})"
    )
    print(
        "Train on it: HF_HUB_OFFLINE=1 lerobot-train --policy.type=hv --policy.push_to_hub=false"
        f" --dataset.repo_id={options.root.name} --dataset.root={options.root} --output_dir=outputs/train/hv"
    )
    return 0


def _parse(arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", type=Path, required=True, help="folder of the dataset; must not exist yet")
    parser.add_argument("--tasks", nargs="+", default=["living_room"], help="names, prefixes or files of tasks")
    parser.add_argument("--repeats", type=_positive, default=1, help="attempts of each task")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--image-size", type=_positive, default=128, help="side of the pictures in pixels")
    parser.add_argument("--max-episode-steps", type=_positive, help="control steps (30 a second) of an attempt")
    parser.add_argument(
        "--frame-stride", type=_positive, default=1, help="control steps from one frame to the next: 6 is 5 frames/s"
    )
    parser.add_argument(
        "--glances", type=int, default=0, help="pictures from random places, so many a task; no attempts"
    )
    parser.add_argument(
        "--looks", metavar="FILE", help="randomised lights, colours, textures, camera (configs/looks.yaml)"
    )
    parser.add_argument("--beta", type=float, default=0.0, help="share of the time in which the teacher acts instead")
    parser.add_argument("--end-when-fallen", action="store_true", help="attempts end a second after a fall")
    parser.add_argument(
        "--policy",
        default="planner",
        help="planner, teacher, a folder of teachers, or of a student: it acts, the teacher's actions are recorded",
    )
    parser.add_argument("--num-envs", type=_positive, default=4, help="attempts that a process simulates side by side")
    parser.add_argument("--workers", type=_positive, default=0, help="processes (default: one a core)")
    parser.add_argument("--engine", choices=("pool", "ray"), default="pool", help="who runs the processes")
    parser.add_argument("--shard", metavar="I/N", help="record only this slice, and join nothing")
    parser.add_argument("--physics", choices=("cpu", "warp"), default="cpu", help="engine and renderer")
    parser.add_argument("--drop-failed", action="store_true", help="leave out attempts that fail")
    parser.add_argument("--resume", action="store_true", help="add to a dataset that exists")
    return parser.parse_args(arguments)


def _positive(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text} is not a positive whole number")
    return value


def _fix_hash_seed() -> None:
    """Starts over with Python's string hashes fixed: LeRobot lists an episode's instructions in their order."""
    if os.environ.get("PYTHONHASHSEED") != "0":
        os.environ["PYTHONHASHSEED"] = "0"
        os.execv(sys.executable, [sys.executable, "-m", "hv_scripts.record", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
