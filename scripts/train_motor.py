"""hv-train-motor: trains the motor prior by PPO; goes on where it was when the folder exists."""

from __future__ import annotations

import argparse
import math
import sys
from dataclasses import replace
from pathlib import Path


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, default=Path("runs/motor"), help="checkpoints, curve and weights")
    parser.add_argument("--samples", type=float, default=50e6, help="control steps over all environments")
    parser.add_argument("--num-envs", type=int, default=1024)
    parser.add_argument("--init", default="", help="another training's resume.pt, to go on from in small steps")
    parser.add_argument("--rooms", type=int, default=0, help="more environments: rooms in which the teachers work")
    parser.add_argument("--learning-rate", type=float, default=3e-5, help="of the actor, with --init")
    parser.add_argument(
        "--get-up", action="store_true", help="train what gets up from the floor; what follows intents stays as shipped"
    )
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    if not (math.isfinite(args.samples) and args.seed >= 0 and 0 < args.learning_rate < 1):
        given = f"{args.samples:g}, {args.seed}, {args.learning_rate:g}"
        print(f"error: --samples, --seed, --learning-rate: {given}; valid: finite, 0 or more, 0 to 1", file=sys.stderr)
        return 2
    if args.rooms < 0:
        print(f"error: --rooms: {args.rooms}; valid: 0 or more", file=sys.stderr)
        return 2
    if args.samples < 1 or args.num_envs < 1:
        print(f"error: --samples, --num-envs: {args.samples:g}, {args.num_envs}; valid: both >= 1", file=sys.stderr)
        return 2
    if args.get_up and (args.rooms or args.init):
        print("error: --get-up: takes neither --rooms nor --init; valid: without them", file=sys.stderr)
        return 2
    from hv_teachers.get_up_practice import GetUpConfig
    from hv_teachers.motor_env import MotorEnvConfig
    from hv_teachers.motor_rooms import RoomsConfig
    from hv_teachers.motor_training import MotorTrainingConfig, fine_tuning, getting_up, train_motor

    env = MotorEnvConfig(num_envs=args.num_envs)
    rooms = RoomsConfig(num_envs=args.rooms)
    config = MotorTrainingConfig(samples=int(args.samples), seed=args.seed, env=env, rooms=rooms, init=args.init)
    if args.get_up:
        config = replace(getting_up(config), get_up=GetUpConfig(num_envs=args.num_envs))
    if args.init:
        if not Path(args.init).is_file():
            print(f"error: --init: {args.init} is not a file; valid: the resume.pt of a training", file=sys.stderr)
            return 2
        config = replace(fine_tuning(config), learning_rate=args.learning_rate)
    try:
        weights = train_motor(config, args.output)
    except ValueError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    print(f"weights: {weights}", f"curve: {args.output / 'curve.png'}", sep="\n")
    print(f"measure: hv-bench-motor --weights {weights} --output DIR")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
