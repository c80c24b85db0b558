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
from hv_policy.motor.kinematics import leg_axes
from hv_policy.motor.proprioception import BodyState
from hv_policy.motor.reference import Reference


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
    squeeze_force: float = 120.0
    grounded_mass_kg: float = 5.0


def leg_torques(state: BodyState, reference: Reference, config: BalanceConfig) -> Tensor:
    """(N, 2, 7) joint torques of the legs in N m, right then left."""
    pelvis = state.pos[:, body.PELVIS]
    rotation = state.rot[:, body.PELVIS]
    wanted_velocity = torch.cat([reference.velocity[:, :2], torch.zeros_like(pelvis[:, :1])], -1)
    force = config.position_gain * (reference.pelvis_pos - pelvis)
    force = force + config.velocity_gain * (wanted_velocity - state.lin_vel[:, body.PELVIS])
    force = force.clamp(-config.force_limit, config.force_limit)
    weight = (body.TOTAL_MASS_KG - config.grounded_mass_kg) * body.GRAVITY
    force = force + force.new_tensor([0.0, 0.0, weight])
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
    lever = state.com - pelvis
    moment = moment + torch.stack([lever[:, 1], -lever[:, 0], torch.zeros_like(weight * lever[:, 0])], -1) * weight

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


def arm_torques(state: BodyState, squeeze: Tensor, config: BalanceConfig) -> Tensor:
    """(N, 2, 4) arm torques in N m that bear the arms' weight and press the hands together, right then left."""
    upper, lower, hand = (state.pos[:, i] for i in (body.UPPER_ARMS, body.LOWER_ARMS, body.HANDS))
    upper_rot = state.rot[:, body.UPPER_ARMS]
    torso_rot = state.rot[:, body.TORSO][:, None]
    axis_x = torso_rot[..., 0].expand_as(upper)
    axis_y = torch.linalg.cross(upper_rot[..., 2], axis_x)
    axis_y = axis_y / axis_y.norm(dim=-1, keepdim=True).clamp(min=0.05)
    # |z| < 90 degrees fixes the sign of the y hinge
    axis_y = axis_y * torch.where((axis_y * upper_rot[..., 1]).sum(-1, keepdim=True) < 0, -1.0, 1.0)
    axes = torch.stack([axis_x, axis_y, upper_rot[..., 2], upper_rot[..., 1]], -2)
    origins = torch.stack([upper, upper, upper, lower], -2)

    def torque(point: Tensor, force: Tensor) -> Tensor:
        return (axes * torch.linalg.cross(point[..., None, :] - origins, force[..., None, :].expand_as(origins))).sum(
            -1
        )

    up = torch.zeros_like(hand)
    up[..., 2] = body.GRAVITY
    bodies = (body.UPPER_ARMS, body.LOWER_ARMS, body.HANDS)
    total = torch.zeros_like(axes[..., 0])
    for ids in bodies:
        mass = float(body.BODY_MASS_KG[ids[0]])
        centre = state.pos[:, ids] + (state.rot[:, ids] @ body.BODY_COM_M[ids[0]].to(hand)[:, None])[..., 0]
        lift = torque(centre, mass * up)
        if ids is body.UPPER_ARMS:
            lift = torch.cat([lift[..., :3], torch.zeros_like(lift[..., 3:])], -1)
        total = total + lift
    between = hand[:, 1] - hand[:, 0]
    between = between / between.norm(dim=-1, keepdim=True).clamp(min=0.05)
    inward = torch.stack([between, -between], 1) * (config.squeeze_force * squeeze)[:, None, None]
    return total + torque(hand, inward)
