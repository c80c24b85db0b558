"""hv-diagnose-student: what keeps a student from doing its tasks: how far what it believes is off in each phase, and
how well it does when it is told where the object is, where its goal is, or which floor is free."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("policy", type=Path, help="checkpoint (pretrained_model)")
    parser.add_argument("--suite", default="seen", help="name, prefix or file of tasks")
    parser.add_argument("--n-tasks", type=int, default=16)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--tell", nargs="*", default=[], metavar="WHAT", help="object, goal, floor")
    parser.add_argument("--max-episode-steps", type=int, help="control steps of an episode")
    args = parser.parse_args()
    from tqdm import tqdm

    from hv_sim.gl_backend import GLError
    from hv_sim.task import TaskError, resolve_tasks
    from hv_teachers.student_diagnosis import diagnose

    try:
        tasks = resolve_tasks(args.suite)
        if not 1 <= args.n_tasks <= len(tasks):
            raise ValueError(f"n_tasks: {args.n_tasks} is not valid; valid: 1 to {len(tasks)}")
        drawn = sorted(np.random.default_rng(args.seed).permutation(len(tasks))[: args.n_tasks])
        with tqdm(desc="student plays", unit="step", disable=None) as bar:

            def on_step(_: int, most: int) -> None:
                bar.total = most
                bar.update()

            chosen = [tasks[i] for i in drawn]
            found = diagnose(args.policy, chosen, args.seed, args.tell, args.max_episode_steps, on_step)
    except (TaskError, GLError, ValueError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    first, second, every = (found.success(k) for k in (0, 1, None))
    falls = np.mean([record.fallen for record in found.records])
    print(f"success 1 {first:.2f}, 2 {second:.2f}, all {every:.2f}; falls {falls:.2f} {found.fell_in}")
    print(f"{'phase':12}{'steps':>8}  median errors (m; walls: degrees)")
    for phase, steps in found.steps.items():
        errors = ", ".join(f"{name} {value:.2f}" for name, value in found.errors.get(phase, {}).items())
        print(f"{phase:12}{steps:8}  {errors}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
