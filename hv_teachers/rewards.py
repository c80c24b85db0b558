"""What the teachers are rewarded for: Tables 6 and 7 of the paper (rearrange) and Algorithm 2 (release, step back).

Every term is a plain function over the whole batch and returns (N,). World frame, SI units. The saturations are
HumanVLA's practice, which the paper omits: without them a robot that has arrived is paid for walking about.
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


# Table 7


def robot2object_vel(x: RewardInputs, c: TaskRewardConfig) -> Tensor:
    """exp(-2 (v_t - v_r . d)^2), d horizontal toward the guide."""
    along = (x.root_vel[:, :2] * _direction(x.robot_guide - x.root_pos[:, :2])).sum(-1)
    return _or_one(torch.exp(-2.0 * (c.target_speed_m_s - along).square()), _approached(x, c))


def robot2object_pos(x: RewardInputs, c: TaskRewardConfig) -> Tensor:
    """exp(-0.5 |p_r - p_guide|^2), horizontal."""
    gap = (x.robot_guide - x.root_pos[:, :2]).square().sum(-1)
    return _or_one(torch.exp(-0.5 * gap), _approached(x, c))


def hand2object(x: RewardInputs, c: TaskRewardConfig) -> Tensor:
    """Mean over the hands of exp(-5 distance to the nearest point of the object)."""
    return _or_one(torch.exp(-5.0 * hand_distances_m(x)).mean(-1), at_goal(x, c))


def height(x: RewardInputs, c: TaskRewardConfig) -> Tensor:
    """(min(z, z_target) - z_start) / (z_target - z_start), not below 0; z_target is `lift_m` above start and goal."""
    start = x.object_start_height
    target = torch.maximum(start, x.goal_pos[:, 2]) + c.lift_m
    share = (torch.minimum(x.object_pos[:, 2], target) - start) / (target - start).clamp(min=1e-3)
    return _or_one(share.clamp(min=0.0), at_goal(x, c))


def object2goal_vel(x: RewardInputs, c: TaskRewardConfig) -> Tensor:
    """exp(-2 (v_t - v_o . d)^2), d horizontal toward the object's guide."""
    along = (x.object_vel[:, :2] * _direction(x.object_guide - x.object_pos[:, :2])).sum(-1)
    return _or_one(torch.exp(-2.0 * (c.object_target_speed_m_s - along).square()), at_goal(x, c))


def object2goal_pos_far(x: RewardInputs, c: TaskRewardConfig) -> Tensor:
    """exp(-|p_o - p_guide|), horizontal."""
    return _or_one(torch.exp(-(x.object_guide - x.object_pos[:, :2]).norm(dim=-1)), at_goal(x, c))


def object2goal_pos_near(x: RewardInputs, c: TaskRewardConfig) -> Tensor:
    """exp(-5 |p_o - p_g|)."""
    return torch.exp(-5.0 * x.object_goal_m)


def object2goal_rot(x: RewardInputs, c: TaskRewardConfig) -> Tensor:
    """exp(-2 angle between the object's rotation and the goal's)."""
    return torch.exp(-2.0 * rotation_angle_rad(x.object_rot, x.goal_rot))


TASK_TERMS = {
    term.__name__: term
    for term in (
        robot2object_vel,
        robot2object_pos,
        hand2object,
        height,
        object2goal_vel,
        object2goal_pos_far,
        object2goal_pos_near,
        object2goal_rot,
    )
}
"""Table 6: the terms of the rearrangement reward by name; `TaskRewardConfig` has the weight of each."""


def task_rewards(x: RewardInputs, config: TaskRewardConfig) -> dict[str, Tensor]:
    """The weighted terms of Table 6, (N,) each; their sum, equation (3), is between 0 and 1."""
    return {name: getattr(config, name) * term(x, config) for name, term in TASK_TERMS.items()}


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
            # the hand in the object's frame: one point to turn, not P
            dx, dy, dz = hands[i, k, 0] - pos[i, 0], hands[i, k, 1] - pos[i, 1], hands[i, k, 2] - pos[i, 2]
            x = rot[i, 0, 0] * dx + rot[i, 1, 0] * dy + rot[i, 2, 0] * dz
            y = rot[i, 0, 1] * dx + rot[i, 1, 1] * dy + rot[i, 2, 1] * dz
            z = rot[i, 0, 2] * dx + rot[i, 1, 2] * dy + rot[i, 2, 2] * dz
            nearest = np.float32(np.inf)
            for p in range(points.shape[1]):
                ahead, aside, above = points[i, p, 0] - x, points[i, p, 1] - y, points[i, p, 2] - z
                nearest = min(nearest, ahead * ahead + aside * aside + above * above)
            out[i, k] = math.sqrt(nearest)


def at_goal(x: RewardInputs, c: TaskRewardConfig) -> Tensor:
    """(N,) bool: the object is so near to its goal that nothing more is asked of the way there."""
    return x.object_goal_m < c.near_goal_m


def rotation_angle_rad(a: Tensor, b: Tensor) -> Tensor:
    """(N,) angle in [0, pi] between rotation matrices (N, 3, 3): the geodesic distance.

    By atan2 of sine and cosine: the arc cosine alone loses its digits near 0.
    """
    # of a.mT @ b: its trace, and what it has more on one side of the diagonal than on the other
    cosine = ((a * b).sum((-2, -1)) - 1.0) / 2.0
    axis = torch.linalg.cross(a, b).sum(-2)
    return torch.atan2(axis.norm(dim=-1) / 2.0, cosine)


def _approached(x: RewardInputs, c: TaskRewardConfig) -> Tensor:
    return (x.robot_object_m < c.near_object_m) | at_goal(x, c)


def _direction(vector: Tensor) -> Tensor:
    return vector / vector.norm(dim=-1, keepdim=True).clamp(min=1e-6)


def _or_one(reward: Tensor, saturated: Tensor) -> Tensor:
    return torch.where(saturated, 1.0, reward)


def _refuse_negative(config: object, where: str) -> None:
    for field in fields(config):  # type: ignore[arg-type]
        value = getattr(config, field.name)
        if not value >= 0:
            raise ValueError(f"{where}.{field.name}: {value!r} is not valid; valid: a number >= 0")
