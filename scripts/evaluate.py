"""hv-eval: how well a policy does on a suite of tasks; the same figures whatever the number of processes.

    hv-eval --policy=planner --suite=unseen --output outputs/eval/planner
    hv-eval --policy=outputs/train/hv --suite=seen --repeats=3 --output outputs/eval/student

Writes episodes.jsonl as it goes (give the same command again to go on) and metrics.json at the end.

On many machines that share a file system, give each the same command and its own slice, --shard 0/16 to 15/16
(configs/slurm/evaluate.sbatch). The same command without --shard then plays what is missing or damaged, and adds up.
"""

from __future__ import annotations

import argparse
import os
import sys
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING

from tqdm import tqdm

if TYPE_CHECKING:
    from hv_sim.instructor import InstructorConfig


def main(arguments: list[str] | None = None) -> int:
    options = _parse(arguments)
    os.environ["OMP_NUM_THREADS"] = "1"  # for the processes that play the episodes
    from hv_sim.gl_backend import GLError
    from hv_sim.task import TaskError, resolve_tasks
    from hv_teachers.engines import Slice
    from hv_teachers.evaluation import METRICS_FILE, EvaluationConfig, EvaluationError, evaluate, read_outcomes, spread
    from hv_teachers.impairments import read_impairments

    try:
        config = EvaluationConfig(
            options.policy, options.suite, options.repeats, options.seed, options.max_episode_steps,
            read_instructor(options.instructor), options.physics,
            read_impairments(options.without, options.wrong_instruction),
        )  # fmt: skip
        tasks = resolve_tasks(options.suite)
        if options.shard and options.film:
            raise ValueError("--film: not with --shard; valid: when the slices are added up")
        if options.wrong_instruction and any(len(task.subtasks) < 2 for task in tasks):
            raise ValueError("--wrong-instruction: a task has one sub-task only; valid: suites of more than one object")
        if options.n_tasks is not None:
            tasks = spread(tasks, options.n_tasks)
        only = Slice.parse(options.shard) if options.shard else None
        before = read_outcomes(options.output)
        placed = [all(o.record.succeeded(0.4)) for o in before]
        total = len(tasks) * options.repeats
        with tqdm(total=total, initial=min(len(before), total), desc=options.suite, unit="episode") as bar:

            def tell(outcome, done: int, total: int) -> None:
                placed.append(all(outcome.record.succeeded(0.4)))
                bar.set_postfix(success=f"{sum(placed) / len(placed):.1%}", refresh=False)
                bar.update(done - bar.n)

            metrics = evaluate(
                config, tasks, options.output, workers=options.workers, engine=options.engine, only=only,
                videos=options.videos, film_typical=options.film, on_episode=tell,
            )  # fmt: skip
    except (TaskError, GLError, EvaluationError, ValueError, RuntimeError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("error: interrupted; the same command goes on with it", file=sys.stderr)
        return 130
    if only is not None:
        print(f"slice {options.shard}: played; when every slice is, add up with the same command without --shard")
        return 0
    print(_table(metrics))
    print(f"written: {options.output / METRICS_FILE}")
    return 0


def read_instructor(settings: list[str]) -> InstructorConfig:
    """`key=value` settings over the defaults; `null` switches a condition off.

    Raises:
        ValueError: a key is unknown, or a value is not valid.
    """
    from hv_sim.instructor import InstructorConfig

    values: dict[str, float | int | None] = {}
    known = {f.name: f.type for f in fields(InstructorConfig)}
    for setting in settings:
        name, _, text = setting.partition("=")
        if name not in known:
            raise ValueError(f"--instructor: {name!r} is unknown; valid: {', '.join(known)}")
        try:
            values[name] = None if text == "null" else int(text) if known[name] == "int" else float(text)
        except ValueError:
            raise ValueError(f"--instructor: {setting!r} is not valid; valid: {name}=NUMBER or null") from None
    try:
        return InstructorConfig(**values)  # type: ignore[arg-type]
    except TypeError as error:
        raise ValueError(f"--instructor: {error}") from None


def _table(metrics: dict) -> str:
    names = [k for k in metrics["at_0.4"] if k != "success_all"]
    lines = [f"{'':<10}" + "".join(f"{n.replace('success_', 'object '):>12}" for n in names) + f"{'all':>12}"]
    for threshold in ("0.4", "0.2"):
        values = [metrics[f"at_{threshold}"][n] for n in (*names, "success_all")]
        low, high = metrics[f"interval_{threshold}"]["success_all"]
        lines.append(f"{threshold + ' m':<10}" + "".join(f"{v:>12.1%}" for v in values) + f"   [{low:.1%}, {high:.1%}]")
    distances = [metrics[f"dist_{i + 1}"] for i in range(len(names))]
    lines.append(f"{'miss (m)':<10}" + "".join(f"{d:>12.2f}" if d is not None else f"{'-':>12}" for d in distances))
    failures = ", ".join(f"{k.replace('_', ' ')} {v}" for k, v in metrics["failures"].items())
    return "\n".join([*lines, f"{metrics['n_episodes']} episodes, {metrics['fall_rate']:.1%} with a fall; {failures}"])


def _parse(arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--policy", required=True, help="planner, teacher, student, or a LeRobot checkpoint's folder")
    parser.add_argument("--suite", default="unseen", help="a suite, some of its tasks (unseen:0-9), a task, or a file")
    parser.add_argument("--n-tasks", type=_positive, help="only so many of them, spread evenly")
    parser.add_argument("--repeats", type=_positive, default=1, help="episodes of each task")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=_positive, default=0, help="processes (default: one a core)")
    parser.add_argument("--engine", choices=("pool", "ray"), default="pool", help="who runs the processes")
    parser.add_argument("--physics", choices=("cpu", "warp"), default="cpu", help="engine of the simulation")
    parser.add_argument("--shard", metavar="I/N", help="play only this slice of the episodes")
    parser.add_argument("--max-episode-steps", type=_positive, help="control steps (30 a second) of an episode")
    parser.add_argument("--videos", nargs="*", default=[], metavar="TASK", help="names of tasks to film")
    parser.add_argument("--film", action="store_true", help="film the best, the worst and one of every kind of failure")
    parser.add_argument(
        "--instructor", nargs="*", default=[], metavar="KEY=VALUE",
        help="thresholds of Algorithm 3, such as max_object_speed_m_s=null (an ablation)",
    )  # fmt: skip
    parser.add_argument(
        "--without", nargs="*", default=[], metavar="MODALITY", help="blank vision, language or proprioception"
    )
    parser.add_argument(
        "--wrong-instruction", action="store_true", help="tell it another sub-task's instruction than the one in force"
    )
    parser.add_argument("--output", type=Path, required=True, help="folder for metrics.json and episodes.jsonl")
    return parser.parse_args(arguments)


def _positive(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text} is not a positive whole number")
    return value


if __name__ == "__main__":
    raise SystemExit(main())
