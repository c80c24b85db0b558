"""Pictures from random places of a room, with what is to be known about the task from there: food for the eyes.

An attempt at a task shows a room from the few ways that lead through it. A student that has lost its way, or looks for
something, sees it from everywhere. So besides attempts a dataset may hold glances: the robot stands somewhere, turned
and looking anywhere, and nothing is done. There are no actions to be learned from them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import torch
from torch import Tensor

from hv_policy.decision.memory import TaskMemory
from hv_sim.humanoid import JOINT_NAMES, ROBOT_NQ
from hv_sim.paths import ROBOT_RADIUS_M
from hv_sim.scene import Scene
from hv_sim.task import Task
from hv_sim.world import RearrangeWorld
from hv_teachers.knowledge import Knowledge
from hv_teachers.routes import RouteViews

VIEWS_PER_PLACE = 3
GAZE_YAW_RAD, GAZE_PITCH_RAD = (-0.7, 0.7), (-0.1, 0.9)
_NECK_YAW, _NECK_PITCH = (7 + JOINT_NAMES.index(name) for name in ("neck_z", "neck_y"))
_MOVED_SHARE, _MOVED_M = 0.3, 0.15


def glance_around(
    tasks: Sequence[Task], seeds: Sequence[int], glances: int
) -> Iterator[tuple[RearrangeWorld, Knowledge]]:
    """Puts the robots of a world somewhere `glances` times, each time yielding the world and what is known there.

    Every sub-task has its turn, with the objects of those before it at their goals. A third of the time the objects
    stand a few centimetres from where they should.

    Args:
        tasks: one for each environment.
        seeds: likewise; they decide everything.
        glances: how many, a few of them from each place.
    """
    world = RearrangeWorld(tasks, num_threads=1)
    world.reset(seeds=seeds)
    rngs = [np.random.default_rng([seed, 11]) for seed in seeds]
    free = [_free_places(scene) for scene in world.scenes]
    routes = RouteViews(world.num_envs)
    everyone = list(range(world.num_envs))
    for number in range(glances):
        if number % VIEWS_PER_PLACE == 0:
            places = [_place(world, env, rngs[env], free[env], number / glances) for env in everyone]
        starts = [_turned(qpos, rng) for qpos, rng in zip(places, rngs, strict=True)]
        world.show(starts, plan=number % VIEWS_PER_PLACE == 0)
        routes.follow(world)
        view = routes.view(world)
        memory = TaskMemory.of(world.num_envs)
        knowledge = Knowledge.of(view, world.navigator.leg_is_done, memory.vector(view), memory.phase)
        yield world, knowledge


def _place(world: RearrangeWorld, env: int, rng: np.random.Generator, free: np.ndarray, share: float) -> np.ndarray:
    """(nq,) the scene with the robot at a free place, at a sub-task that comes after a `share` of the glances."""
    scene, subtasks = world.scenes[env], len(world.tasks[env].subtasks)
    subtask = min(int(share * subtasks), subtasks - 1)
    world.instructor.num_finished[env] = subtask
    world.episode_seed[env] = int(rng.integers(2**31))  # another phrasing
    qpos = np.array(scene.initial_qpos, dtype=np.float64)
    objects = qpos[ROBOT_NQ:].reshape(-1, 7)
    for done in range(subtask):
        k = int(scene.subtask_object[done])
        objects[k, :3] = scene.goal_pos_w[done]
        objects[k, 3:] = _quaternion(scene.goal_rot_w[done])
    if rng.uniform() < _MOVED_SHARE:
        objects[:, :2] += rng.uniform(-_MOVED_M, _MOVED_M, (len(objects), 2))
    apart = np.linalg.norm(free[:, None] - objects[None, :, :2], axis=-1).min(1)
    far = free[apart > 0.4] if (apart > 0.4).any() else free
    qpos[:2] = far[rng.integers(len(far))] + rng.uniform(-0.05, 0.05, 2)
    return qpos


def _turned(qpos: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """(nq,) the same, the robot turned and looking anywhere."""
    turned, yaw = qpos.copy(), rng.uniform(-np.pi, np.pi)
    turned[3:7] = np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)
    turned[_NECK_YAW], turned[_NECK_PITCH] = rng.uniform(*GAZE_YAW_RAD), rng.uniform(*GAZE_PITCH_RAD)
    return turned


def _free_places(scene: Scene) -> np.ndarray:
    """(P, 2) cells of the room where the robot has room to stand, m, world."""
    grid = scene.occupancy
    return grid.centers_m()[grid.clearance_m() > ROBOT_RADIUS_M].reshape(-1, 2)


def _quaternion(rotation: np.ndarray) -> np.ndarray:
    """(4,) of a rotation about z."""
    yaw = np.arctan2(rotation[1, 0], rotation[0, 0])
    return np.array([np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)])


def no_action(world: RearrangeWorld) -> tuple[Tensor, Tensor]:
    """Intents (N, 14) and joint targets (N, 28) of standing still."""
    return torch.zeros(world.num_envs, 14), torch.zeros(world.num_envs, 28)
