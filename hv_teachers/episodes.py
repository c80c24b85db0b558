"""Episodes of an evaluation: played side by side, each with the same result as alone, and what came of them."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import torch
from torch import Tensor

from hv_sim.humanoid import BODY_NAMES
from hv_sim.instructor import InstructorConfig
from hv_sim.metrics import EpisodeRecord
from hv_sim.rearrange_env import RearrangeEnv
from hv_sim.task import Task, built_object
from hv_sim.world import RearrangeWorld

LIFTED_M = 0.08
PLACED_M = 0.4
NEVER = 1_000_000
FAILURES = ("fell", "not_reached", "blocked", "not_grasped", "dropped", "timed_out", "knocked")
"""Why a sub-task failed: the robot fell while it was in force or before; its instruction was never given; the robot
never came near its object; it came, and never lifted it; it did, and the object lies somewhere else; it is still being
held when time is up; it had been accepted, and was moved again later."""
NEAR_M = 0.9
HELD_M = 0.3
_HANDS = [BODY_NAMES.index("right_hand"), BODY_NAMES.index("left_hand")]


class EvaluatedPolicy(Protocol):
    """What is evaluated. It acts for every environment of a world, each as if it were alone."""

    sees: bool
    """It needs the camera, and is shown one environment at a time."""

    def reset(self, num_envs: int) -> None:
        """Forgets the last episodes; as many begin now."""

    @property
    def picture_px(self) -> tuple[int, int]:
        """Height and width of the pictures that it looks at."""

    def needs_picture(self, world: RearrangeWorld) -> bool:
        """Whether it will look at the camera's picture when it acts next."""

    def __call__(self, world: RearrangeWorld, observation: dict[str, Any] | None) -> Tensor:
        """(N, 28) servo targets in rad; the observation is `RearrangeEnv`'s, None for a policy that does not see."""

    def fingerprint(self) -> str:
        """A hash of everything that decides what it does."""


@dataclass(frozen=True)
class Episode:
    """What is to be played: the task and the seed decide everything, `repeat` is its number for the record."""

    task: Task
    repeat: int
    seed: int


@dataclass(frozen=True)
class SubTaskOutcome:
    """What became of one sub-task."""

    object_kind: str
    mass_kg: float
    way_m: float
    from_height_m: float
    to_height_m: float
    distance_m: float
    seconds: float | None
    """How long it took, None if the instructor never accepted it."""
    lifted: bool
    failure: str
    """One of `FAILURES`, "" for a success (nearer than `PLACED_M`)."""


@dataclass(frozen=True)
class EpisodeOutcome:
    """An episode of an evaluation: what `hv_sim.metrics` counts, and why it ended so."""

    record: EpisodeRecord
    repeat: int
    room: str
    subtasks: tuple[SubTaskOutcome, ...]

    def to_json(self) -> str:
        """One line."""
        return json.dumps(asdict(self), allow_nan=True)

    @staticmethod
    def from_json(line: str) -> EpisodeOutcome:
        """What `to_json` wrote."""
        data = json.loads(line)
        record = {**data["record"], "distances_m": tuple(data["record"]["distances_m"])}
        subtasks = tuple(SubTaskOutcome(**s) for s in data["subtasks"])
        return EpisodeOutcome(EpisodeRecord(**record), data["repeat"], data["room"], subtasks)


def run_episodes(
    episodes: Sequence[Episode],
    policy: EvaluatedPolicy,
    max_episode_steps: int | None = None,
    instructor: InstructorConfig | None = None,
    physics: str = "cpu",
) -> list[EpisodeOutcome]:
    """Plays episodes to their ends, side by side where the policy does not see, on one thread.

    Each ends as it would alone, bit for bit: physics, planner and controllers treat every environment by itself.

    Args:
        episodes: with equally many sub-tasks each, if `max_episode_steps` is not given.
        policy: who acts.
        max_episode_steps: control steps before an episode is cut off (default: the world's).
        instructor: thresholds of Algorithm 3.
        physics: one of `hv_sim.physics_backends.BACKENDS`; bit for bit holds for `cpu`.
    """
    if policy.sees:
        return [film_episode(e, policy, max_episode_steps, instructor, physics=physics) for e in episodes]
    world = RearrangeWorld(
        [e.task for e in episodes],
        max_episode_steps=max_episode_steps,
        instructor=instructor,
        num_threads=1,
        physics=physics,
    )
    world.reset(seeds=[e.seed for e in episodes])
    policy.reset(len(episodes))
    watch = _Watch(world)
    with torch.no_grad():
        while not bool(world.done.all()):
            world.step(policy(world, None))
            watch.look()
    return watch.outcomes(episodes)


def film_episode(
    episode: Episode,
    policy: EvaluatedPolicy,
    max_episode_steps: int | None = None,
    instructor: InstructorConfig | None = None,
    on_frame: Callable[[np.ndarray], None] | None = None,
    frame_stride: int = 2,
    physics: str = "cpu",
) -> EpisodeOutcome:
    """Plays one episode in `RearrangeEnv`, as a policy with a camera needs it and as `lerobot-eval` does.

    What a policy draws at random follows from the episode's seed.

    Args:
        episode: what is played.
        policy: who acts.
        max_episode_steps: control steps before it is cut off (default: the world's).
        instructor: thresholds of Algorithm 3.
        on_frame: is given a picture of the episode every `frame_stride` steps.
        frame_stride: see there.
        physics: one of `hv_sim.physics_backends.BACKENDS`; pictures are OpenGL's all the same.
    """
    height, width = policy.picture_px
    env = RearrangeEnv(
        episode.task, max_episode_steps=max_episode_steps, instructor=instructor, physics=physics,
        observation_height=height, observation_width=width,
    )  # fmt: skip
    if policy.sees:
        from lerobot.utils.random_utils import set_seed

        set_seed(episode.seed)
    try:
        env.wants_picture = policy.needs_picture
        observation = env.reset(seed=episode.seed)[0] if policy.sees else None
        world = env.world
        if observation is None:
            world.reset(seeds=[episode.seed])
        policy.reset(1)
        watch = _Watch(world)
        with torch.no_grad():
            while not bool(world.done[0]):
                if on_frame and int(world.episode_step[0]) % frame_stride == 0:
                    frame = env.render()
                    assert frame is not None
                    on_frame(frame)
                targets = policy(world, observation)
                if observation is None:
                    env.step_world(targets)
                else:
                    observation = env.step(targets[0].numpy())[0]
                watch.look()
        return watch.outcomes([episode])[0]
    finally:
        env.close()


class _Watch:
    """Notes when sub-tasks are finished, what was lifted, and when the robot fell, in every environment."""

    def __init__(self, world: RearrangeWorld) -> None:
        self.world = world
        self.finished_at: list[list[int]] = [[] for _ in range(world.num_envs)]
        self.start_height = world.state.object_pos_w[..., 2].clone()
        self.rose = torch.zeros_like(self.start_height)
        self.fell_during = torch.full((world.num_envs,), NEVER)
        self.nearest = torch.full(world.subtask_exists.shape, torch.inf)

    def look(self) -> None:
        world = self.world
        self.rose = torch.maximum(self.rose, world.state.object_pos_w[..., 2] - self.start_height)
        finished = world.num_finished.tolist()
        for i, times in enumerate(self.finished_at):
            while len(times) < finished[i]:
                times.append(int(world.episode_step[i]))
        fell_now = world.fallen & (self.fell_during == NEVER)
        self.fell_during = torch.where(fell_now, world.subtask_index, self.fell_during)
        rows, index = torch.arange(world.num_envs), world.subtask_index
        self.nearest[rows, index] = torch.minimum(self.nearest[rows, index], self._away()[rows, world.object_index])

    def _away(self) -> Tensor:
        """(N, K) horizontal distance of robot and objects, m."""
        state = self.world.state
        return (state.object_pos_w[..., :2] - state.link_pos_w[:, :1, :2]).norm(dim=-1)

    def outcomes(self, episodes: Sequence[Episode]) -> list[EpisodeOutcome]:
        records = self.world.records()
        return [
            EpisodeOutcome(record, e.repeat, e.task.room.kind, tuple(self._subtasks(i, record)))
            for i, (e, record) in enumerate(zip(episodes, records, strict=True))
        ]

    def _subtasks(self, env: int, record: EpisodeRecord) -> Iterator[SubTaskOutcome]:
        task, finished_at = self.world.tasks[env], self.finished_at[env]
        names = [o.name for o in task.objects]
        starts = {o.name: o.position_m for o in task.objects}
        for i, subtask in enumerate(task.subtasks):
            k = names.index(subtask.object)
            placed = task.objects[k]
            built = built_object(placed)
            start, half = starts[subtask.object], float(built.half_extents_m[2])
            lifted = float(self.rose[env, k]) > LIFTED_M
            begun = 0 if i == 0 else finished_at[i - 1] if i <= len(finished_at) else None
            done = finished_at[i] if i < len(finished_at) else None
            distance = record.distances_m[i]
            yield SubTaskOutcome(
                object_kind=placed.kind,
                mass_kg=built.mass_kg,
                way_m=round(float(np.hypot(*np.subtract(subtask.goal_position_m, start)[:2])), 4),
                from_height_m=round(float(start[2]) - half, 4),
                to_height_m=round(float(subtask.goal_position_m[2]) - half, 4),
                distance_m=distance,
                seconds=None if done is None or begun is None else (done - begun) / 30.0,
                lifted=lifted,
                failure=self._failure(env, i, k, distance, lifted, begun is not None),
            )
            starts[subtask.object] = subtask.goal_position_m

    def _failure(self, env: int, i: int, k: int, distance_m: float, lifted: bool, was_told: bool) -> str:
        if distance_m < PLACED_M:
            return ""
        if i < len(self.finished_at[env]):
            return "knocked"
        if int(self.fell_during[env]) <= i:
            return "fell"
        if not was_told:
            return "not_reached"
        if not lifted:
            return "not_grasped" if float(self.nearest[env, i]) < NEAR_M else "blocked"
        hands = self.world.state.link_pos_w[env, _HANDS]
        between = (self.world.state.object_pos_w[env, k] - hands.mean(0)).norm()
        return "timed_out" if float(between) < HELD_M else "dropped"


def tasks_fingerprint(tasks: list[Task]) -> str:
    """A hash of tasks, in their order."""
    text = "\n".join(json.dumps(t.to_dict(), sort_keys=True) for t in tasks)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def files_fingerprint(*paths: Path) -> str:
    """A hash of files, in the order given."""
    digest = hashlib.sha256()
    for path in paths:
        digest.update(path.name.encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]
