"""hv-checkpoint: where the weights that come with the package are.

lerobot-eval --policy.path=$(hv-checkpoint student) --env.type=hv_sim --env.task=unseen
"""

from __future__ import annotations

import argparse
import sys


def main(arguments: list[str] | None = None) -> int:
    from hv_policy.motor.prior import SHIPPED_MOTOR_PRIOR
    from hv_policy.network_file import SHIPPED_STUDENT
    from hv_teachers.teacher import TEACHER_FILES, WEIGHTS

    places = {
        "motor_prior": SHIPPED_MOTOR_PRIOR,
        "teacher_1": WEIGHTS / TEACHER_FILES[0],
        "teacher_2": WEIGHTS / TEACHER_FILES[1],
        "student": SHIPPED_STUDENT,
    }
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("name", choices=sorted(places))
    path = places[parser.parse_args(arguments).name]
    if not path.exists():
        print(f"error: {path.name}: this package comes without it; looked for {path}", file=sys.stderr)
        return 2
    print(path)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
