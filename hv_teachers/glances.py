"""Pictures from random places of a room, with what is to be known about the task from there: food for the eyes.

An attempt at a task shows a room from the few ways that lead through it. A student that has lost its way, or looks for
something, sees it from everywhere. So besides attempts a dataset may hold glances: the robot stands somewhere, turned
and looking anywhere, and nothing is done. There are no actions to be learned from them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
import torch
from torch import Tensor

from hv_policy.belief.stands import WIDEST_M
from hv_policy.decision.memory import TaskMemory
from hv_policy.motor.reference import standing_pose
from hv_sim.humanoid import JOINT_NAMES, ROBOT_NQ
from hv_sim.paths import ROBOT_RADIUS_M
from hv_sim.scene import Scene
from hv_sim.task import Task
from hv_sim.world import RearrangeWorld, jittered_start
from hv_teachers.knowledge import Knowledge
from hv_teachers.routes import RouteViews

VIEWS_PER_PLACE = 3
GAZE_YAW_RAD, GAZE_PITCH_RAD = (-0.7, 0.7), (-0.1, 0.9)
_NECK_YAW, _NECK_PITCH = (7 + JOINT_NAMES.index(name) for name in ("neck_z", "neck_y"))
_MOVED_SHARE, _MOVED_M = 0.3, 0.15
_OTHER_SHARE = 0.2
"""So often something else takes the place of the object and its goal in what follows: to be near a thing, and to look
at it, must not mean that it is the one asked for."""
_NEAR_SHARE, _NEAR_M = 0.5, 1.5
"""So often the robot stands near the object or its goal."""
_FACING_SHARE, _FACING_RAD = 0.5, 0.9
"""So often it has the object or the goal about before it."""
BEGINNING_SHARE, _BEGINNING_M = 0.3, (0.5, 1.5)
"""So often the robot stands where it is told the sub-task: at the task's start, or so far from where it has just put
down the object before; and half of the time about as it is turned then."""
_WORKING_SHARE = 0.5
"""So often it is bent and has its hands somewhere before it."""
_HEIGHT_M, _PITCH_RAD = (0.5, 0.86), (0.0, 1.2)
_HANDS_LOW_M, _HANDS_HIGH_M = (0.15, 0.05, 0.2), (0.55, 0.35, 1.2)
LYING_SHARE, _LYING_M = 0.15, (0.4, 1.6)
"""So often, of other places, the object was dropped: it lies on its side on the floor, so far from the robot."""
_CARRYING_SHARE = 0.4
"""So often, but not in the first view from a place, it holds the object before it, which hides much of the room."""
_CARRIED_HEIGHT_M, _CARRIED_PITCH_RAD = (0.7, 0.84), (0.0, 0.3)
_CARRIED_AHEAD_M, _CARRIED_AT_M = (0.2, 0.3), (0.8, 1.1)
"""How far before the pelvis the object's near side is, and how high its middle."""


def glance_around(
    tasks: Sequence[Task],
    seeds: Sequence[int],
    glances: int,
    beginning_share: float = BEGINNING_SHARE,
    lying_share: float = LYING_SHARE,
) -> Iterator[tuple[RearrangeWorld, Knowledge]]:
    """Puts the robots of a world somewhere `glances` times, each time yielding the world and what is known there.

    Every sub-task has its turn, with the objects of those before it at their goals. A third of the time the objects
    stand a few centimetres from where they should; sometimes the sub-task's lies on its side on the floor, and in some
    views the robot has it in its hands.

    Args:
        tasks: one for each environment.
        seeds: likewise; they decide everything.
        glances: how many, a few of them from each place.
        beginning_share: how often the robot stands where it is told the sub-task.
        lying_share: how often, of the other places, the object was dropped near it.
    """
    world = RearrangeWorld(tasks, num_threads=1)
    world.reset(seeds=seeds)
    rngs = [np.random.default_rng([seed, 11]) for seed in seeds]
    free = [_free_places(scene) for scene in world.scenes]
    routes = RouteViews(world.num_envs)
    everyone = list(range(world.num_envs))
    for number in range(glances):
        if number % VIEWS_PER_PLACE == 0:
            shares = number / glances, beginning_share, lying_share
            places = [_place(world, env, rngs[env], free[env], *shares) for env in everyone]
        first = number % VIEWS_PER_PLACE == 0  # the routes begin where the object stands
        starts = [_turned(place, rng) for place, rng in zip(places, rngs, strict=True)]
        carried = [None if first else _carried(world, env, rngs[env]) for env in everyone]
        world.show(_postured(starts, carried, rngs), plan=first)
        routes.follow(world)
        view = routes.view(world)
        memory = TaskMemory.of(world.num_envs)
        knowledge = Knowledge.of(view, world.navigator.leg_is_done, memory.vector(view), memory.phase)
        yield world, knowledge


def _place(
    world: RearrangeWorld,
    env: int,
    rng: np.random.Generator,
    free: np.ndarray,
    share: float,
    beginning_share: float,
    lying_share: float,
) -> tuple[np.ndarray, np.ndarray]:
    """(nq,) the scene with the robot at a free place, at a sub-task that comes after a `share` of the glances; and
    (2,) the object's or the goal's place, m, world."""
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
    aim = (objects[int(scene.subtask_object[subtask]), :2], scene.goal_pos_w[subtask][:2])[rng.integers(2)].copy()
    if rng.uniform() < _OTHER_SHARE:
        aim = objects[rng.integers(len(objects)), :2].copy() if rng.uniform() < 0.5 else far[rng.integers(len(far))]
    if rng.uniform() < _NEAR_SHARE:
        near = far[np.linalg.norm(far - aim, axis=-1) < _NEAR_M]
        far = near if len(near) else far
    qpos[:2] = far[rng.integers(len(far))] + rng.uniform(-0.05, 0.05, 2)
    if rng.uniform() < beginning_share:
        return _beginning(scene, qpos, subtask, free, rng)
    if rng.uniform() < lying_share:
        around = _around(free, qpos[:2], _LYING_M)
        if len(around):
            row = int(scene.subtask_object[subtask])
            aim = around[rng.integers(len(around))]
            objects[row] = _lying(aim, scene.half_extents_m[row], rng)
    return qpos, aim


def _beginning(
    scene: Scene, qpos: np.ndarray, subtask: int, free: np.ndarray, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """As `_place`, with the robot where sub-task `subtask` begins."""
    if subtask == 0:
        qpos[:ROBOT_NQ] = jittered_start(scene, int(rng.integers(2**31)))[:ROBOT_NQ]
        yaw = 2 * np.arctan2(qpos[6], qpos[3])
        return qpos, qpos[:2] + np.array([np.cos(yaw), np.sin(yaw)])
    before = scene.goal_pos_w[subtask - 1][:2]
    around = _around(free, before, _BEGINNING_M)
    if len(around):
        qpos[:2] = around[rng.integers(len(around))] + rng.uniform(-0.05, 0.05, 2)
    return qpos, before.copy()


def _lying(xy_w: np.ndarray, half_extents_m: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """(7,) pose of a thing with half extents (3,) on the floor at (2,), fallen over to one of its four sides."""
    axis, turn = int(rng.integers(2)), rng.uniform(-np.pi, np.pi)
    fallen = np.sqrt(0.5) * np.array([1.0, *(np.eye(3)[axis] * rng.choice([-1.0, 1.0]))])
    lying = np.zeros(4)
    mujoco.mju_mulQuat(lying, _about_z(turn), fallen)
    return np.array([*xy_w, half_extents_m[1 - axis], *lying])


def _turned(place: tuple[np.ndarray, np.ndarray], rng: np.random.Generator) -> np.ndarray:
    """(nq,) the state of a `_place`, the robot turned and looking anywhere, or about to where it leads."""
    qpos, aim = place
    turned, yaw = qpos.copy(), rng.uniform(-np.pi, np.pi)
    if rng.uniform() < _FACING_SHARE:
        ahead = aim - qpos[:2]
        yaw = np.arctan2(ahead[1], ahead[0]) + rng.uniform(-_FACING_RAD, _FACING_RAD)
    turned[3:7] = _about_z(yaw)
    turned[_NECK_YAW], turned[_NECK_PITCH] = rng.uniform(*GAZE_YAW_RAD), rng.uniform(*GAZE_PITCH_RAD)
    return turned


@dataclass
class _Carried:
    """How a robot holds its object: heading frame."""

    row: int  # of the scene's objects
    at_m: np.ndarray  # (3,) its middle
    yaw_rad: float
    half_width_m: float  # between the hands
    height_m: float  # of the pelvis
    pitch_rad: float


def _carried(world: RearrangeWorld, env: int, rng: np.random.Generator) -> _Carried | None:
    """How environment `env` holds the object of its sub-task; mostly it does not, and never one that is too wide."""
    scene = world.scenes[env]
    row = int(scene.subtask_object[int(world.subtask_index[env])])
    quarter = int(rng.integers(2))
    depth, width = scene.half_extents_m[row, :2] if quarter == 0 else scene.half_extents_m[row, 1::-1]
    at = np.array([rng.uniform(*_CARRIED_AHEAD_M) + depth, 0.0, rng.uniform(*_CARRIED_AT_M)])
    yaw = quarter * np.pi / 2 + np.pi * int(rng.integers(2)) + rng.uniform(-0.1, 0.1)
    held = _Carried(row, at, yaw, width, rng.uniform(*_CARRIED_HEIGHT_M), rng.uniform(*_CARRIED_PITCH_RAD))
    return held if rng.uniform() < _CARRYING_SHARE and 2 * width < WIDEST_M else None


def _postured(
    states: Sequence[np.ndarray], carried: Sequence[_Carried | None], rngs: Sequence[np.random.Generator]
) -> list[np.ndarray]:
    """(nq,) each: the same, some of them with their object in their hands, some bent as if at work, so that a posture
    says nothing of where the object is."""
    drawn = []
    for held, rng in zip(carried, rngs, strict=True):
        works = (rng.uniform(*_HEIGHT_M), rng.uniform(*_PITCH_RAD), rng.uniform(_HANDS_LOW_M, _HANDS_HIGH_M, (2, 3)))
        holds = None if held is None else np.tile([held.at_m[0], held.half_width_m, held.at_m[2]], (2, 1))
        drawn.append(works if held is None else (held.height_m, held.pitch_rad, holds))
    height, pitch, hands = (torch.tensor(np.array(x), dtype=torch.float32) for x in zip(*drawn, strict=True))
    hands = hands * torch.tensor([[[1.0, -1.0, 1.0], [1.0, 1.0, 1.0]]])  # the right one is on the right
    joints, lean = (x.double().numpy() for x in standing_pose(height, pitch, hands))
    shown = []
    for env, (state, held, rng) in enumerate(zip(states, carried, rngs, strict=True)):
        state = state.copy()
        (w, _, _, z), c, s = state[3:7].copy(), np.cos(lean[env] / 2), np.sin(lean[env] / 2)
        if held is not None:
            cos, sin = w * w - z * z, 2 * w * z
            thing = state[ROBOT_NQ + 7 * held.row :][:7]
            x, y, thing[2] = held.at_m
            thing[:2] = state[0] + cos * x - sin * y, state[1] + sin * x + cos * y
            yaw = np.arctan2(sin, cos) + held.yaw_rad
            thing[3:] = _about_z(yaw)
        if rng.uniform() < _WORKING_SHARE or held is not None:
            neck = state[[_NECK_YAW, _NECK_PITCH]]
            state[7:ROBOT_NQ] = joints[env]
            state[[_NECK_YAW, _NECK_PITCH]] = neck
            state[2] = height[env]
            state[3:7] = w * c, -z * s, w * s, z * c  # turned about z, then leant about its own y
        shown.append(state)
    return shown


def _around(places: np.ndarray, middle: np.ndarray, range_m: tuple[float, float]) -> np.ndarray:
    """Those of places (P, 2) that are so far from a `middle` (2,)."""
    away = np.linalg.norm(places - middle, axis=-1)
    return places[(away > range_m[0]) & (away < range_m[1])]


def _free_places(scene: Scene) -> np.ndarray:
    """(P, 2) cells of the room where the robot has room to stand, m, world."""
    grid = scene.occupancy
    return grid.centers_m()[grid.clearance_m() > ROBOT_RADIUS_M].reshape(-1, 2)


def _quaternion(rotation: np.ndarray) -> np.ndarray:
    """(4,) of a rotation about z."""
    return _about_z(np.arctan2(rotation[1, 0], rotation[0, 0]))


def _about_z(yaw_rad: float) -> np.ndarray:
    """(4,) of a turn about z."""
    return np.array([np.cos(yaw_rad / 2), 0.0, 0.0, np.sin(yaw_rad / 2)])


def no_action(world: RearrangeWorld) -> tuple[Tensor, Tensor]:
    """Intents (N, 14) and joint targets (N, 28) of standing still."""
    return torch.zeros(world.num_envs, 14), torch.zeros(world.num_envs, 28)
