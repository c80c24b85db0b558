"""Recipes: the stages that make a system of the paper, or one of its baselines and ablations (configs/*.yaml).

A recipe names its stages in order; each is a configuration of one training with what differs from it. `init` and
`first_teacher` may name an earlier stage. `teacher_1` and `teacher_2` say whose weights play in the end.
"""

from __future__ import annotations

import json
import shutil
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from hv_sim.instructor import InstructorConfig
from hv_teachers.ranks import Ranks
from hv_teachers.teacher import TEACHER_FILES
from hv_teachers.teacher_config import TeacherTrainingConfig, plain, read_yaml, training_config
from hv_teachers.teacher_training import train_teacher

RECIPE_FILE = "recipe.json"
"""Beside the teachers that a recipe made: what it was, the samples of each stage, the instructor's thresholds."""
_KEYS = ("about", "stages", "teacher_1", "teacher_2", "instructor", "common")


@dataclass(frozen=True)
class Recipe:
    """See the module's docstring."""

    name: str
    about: str
    stages: dict[str, dict[str, Any]]
    teacher_1: str
    teacher_2: str | None
    instructor: InstructorConfig

    def config(
        self, stage: str, folder: Path, overrides: dict[str, Any] | None = None, scale: float = 1.0
    ) -> TeacherTrainingConfig:
        """The configuration of one of its stages, with weights of earlier stages looked for in `folder`.

        Args:
            stage: its name.
            folder: of the recipe's stages.
            overrides: keys of the configuration.
            scale: what its samples are multiplied by.
        """
        values = dict(self.stages[stage])
        base = values.pop("config", None)
        for key in ("init", "first_teacher"):
            if values.get(key) in self.stages:
                values[key] = str(folder / values[key] / "teacher.safetensors")
        layers = [read_yaml(base) if base else {}, {"env": {"instructor": plain(self.instructor)}}, values]
        config = training_config(*layers, overrides or {}, {"name": f"{self.name} {stage}"})
        return replace(
            config,
            dagger=replace(config.dagger, samples=round(scale * config.dagger.samples)),
            ppo=replace(config.ppo, samples=round(scale * config.ppo.samples)),
        )

    def samples(self, *stages: str, scale: float = 1.0) -> int:
        """Control steps of some of its stages (default: all), the learner's own: its budget."""
        return sum(self.config(stage, Path(), scale=scale).samples for stage in stages or self.stages)


def read_recipe(name_or_path: str) -> Recipe:
    """A recipe by name (configs/) or path.

    Raises:
        ValueError: there is none, a key is unknown or missing, or a stage refers to a later one.
    """
    data = read_yaml(name_or_path)
    unknown = [key for key in data if key not in _KEYS]
    if unknown:
        raise ValueError(f"{name_or_path}: {unknown[0]}: unknown; valid: {', '.join(_KEYS)}")
    stages = data.get("stages")
    if not isinstance(stages, dict) or not stages:
        raise ValueError(f"{name_or_path}: stages: missing; valid: a mapping of stages")
    common = data.get("common") or {}
    before: list[str] = []
    for stage, values in stages.items():
        values = stages[stage] = {**common, **(values or {})}
        for key in ("init", "first_teacher"):
            refers = values.get(key)
            if refers in stages and refers not in before:
                raise ValueError(f"{name_or_path}: stages.{stage}.{key}: {refers!r} comes later; valid: {before}")
        before.append(stage)
    for key in ("teacher_1", "teacher_2"):
        if data.get(key) not in stages and (key == "teacher_1" or data.get(key) is not None):
            raise ValueError(f"{name_or_path}: {key}: {data.get(key)!r} is not valid; valid: {', '.join(stages)}")
    try:
        instructor = InstructorConfig(**(data.get("instructor") or {}))
    except TypeError as error:
        valid = ", ".join(plain(InstructorConfig()))
        raise ValueError(f"{name_or_path}: instructor: {error}; valid: {valid}") from None
    return Recipe(
        name=Path(name_or_path).stem,
        about=str(data.get("about", "")).strip(),
        stages=stages,
        teacher_1=data["teacher_1"],
        teacher_2=data.get("teacher_2"),
        instructor=instructor,
    )


def checked_scale(value: object) -> float:
    """What a recipe's samples are multiplied by.

    Raises:
        ValueError: it is not a number above 0.
    """
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not value > 0:
        raise ValueError(f"scale: {value!r} is not valid; valid: a number > 0")
    return float(value)


def train_recipe(
    recipe: Recipe,
    output: Path,
    overrides: dict[str, Any] | None = None,
    *,
    ranks: Ranks | None = None,
    progress: bool = True,
) -> None:
    """Trains every stage in turn, going on where it was, and gathers the teachers in `output`.

    Leaves a folder for each stage, `teacher_1.safetensors`, `teacher_2.safetensors` where the recipe has one, and
    `recipe.json` with the samples of each stage and the instructor's thresholds.

    Args:
        recipe: what to train.
        output: folder.
        overrides: configuration keys for every stage; `reuse.STAGE` copies a stage's folder instead of training it;
            `scale` multiplies every stage's samples.
        ranks: the processes that train (default: this one alone).
        progress: show bars.

    Raises:
        ValueError: a stage's configuration is not valid, or a folder to be reused holds no weights.
    """
    output, ranks = Path(output), ranks or Ranks()
    values = dict(overrides or {})
    scale = checked_scale(values.pop("scale", 1.0))
    reuse = {key.removeprefix("reuse."): Path(str(values.pop(key))) for key in list(values) if key.startswith("reuse.")}
    unknown = [stage for stage in reuse if stage not in recipe.stages]
    if unknown:
        raise ValueError(f"reuse.{unknown[0]}: no such stage; valid: {', '.join(recipe.stages)}")
    samples = {}
    for stage in recipe.stages:
        config = recipe.config(stage, output, values, scale)
        samples[stage] = config.samples
        target = output / stage / "teacher.safetensors"
        if stage in reuse:
            source = reuse[stage] / "teacher.safetensors"
            if not source.is_file():
                raise ValueError(f"reuse.{stage}: {source} does not exist")
            if ranks.is_first:
                target.parent.mkdir(parents=True, exist_ok=True)
                _copy(source, target)
            ranks.wait()
        else:
            train_teacher(config, output / stage, ranks=ranks, progress=progress)
    if ranks.is_first:
        _gather(recipe, output, samples)
    ranks.wait()


def _gather(recipe: Recipe, output: Path, samples: dict[str, int]) -> None:
    for name, whose in zip(TEACHER_FILES, (recipe.teacher_1, recipe.teacher_2), strict=True):
        if whose is None:
            (output / name).unlink(missing_ok=True)
        else:
            _copy(output / whose / "teacher.safetensors", output / name)
    document = {
        "name": recipe.name,
        "about": recipe.about,
        "samples": samples,
        "samples_total": sum(samples.values()),
        "instructor": plain(recipe.instructor),
    }
    temporary = output / "recipe.tmp"
    temporary.write_text(json.dumps(document, indent=2) + "\n")
    temporary.replace(output / RECIPE_FILE)


def _copy(source: Path, target: Path) -> None:
    temporary = target.with_suffix(".tmp")
    shutil.copyfile(source, temporary)
    temporary.replace(target)
