"""One episode of an evaluation, alone in its world, so that nothing else can change its result."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import torch
from torch import Tensor

from hv_sim.metrics import EpisodeRecord
from hv_sim.rearrange_env import RearrangeEnv
from hv_sim.task import Task, built_object
from hv_sim.world import RearrangeWorld

LIFTED_M = 0.08
PLACED_M = 0.4
FAILURES = ("fell", "not_reached", "never_lifted", "misplaced")
"""Why a sub-task failed: the robot fell while it was in force or before; its instruction was never given; its object
was never lifted; it was, and ended somewhere else."""


class EvaluatedPolicy(Protocol):
    """What is evaluated. It acts for one environment; `reset` comes before each episode."""

    sees: bool
    """It needs the camera."""

    def reset(self) -> None:
        """Forgets the last episode."""

    def __call__(self, env: RearrangeEnv, observation: dict[str, Any] | None) -> Tensor:
        """(1, 28) servo targets in rad; the observation is None for one that does not see."""

    def fingerprint(self) -> str:
        """A hash of everything that decides what it does."""


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


def run_episode(
    task: Task,
    repeat: int,
    seed: int,
    policy: EvaluatedPolicy,
    max_episode_steps: int | None = None,
    on_frame: Callable[[np.ndarray], None] | None = None,
    frame_stride: int = 2,
) -> EpisodeOutcome:
    """Plays an episode to its end.

    Args:
        task: what is to be done.
        repeat: its number, for the record.
        seed: decides the episode together with the task.
        policy: who acts.
        max_episode_steps: control steps before it is cut off (default: the world's).
        on_frame: is given a picture of the episode every `frame_stride` steps.
    """
    env = RearrangeEnv(task, max_episode_steps=max_episode_steps)
    try:
        observation = env.reset(seed=seed)[0] if policy.sees or on_frame else None
        if observation is None:
            env.world.reset(seeds=[seed])
        policy.reset()
        world = env.world
        watch = _Watch(world)
        with torch.no_grad():
            while not bool(world.done[0]):
                if on_frame and int(world.episode_step[0]) % frame_stride == 0:
                    frame = env.render()
                    assert frame is not None
                    on_frame(frame)
                targets = policy(env, observation)
                if observation is None:
                    world.step(targets)
                else:
                    observation = env.step(targets[0].numpy())[0]
                watch.look()
        return EpisodeOutcome(world.records()[0], repeat, task.room.kind, watch.outcomes())
    finally:
        env.close()


class _Watch:
    """Notes when sub-tasks are finished, what was lifted, and when the robot fell."""

    def __init__(self, world: RearrangeWorld) -> None:
        self.world, self.task = world, world.tasks[0]
        self.finished_at: list[int] = []
        self.start = world.state.object_pos_w[0].clone()
        self.rose = torch.zeros(len(self.start))
        self.fell_during: int | None = None

    def look(self) -> None:
        world = self.world
        self.rose = torch.maximum(self.rose, world.state.object_pos_w[0, :, 2] - self.start[:, 2])
        while len(self.finished_at) < int(world.num_finished[0]):
            self.finished_at.append(int(world.episode_step[0]))
        if self.fell_during is None and bool(world.fallen[0]):
            self.fell_during = int(world.subtask_index[0])

    def outcomes(self) -> tuple[SubTaskOutcome, ...]:
        distances = self.world.object_goal_distances_m()[0].tolist()
        names = [o.name for o in self.task.objects]
        starts = {o.name: o.position_m for o in self.task.objects}
        found = []
        for i, subtask in enumerate(self.task.subtasks):
            k = names.index(subtask.object)
            placed = self.task.objects[k]
            built = built_object(placed)
            start, half = starts[subtask.object], float(built.half_extents_m[2])
            lifted = float(self.rose[k]) > LIFTED_M
            begun = 0 if i == 0 else self.finished_at[i - 1] if i <= len(self.finished_at) else None
            done = self.finished_at[i] if i < len(self.finished_at) else None
            found.append(
                SubTaskOutcome(
                    object_kind=placed.kind,
                    mass_kg=built.mass_kg,
                    way_m=round(float(np.hypot(*np.subtract(subtask.goal_position_m, start)[:2])), 4),
                    from_height_m=round(float(start[2]) - half, 4),
                    to_height_m=round(float(subtask.goal_position_m[2]) - half, 4),
                    distance_m=distances[i],
                    seconds=None if done is None or begun is None else (done - begun) / 30.0,
                    lifted=lifted,
                    failure=self._failure(i, distances[i], lifted, begun is not None),
                )
            )
            starts[subtask.object] = subtask.goal_position_m
        return tuple(found)

    def _failure(self, i: int, distance_m: float, lifted: bool, was_told: bool) -> str:
        if distance_m < PLACED_M:
            return ""
        if self.fell_during is not None and self.fell_during <= i:
            return "fell"
        if not was_told:
            return "not_reached"
        return "misplaced" if lifted else "never_lifted"


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
