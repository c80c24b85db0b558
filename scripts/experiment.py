"""hv-experiment: one row of a table from one command: trains what is missing, evaluates, and writes RESULTS.md.

    hv-experiment                          # what there is, and how long each will take
    hv-experiment planner
    hv-experiment wo_stage2 --suites seen --repeats 1

Finished parts are reused and interrupted ones gone on with, unless the policy has changed since: trainings in
runs/experiments/NAME, episodes in outputs/experiments/NAME/SUITE.
The figures go to results/NAME-SUITE/metrics.json, of which RESULTS.md is made.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("name", nargs="?", help="one of configs/experiments, or a YAML file")
    parser.add_argument("--suites", nargs="*", help="only these of its suites")
    parser.add_argument("--repeats", type=int, help="episodes of each task instead of the experiment's")
    parser.add_argument("--n-tasks", type=int, help="only so many tasks of each suite, spread evenly")
    parser.add_argument("--seed", type=int, default=0, help="of the evaluation")
    parser.add_argument("--workers", type=int, default=0, help="processes (default: one a core)")
    parser.add_argument("--film", action="store_true", help="film the best, the worst and one of every kind of failure")
    parser.add_argument("--dry-run", action="store_true", help="only say what would be done and how long it takes")
    parser.add_argument("--root", type=Path, default=ROOT, help="folder of runs/, outputs/, results/ and RESULTS.md")
    options = parser.parse_args(arguments)
    from hv_sim.task import TaskError
    from hv_teachers.evaluation import EvaluationError
    from hv_teachers.experiments import Places, known_experiments, plan_of, read_experiment, run_experiment

    try:
        places = Places(options.root)
        if options.name is None:
            for name in known_experiments():
                print(plan_of(read_experiment(name), places))
            return 0
        experiment = read_experiment(options.name).narrowed(options.suites, options.repeats)
        print(plan_of(experiment, places, options.seed, options.n_tasks), flush=True)
        if options.dry_run:
            return 0
        written = run_experiment(
            experiment, places, seed=options.seed, n_tasks=options.n_tasks, workers=options.workers, film=options.film
        )
    except (EvaluationError, TaskError, ValueError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("error: interrupted; the same command goes on with it", file=sys.stderr)
        return 130
    print("written:", *written)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
