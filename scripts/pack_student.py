"""hv-pack-student: puts a trained student where `hv-checkpoint student` finds it, with a model card of its evaluations.

hv-eval --policy=CHECKPOINT --suite=seen --output outputs/eval/student-seen
hv-pack-student CHECKPOINT --evaluations seen=outputs/eval/student-seen --trained docs/student_commands.txt
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path


def main(arguments: list[str] | None = None) -> int:
    from hv_policy.motor.prior import SHIPPED_MOTOR_PRIOR
    from hv_teachers.student_package import pack_student

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("checkpoint", type=Path, help="a pretrained_model folder of lerobot-train")
    parser.add_argument("--evaluations", nargs="+", required=True, metavar="SUITE=FOLDER", help="of hv-eval")
    parser.add_argument("--trained", type=Path, required=True, help="text file with the commands that made it")
    parser.add_argument("--folder", type=Path, default=SHIPPED_MOTOR_PRIOR.parent / "student")
    options = parser.parse_args(arguments)
    try:
        pairs = [text.partition("=") for text in options.evaluations]
        if bad := [name for name, equals, _ in pairs if not equals]:
            raise ValueError(f"--evaluations: {bad[0]!r} is not valid; valid: SUITE=FOLDER")
        evaluations = {suite: Path(folder) for suite, _, folder in pairs}
        pack_student(options.checkpoint, options.folder, evaluations, options.trained.read_text(encoding="utf-8"))
    except (ValueError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    print(options.folder)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
