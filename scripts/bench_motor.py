"""hv-bench-motor: measures a motor prior and writes DIR/motor.json."""

from __future__ import annotations

import argparse
import json
import math
import sys
from pathlib import Path

BARS = {
    "intent_survival": (0.95, True), "velocity_rmse": (0.15, False), "yaw_rate_rmse": (0.25, False),
    "hand_error_standing": (0.05, False), "hand_error_walking": (0.08, False), "carry_success": (0.85, True),
    "push_survival": (0.85, True),
}  # fmt: skip


def table(result: dict[str, float]) -> list[str]:
    """Lines: what was measured beside its bar; what is not a number is short of it."""
    lines = [f"{'test':<22}{'measured':>10}{'bar':>8}"]
    for name, value in result.items():
        bar, higher = BARS.get(name, (None, True))
        reached = bar is not None and (value >= bar if higher else value <= bar)
        mark = "" if bar is None else ("  reached" if reached else "  short")
        lines.append(f"{name:<22}{value:>10.3f}{'' if bar is None else bar:>8}{mark}")
    return lines


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--episodes", type=int, default=512, help="episodes of each test")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--output", type=Path, required=True, help="folder for motor.json")
    parser.add_argument("--weights", type=Path, help="a motor prior's safetensors (default: the shipped one)")
    parser.add_argument("--physics-hz", type=int, default=120, choices=[120, 240, 480])
    args = parser.parse_args()
    if args.episodes < 1 or args.seed < 0:
        print(f"error: --episodes, --seed: {args.episodes}, {args.seed}; valid: at least 1, 0", file=sys.stderr)
        return 2
    import torch

    from hv_policy.motor.prior import load_motor_prior, load_shipped_motor_prior
    from hv_teachers.motor_benchmark import MotorBenchmark, run_motor_benchmark

    torch.set_num_threads(1)
    try:
        prior = load_motor_prior(args.weights) if args.weights else load_shipped_motor_prior()
    except (OSError, ValueError) as error:
        print(f"error: --weights: {error}", file=sys.stderr)
        return 2
    try:
        args.output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        print(f"error: --output: {args.output} cannot be a folder ({error.strerror})", file=sys.stderr)
        return 2
    result = run_motor_benchmark(prior, MotorBenchmark(args.episodes, args.seed, args.physics_hz))
    temporary = args.output / "motor.json.tmp"
    temporary.write_text(json.dumps({k: v if math.isfinite(v) else None for k, v in result.items()}, indent=2) + "\n")
    temporary.replace(args.output / "motor.json")
    print(*table(result), sep="\n")
    print(f"written: {args.output / 'motor.json'}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
