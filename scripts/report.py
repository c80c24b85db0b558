"""hv-report: one HTML page with what evaluations and trainings found, beside the paper's tables.

    hv-report outputs/eval/planner outputs/eval/teacher runs/teacher/stage1 --output outputs/report.html

Folders: of hv-eval, of hv-experiment (with evaluations below them), of a training (with a curve.csv), or of hv-dagger.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="+", type=Path, metavar="DIR", help="evaluations and trainings")
    parser.add_argument("--output", type=Path, default=Path("outputs/report.html"), help="the page")
    options = parser.parse_args(arguments)
    from hv_scripts.report_page import ROUNDS_TABLE, write_report
    from hv_teachers.evaluation import EvaluationError
    from hv_teachers.results import find_results

    try:
        results = find_results(options.folders)
        trainings = sorted({p.parent for folder in options.folders for p in folder.rglob("curve.csv")})
        rounds = sorted({p.parent for folder in options.folders for p in folder.rglob(ROUNDS_TABLE)})
        if not results and not trainings and not rounds:
            raise EvaluationError(f"{options.folders[0]}: holds neither metrics.json nor curve.csv nor {ROUNDS_TABLE}")
        page = write_report(results, trainings, options.output, rounds)
    except (EvaluationError, OSError, ValueError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    print(f"{len(results)} evaluations, {len(trainings)} trainings, {len(rounds)} times DAgger: {page}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
