"""Records what an expert does as a LeRobot v3 dataset: one episode per attempt, instructions changing on the way.

An attempt is (task, repeat); its seed follows from (seed, task's name, repeat) alone, so that an attempt is the same
in whatever company and order it is recorded. Episodes are stored in the order of the attempts. Everything is written
to a temporary folder beside the target, read back and compared frame by frame, and only then moved into place.
"""

import itertools
import json
import math
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, Protocol

import torch
from datasets.utils.logging import disable_progress_bar
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from torch import Tensor
from tqdm import tqdm

from hv_policy.motor.proprioception import read_proprioception
from hv_sim.looks import NO_LOOKS, LookRanges
from hv_sim.metrics import SUCCESS_THRESHOLDS_M
from hv_sim.physics_backends import check_backend, make_renderer
from hv_sim.rendering import StepCamera
from hv_sim.task import Task
from hv_sim.world import RearrangeWorld
from hv_teachers.dataset_format import (
    FPS,
    HEAD_IMAGE,
    STATE,
    FrameDigest,
    RecordingError,
    digest,
    features,
    verify_dataset,
)
from hv_teachers.frames import attempt_seed, draw_looks, frame_row, glance_frames, vector_columns
from hv_teachers.knowledge import Knowledge
from hv_teachers.picture_embedding import pictures_embedded_whole

REPORT_FILE = "meta/hv_recording.json"


class Expert(Protocol):
    """Decides for every environment of a world at once; may use everything that the simulator knows."""

    @property
    def knowledge(self) -> Knowledge | None:
        """What it knew when it was last asked; None if that cannot be said, and zeros are recorded then."""

    @property
    def executed(self) -> Tensor | None:
        """(N, 28) joint targets that are done instead of those that it says, which are recorded; None: what it says."""

    def see_through(self, camera: StepCamera) -> None:
        """The camera to look through, for one that needs pictures; called before the first step."""

    def reset(self, ids: Tensor | None = None) -> None:
        """Forget what is remembered of environments `ids` (all by default): new episodes begin there."""

    def __call__(self, world: RearrangeWorld) -> tuple[Tensor, Tensor]:
        """Intents (N, 14), see `hv_sim.control.INTENT_NAMES`, and joint targets (N, 28) in rad."""


@dataclass(frozen=True)
class RecordingConfig:
    """What determines the frames of a recording.

    Args:
        seed: of the whole recording.
        image_size_px: side of the square head camera picture.
        max_episode_steps: control steps (30 a second) after which an attempt ends; None: the world's default.
        glances: pictures from random places to be recorded of each task instead of an attempt (`hv_teachers.glances`);
            0 for attempts.
        beta: share of the time in which the teacher acts where a student is recorded.
        end_when_fallen: an attempt ends a second after a fall; what follows teaches nothing.
        frame_stride: control steps from one frame to the next; the dataset then has 30 / frame_stride frames a second.
        drop_failed: leave out attempts in which not every object ends at its goal; they are still counted.
        physics: one of `hv_sim.physics_backends.BACKENDS`; it also says who renders.
        looks: how different every attempt, and every place of glances, looks (`hv_sim.looks`).

    Raises:
        ValueError: there is no such physics.
    """

    seed: int = 0
    image_size_px: int = 128
    max_episode_steps: int | None = None
    glances: int = 0
    beta: float = 0.0
    end_when_fallen: bool = False
    frame_stride: int = 1
    drop_failed: bool = False
    physics: str = "cpu"
    looks: LookRanges = NO_LOOKS

    def __post_init__(self) -> None:
        check_backend(self.physics)
        if self.glances and self.physics != "cpu":
            raise RecordingError(f"physics: {self.physics!r} is not valid with glances; valid: cpu")
        if self.looks.vary and self.physics != "cpu":
            raise RecordingError(f"physics: {self.physics!r} is not valid with looks; valid: cpu")
        if not 0 <= self.beta <= 1:
            raise RecordingError(f"beta: {self.beta} is not valid; valid: 0 to 1")
        if self.frame_stride < 1 or FPS % self.frame_stride:
            raise RecordingError(f"frame_stride: {self.frame_stride} is not valid; valid: a divisor of {FPS}")


@dataclass
class Attempt:
    """One attempt of the expert and where it went: `episode_index` is None for one that was left out."""

    task: str
    repeat: int
    seed: int
    success: bool
    num_finished: int
    num_frames: int
    fallen: bool
    distances_m: list[float | None]
    episode_index: int | None = None


@dataclass
class RecordingReport:
    """What a recording holds (`attempts`, those of earlier sessions included) and how long this session took."""

    attempts: list[Attempt] = field(default_factory=list)
    frames_recorded: int = 0
    rollout_s: float = 0.0
    writing_s: float = 0.0
    checking_s: float = 0.0
    damaged: int = 0
    """Shards that were found damaged, and recorded again."""
    doubled: int = 0
    """Shards that held what others held, and were thrown away."""

    @property
    def num_failed(self) -> int:
        return sum(not attempt.success for attempt in self.attempts)

    @property
    def num_episodes(self) -> int:
        return sum(attempt.episode_index is not None for attempt in self.attempts)


class NothingRecordedError(RecordingError):
    """Every attempt failed and was dropped; `report` tells which."""

    def __init__(self, root: Path, report: RecordingReport) -> None:
        super().__init__(f"dataset {root}: all {len(report.attempts)} attempts failed and were dropped")
        self.report = report


def record_dataset(
    root: str | Path,
    tasks: Sequence[Task],
    make_expert: Callable[[int], Expert],
    config: RecordingConfig = RecordingConfig(),
    *,
    repeats: int | Sequence[int] = 1,
    num_envs: int = 2,
    resume: bool = False,
    progress: bool = True,
) -> RecordingReport:
    """Lets an expert attempt every task `repeats` times and stores the attempts as a LeRobot dataset.

    Args:
        root: folder of the dataset; its last part is also the dataset's name.
        tasks: their names must differ.
        make_expert: builds an expert for a number of environments.
        config: see `RecordingConfig`.
        repeats: how many attempts of each task, or their numbers.
        num_envs: attempts simulated at a time; does not change the result.
        resume: add the attempts that an existing dataset at `root` does not hold yet. Without it an existing folder
            is left alone.
        progress: show bars.

    Returns:
        The report, which is also stored in the dataset as `meta/hv_recording.json`.

    Raises:
        RecordingError: `root` exists (without `resume`), was recorded with another configuration, two tasks share a
            name, no attempt was left to store, or the dataset that was written does not hold what was recorded.
    """
    root = Path(root)
    earlier = attempts_before(root, tasks, config, resume)
    done = {(attempt.task, attempt.repeat) for attempt in earlier}
    numbers = range(repeats) if isinstance(repeats, int) else repeats
    wanted = [(task, repeat) for repeat in numbers for task in tasks if (task.name, repeat) not in done]
    report = RecordingReport(attempts=list(earlier))
    if not wanted:
        return report

    root.parent.mkdir(parents=True, exist_ok=True)
    with moved_into_place(root) as written:
        if earlier:
            shutil.copytree(root, written)
        _record_attempts(written, root.name, wanted, make_expert, config, num_envs, report, progress)
        if report.num_episodes == 0:
            raise NothingRecordedError(root, report)
        (written / REPORT_FILE).write_text(report_as_json(config, report))
    return report


def attempts_before(root: Path, tasks: Sequence[Task], config: RecordingConfig, resume: bool) -> list[Attempt]:
    """The attempts that a dataset at `root` holds already.

    Raises:
        RecordingError: two tasks share a name, `root` exists (without `resume`), or is of another recording.
    """
    names = [task.name for task in tasks]
    if len(set(names)) != len(names):
        raise RecordingError(f"tasks: {next(n for n in names if names.count(n) > 1)!r} is the name of more than one")
    if not root.exists():
        return []
    if not resume:
        raise RecordingError(f"dataset {root}: exists already; choose another folder, or add to it with --resume")
    return read_attempts(root / REPORT_FILE, config)


@contextmanager
def moved_into_place(root: Path) -> Iterator[Path]:
    """A folder of the same name beside `root` to write into, which takes its place when all went well."""
    workplace = Path(tempfile.mkdtemp(prefix=f".{root.name}.partial-", dir=root.parent))
    before = workplace / "before"
    try:
        yield workplace / root.name
        if root.exists():
            root.rename(before)
        (workplace / root.name).rename(root)
    finally:
        if before.exists() and not root.exists():
            before.rename(root)
        shutil.rmtree(workplace, ignore_errors=True)


def _record_attempts(
    written: Path,
    name: str,
    wanted: Sequence[tuple[Task, int]],
    make_expert: Callable[[int], Expert],
    config: RecordingConfig,
    num_envs: int,
    report: RecordingReport,
    show: bool,
) -> None:
    """Rolls, writes, finalises and checks; extends `report`."""
    disable_progress_bar()
    if written.exists():
        dataset = LeRobotDataset.resume(name, root=written, video_backend="pyav")
    else:
        dataset = LeRobotDataset.create(
            name,
            fps=FPS // config.frame_stride,
            features=features(config.image_size_px),
            root=written,
            robot_type="hv_humanoid",
            use_videos=False,
            video_backend="pyav",  # never used, but LeRobot would look for torchcodec, loudly
        )
    digests: dict[int, list[FrameDigest]] = {}
    try:
        with tqdm(total=len(wanted), desc="Recording", unit="episode", disable=not show) as progress:
            for group in _groups(wanted, config, num_envs):
                started = time.perf_counter()
                rolled = roll_glances(group, config) if config.glances else roll_attempts(group, make_expert, config)
                report.rollout_s += time.perf_counter() - started
                for attempt, frames in rolled:
                    started = time.perf_counter()
                    if attempt.success or not config.drop_failed:
                        attempt.episode_index = dataset.meta.total_episodes
                        digests[attempt.episode_index] = _write_episode(dataset, frames)
                    report.writing_s += time.perf_counter() - started
                    report.attempts.append(attempt)
                    report.frames_recorded += attempt.num_frames
                    progress.set_postfix(failed=report.num_failed, refresh=False)
                    progress.update()
    finally:
        dataset.finalize()
    started = time.perf_counter()
    verify_dataset(written, name, digests, progress=show)
    report.checking_s = time.perf_counter() - started


def roll_attempts(
    attempts: Sequence[tuple[Task, int]], make_expert: Callable[[int], Expert], config: RecordingConfig
) -> list[tuple[Attempt, list[dict[str, Any]]]]:
    """Simulates attempts (task, repeat) side by side.

    Returns:
        For each, what became of it and its frames, ready for `LeRobotDataset.add_frame`.
    """
    tasks = [task for task, _ in attempts]
    seeds = [attempt_seed(config.seed, task.name, repeat) for task, repeat in attempts]
    # a process is a core: more cores are more processes
    world = RearrangeWorld(tasks, max_episode_steps=config.max_episode_steps, num_threads=1, physics=config.physics)
    world.reset(seeds=seeds)
    expert = make_expert(len(attempts))
    expert.reset()
    renderer = make_renderer(config.physics, config.image_size_px, config.image_size_px)
    camera = StepCamera(renderer, world.physics, draw_looks(config.looks, seeds))
    expert.see_through(camera)
    frames: list[list[dict[str, Any]]] = [[] for _ in attempts]
    since_fall = torch.zeros(len(attempts), dtype=torch.long)
    try:
        while True:
            since_fall += world.fallen
            over = world.done | (since_fall > FPS) if config.end_when_fallen else world.done
            if bool(over.all()):
                break
            intent, joint_targets = expert(world)
            due = torch.nonzero(~over & (world.episode_step % config.frame_stride == 0)).flatten().tolist()
            if due:
                arrays = vector_columns(world, expert.knowledge, intent, joint_targets)
                instructions = world.instructions()
                body = read_proprioception(torch.from_numpy(arrays[STATE]))
                for env in due:
                    row = frame_row(world, env, arrays, body, len(frames[env]))
                    frames[env].append({HEAD_IMAGE: camera.picture(env).copy(), **row, "task": instructions[env]})
            world.step(joint_targets if expert.executed is None else expert.executed)
            camera.forget()
    finally:
        renderer.close()
    return _outcomes(attempts, world, frames)


def roll_glances(
    attempts: Sequence[tuple[Task, int]], config: RecordingConfig
) -> list[tuple[Attempt, list[dict[str, Any]]]]:
    """As `roll_attempts`, but `config.glances` pictures from random places instead (`hv_teachers.glances`)."""
    tasks = [task for task, _ in attempts]
    seeds = [attempt_seed(config.seed, task.name, repeat) for task, repeat in attempts]
    frames: list[list[dict[str, Any]]] = [[] for _ in attempts]
    for world, rows in glance_frames(tasks, seeds, config.glances, config.image_size_px, config.looks):
        for held, row in zip(frames, rows, strict=True):
            held.append(row)
        shown = world
    outcomes = _outcomes(attempts, shown, frames)
    return [(replace(attempt, seed=seed), rows) for (attempt, rows), seed in zip(outcomes, seeds, strict=True)]


def _outcomes(
    attempts: Sequence[tuple[Task, int]], world: RearrangeWorld, frames: list[list[dict[str, Any]]]
) -> list[tuple[Attempt, list[dict[str, Any]]]]:
    """What became of each attempt, and its frames."""
    outcomes = [
        Attempt(
            task=record.task,
            repeat=repeat,
            seed=record.seed,
            success=all(record.succeeded(SUCCESS_THRESHOLDS_M[0])),
            num_finished=record.num_finished,
            num_frames=len(rows),
            fallen=record.fallen,
            distances_m=[d if math.isfinite(d) else None for d in record.distances_m],
        )
        for (_, repeat), record, rows in zip(attempts, world.records(), frames, strict=True)
    ]
    return list(zip(outcomes, frames, strict=True))


def _groups(
    wanted: Sequence[tuple[Task, int]], config: RecordingConfig, num_envs: int
) -> Iterator[list[tuple[Task, int]]]:
    """Neighbours to be simulated side by side, at most `num_envs`; a world has one time limit for all of its tasks."""

    def time_limit(attempt: tuple[Task, int]) -> int:
        return config.max_episode_steps or RearrangeWorld.default_max_episode_steps([attempt[0]])

    for _, alike in itertools.groupby(wanted, key=time_limit):
        for group in itertools.batched(alike, num_envs):
            yield list(group)


def _write_episode(dataset: LeRobotDataset, frames: Sequence[dict[str, Any]]) -> list[FrameDigest]:
    """Appends an episode to the dataset; returns what to find there later."""
    # In the order of appearance; left to itself, LeRobot numbers them in the order of Python's randomised hashes.
    dataset.meta.save_episode_tasks(list(dict.fromkeys(frame["task"] for frame in frames)))
    digests = []
    for frame in frames:
        digests.append(digest(frame[HEAD_IMAGE], frame, frame["task"]))
        dataset.add_frame(dict(frame))
    with pictures_embedded_whole():
        dataset.save_episode()
    return digests


def report_as_json(config: RecordingConfig, report: RecordingReport) -> str:
    """What `meta/hv_recording.json` holds."""
    content = {"config": asdict(config), "attempts": [asdict(attempt) for attempt in report.attempts]}
    return json.dumps(content, indent=1) + "\n"


def read_attempts(file: Path, config: RecordingConfig) -> list[Attempt]:
    """Attempts that a report tells of, `REPORT_FILE` of a dataset.

    Raises:
        RecordingError: it is not a report of ours, or of a recording with another configuration.
    """
    root = file.parents[1] if file.name == Path(REPORT_FILE).name else file
    try:
        content = json.loads(file.read_text())
        before, attempts = content["config"], [Attempt(**attempt) for attempt in content["attempts"]]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise RecordingError(f"dataset {root}: cannot be resumed, {REPORT_FILE} is missing or damaged") from error
    before = {**asdict(RecordingConfig()), **before}  # what is younger had its default then
    for name, value in asdict(config).items():
        if before[name] != value:
            raise RecordingError(f"dataset {root}: was recorded with {name}={before[name]}, not {value}")
    return attempts
