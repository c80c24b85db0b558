"""What the teachers are rewarded for: Tables 6 and 7 of the paper (rearrange) and Algorithm 2 (release, step back).

Over the whole batch, (N,) each. World frame, SI units. The saturations are HumanVLA's practice, which the paper omits:
without them a robot that has arrived is paid for walking about.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import cached_property

import numba
import numpy as np
import torch
from torch import Tensor

from hv_policy.motor import embodiment as body
from hv_policy.motor.kinematics import Array, as_arrays
from hv_sim.basis_point_set import BASIS_POINTS
from hv_sim.world import RearrangeWorld


@dataclass(frozen=True)
class TaskRewardConfig:
    """Weights of Table 6, which sum to 1, and the distances at which terms saturate.

    Raises:
        ValueError: a value is negative.
    """

    robot2object_vel: float = 0.1
    robot2object_pos: float = 0.1
    hand2object: float = 0.1
    height: float = 0.1
    object2goal_vel: float = 0.2
    object2goal_pos_far: float = 0.2
    object2goal_pos_near: float = 0.1
    object2goal_rot: float = 0.1
    target_speed_m_s: float = 1.5
    """v_t of Table 7, the robot's; the paper's value."""
    object_target_speed_m_s: float = 1.5
    """v_o^target of Table 7."""
    near_object_m: float = 0.5
    """Nearer than this (horizontally) the robot need not approach the object any more."""
    near_goal_m: float = 0.3
    """Nearer than this to its goal the object need not be approached, touched, lifted or hurried any more."""
    lift_m: float = 0.1
    """How far above the higher of start and goal the object shall be carried."""

    def __post_init__(self) -> None:
        _refuse_negative(self, "reward")


@dataclass(frozen=True)
class RetreatRewardConfig:
    """Algorithm 2. The paper names the threshold of line 9 but does not give it; ours is the instructor's.

    Raises:
        ValueError: a value is negative.
    """

    robot2object: float = 0.5
    hand2object: float = 0.5
    robot_object_m: float = 1.0
    hand_object_m: float = 0.5
    object_goal_m: float = 0.4

    def __post_init__(self) -> None:
        _refuse_negative(self, "retreat_reward")


@dataclass
class RewardInputs:
    """What the rewards look at, one row per environment."""

    root_pos: Tensor  # (N, 3) pelvis
    root_vel: Tensor  # (N, 3)
    hands: Tensor  # (N, 2, 3) right, left
    object_pos: Tensor  # (N, 3)
    object_rot: Tensor  # (N, 3, 3)
    object_vel: Tensor  # (N, 3)
    object_points: Tensor  # (N, P, 3) on the object's surface, object frame
    object_start_height: Tensor  # (N,) of its centre, when the instruction was given
    goal_pos: Tensor  # (N, 3)
    goal_rot: Tensor  # (N, 3, 3)
    robot_guide: Tensor  # (N, 2) where the robot should walk to: a waypoint before the object, then the object
    object_guide: Tensor  # (N, 2) where the object should go: a waypoint before the goal, then the goal

    @cached_property
    def object_goal_m(self) -> Tensor:
        """(N,) how far the object is from its goal: half of the terms ask."""
        return (self.object_pos - self.goal_pos).norm(dim=-1)

    @cached_property
    def robot_object_m(self) -> Tensor:
        """(N,) how far the pelvis is from the object, horizontally."""
        return (self.root_pos - self.object_pos)[:, :2].norm(dim=-1)


def surface_points(bps: Tensor, half_extents: Tensor) -> Tensor:
    """(N, 200, 3) points on the objects' surfaces, m, object frame, from basis point sets (N, 200, 3) in the unit ball.

    A basis point set has lost the size; the half-extents (N, 3) give it back, because some point lies on each face.
    """
    unit = bps + torch.tensor(BASIS_POINTS, dtype=bps.dtype, device=bps.device)
    reach = unit.abs().amax(1).clamp(min=1e-6)
    scale = (half_extents / reach).amin(-1)
    return unit * scale[:, None, None]


def read_world(world: RearrangeWorld, object_points: Tensor, object_start_height: Tensor) -> RewardInputs:
    """What the rewards look at, from a world's present state.

    Args:
        world: the world.
        object_points: (N, P, 3) on the current objects' surfaces, object frame.
        object_start_height: (N,) height of the current object's centre when its instruction was given.
    """
    state = world.state
    rows = torch.arange(world.num_envs)
    index = world.object_index
    position, rotation = state.object_pos_w[rows, index], state.object_rot_w[rows, index]
    goal = world.goal_pos_w[rows, world.subtask_index]
    waypoint = world.navigator.current_waypoint[:, :2]
    carrying, last = world.navigator.picked_up, world.navigator.leg_is_done
    before_object, before_goal = ~carrying & ~last, carrying & ~last
    return RewardInputs(
        root_pos=state.link_pos_w[:, body.PELVIS],
        root_vel=state.link_lin_vel_w[:, body.PELVIS],
        hands=state.link_pos_w[:, body.HANDS],
        object_pos=position,
        object_rot=rotation,
        object_vel=state.object_lin_vel_w[rows, index],
        object_points=object_points,
        object_start_height=object_start_height,
        goal_pos=goal,
        goal_rot=world.goal_rot_w[rows, world.subtask_index],
        robot_guide=torch.where(before_object[:, None], waypoint, position[:, :2]),
        object_guide=torch.where(before_goal[:, None], waypoint, goal[:, :2]),
    )


TASK_TERMS = {
    "robot2object_vel": "exp(-2 (v_t - v_r . d)^2), d horizontal from the robot to its guide; 1 near the object",
    "robot2object_pos": "exp(-0.5 |p_r - p_guide|^2), horizontal; 1 near the object",
    "hand2object": "mean over the hands of exp(-5 distance to the nearest point of the object); 1 near the goal",
    "height": "(min(z, z_target) - z_start) / (z_target - z_start), not below 0; 1 near the goal",
    "object2goal_vel": "exp(-2 (v_t - v_o . d)^2), d horizontal from the object to its guide; 1 near the goal",
    "object2goal_pos_far": "exp(-|p_o - p_guide|), horizontal; 1 near the goal",
    "object2goal_pos_near": "exp(-5 |p_o - p_g|)",
    "object2goal_rot": "exp(-2 angle between the object's rotation and the goal's)",
}
"""Table 7: the terms of the rearrangement reward; `TaskRewardConfig` has the weight of each (Table 6). Near the object:
`near_object_m`, or near the goal; near the goal: `near_goal_m`; z_target is `lift_m` above start and goal."""


def task_terms(x: RewardInputs, c: TaskRewardConfig) -> dict[str, Tensor]:
    """(N,) each of `TASK_TERMS`, without its weight."""
    out = torch.empty(len(TASK_TERMS), len(x.root_pos))
    robot = x.root_pos, x.root_vel, x.hands, x.robot_guide
    thing = x.object_pos, x.object_rot, x.object_vel, x.object_points, x.object_start_height, x.object_guide
    arrays = as_arrays(*(value.float() for value in (*robot, *thing, x.goal_pos, x.goal_rot)))
    limits = (c.target_speed_m_s, c.object_target_speed_m_s, c.near_object_m, c.near_goal_m, c.lift_m)
    _fill_terms(out.numpy(), *arrays, limits)
    return dict(zip(TASK_TERMS, out.to(x.root_pos), strict=True))


def task_rewards(x: RewardInputs, config: TaskRewardConfig) -> dict[str, Tensor]:
    """The weighted terms of Table 6, (N,) each; their sum, equation (3), is between 0 and 1."""
    return {name: getattr(config, name) * term for name, term in task_terms(x, config).items()}


@numba.njit(cache=True)
def _speed_toward(velocity: Array, here: Array, there: Array) -> float:
    """Horizontal speed along the way from a point to another."""
    x, y = np.float64(there[0]) - here[0], np.float64(there[1]) - here[1]
    return (velocity[0] * x + velocity[1] * y) / max(math.hypot(x, y), 1e-6)


@numba.njit(cache=True)
def _fill_terms(
    out: Array,
    root: Array,
    root_vel: Array,
    hands: Array,
    robot_guide: Array,
    obj: Array,
    rot: Array,
    vel: Array,
    points: Array,
    start: Array,
    object_guide: Array,
    goal: Array,
    goal_rot: Array,
    limits: tuple[float, float, float, float, float],
) -> None:
    """`task_terms` (8, N), robot by robot."""
    speed, object_speed, near_object_m, near_goal_m, lift_m = limits
    for i in range(len(root)):
        x, y, z = np.float64(obj[i, 0]), np.float64(obj[i, 1]), np.float64(obj[i, 2])
        left_m = math.sqrt((x - goal[i, 0]) ** 2 + (y - goal[i, 1]) ** 2 + (z - goal[i, 2]) ** 2)
        placed = left_m < near_goal_m
        out[:6, i] = 1.0
        if not placed and math.hypot(x - root[i, 0], y - root[i, 1]) >= near_object_m:
            out[0, i] = math.exp(-2.0 * (speed - _speed_toward(root_vel[i], root[i], robot_guide[i])) ** 2)
            gap = (np.float64(robot_guide[i, 0]) - root[i, 0]) ** 2 + (np.float64(robot_guide[i, 1]) - root[i, 1]) ** 2
            out[1, i] = math.exp(-0.5 * gap)
        if not placed:
            right = _hand_distance_m(hands[i, 0], obj[i], rot[i], points[i])
            left = _hand_distance_m(hands[i, 1], obj[i], rot[i], points[i])
            out[2, i] = (math.exp(-5.0 * right) + math.exp(-5.0 * left)) / 2
            target = max(np.float64(start[i]), np.float64(goal[i, 2])) + lift_m
            out[3, i] = max(0.0, (min(z, target) - start[i]) / max(target - start[i], 1e-3))
            pushed = _speed_toward(vel[i], obj[i], object_guide[i])
            out[4, i] = math.exp(-2.0 * (object_speed - pushed) ** 2)
            out[5, i] = math.exp(-math.hypot(object_guide[i, 0] - x, object_guide[i, 1] - y))
        out[6, i] = math.exp(-5.0 * left_m)
        out[7, i] = math.exp(-2.0 * _rotation_angle_rad(rot[i], goal_rot[i]))


def retreat_rewards(x: RewardInputs, config: RetreatRewardConfig) -> dict[str, Tensor]:
    """The two weighted terms of Algorithm 2, (N,) each: let go, step back, leave the object where it is wanted.

    The robot's distance is horizontal, as the instructor measures it: a torso is a metre above a thing on the floor
    without having left it.
    """
    robot = x.robot_object_m
    hand = hand_distances_m(x).amin(-1)
    robot_term = _or_one(1.0 - torch.exp(-0.5 * robot), robot > config.robot_object_m)
    hand_term = _or_one(1.0 - torch.exp(-0.5 * hand), hand > config.hand_object_m)
    placed = (x.object_goal_m < config.object_goal_m).to(robot.dtype)
    return {
        "retreat_robot2object": config.robot2object * robot_term * placed,
        "retreat_hand2object": config.hand2object * hand_term * placed,
    }


# distances


def hand_distances_m(x: RewardInputs) -> Tensor:
    """(N, 2) of each hand's centre from the nearest point of the object."""
    distances = torch.empty(len(x.hands), 2)
    inputs = (value.float() for value in (x.hands, x.object_pos, x.object_rot, x.object_points))
    _fill_hand_distances(distances.numpy(), *as_arrays(*inputs))
    return distances.to(x.hands)


@numba.njit(cache=True)
def _fill_hand_distances(out: Array, hands: Array, pos: Array, rot: Array, points: Array) -> None:
    """`hand_distances_m` of hands (N, 2, 3), objects at (N, 3), turned by (N, 3, 3), and their points (N, P, 3)."""
    for i in range(len(out)):
        for k in range(2):
            out[i, k] = _hand_distance_m(hands[i, k], pos[i], rot[i], points[i])


@numba.njit(cache=True)
def _hand_distance_m(hand: Array, pos: Array, rot: Array, points: Array) -> float:
    """How far a hand (3,) is from the nearest of an object's points (P, 3), which are in its frame."""
    dx, dy, dz = hand[0] - pos[0], hand[1] - pos[1], hand[2] - pos[2]  # one point to turn, not P
    x = rot[0, 0] * dx + rot[1, 0] * dy + rot[2, 0] * dz
    y = rot[0, 1] * dx + rot[1, 1] * dy + rot[2, 1] * dz
    z = rot[0, 2] * dx + rot[1, 2] * dy + rot[2, 2] * dz
    nearest = np.float32(np.inf)
    for p in range(len(points)):
        ahead, aside, above = points[p, 0] - x, points[p, 1] - y, points[p, 2] - z
        nearest = min(nearest, ahead * ahead + aside * aside + above * above)
    return math.sqrt(nearest)


@numba.njit(cache=True)
def _rotation_angle_rad(a: Array, b: Array) -> float:
    """Angle in [0, pi] between rotation matrices (3, 3): the geodesic distance.

    By atan2 of sine and cosine: the arc cosine alone loses its digits near 0.
    """
    # of a.T @ b: its trace, and what it has more on one side of the diagonal than on the other
    trace, x, y, z = 0.0, 0.0, 0.0, 0.0
    for k in range(3):
        trace += np.float64(a[k, 0]) * b[k, 0] + np.float64(a[k, 1]) * b[k, 1] + np.float64(a[k, 2]) * b[k, 2]
        x += np.float64(a[k, 1]) * b[k, 2] - np.float64(a[k, 2]) * b[k, 1]
        y += np.float64(a[k, 2]) * b[k, 0] - np.float64(a[k, 0]) * b[k, 2]
        z += np.float64(a[k, 0]) * b[k, 1] - np.float64(a[k, 1]) * b[k, 0]
    return math.atan2(math.sqrt(x * x + y * y + z * z) / 2, (trace - 1) / 2)


def _or_one(reward: Tensor, saturated: Tensor) -> Tensor:
    return torch.where(saturated, 1.0, reward)


def _refuse_negative(config: object, where: str) -> None:
    for field in fields(config):  # type: ignore[arg-type]
        value = getattr(config, field.name)
        if not value >= 0:
            raise ValueError(f"{where}.{field.name}: {value!r} is not valid; valid: a number >= 0")
