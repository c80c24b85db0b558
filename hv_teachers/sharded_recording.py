"""Recording in many processes, here or on many machines: shards, each a LeRobot dataset, joined by LeRobot's own tool.

A shard holds the attempts that one process simulates side by side. It is written beside its place, checked, moved there
whole (`hv_teachers.recording`) and sealed with checksums, so a kill at any moment costs the attempts in flight and
nothing else. Given the same command again, the recording takes stock: shards that are damaged, or hold what another one
holds, are thrown away, and what is missing is recorded. What an attempt holds follows from (seed, task, repeat) alone,
and the shards are joined in the order of the attempts: the dataset is the same whatever the number of processes.

Many machines record a slice each of the shards into one folder that they share, and one of them then joins them.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
from datasets.utils.logging import disable_progress_bar
from lerobot.datasets.aggregate import aggregate_datasets
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from tqdm import tqdm

from hv_sim.task import Task
from hv_teachers.dataset_format import HEAD_IMAGE, TEXT_COLUMNS, VECTOR_COLUMNS, RecordingError
from hv_teachers.engines import Slice, check_engine, run_jobs
from hv_teachers.picture_embedding import pictures_embedded_whole
from hv_teachers.recording import (
    REPORT_FILE,
    Attempt,
    Expert,
    NothingRecordedError,
    RecordingConfig,
    RecordingReport,
    attempts_before,
    moved_into_place,
    read_attempts,
    record_dataset,
    report_as_json,
)
from hv_teachers.sealed_folders import is_whole, seal
from hv_teachers.whole_files import write_whole

PLAN_FILE, DROPPED_SUFFIX = "plan.json", ".dropped.json"


@dataclass(frozen=True)
class _Shard:
    """Neighbouring tasks' attempts number `repeat`, to be recorded by one process."""

    folder: Path
    tasks: tuple[Task, ...]
    repeat: int
    config: RecordingConfig
    make_expert: Callable[[int], Expert]


@dataclass(frozen=True)
class Stock:
    """What an interrupted recording, or several machines, left."""

    found: list[tuple[Path, list[Attempt]]]
    """Whole shards in the order of their attempts, and those attempts; a dropped shard's path is its report."""
    damaged: int
    doubled: int


def record_shards(
    root: str | Path,
    tasks: Sequence[Task],
    make_expert: Callable[[int], Expert],
    config: RecordingConfig,
    *,
    repeats: int = 1,
    num_envs: int = 4,
    workers: int = 0,
    engine: str = "pool",
    resume: bool = False,
    only: Slice | None = None,
) -> RecordingReport:
    """As `hv_teachers.recording.record_dataset`, in `workers` processes, and to be gone on with after a kill.

    Args:
        root: folder of the dataset; shards are kept beside it until they are joined.
        tasks: their names must differ.
        make_expert: builds an expert for a number of environments; a module's function or class, or a partial of one.
        config: see `RecordingConfig`.
        repeats: attempts of each task, 0, 1, ...
        num_envs: attempts that a process simulates side by side: what a kill costs.
        workers: processes, 0 for one per core.
        engine: see `hv_teachers.engines`.
        resume: add to a dataset that exists at `root`. Shards that an interrupted recording left are always used.
        only: record this slice of the shards and join nothing. The same call without it, when all have ended, records
            what is missing and joins them.

    Raises:
        RecordingError: as `record_dataset` does; or the shards there are of another recording.
        ValueError: there is no such engine here.
    """
    check_engine(engine)
    root = Path(root)
    names = [task.name for task in tasks]
    earlier = attempts_before(root, tasks, config, resume)
    folder = root.with_name(f".{root.name}.shards")
    before = {(a.task, a.repeat) for a in earlier}
    blocks = [
        (repeat, first, count)
        for repeat in range(repeats)
        for first, count in _runs([(name, repeat) not in before for name in names], num_envs)
    ]
    if only is not None:
        blocks = [block for number, block in enumerate(blocks) if number in only]
    _begin(folder, config, num_envs if only else None)
    stock = _take_stock(folder, config, blocks)
    done = {(a.task, a.repeat) for _, attempts in stock.found for a in attempts}
    shards = []
    for repeat, start, length in blocks:
        missing = [(name, repeat) not in done for name in names[start : start + length]]
        for first, count in _runs(missing, num_envs):
            place = folder / f"shard_{repeat:03d}_{start + first:05d}"
            chosen = tuple(tasks[start + first : start + first + count])
            shards.append(_Shard(place, chosen, repeat, config, make_expert))
    report = RecordingReport(damaged=stock.damaged, doubled=stock.doubled)
    try:
        with tqdm(total=sum(len(s.tasks) for s in shards), desc="Recording", unit="episode", disable=not shards) as bar:
            for count, part in run_jobs(_record, shards, workers=workers, engine=engine, prepare=_one_thread):
                report.frames_recorded += part.frames_recorded
                report.rollout_s += part.rollout_s
                report.writing_s += part.writing_s
                report.checking_s += part.checking_s
                bar.update(count)
        if only is None:
            _join(root, folder, config, earlier, report)
        else:
            report.attempts = [a for _, attempts in _take_stock(folder, config, blocks).found for a in attempts]
    finally:
        if folder.exists() and only is None and not any(folder.glob("shard_*")):
            shutil.rmtree(folder)  # nothing to go on from
    return report


def _runs(missing: Sequence[bool], longest: int) -> Iterator[tuple[int, int]]:
    """(first, count) of the stretches of missing attempts, at most `longest` each."""
    first = 0
    while first < len(missing):
        if not missing[first]:
            first += 1
            continue
        count = 1
        while count < longest and first + count < len(missing) and missing[first + count]:
            count += 1
        yield first, count
        first += count


def _begin(folder: Path, config: RecordingConfig, shared_by: int | None) -> None:
    """Makes the shards' folder, or checks that the one there is of the same recording.

    Args:
        folder: of the shards.
        config: of the recording.
        shared_by: attempts in a shard, if other machines record into the folder too; None: nobody else does, and what
            was left unfinished is removed.
    """
    plan = folder / PLAN_FILE
    wanted = {**asdict(config), **({} if shared_by is None else {"num_envs": shared_by})}
    defaults = {**asdict(RecordingConfig()), "num_envs": shared_by}  # alone, one may cut the shards another way
    if plan.exists():
        before = json.loads(plan.read_text())
        for name, value in wanted.items():
            if before.get(name, defaults[name]) != value:
                raise RecordingError(f"{folder}: holds shards recorded with {name}={before.get(name)}, not {value}")
        wanted = {**before, **wanted}
    folder.mkdir(parents=True, exist_ok=True)
    if shared_by is None:
        for left in folder.glob(".shard_*"):
            shutil.rmtree(left, ignore_errors=True)
    write_whole(plan, json.dumps(wanted))


def _take_stock(folder: Path, config: RecordingConfig, blocks: Sequence[tuple[int, int, int]] | None = None) -> Stock:
    """The whole shards; those that are damaged, or hold again what another one holds, are removed.

    Args:
        folder: of the shards.
        config: of the recording.
        blocks: (repeat, first task, count); look only at shards that lie in them. Others may be being written.
    """
    found: list[tuple[Path, list[Attempt]]] = []
    damaged, doubled = 0, 0
    known: set[tuple[str, int]] = set()
    for path in sorted(folder.glob("shard_*"), key=lambda p: p.name.removesuffix(DROPPED_SUFFIX)):
        repeat, first = (int(part) for part in path.name.removesuffix(DROPPED_SUFFIX).split("_")[1:])
        if blocks is not None and not any(r == repeat and f <= first < f + n for r, f, n in blocks):
            continue
        attempts = _attempts_of(path, config)
        held = {(a.task, a.repeat) for a in attempts}
        if attempts and not held & known:
            found.append((path, attempts))
            known |= held
            continue
        damaged, doubled = damaged + (not attempts), doubled + bool(attempts)
        shutil.rmtree(path) if path.is_dir() else path.unlink()
    return Stock(found, damaged, doubled)


def _attempts_of(shard: Path, config: RecordingConfig) -> list[Attempt]:
    """What a shard holds; nothing, if it is damaged."""
    if shard.is_dir():
        return read_attempts(shard / REPORT_FILE, config) if is_whole(shard) else []
    try:
        json.loads(shard.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return []
    return read_attempts(shard, config)


def _one_thread() -> None:
    import torch

    torch.set_num_threads(1)


def _record(shard: _Shard) -> tuple[int, RecordingReport]:
    """How many attempts a shard has, and what came of them."""
    if shard.folder.exists():
        if is_whole(shard.folder):
            return len(shard.tasks), RecordingReport()  # whoever finished it was killed before it could say so
        shutil.rmtree(shard.folder)
    try:
        report = record_dataset(
            shard.folder, shard.tasks, shard.make_expert, shard.config,
            repeats=[shard.repeat], num_envs=len(shard.tasks), progress=False,
        )  # fmt: skip
        seal(shard.folder)
    except NothingRecordedError as nothing:
        place = shard.folder.with_name(shard.folder.name + DROPPED_SUFFIX)
        write_whole(place, report_as_json(shard.config, nothing.report))
        report = nothing.report
    return len(shard.tasks), report


def _join(
    root: Path, folder: Path, config: RecordingConfig, earlier: list[Attempt], report: RecordingReport
) -> None:
    """Joins what is there and the finished shards to the dataset at `root`, checks it, and removes the shards."""
    finished = _take_stock(folder, config).found
    if not finished:
        report.attempts = earlier
        shutil.rmtree(folder)
        return
    parts = [(root, earlier), *finished] if root.exists() else finished
    sources = [path for path, _ in parts if path.is_dir()]
    if not sources:
        report.attempts = [a for _, attempts in parts for a in attempts]
        shutil.rmtree(folder)
        raise NothingRecordedError(root, report)
    with moved_into_place(root) as written:
        disable_progress_bar()
        with pictures_embedded_whole():
            aggregate_datasets([p.name for p in sources], root.name, roots=sources, aggr_root=written)
        report.attempts, episodes = [], 0
        for _, attempts in parts:
            for attempt in attempts:
                kept = attempt.episode_index is not None
                report.attempts.append(replace(attempt, episode_index=episodes if kept else None))
                episodes += kept
        _compare(written, root.name, sources)
        (written / REPORT_FILE).write_text(report_as_json(config, report))
    shutil.rmtree(folder)


def _compare(written: Path, name: str, sources: Sequence[Path]) -> None:
    """Raises RecordingError unless the joined dataset holds the shards' frames, bit for bit and in order."""
    joined = LeRobotDataset(name, root=written, video_backend="pyav")
    texts = list(joined.meta.tasks.index)
    table = joined.hf_dataset.with_format("arrow")
    offset = 0
    for source in sources:
        shard = LeRobotDataset(source.name, root=source, video_backend="pyav")
        own, theirs = shard.hf_dataset.with_format("arrow")[:], table[offset : offset + shard.num_frames]
        for column in (*VECTOR_COLUMNS, *TEXT_COLUMNS, HEAD_IMAGE):
            if not own[column].combine_chunks().equals(theirs[column].combine_chunks()):
                raise RecordingError(f"dataset {written}: {column} of {source.name} is not what was recorded")
        own_texts = list(shard.meta.tasks.index)
        said = [own_texts[i] for i in np.ravel(own["task_index"].to_numpy())]
        if said != [texts[i] for i in np.ravel(theirs["task_index"].to_numpy())]:
            raise RecordingError(f"dataset {written}: instructions of {source.name} are not those recorded")
        offset += shard.num_frames
    if offset != joined.num_frames:
        raise RecordingError(f"dataset {written}: has {joined.num_frames} frames instead of {offset}")
