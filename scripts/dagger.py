"""hv-dagger: rounds in which the student acts and the teacher corrects, each followed by more training.

    hv-dagger --output outputs/dagger                       # 3 rounds on the seen suite
    hv-dagger --output outputs/dagger --rounds 6            # three more: what is done stays done
    hv-dagger --output outputs/try --tasks seen:0-31 --first-steps 500 --steps 200 --train batch_size=32

Recordings, checkpoints and evaluations lie in OUTPUT/round_K; OUTPUT/rounds.csv and rounds.png compare the rounds.
After a kill the same command goes on. --train takes options of lerobot-train, without their dashes.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import fields
from pathlib import Path


def main(arguments: list[str] | None = None) -> int:
    from hv_teachers.dagger import DaggerError, DaggerRounds, run_rounds

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, required=True, help="folder of the rounds")
    for field in fields(DaggerRounds):
        option, default = "--" + field.name.replace("_", "-"), field.default
        if field.name == "train":
            parser.add_argument(option, nargs="*", default=[], metavar="KEY=VALUE", help="options of lerobot-train")
        else:
            parser.add_argument(option, type=type(default), default=default, help=f"default: {default}")
    options = vars(parser.parse_args(arguments))
    folder = options.pop("output")
    train = tuple("--" + text.removeprefix("--") for text in options.pop("train"))
    try:
        table = run_rounds(folder, DaggerRounds(**options, train=train))
    except (DaggerError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("error: interrupted; the same command goes on with it", file=sys.stderr)
        return 130
    print("  ".join(f"{name:>12}" for name in table[0]))
    for row in table:
        print("  ".join(f"{value:>12.3g}" for value in row.values()))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
