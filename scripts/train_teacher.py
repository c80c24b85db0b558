"""hv-train-teacher: trains a teacher by stages, or a whole system by a recipe; goes on where it was.

hv-train-teacher stage=1                        one stage (configs/teacher_stage1.yaml)
hv-train-teacher recipe=wo_stage2               all stages of a system or ablation (configs/wo_stage2.yaml)
hv-train-teacher recipe=wo_stage2 scale=0.1     with a tenth of every stage's samples
hv-train-teacher stage=1 env.num_envs=64 output=runs/try dagger.samples=1e6       anything may be overridden

Stages: 1 single objects from many starts, until they are where they belong; 2 let go and step back; 3 the second object
after teacher 1 has placed the first; `student` is what the policy that sees decides with, learned with errors of sight
(docs/student.md). Keys are those of hv_teachers.teacher_config.TeacherTrainingConfig, dotted, and `output`. With a
recipe they hold for every stage; `reuse.STAGE=FOLDER` takes a stage from another training.

Several processes, on one machine or many, share the environments and learn what one would (docs/scaling.md):
torchrun --nproc-per-node=2 -m hv_scripts.train_teacher stage=1
"""

from __future__ import annotations

import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import yaml

if TYPE_CHECKING:
    from hv_sim.instructor import InstructorConfig
    from hv_teachers.ranks import Ranks

STAGES = (1, 2, 3, "student")


def parse(arguments: list[str]) -> dict[str, Any]:
    """`key=value` arguments; values are YAML.

    Raises:
        ValueError: an argument has no `=`, or a key is given twice.
    """
    values: dict[str, Any] = {}
    for argument in arguments:
        key, sign, text = argument.removeprefix("--").partition("=")
        if not sign or not key:
            raise ValueError(f"{argument!r}: not valid; valid: key=value, such as stage=1")
        if key in values:
            raise ValueError(f"{key}: given twice")
        try:
            values[key] = yaml.safe_load(text)
        except yaml.YAMLError:
            raise ValueError(
                f"{key}: {text!r} is not valid; valid: a number, true, false, null, a name or [a, b]"
            ) from None
    return values


def main() -> int:
    arguments = sys.argv[1:]
    if not arguments or arguments[0] in ("-h", "--help"):
        print(__doc__)
        return 0
    try:
        values = parse(arguments)
    except ValueError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    from hv_teachers.ranks import joined_ranks

    with joined_ranks() as ranks:
        try:
            lines = _train(values, ranks)
        except (ValueError, OSError) as error:
            if ranks.is_first:
                print(f"error: {error}", file=sys.stderr)
            return 2
        if ranks.is_first:
            print(*lines, sep="\n")
    return 0


def _conditions(instructor: InstructorConfig) -> str:
    """The instructor's conditions that are not the usual ones, as hv-eval wants them."""
    usual, own = asdict(type(instructor)()), asdict(instructor)
    changed = [f"{k}={'null' if v is None else v}" for k, v in own.items() if v != usual[k]]
    return f" --instructor {' '.join(changed)}" if changed else ""


def _train(values: dict[str, Any], ranks: Ranks) -> list[str]:
    """Trains; what to say in the end."""
    from hv_teachers.teacher_config import read_yaml, training_config
    from hv_teachers.teacher_recipe import read_recipe, train_recipe
    from hv_teachers.teacher_training import train_teacher

    output = values.pop("output", None)
    if "recipe" in values:
        recipe = read_recipe(str(values.pop("recipe")))
        folder = Path(str(output or f"runs/teacher/{recipe.name}"))
        train_recipe(recipe, folder, values, ranks=ranks)
        command = f"hv-eval --policy={folder} --suite=seen --output DIR{_conditions(recipe.instructor)}"
        return [f"teachers: {folder}", f"measure: {command}"]
    stage = values.pop("stage", None)
    if stage not in STAGES:
        raise ValueError(f"stage: {stage!r} is not valid; valid: {', '.join(map(str, STAGES))} (or recipe=NAME)")
    config = training_config(read_yaml("teacher_student" if stage == "student" else f"teacher_stage{stage}"), values)
    weights = train_teacher(config, Path(str(output or f"runs/teacher/stage{stage}")), ranks=ranks)
    return [f"weights: {weights}", f"curve: {weights.with_name('curve.csv')}"]


if __name__ == "__main__":
    raise SystemExit(main())
