"""Evaluations: many episodes in any number of processes, written down as they end, and what they add up to.

An episode follows from the task and a seed that follows from the evaluation's, the task's name and the repeat, in any
company (`hv_teachers.episodes`). So the result depends on nothing else, and an interrupted evaluation goes on where it
was. Many machines play a slice each into one folder that they share, and one of them then adds it all up.
"""

from __future__ import annotations

import json
import math
import time
import zlib
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from hv_sim.instructor import InstructorConfig
from hv_sim.metrics import SUCCESS_THRESHOLDS_M, summarize
from hv_sim.physics_backends import check_backend
from hv_sim.task import Task
from hv_teachers.engines import Slice, check_engine, num_processes, run_jobs
from hv_teachers.episodes import (
    FAILURES,
    Episode,
    EpisodeOutcome,
    EvaluatedPolicy,
    film_episode,
    run_episodes,
    tasks_fingerprint,
)
from hv_teachers.evaluated_policies import load_evaluated_policy
from hv_teachers.impairments import NOTHING_TAKEN, Impairments
from hv_teachers.provenance import code_hash, physics, versions
from hv_teachers.whole_files import write_whole

EPISODES_FILE, METRICS_FILE, PLAN_FILE = "episodes.jsonl", "metrics.json", "evaluation.json"
TIMING_FILE = "timing.json"
BATCH = 32
"""Episodes that a process plays side by side: more is hardly faster, and an interruption loses more."""


@dataclass(frozen=True)
class EvaluationConfig:
    """What is evaluated on what. `suite` is only a title; the tasks are given beside it."""

    policy: str
    suite: str
    repeats: int = 1
    seed: int = 0
    max_episode_steps: int | None = None
    instructor: InstructorConfig = field(default_factory=InstructorConfig)
    """Thresholds of Algorithm 3; None for one of them is an ablation of the paper."""
    physics: str = "cpu"
    """See `hv_sim.physics_backends`. With `warp` an episode depends on its company, by rounding."""
    impairments: Impairments = NOTHING_TAKEN
    """What is taken from a policy that sees."""

    def __post_init__(self) -> None:
        check_backend(self.physics)


class EvaluationError(RuntimeError):
    """An evaluation that cannot be made or gone on with; one line that says why."""


def episode_seed(seed: int, task_name: str, repeat: int) -> int:
    """The environment's seed of one episode."""
    return int(np.random.SeedSequence([seed, zlib.crc32(task_name.encode()), repeat]).generate_state(1)[0])


def evaluate(
    config: EvaluationConfig,
    tasks: Sequence[Task],
    output: Path,
    *,
    workers: int = 0,
    engine: str = "pool",
    only: Slice | None = None,
    videos: Iterable[str] = (),
    film_typical: bool = False,
    on_episode: Callable[[EpisodeOutcome, int, int], None] | None = None,
) -> dict[str, Any]:
    """Plays every task `repeats` times and writes `metrics.json`; returns what is in it.

    Args:
        config: see there.
        tasks: their names must differ.
        output: folder; one that holds a part of the same evaluation is gone on with, and so is one with fewer repeats.
        workers: processes, 0 for one per core.
        engine: see `hv_teachers.engines`.
        only: play this slice of the episodes, write them down and return nothing ({}). The same call without it, when
            all have ended, plays what is missing or damaged and adds everything up.
        videos: names of tasks whose first episodes are filmed.
        film_typical: play the best episode and one of every kind of failure once more and film them.
        on_episode: is told each outcome, how many there are by then, and how many there will be.

    Raises:
        EvaluationError: the folder holds another evaluation, or two different outcomes of one episode.
        ValueError: the policy cannot be loaded, there is no such engine here, two tasks have one name, or none has the
            name of a film.
    """
    check_engine(engine)
    output = Path(output)
    policy = load_evaluated_policy(config.policy, config.impairments)
    plan = plan_of(config, tasks, policy)
    filmed = set(videos)
    unknown = sorted(filmed - {task.name for task in tasks})
    if unknown:
        raise ValueError(f"videos: {unknown[0]!r} is not among the tasks; valid: {tasks[0].name}, ...")
    file = output / EPISODES_FILE if only is None else output / f"episodes.{only.index}-of-{only.of}.jsonl"
    found = {(o.record.task, o.repeat): o for o in _begin(output, plan)}
    wanted = [(task, repeat) for repeat in range(config.repeats) for task in tasks]
    if only is not None:
        wanted = [episode for number, episode in enumerate(wanted) if number in only]
    done = {key: found[key] for task, repeat in wanted if (key := (task.name, repeat)) in found}
    # written anew: without what was damaged or cut short in the middle of a line
    kept = found if only is None else done
    write_whole(file, "".join(o.to_json() + "\n" for o in kept.values()))
    missing = [
        Episode(task, repeat, episode_seed(config.seed, task.name, repeat))
        for task, repeat in wanted
        if (task.name, repeat) not in done
    ]
    jobs = _jobs(missing, config, num_processes(workers), 1 if policy.sees else BATCH, filmed, output)
    started = time.time()
    with file.open("a", encoding="utf-8") as lines:
        for outcome in _play(jobs, config, workers, engine):
            done[(outcome.record.task, outcome.repeat)] = outcome
            lines.write(outcome.to_json() + "\n")
            lines.flush()
            if on_episode:
                on_episode(outcome, len(done), len(wanted))
    if only is not None:
        return {}
    for part in _slices(output):
        part.unlink()
    if missing:
        _add_time(output, len(missing), time.time() - started)
    outcomes = [done[(task.name, repeat)] for task, repeat in wanted]
    metrics = {**metrics_of(outcomes), "versions": versions(), **physics(tasks[0]), "plan": plan}
    _write(output / METRICS_FILE, metrics)
    if film_typical:
        by_name = {task.name: task for task in tasks}
        chosen = [
            Episode(by_name[o.record.task], o.repeat, o.record.seed)
            for o in typical_outcomes(outcomes)
            if not video_path(output, o.record.task, o.repeat).exists()
        ]
        again = _play([_Job((e,), config, output) for e in chosen], config, workers, engine)
        for outcome in again:
            if outcome.to_json() != done[(outcome.record.task, outcome.repeat)].to_json():
                raise EvaluationError(f"{output}: {outcome.record.task}: the film ends otherwise than the episode did")
    return metrics


def plan_of(config: EvaluationConfig, tasks: Sequence[Task], policy: EvaluatedPolicy) -> dict[str, Any]:
    """Everything that decides the outcomes: the configuration, and hashes of tasks, policy, code and packages.

    Raises:
        ValueError: there is no task, or two have one name.
    """
    names = Counter(task.name for task in tasks)
    twice = [name for name, count in names.items() if count > 1]
    if not names or twice:
        raise ValueError(f"tasks: {f'{twice[0]!r} twice' if twice else 'none'}; valid: one or more, each with its name")
    return {
        **_plan(config), "tasks": tasks_fingerprint(list(tasks)), "n_tasks": len(tasks),
        "policy_hash": policy.fingerprint(), "code_hash": code_hash(), "packages": versions(),
    }  # fmt: skip


def spread(tasks: Sequence[Task], n: int) -> list[Task]:
    """`n` of the tasks, evenly, so that a part has every kind of room.

    Raises:
        ValueError: there are fewer.
    """
    if not 1 <= n <= len(tasks):
        raise ValueError(f"--n-tasks: {n} is not valid; valid: 1 to {len(tasks)}")
    return [tasks[round(i * len(tasks) / n)] for i in range(n)]


def metrics_of(outcomes: Sequence[EpisodeOutcome]) -> dict[str, Any]:
    """Everything that an evaluation reports, ready for JSON.

    The keys of `hv_sim.metrics.summarize`; `interval_0.4` and `interval_0.2`, 95 % intervals (Wilson) of the successes;
    `seconds_i`, mean time of the sub-tasks that were finished; `failures`, how many sub-tasks failed for each reason;
    `rooms` and `kinds`, success by room (of whole episodes) and by kind of object (of sub-tasks), at .4 m.
    """
    records = [o.record for o in outcomes]
    found = summarize(records)
    for threshold in SUCCESS_THRESHOLDS_M:
        results = [r.succeeded(threshold) for r in records]
        most = max(len(r) for r in results)
        shares = {f"success_{i + 1}": [r[i] for r in results if len(r) > i] for i in range(most)}
        shares["success_all"] = [all(r) for r in results]
        found[f"interval_{threshold}"] = {name: wilson_interval(sum(v), len(v)) for name, v in shares.items()}
    for i in range(max(len(o.subtasks) for o in outcomes)):
        took = [t for o in outcomes if len(o.subtasks) > i and (t := o.subtasks[i].seconds) is not None]
        found[f"seconds_{i + 1}"] = round(float(np.mean(took)), 3) if took else None
    subtasks = [s for o in outcomes for s in o.subtasks]
    reasons = Counter(s.failure for s in subtasks)
    found["failures"] = {name: reasons[name] for name in FAILURES}
    threshold = SUCCESS_THRESHOLDS_M[0]
    rooms: dict[str, list[bool]] = {}
    for o in outcomes:
        rooms.setdefault(o.room, []).append(all(o.record.succeeded(threshold)))
    kinds: dict[str, list[bool]] = {}
    for s in subtasks:
        kinds.setdefault(s.object_kind, []).append(s.distance_m < threshold)
    for title, groups in (("rooms", rooms), ("kinds", kinds)):
        found[title] = {k: {"success": sum(v) / len(v), "n": len(v)} for k, v in sorted(groups.items())}
    return found


def video_path(output: Path, task: str, repeat: int) -> Path:
    """Where an evaluation's film of an episode is."""
    return output / "videos" / f"{task}_{repeat}.mp4"


def typical_outcomes(outcomes: Sequence[EpisodeOutcome]) -> list[EpisodeOutcome]:
    """The best episode, the worst, and the first of every kind of failure; each once."""
    if not outcomes:
        return []

    def misses(outcome: EpisodeOutcome) -> float:
        total = sum(outcome.record.distances_m)
        return total if math.isfinite(total) else math.inf

    chosen = [min(outcomes, key=misses), max(outcomes, key=misses)]
    for reason in FAILURES:
        chosen += [o for o in outcomes if any(s.failure == reason for s in o.subtasks)][:1]
    return [o for i, o in enumerate(chosen) if o not in chosen[:i]]


def wilson_interval(successes: int, trials: int, z: float = 1.959964) -> list[float] | None:
    """95 % interval of a share (Wilson, 1927), [low, high]; None without trials."""
    if trials == 0:
        return None
    p, n = successes / trials, trials
    middle = (p + z * z / (2 * n)) / (1 + z * z / n)
    half = z / (1 + z * z / n) * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    return [round(max(0.0, middle - half), 4), round(min(1.0, middle + half), 4)]


def read_outcomes(folder: Path) -> list[EpisodeOutcome]:
    """The episodes that an evaluation's folder holds, slices included; each once.

    A line that is damaged, or was cut short, is left out.

    Raises:
        EvaluationError: two outcomes of one episode differ.
    """
    found: dict[tuple[str, int], EpisodeOutcome] = {}
    for file in (folder / EPISODES_FILE, *_slices(folder)):
        for line in file.read_text(encoding="utf-8", errors="replace").splitlines() if file.exists() else ():
            try:
                outcome = EpisodeOutcome.from_json(line)
            except (ValueError, KeyError, TypeError):
                continue
            earlier = found.setdefault((outcome.record.task, outcome.repeat), outcome)
            if earlier.to_json() != outcome.to_json():  # as text: what is not a number equals itself there
                raise EvaluationError(f"{file}: {outcome.record.task} {outcome.repeat} ended otherwise before")
    return list(found.values())


def _slices(folder: Path) -> list[Path]:
    """What other machines wrote down."""
    return sorted(folder.glob("episodes.*-of-*.jsonl"))


@dataclass(frozen=True)
class _Job:
    episodes: tuple[Episode, ...]
    config: EvaluationConfig
    output: Path | None = None
    """Where films go; None: nothing is filmed."""


def _jobs(
    episodes: Sequence[Episode], config: EvaluationConfig, processes: int, batch: int, filmed: set[str], output: Path
) -> list[_Job]:
    """Films first, one by one; then equal shares of at most `batch` episodes that are equally long."""
    films = [e for e in episodes if e.task.name in filmed and e.repeat == 0]
    jobs = [_Job((e,), config, output) for e in films]
    lengths: dict[int, list[Episode]] = {}
    for e in episodes:
        if e not in films:
            lengths.setdefault(len(e.task.subtasks), []).append(e)
    for group in lengths.values():
        turns = math.ceil(len(group) / (batch * processes))
        size = math.ceil(len(group) / (turns * processes))
        jobs += [_Job(tuple(group[i : i + size]), config) for i in range(0, len(group), size)]
    return jobs


def _begin(output: Path, plan: dict[str, Any]) -> list[EpisodeOutcome]:
    """Makes the folder, or checks that it holds the same evaluation; returns what it holds."""
    output.mkdir(parents=True, exist_ok=True)
    file = output / PLAN_FILE
    if file.exists():
        before = read_plan(output)
        name = differs(before, plan)
        if name:
            raise EvaluationError(
                f"{output}: holds an evaluation with {name}={before.get(name)!r}, not {plan[name]!r}; "
                "choose another folder"
            )
        if before["repeats"] >= plan["repeats"]:
            return read_outcomes(output)
    found = read_outcomes(output) if file.exists() else []
    _write(file, plan)
    return found


def read_plan(folder: Path) -> dict[str, Any]:
    """What a folder's episodes were played with.

    Raises:
        EvaluationError: it cannot be read.
    """
    file = folder / PLAN_FILE
    try:
        before = json.loads(file.read_text(encoding="utf-8"))
        return {**_plan(EvaluationConfig("", "")), **before}  # folders that are older than a choice
    except (OSError, ValueError, TypeError) as error:
        raise EvaluationError(f"{file}: damaged ({error}); choose another folder") from None


def differs(before: dict[str, Any], plan: dict[str, Any]) -> str:
    """The first thing in which two plans differ that changes an episode (repeats only add some); "" if they do not."""
    return next((name for name, value in plan.items() if name != "repeats" and before.get(name) != value), "")


def _plan(config: EvaluationConfig) -> dict[str, Any]:
    """The configuration as JSON has it."""
    return json.loads(json.dumps(asdict(config)))


def _play(jobs: list[_Job], config: EvaluationConfig, workers: int, engine: str) -> Iterator[EpisodeOutcome]:
    arguments = (config.policy, config.impairments)
    for outcomes in run_jobs(_run, jobs, workers=workers, engine=engine, prepare=_load, arguments=arguments):
        yield from outcomes


_POLICY: Any = None


def _load(policy: str, impairments: Impairments) -> None:
    import torch

    global _POLICY
    torch.set_num_threads(1)
    _POLICY = load_evaluated_policy(policy, impairments)


def _run(job: _Job) -> list[EpisodeOutcome]:
    config = job.config
    if job.output is None:
        return run_episodes(job.episodes, _POLICY, config.max_episode_steps, config.instructor, config.physics)
    from lerobot.utils.io_utils import write_video

    frames: list[np.ndarray] = []
    (episode,) = job.episodes
    outcome = film_episode(
        episode, _POLICY, config.max_episode_steps, config.instructor, frames.append, physics=config.physics
    )
    path = video_path(job.output, episode.task.name, episode.repeat)
    path.parent.mkdir(parents=True, exist_ok=True)
    draft = path.with_suffix(".tmp.mp4")
    write_video(draft, frames, fps=15)
    draft.replace(path)
    return [outcome]


def read_timing(folder: Path) -> tuple[int, float]:
    """How many of a folder's episodes were played in how many seconds, without interruptions; zeros if unknown."""
    try:
        timing = json.loads((folder / TIMING_FILE).read_text(encoding="utf-8"))
        return int(timing["episodes"]), float(timing["seconds"])
    except (OSError, ValueError, KeyError, TypeError):
        return 0, 0.0


def _add_time(output: Path, episodes: int, seconds: float) -> None:
    before, took_s = read_timing(output)
    _write(output / TIMING_FILE, {"episodes": before + episodes, "seconds": round(took_s + seconds, 1)})


def _write(path: Path, data: dict[str, Any]) -> None:
    write_whole(path, json.dumps(data, indent=1) + "\n")
