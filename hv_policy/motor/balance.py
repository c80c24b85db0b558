"""Virtual model control: the wrench that would pull the pelvis onto its reference, exerted through the standing legs.

tau = -J_leg^T f for each foot's share of the wrench (Pratt et al., "Virtual Model Control", 2001), added to the servo
targets as tau / kp. The horizontal force follows from what the sole can carry: a foot that may not tip can only push as
hard as its ankle torque and the lean of the leg allow.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from hv_policy.motor import embodiment as body
from hv_policy.motor.kinematics import euler_angles, leg_axes
from hv_policy.motor.proprioception import BodyState
from hv_policy.motor.reference import Reference, ReferenceState, loaded_com


@dataclass(frozen=True)
class BalanceConfig:
    """Stiffness, damping and limits of the virtual wrench (N/m, N s/m, N m/rad, N m s/rad, N, N m)."""

    position_gain: float = 1500.0
    velocity_gain: float = 250.0
    rotation_gain: float = 500.0
    rotation_damping: float = 50.0
    stepping_share: float = 0.5
    """What is left of the rotation's stiffness while stepping: one leg's worth of inertia rings at 30 Hz with more."""
    force_limit: float = 250.0
    moment_limit: float = 120.0
    sole_toe_m: float = 0.11
    sole_heel_m: float = 0.035
    sole_half_width_m: float = 0.035
    sole_yaw_limit: float = 15.0
    squeeze_force: float = 190.0
    grounded_mass_kg: float = 5.0
    load_gain: float = 0.25
    unload_gain: float = 0.02
    release_gain: float = 0.25
    """Share of the difference that the estimate of the load rises, falls while squeezing, and falls after that, by in a
    step."""
    load_limit: float = 110.0


def leg_torques(state: BodyState, reference: Reference, load: Tensor, config: BalanceConfig) -> Tensor:
    """(N, 2, 7) joint torques of the legs in N m, right then left; `load` (N,) is the weight held in N."""
    pelvis = state.pos[:, body.PELVIS]
    rotation = state.rot[:, body.PELVIS]
    wanted_velocity = torch.cat([reference.velocity[:, :2], torch.zeros_like(pelvis[:, :1])], -1)
    force = config.position_gain * (reference.pelvis_pos - pelvis)
    force = force + config.velocity_gain * (wanted_velocity - state.lin_vel[:, body.PELVIS])
    force = force.clamp(-config.force_limit, config.force_limit)
    weight = (body.TOTAL_MASS_KG - config.grounded_mass_kg) * body.GRAVITY
    weight = weight + load
    force = torch.cat([force[:, :2], force[:, 2:] + weight[:, None]], -1)
    error = reference.pelvis_rot @ rotation.mT
    turn = 0.5 * torch.stack(
        [error[:, 2, 1] - error[:, 1, 2], error[:, 0, 2] - error[:, 2, 0], error[:, 1, 0] - error[:, 0, 1]], -1
    )
    spin = -state.ang_vel[:, body.PELVIS]
    spin = torch.cat([spin[:, :2], spin[:, 2:] + reference.velocity[:, 2:]], -1)
    share = 1.0 - (1.0 - config.stepping_share) * reference.moving[:, None]
    moment = (config.rotation_gain * turn + config.rotation_damping * spin) * share
    moment = moment.clamp(-config.moment_limit, config.moment_limit)
    # gravity acts at the centre of mass, the wrench at the pelvis
    lever = loaded_com(state, load) - pelvis
    moment = moment + torch.stack([lever[:, 1], -lever[:, 0], torch.zeros_like(weight)], -1) * weight[:, None]

    feet = state.pos[:, body.FEET]
    share = _load_share(reference.stance, feet, pelvis, force, moment)
    foot_force = force[:, None] * share[..., None]
    foot_moment = moment[:, None] * share[..., None]
    arm = pelvis[:, None] - feet
    sole = foot_moment + torch.linalg.cross(arm, foot_force)
    # ankle moments the sole can carry, and the horizontal force that is then left (row by row of M + r x F)
    load = foot_force[..., 2].clamp(min=0.0)
    pitch = torch.minimum(torch.maximum(sole[..., 1], -config.sole_toe_m * load), config.sole_heel_m * load)
    roll = torch.minimum(torch.maximum(sole[..., 0], -config.sole_half_width_m * load), config.sole_half_width_m * load)
    height = arm[..., 2].clamp(min=0.3)
    fx = foot_force[..., 0] + (pitch - sole[..., 1]) / height
    fy = foot_force[..., 1] - (roll - sole[..., 0]) / height
    foot_force = torch.stack([fx, fy, foot_force[..., 2]], -1)

    axes = leg_axes(rotation, state.rot[:, body.THIGHS], state.rot[:, body.SHINS], state.rot[:, body.FEET])
    origins = torch.stack([state.pos[:, body.THIGHS]] * 3 + [state.pos[:, body.SHINS]] + [feet] * 3, -2)
    # moment that the leg above a joint must transmit about it: the pelvis wrench carried down to the joint
    lever_arm = pelvis[:, None, None] - origins
    about = foot_moment[:, :, None] + torch.linalg.cross(lever_arm, foot_force[:, :, None].expand_as(lever_arm))
    torques = -(axes * about).sum(-1)
    yaw = torques[..., 6:].clamp(-config.sole_yaw_limit, config.sole_yaw_limit)
    return torch.cat([torques[..., :6], yaw], -1)


def _load_share(stance: Tensor, feet: Tensor, pelvis: Tensor, force: Tensor, moment: Tensor) -> Tensor:
    """(N, 2) share of the wrench that each foot bears: where the wanted centre of pressure lies between them."""
    weight = force[:, 2].clamp(min=50.0)
    height = pelvis[:, 2] - body.ANKLE_HEIGHT_M
    x = pelvis[:, 0] - (moment[:, 1] + height * force[:, 0]) / weight
    y = pelvis[:, 1] + (moment[:, 0] - height * force[:, 1]) / weight
    line = feet[:, 1, :2] - feet[:, 0, :2]
    along = ((torch.stack([x, y], -1) - feet[:, 0, :2]) * line).sum(-1) / line.square().sum(-1).clamp(min=1e-3)
    along = along.clamp(0.04, 0.96)
    share = stance * torch.stack([1 - along, along], -1)
    return share / share.sum(-1, keepdim=True).clamp(min=1e-6)


def arm_torques(state: BodyState, squeeze: Tensor, load: Tensor, config: BalanceConfig) -> Tensor:
    """(N, 2, 4) arm torques in N m that bear the arms' weight and the load (N,) in N, and press the hands together."""
    hand = state.pos[:, body.HANDS]
    axes, origins = _arm_axes(state)
    between = hand[:, 1] - hand[:, 0]
    between = between / between.norm(dim=-1, keepdim=True).clamp(min=0.05)
    force = torch.stack([between, -between], 1) * (config.squeeze_force * squeeze)[:, None, None]
    force = force + 0.5 * load[:, None, None] * force.new_tensor([0.0, 0.0, 1.0])
    return _arm_weight(state, axes, origins) + _torque(axes, origins, hand, force)


def measured_arm_angles(state: BodyState, near: Tensor) -> Tensor:
    """(N, 2, 4) shoulder xyz and elbow in rad; of the two ways to turn a shoulder there, the one nearer to `near`."""
    upper, lower = state.rot[:, body.UPPER_ARMS], state.rot[:, body.LOWER_ARMS]
    first = euler_angles(state.rot[:, body.TORSO][:, None].mT @ upper)
    second = torch.stack([first[..., 0] + torch.pi, torch.pi - first[..., 1], first[..., 2] + torch.pi], -1)
    options = torch.stack([first, second], 0)
    options = near[..., :3] + torch.remainder(options - near[..., :3] + torch.pi, 2 * torch.pi) - torch.pi
    nearer = (options - near[..., :3]).abs().sum(-1).argmin(0)
    shoulder = torch.where((nearer == 0)[..., None], options[0], options[1])
    bend = upper.mT @ lower
    return torch.cat([shoulder, torch.atan2(bend[..., 0, 2], bend[..., 0, 0])[..., None]], -1)


def estimate_load(state: BodyState, memory: ReferenceState, config: BalanceConfig) -> Tensor:
    """(N,) weight between the hands in N, from what the arms' servos exert beyond the arms' own weight.

    Each hand's force, up and sideways, is the least-squares solution of J^T f = tau over the arm's joints, with
    tau = kp (target - q) - kd dq less the arm's weight. Filtered, and only while the hands squeeze. Updates
    `memory.load` and `memory.arm_angles`.
    """
    angles = measured_arm_angles(state, memory.arm_angles)
    kp = torch.stack([body.KP[j] for j in body.ARM_JOINTS]).to(angles)
    speed = (angles - memory.arm_angles) / body.CONTROL_DT_S
    exerted = kp * (memory.arm_targets - angles) - body.DAMPING_TIME_S * kp * speed
    axes, origins = _arm_axes(state)
    exerted = exerted - _arm_weight(state, axes, origins)
    hand = state.pos[:, body.HANDS]
    jacobian = torch.linalg.cross(axes, hand[..., None, :] - origins)  # (N, 2, 4, 3)
    # what the hands hold pulls them down and apart; along a stretched arm a free force could not be told from nothing
    between = hand[:, 1] - hand[:, 0]
    between = between / between.norm(dim=-1, keepdim=True).clamp(min=0.05)
    up = torch.zeros_like(between)
    up[:, 2] = 1.0
    effect = torch.stack([(jacobian * d[:, None, None]).sum(-1) for d in (up, between)], -1)  # (N, 2, 4, 2)
    gram = effect.mT @ effect + 1e-3 * torch.eye(2, dtype=angles.dtype, device=angles.device)
    force = torch.linalg.solve(gram, effect.mT @ exerted[..., None])[..., 0]
    lift = force[..., 0].sum(1).clamp(0.0, config.load_limit)
    memory.arm_angles = angles
    holds = memory.squeeze > 0.95  # whoever begins to let go has put it down
    change = lift * holds - memory.load
    gain = torch.where(change < 0, config.unload_gain, config.load_gain)
    memory.load = memory.load + torch.where(holds, gain, config.release_gain) * change
    return memory.load


def _torque(axes: Tensor, origins: Tensor, point: Tensor, force: Tensor) -> Tensor:
    """(N, 2, 4) joint torques that exert (N, 2, 3) forces at (N, 2, 3) points."""
    levers = torch.linalg.cross(point[..., None, :] - origins, force[..., None, :].expand_as(origins))
    return (axes * levers).sum(-1)


def _arm_axes(state: BodyState) -> tuple[Tensor, Tensor]:
    """(N, 2, 4, 3) directions and origins of the arms' hinges."""
    upper, lower = state.pos[:, body.UPPER_ARMS], state.pos[:, body.LOWER_ARMS]
    upper_rot = state.rot[:, body.UPPER_ARMS]
    axis_x = state.rot[:, body.TORSO][:, None, :, 0].expand_as(upper)
    axis_y = torch.linalg.cross(upper_rot[..., 2], axis_x)
    axis_y = axis_y / axis_y.norm(dim=-1, keepdim=True).clamp(min=0.05)
    # |z| < 90 degrees fixes the sign of the y hinge
    axis_y = axis_y * torch.where((axis_y * upper_rot[..., 1]).sum(-1, keepdim=True) < 0, -1.0, 1.0)
    return torch.stack([axis_x, axis_y, upper_rot[..., 2], upper_rot[..., 1]], -2), torch.stack(
        [upper] * 3 + [lower], -2
    )


def _arm_weight(state: BodyState, axes: Tensor, origins: Tensor) -> Tensor:
    """(N, 2, 4) torques that bear the weight of upper arms, forearms and hands."""
    total = torch.zeros_like(axes[..., 0])
    for ids in (body.UPPER_ARMS, body.LOWER_ARMS, body.HANDS):
        centre = state.pos[:, ids] + (state.rot[:, ids] @ body.BODY_COM_M[ids[0]].to(total)[:, None])[..., 0]
        weight = torch.zeros_like(centre)
        weight[..., 2] = float(body.BODY_MASS_KG[ids[0]]) * body.GRAVITY
        lift = _torque(axes, origins, centre, weight)
        if ids is body.UPPER_ARMS:  # the elbow bears nothing of the upper arm
            lift = torch.cat([lift[..., :3], torch.zeros_like(lift[..., 3:])], -1)
        total = total + lift
    return total
