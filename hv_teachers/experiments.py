"""Experiments: a system, trained if need be, on suites of tasks; the parts that are there already are reused."""

from __future__ import annotations

import hashlib
import json
import shutil
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from tqdm import tqdm

from hv_sim.instructor import InstructorConfig
from hv_sim.suites import SUITE_SIZES, SUITES, load_suite
from hv_sim.task import Task
from hv_teachers.episodes import EpisodeOutcome, EvaluatedPolicy
from hv_teachers.evaluated_policies import load_evaluated_policy
from hv_teachers.evaluation import (
    METRICS_FILE,
    PLAN_FILE,
    EvaluationConfig,
    differs,
    evaluate,
    read_outcomes,
    read_plan,
    read_timing,
    spread,
)
from hv_teachers.evaluation import plan_of as evaluation_plan
from hv_teachers.impairments import NOTHING_TAKEN, Impairments, read_impairments
from hv_teachers.results import EARLIER_FOLDER, EXPERIMENT_FILE, find_results, leaderboard, read_result, with_results
from hv_teachers.teacher import TEACHER_FILES
from hv_teachers.teacher_config import CONFIG_FOLDER, read_yaml
from hv_teachers.teacher_recipe import RECIPE_FILE, checked_scale, read_recipe, train_recipe
from hv_teachers.whole_files import write_whole

TRAINED_PER_S, SECONDS_PER_EPISODE, SECONDS_PER_SEEN_EPISODE = 2500.0, 1.5, 20.0
"""On two cores of an AMD EPYC, idle: control steps of a teacher's training, and a two-object episode of a policy that
does not see (`docs/teachers.md`), and of one that does. What is measured here (`timing.json`) is taken instead where
there is any."""
_KEYS = ("policy", "train", "scale", "reuse", "suites", "without", "wrong_instruction")


@dataclass(frozen=True)
class Places:
    """Where things go, below one folder."""

    root: Path

    def training(self, name: str) -> Path:
        return self.root / "runs" / "experiments" / name

    def evaluation(self, name: str, suite: str) -> Path:
        return self.root / "outputs" / "experiments" / name / suite

    def result(self, name: str, suite: str) -> Path:
        return self.root / "results" / f"{name}-{suite}" / METRICS_FILE

    @property
    def leaderboard(self) -> Path:
        return self.root / "RESULTS.md"

    @property
    def readme(self) -> Path:
        return self.root / "README.md"


@dataclass(frozen=True)
class Experiment:
    """What is to be measured: `policy` as hv-eval knows it, or the recipe (`train`) that makes it."""

    name: str
    policy: str | None
    train: str | None
    reuse: dict[str, str]
    suites: dict[str, int]
    scale: float = 1.0
    """What the recipe's samples are multiplied by."""
    impairments: Impairments = NOTHING_TAKEN

    def narrowed(self, suites: list[str] | None, repeats: int | None) -> Experiment:
        """Only some of its suites, with other repeats.

        Raises:
            ValueError: a suite is not among its own, or repeats are below 1.
        """
        unknown = [s for s in suites or () if s not in self.suites]
        if unknown:
            raise ValueError(f"--suites: {unknown[0]!r} is not valid; valid: {', '.join(self.suites)}")
        if repeats is not None and repeats < 1:
            raise ValueError(f"--repeats: {repeats} is not valid; valid: an integer >= 1")
        chosen = {s: repeats or n for s, n in self.suites.items() if not suites or s in suites}
        return replace(self, suites=chosen)


def known_experiments() -> list[str]:
    """Names of those that come with the project."""
    return sorted(p.stem for p in (CONFIG_FOLDER / "experiments").glob("*.yaml"))


def read_experiment(name_or_path: str) -> Experiment:
    """An experiment by name or by the path of a YAML file.

    Raises:
        ValueError: there is none, or a key is unknown, missing or not valid.
    """
    path = Path(name_or_path)
    if path.suffix not in (".yaml", ".yml"):
        path = CONFIG_FOLDER / "experiments" / f"{name_or_path}.yaml"
    if not path.is_file():
        raise ValueError(f"experiment: {name_or_path!r} is not known; valid: {', '.join(known_experiments())}")
    data = read_yaml(str(path))
    unknown = [key for key in data if key not in _KEYS]
    if unknown:
        raise ValueError(f"{path}: {unknown[0]}: unknown; valid: {', '.join(_KEYS)}")
    if ("policy" in data) == ("train" in data):
        raise ValueError(f"{path}: policy, train: valid: one of them")
    suites = data.get("suites")
    if not isinstance(suites, dict) or not suites or any(s not in SUITES for s in suites):
        raise ValueError(f"{path}: suites: {suites!r} is not valid; valid: a mapping of {', '.join(SUITES)} to repeats")
    if any(not isinstance(n, int) or n < 1 for n in suites.values()):
        raise ValueError(f"{path}: suites: {suites!r} is not valid; valid: repeats are integers >= 1")
    try:
        scale = checked_scale(data.get("scale", 1.0))
        taken = read_impairments(data.get("without") or [], bool(data.get("wrong_instruction")))
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    reuse = dict(data.get("reuse") or {})
    return Experiment(path.stem, data.get("policy"), data.get("train"), reuse, suites, scale, taken)


def plan_of(experiment: Experiment, places: Places, seed: int = 0, n_tasks: int | None = None) -> str:
    """One line: what is still to be done and about how long it takes."""
    steps, seconds = [], 0.0
    trained = not experiment.train or _is_trained(places.training(experiment.name))
    if experiment.train and not trained:
        recipe = read_recipe(experiment.train)
        left = [stage for stage in recipe.stages if stage not in experiment.reuse]
        samples = recipe.samples(*left, scale=experiment.scale) if left else 0
        missing = [other for stage, other in experiment.reuse.items() if not (places.training(other) / stage).is_dir()]
        seconds += samples / TRAINED_PER_S
        steps += [f"first hv-experiment {name}" for name in dict.fromkeys(missing)]
        steps.append(f"train {samples / 1e6:.1f} M control steps")
    sees = experiment.policy not in (None, "planner", "teacher")
    for suite, repeats in experiment.suites.items():
        folder = places.evaluation(experiment.name, suite)
        total = (n_tasks or SUITE_SIZES[suite]) * repeats
        done = 0
        if trained and (folder / PLAN_FILE).is_file():
            config, tasks = _evaluation(experiment, places, suite, seed, n_tasks)
            if not differs(read_plan(folder), evaluation_plan(config, tasks, _policy(config))):
                done = sum(o.repeat < repeats for o in read_outcomes(folder))
        if done < total:
            seconds += (total - done) * _seconds_per_episode(folder, sees)
            steps.append(f"{total - done} episodes of {suite}")
    if not steps:
        return f"{experiment.name}: done"
    return f"{experiment.name}: {', '.join(steps)}; about {_duration(seconds)}"


def run_experiment(
    experiment: Experiment,
    places: Places,
    *,
    seed: int = 0,
    n_tasks: int | None = None,
    workers: int = 0,
    film: bool = False,
) -> list[Path]:
    """Trains and evaluates what is missing; returns the files of results.

    Episodes that were played with another policy, code or configuration are put aside, in `EARLIER_FOLDER` beside
    SUITE, and come back when everything is as it was then.

    Args:
        experiment, places: what, and where.
        seed: of the evaluation.
        n_tasks: only so many of each suite's tasks, spread evenly.
        workers: processes, 0 for one per core.
        film: see `evaluate`.

    Raises:
        ValueError: a configuration is not valid.
        hv_teachers.evaluation.EvaluationError: a folder is damaged.
    """
    if experiment.train:
        folder = places.training(experiment.name)
        if not _is_trained(folder):
            reuse = {f"reuse.{s}": str(places.training(other) / s) for s, other in experiment.reuse.items()}
            train_recipe(read_recipe(experiment.train), folder, {**reuse, "scale": experiment.scale})
    written = []
    for suite in experiment.suites:
        config, tasks = _evaluation(experiment, places, suite, seed, n_tasks)
        output = places.evaluation(experiment.name, suite)
        _make_room(output, evaluation_plan(config, tasks, _policy(config)))
        total = len(tasks) * config.repeats
        with tqdm(total=total, desc=f"{experiment.name} {suite}", unit="episode") as bar:

            def tell(_: EpisodeOutcome, done: int, __: int, bar: tqdm = bar) -> None:
                bar.update(done - bar.n)

            evaluate(config, tasks, output, workers=workers, film_typical=film, on_episode=tell)
        write_whole(output / EXPERIMENT_FILE, json.dumps({"name": experiment.name}) + "\n")
        metrics = {**read_result(output / METRICS_FILE).metrics, "experiment": experiment.name}
        if experiment.train:
            recipe = json.loads((places.training(experiment.name) / RECIPE_FILE).read_text(encoding="utf-8"))
            metrics["trained_samples"] = recipe["samples_total"]
        target = places.result(experiment.name, suite)
        write_whole(target, json.dumps(metrics, indent=1) + "\n")
        written.append(target)
    results = find_results([places.root / "results"])
    write_whole(places.leaderboard, leaderboard(results))
    if places.readme.is_file():
        write_whole(places.readme, with_results(places.readme.read_text(encoding="utf-8"), results))
    return [*written, places.leaderboard]


def _evaluation(
    experiment: Experiment, places: Places, suite: str, seed: int, n_tasks: int | None
) -> tuple[EvaluationConfig, list[Task]]:
    tasks = load_suite(suite)
    policy, instructor = experiment.policy or str(places.training(experiment.name)), InstructorConfig()
    if experiment.train:
        instructor = read_recipe(experiment.train).instructor
    repeats = experiment.suites[suite]
    config = EvaluationConfig(policy, suite, repeats, seed, None, instructor, impairments=experiment.impairments)
    return config, tasks if n_tasks is None else spread(tasks, n_tasks)


def _policy(config: EvaluationConfig) -> EvaluatedPolicy:
    return load_evaluated_policy(config.policy, config.impairments)


def _make_room(output: Path, plan: dict[str, Any]) -> None:
    """Puts another evaluation's folder aside, and takes back what was put aside of this one."""

    def aside(of: dict[str, Any]) -> Path:
        text = json.dumps({k: v for k, v in of.items() if k != "repeats"}, sort_keys=True)
        return output.parent / EARLIER_FOLDER / f"{output.name}.{hashlib.sha256(text.encode()).hexdigest()[:8]}"

    if (output / PLAN_FILE).is_file():
        before = read_plan(output)
        if not differs(before, plan):
            return
        put = aside(before)
        put.parent.mkdir(exist_ok=True)
        if put.exists():  # the same evaluation, interrupted earlier
            shutil.rmtree(put)
        output.rename(put)
    if aside(plan).exists():
        aside(plan).rename(output)


def _is_trained(folder: Path) -> bool:
    return (folder / TEACHER_FILES[0]).is_file() and (folder / RECIPE_FILE).is_file()


def _seconds_per_episode(folder: Path, sees: bool) -> float:
    """As measured here before; else a figure of ours."""
    episodes, seconds = read_timing(folder)
    if episodes:
        return seconds / episodes
    return SECONDS_PER_SEEN_EPISODE if sees else SECONDS_PER_EPISODE


def _duration(seconds: float) -> str:
    return f"{seconds / 3600:.1f} h" if seconds >= 5400 else f"{max(1, round(seconds / 60))} min"
