"""The batched world: tasks -> scenes -> physics -> observations -> instructor -> routes.

Everything that decides an episode (its start, the instructions, the routes, its end) happens here, for all
environments at once; gymnasium, recorder, teachers and evaluation all stand on it.
"""

from __future__ import annotations

import functools
import json
from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor

from hv_sim.humanoid import NUM_JOINTS, ROBOT_NQ
from hv_sim.instructor import Instructor, InstructorConfig
from hv_sim.metrics import EpisodeRecord, is_fallen, summarize
from hv_sim.navigation import Navigator
from hv_sim.observations import (
    Heading,
    Observation,
    goal_observation,
    object_observation,
    proprioception,
    waypoint_observation,
)
from hv_sim.physics import PhysicsBackend, PhysicsState
from hv_sim.physics_backends import make_physics
from hv_sim.scene import Scene, compile_scene
from hv_sim.task import Task

STEPS_PER_SUBTASK = 1500
"""Default length of an episode: 50 s for each sub-task. A fetch, carry and retreat takes about 25 s; the longest ways
round the racks of a warehouse (15 m) take 15 s more."""

START_JITTER_M = 0.05
START_JITTER_RAD = np.radians(5.0)


class RearrangeWorld:
    """Many rearrangement episodes at once; the tasks may differ in room, objects and number of sub-tasks.

    An environment whose episode is over stands still until it is reset. The seed of `reset` and the task decide an
    episode completely: neither the other environments nor the number of threads matter.

    Args:
        tasks: one per environment; a task that appears several times is compiled once.
        instructor: thresholds of Algorithm 3.
        max_episode_steps: control steps before an episode is cut off (default: `STEPS_PER_SUBTASK` for each sub-task
            of the task that has most).
        num_threads: threads of the physics, 0 for one per core.
        physics: one of `hv_sim.physics_backends.BACKENDS`.

    Raises:
        ValueError: there is no task, `max_episode_steps` is below 1, or there is no such physics here.
        hv_sim.task.TaskError: a task is invalid.
    """

    def __init__(
        self,
        tasks: Sequence[Task],
        *,
        instructor: InstructorConfig | None = None,
        max_episode_steps: int | None = None,
        num_threads: int = 0,
        physics: str = "cpu",
    ) -> None:
        if not tasks:
            raise ValueError("tasks: empty; at least one task is needed")
        if max_episode_steps is not None and max_episode_steps < 1:
            raise ValueError(f"max_episode_steps: {max_episode_steps} is not valid; valid: an integer >= 1")
        self.tasks = list(tasks)
        self.num_envs = len(self.tasks)
        self.scenes = _compile_all(self.tasks)
        self.max_episode_steps = max_episode_steps or self.default_max_episode_steps(self.tasks)
        models = [scene.model for scene in self.scenes]
        self.physics: PhysicsBackend = make_physics(physics, models, num_threads=num_threads)
        num_subtasks = [len(task.subtasks) for task in self.tasks]
        self.instructor = Instructor(num_subtasks, instructor)
        self.navigator = Navigator(self.scenes)

        most = max(num_subtasks)
        self.subtask_exists = torch.arange(most) < self.instructor.num_subtasks[:, None]
        """(N, S) bool: environment has such a sub-task; S is the most that any has."""
        self.subtask_object = _pad([torch.as_tensor(s.subtask_object) for s in self.scenes], most).long()
        self.goal_pos_w = _pad([torch.as_tensor(s.goal_pos_w) for s in self.scenes], most).float()
        self.goal_rot_w = _pad([torch.as_tensor(s.goal_rot_w) for s in self.scenes], most).float()
        objects = self.physics.num_objects
        self._bps = _pad([torch.as_tensor(s.bps) for s in self.scenes], objects).float()
        self._half_extents = _pad([torch.as_tensor(s.half_extents_m) for s in self.scenes], objects).float()

        self._rows = torch.arange(self.num_envs)
        self._current: tuple[Tensor, Tensor, Tensor] | None = None
        self._shape_of = torch.full((self.num_envs,), -1)
        self._shape = self._bps[:, 0], self._half_extents[:, 0]
        self.episode_step = torch.zeros(self.num_envs, dtype=torch.int64)
        """(N,) control steps since the episode began."""
        self.fallen = torch.zeros(self.num_envs, dtype=torch.bool)
        """(N,) the robot has fallen at some time in this episode."""
        self.episode_seed: list[int | None] = [None] * self.num_envs
        self._episodes_begun = np.zeros(self.num_envs, dtype=np.int64)
        self._distance_at_instruction_m = torch.ones(self.num_envs)
        self.reset()

    @staticmethod
    def default_max_episode_steps(tasks: Sequence[Task]) -> int:
        """Length of an episode of these tasks when none is given."""
        return STEPS_PER_SUBTASK * max(len(task.subtasks) for task in tasks)

    # what is so now

    @property
    def state(self) -> PhysicsState:
        """The physical state after the last `step` or `reset`."""
        return self._state

    @property
    def heading(self) -> Heading:
        """The heading frames of that state."""
        return self._heading

    @property
    def subtask_index(self) -> Tensor:
        """(N,) sub-task whose instruction is in force."""
        return self.instructor.subtask_index

    @property
    def num_finished(self) -> Tensor:
        """(N,) sub-tasks that the instructor has accepted."""
        return self.instructor.num_finished

    @property
    def finished(self) -> Tensor:
        """(N,) bool: the instructor has accepted every sub-task."""
        return self.instructor.finished

    @property
    def done(self) -> Tensor:
        """(N,) bool: the episode is over, because everything is finished or because time is up."""
        return self.finished | (self.episode_step >= self.max_episode_steps)

    @property
    def object_index(self) -> Tensor:
        """(N,) object of the current sub-task."""
        index, objects = self.subtask_index, self.subtask_object
        if self._current is None or self._current[0] is not index or self._current[1] is not objects:
            self._current = index, objects, objects[self._rows, index]
        return self._current[2]

    def instructions(self) -> list[str]:
        """The instruction in force in each environment; the episode's seed picks one of its phrasings."""
        chosen = zip(self.tasks, self.subtask_index.tolist(), self.episode_seed, strict=True)
        return [pick_phrasing(task.subtasks[i].phrasings, seed or 0, i) for task, i, seed in chosen]

    def object_goal_distances_m(self) -> Tensor:
        """(N, S) distance of each sub-task's object from its goal, now; 0 where there is no such sub-task."""
        objects = self.state.object_pos_w[self._rows[:, None], self.subtask_object]
        return (objects - self.goal_pos_w).norm(dim=-1) * self.subtask_exists

    def progress(self) -> Tensor:
        """(N,) sub-tasks finished, plus how much of its way to the goal the current object has gone, in [0, 1)."""
        distance = self.object_goal_distances_m()[self._rows, self.subtask_index]
        fraction = (1 - distance / self._distance_at_instruction_m).clamp(0.0, 0.999)
        return self.num_finished + fraction * ~self.finished

    def room_bounds_xy_m(self, env: int) -> tuple[np.ndarray, np.ndarray]:
        """The room's lower and upper corner, (2,) each, m, world."""
        half = np.asarray(self.tasks[env].room.size_m) / 2
        return -half, half

    def places_xy_m(self, env: int) -> np.ndarray:
        """(P, 2) where things happen in an environment's task: robot start, objects, goals; m, world."""
        scene = self.scenes[env]
        objects = scene.initial_qpos[ROBOT_NQ:].reshape(-1, 7)[:, :2]
        return np.vstack([scene.initial_qpos[:2], objects, scene.goal_pos_w[:, :2]])

    # what happens

    def reset(self, ids: Sequence[int] | Tensor | None = None, seeds: Sequence[int] | None = None) -> None:
        """Begins episodes in environments `ids` (default: all).

        Args:
            ids: environments, (n,).
            seeds: one per environment in `ids`; each decides its episode. By default the environment's number and how
                many episodes it has begun.

        Raises:
            ValueError: the number of seeds differs from the number of environments.
        """
        chosen = list(range(self.num_envs)) if ids is None else [int(i) for i in ids]
        if not chosen:
            return
        if seeds is None:
            seeds = [int(i + self.num_envs * self._episodes_begun[i]) for i in chosen]
        if len(seeds) != len(chosen):
            raise ValueError(f"seeds: {len(seeds)} given for {len(chosen)} environments; valid: one each")
        starts = []
        for env, seed in zip(chosen, seeds, strict=True):
            starts.append(jittered_start(self.scenes[env], seed))
            self.episode_seed[env] = int(seed)
        self._episodes_begun[chosen] += 1
        self.physics.reset(chosen, starts)
        self.instructor.reset(chosen)
        self.episode_step[chosen] = 0
        self.fallen[chosen] = False
        self._look()
        self._begin_subtask(chosen)

    def show(self, qpos: Sequence[np.ndarray], *, plan: bool) -> None:
        """Puts every environment into a state, for pictures; no time passes, and it is no part of an episode.

        Args:
            qpos: (nq,) generalised position for each environment.
            plan: plan the routes of the present instructions anew from there.
        """
        everyone = list(range(self.num_envs))
        self.physics.reset(everyone, qpos)
        self._look()
        if plan:
            self._begin_subtask(everyone)
        else:
            self._walk_on()

    def step(self, joint_targets: Tensor) -> None:
        """One control step (1/30 s) with servo targets (N, 28) in radians; environments that are done stand still.

        Raises:
            ValueError: the targets have another shape.
        """
        if joint_targets.shape != (self.num_envs, NUM_JOINTS):
            shape, valid = tuple(joint_targets.shape), (self.num_envs, NUM_JOINTS)
            raise ValueError(f"joint_targets: shape {shape} is not valid; valid: {valid}")
        active = ~self.done
        if not active.any():
            return
        self.physics.step(joint_targets, None if active.all() else active.nonzero()[:, 0].numpy())
        self.episode_step += active
        self._look()
        self.fallen |= active & is_fallen(self.state)
        obj = self.object_index
        position = self.state.object_pos_w[self._rows, obj]
        switched = self.instructor.update(
            object_speed_m_s=self.state.object_lin_vel_w[self._rows, obj].norm(dim=-1),
            object_goal_distance_m=self.object_goal_distances_m()[self._rows, self.subtask_index],
            robot_object_distance_m=(position - self.state.link_pos_w[:, 0])[:, :2].norm(dim=-1),
            active=active,
        )
        replan = (switched & ~self.finished).nonzero()[:, 0].tolist()
        if replan:
            self._begin_subtask(replan)
        self._walk_on()

    def observe(self) -> Observation:
        """What the privileged policies see, for every environment."""
        index = self.subtask_index
        obj = self.object_index
        rows = self._rows
        if not torch.equal(obj, self._shape_of):  # 600 numbers an environment, and they seldom change
            self._shape, self._shape_of = (self._bps[rows, obj], self._half_extents[rows, obj]), obj
        return Observation(
            proprioception=proprioception(self.state, self._heading),
            object=object_observation(self.state, obj, self._heading),
            goal=goal_observation(self.goal_pos_w[rows, index], self.goal_rot_w[rows, index], self._heading),
            waypoint=waypoint_observation(self.navigator.current_waypoint, self._heading),
            bps=self._shape[0],
            half_extents=self._shape[1],
        )

    # what came of it

    def records(self, ids: Sequence[int] | Tensor | None = None) -> list[EpisodeRecord]:
        """How the episodes of environments `ids` (default: all) stand, or ended."""
        chosen = range(self.num_envs) if ids is None else [int(i) for i in ids]
        distances = self.object_goal_distances_m()
        return [
            EpisodeRecord(
                task=self.tasks[i].name,
                seed=int(self.episode_seed[i] or 0),
                distances_m=tuple(distances[i, : len(self.tasks[i].subtasks)].tolist()),
                fallen=bool(self.fallen[i]),
                num_finished=int(self.num_finished[i]),
                num_steps=int(self.episode_step[i]),
            )
            for i in chosen
        ]

    def metrics(self) -> dict:
        """The metrics over every environment's present episode (`hv_sim.metrics.summarize`)."""
        return summarize(self.records())

    # inside

    def _look(self) -> None:
        self._state = self.physics.state()
        self._heading = Heading.of(self._state)

    def _begin_subtask(self, ids: list[int]) -> None:
        """Plans the routes of a new instruction from where the robot and the objects now are."""
        index = self.subtask_index
        distances = self.object_goal_distances_m()[self._rows, index]
        self._distance_at_instruction_m[ids] = distances[ids].clamp(min=0.4)
        state = self.state
        self.navigator.plan(ids, index, state.link_pos_w[:, 0], state.object_pos_w, state.object_rot_w)
        self._walk_on()

    def _walk_on(self) -> None:
        self.navigator.update(self.state.link_pos_w[:, 0], self.state.object_pos_w[self._rows, self.object_index])


@functools.lru_cache(maxsize=4096)
def pick_phrasing(phrasings: tuple[str, ...], seed: int, subtask: int) -> str:
    """One of the ways to say an instruction, the same one for the same seed and number of the sub-task."""
    if len(phrasings) == 1:
        return phrasings[0]
    return phrasings[int(np.random.default_rng([seed, subtask]).integers(len(phrasings)))]


def jittered_start(scene: Scene, seed: int) -> np.ndarray:
    """(nq,) the scene's initial position, the robot moved by up to 5 cm along x and y and turned by up to 5 degrees."""
    rng = np.random.default_rng(seed)
    shift = rng.uniform(-START_JITTER_M, START_JITTER_M, size=2)
    turn = rng.uniform(-START_JITTER_RAD, START_JITTER_RAD)
    qpos = np.array(scene.initial_qpos, dtype=np.float64)
    qpos[:2] += shift
    w, x, y, z = qpos[3:7]
    c, s = np.cos(turn / 2), np.sin(turn / 2)
    qpos[3:7] = c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w  # (c, 0, 0, s) times (w, x, y, z)
    return qpos


def _compile_all(tasks: Sequence[Task]) -> list[Scene]:
    compiled: dict[str, Scene] = {}
    scenes = []
    for task in tasks:
        key = json.dumps(task.to_dict(), sort_keys=True)
        if key not in compiled:
            compiled[key] = compile_scene(task)
        scenes.append(compiled[key])
    return scenes


def _pad(rows: Sequence[Tensor], length: int) -> Tensor:
    """Stacks tensors (n_i, ...) as (N, length, ...), zeros behind."""
    out = rows[0].new_zeros(len(rows), length, *rows[0].shape[1:])
    for i, row in enumerate(rows):
        out[i, : len(row)] = row
    return out
