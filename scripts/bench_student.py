"""hv-bench-student: how long the student takes for a step and for a training sample, beside LeRobot's stock ACT.

    hv-bench-student                                   # the shipped student, one core, 128 px
    hv-bench-student --policy outputs/train/hv/checkpoints/last/pretrained_model --output speed.json
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path


def main(argv: list[str] | None = None) -> int:
    """Parses the command line, runs the benchmark and prints the figures."""
    parser = argparse.ArgumentParser(
        prog="hv-bench-student", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--policy", type=Path, help="folder of an hv policy (default: the shipped student)")
    parser.add_argument("--task", default="seen:49", help="what it does meanwhile: a task, or a task file")
    parser.add_argument("--steps", type=int, default=600, help="control steps that are timed")
    parser.add_argument("--batch-size", type=int, default=64, help="of training")
    parser.add_argument("--train-seconds", type=float, default=30.0, help="of training, for each of the two; 0: none")
    parser.add_argument("--output", type=Path, help="also write the figures to this JSON file")
    args = parser.parse_args(argv)
    from hv_policy.network_file import SHIPPED_STUDENT
    from hv_sim.gl_backend import GLError
    from hv_sim.suites import load_suite
    from hv_sim.task import TaskError, resolve_tasks
    from hv_teachers.corrected_student import load_student
    from hv_teachers.student_benchmark import benchmark_latency, benchmark_training
    from hv_teachers.whole_files import write_whole

    try:
        if args.steps < 1 or args.batch_size < 1 or args.train_seconds < 0:
            raise ValueError("steps, batch-size, train-seconds: valid: 1 or more, 1 or more, 0 or more")
        policy = load_student(args.policy or SHIPPED_STUDENT)
        figures = benchmark_latency(policy, resolve_tasks(args.task)[0], args.steps, progress=True)
        print(
            f"a step, one core, {policy.config.image_size} px: {figures['student_mean_ms']:.1f} ms "
            f"(median {figures['student_median_ms']:.1f}, 95 % {figures['student_p95_ms']:.1f}); "
            f"stock ACT {figures['act_mean_ms']:.0f} ms, {figures['times_as_fast_as_act']:.1f} times as long"
        )
        if args.train_seconds:
            figures |= benchmark_training(policy, load_suite("seen")[:8], args.batch_size, args.train_seconds)
            print(
                f"training, batch {args.batch_size}: {figures['student_samples_per_s']:.0f} samples/s; "
                f"stock ACT {figures['act_samples_per_s']:.1f}, "
                f"{figures['trains_times_as_fast_as_act']:.1f} times fewer"
            )
    except (GLError, TaskError, ValueError) as error:
        print(f"hv-bench-student: {error}", file=sys.stderr)
        return 1
    if args.output:
        write_whole(args.output, json.dumps(figures, indent=2) + "\n")
        print(f"figures: {args.output}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
