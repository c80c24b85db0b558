"""Virtual model control: the wrench that would pull the pelvis onto its reference, exerted through the standing legs.

tau = -J_leg^T f for each foot's share of the wrench (Pratt et al., "Virtual Model Control", 2001), added to the servo
targets as tau / kp. The horizontal force follows from what the sole can carry: a foot that may not tip can only push as
hard as its ankle torque and the lean of the leg allow.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numba
import numpy as np
import torch
from torch import Tensor

from hv_policy.motor import embodiment as body
from hv_policy.motor.gait import loaded_com_at
from hv_policy.motor.kinematics import Array, as_arrays, leg_axes_at
from hv_policy.motor.proprioception import BodyState
from hv_policy.motor.reference import Reference, ReferenceState
from hv_policy.motor.vectors import (
    Vector,
    add,
    clip,
    column_at,
    columns_at,
    cross,
    dot,
    hinge_angles,
    scaled,
    sub,
    times,
    transposed_product,
    transposed_times,
    unit,
    vector_at,
)


@dataclass(frozen=True)
class BalanceConfig:
    """Stiffness, damping and limits of the virtual wrench, in the order of the fields: N/m, N s/m, N m/rad, N m s/rad,
    a share, N, N m; then the sole (m) and its moment about the vertical (N m), forces in N, masses in kg."""

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
    torques = load.new_empty(len(load), 2, 7)
    r = reference
    _leg_torques(
        *as_arrays(state.pos, state.rot, state.lin_vel, state.ang_vel),
        *as_arrays(r.pelvis_pos, r.pelvis_rot[:, None], r.velocity, r.stance, r.moving, load, torques),
        _balance_of(config),
    )
    return torques


def arm_torques(state: BodyState, squeeze: Tensor, load: Tensor, config: BalanceConfig) -> Tensor:
    """(N, 2, 4) arm torques in N m that bear the arms' weight and the load (N,) in N, and press the hands together."""
    torques = load.new_empty(len(load), 2, 4)
    _arm_torques(*as_arrays(state.pos, state.rot, squeeze, load, torques), config.squeeze_force)
    return torques


def measured_arm_angles(state: BodyState, near: Tensor) -> Tensor:
    """(N, 2, 4) shoulder xyz and elbow in rad; of the two ways to turn a shoulder there, the one nearer to `near`."""
    angles = near.clone(memory_format=torch.contiguous_format)
    _measure(*as_arrays(state.rot, angles))
    return angles


def estimate_load(state: BodyState, memory: ReferenceState, config: BalanceConfig) -> Tensor:
    """(N,) weight between the hands in N, from what the arms' servos exert beyond the arms' own weight.

    Each hand's force, up and sideways, is the least-squares solution of J^T f = tau over the arm's joints, with
    tau = kp (target - q) - kd dq less the arm's weight. Filtered, and only while the hands squeeze. Updates
    `memory.load` and `memory.arm_angles`.
    """
    angles = measured_arm_angles(state, memory.arm_angles)
    load = memory.load.clone()
    _estimate_load(
        *as_arrays(state.pos, state.rot, memory.arm_angles, angles, memory.arm_targets, memory.squeeze, load),
        _balance_of(config),
    )
    memory.arm_angles, memory.load = angles, load
    return load


_Balance = NamedTuple("_Balance", [(f.name, Any) for f in fields(BalanceConfig)])  # type: ignore[misc]
_KP = body.KP.double().numpy()[body.ARM_JOINTS]
_PELVIS, _TORSO = body.PELVIS, body.TORSO
_UPPER_ARM, _LOWER_ARM, _HAND = tuple(body.UPPER_ARMS), tuple(body.LOWER_ARMS), tuple(body.HANDS)
_THIGH, _SHIN, _FOOT = tuple(body.THIGHS), tuple(body.SHINS), tuple(body.FEET)
_ARM_WEIGHT_N = tuple(float(body.BODY_MASS_KG[ids[0]]) * body.GRAVITY for ids in (_UPPER_ARM, _LOWER_ARM, _HAND))
_ARM_COM_M = tuple(tuple(body.BODY_COM_M[ids[0]].tolist()) for ids in (_UPPER_ARM, _LOWER_ARM, _HAND))
_UP = (0.0, 0.0, 1.0)


@functools.cache
def _balance_of(config: BalanceConfig) -> Any:
    """The configuration as compiled code can read it, with the same fields."""
    return _Balance(*(getattr(config, f.name) for f in fields(config)))


@numba.njit(cache=True)
def _leg_torques(
    pos: Array, rot: Array, lin_vel: Array, ang_vel: Array,
    pelvis_pos: Array, pelvis_rot: Array, velocity: Array, stance: Array, moving: Array, load: Array, torques: Array,
    config: BalanceConfig,
) -> None:  # fmt: skip
    """Writes `torques` of `leg_torques`."""
    c = config
    for i in range(len(load)):
        pelvis, rotation = vector_at(pos, i, _PELVIS), columns_at(rot, i, _PELVIS)
        weight = (body.TOTAL_MASS_KG - c.grounded_mass_kg) * body.GRAVITY + load[i]
        pull = np.empty(3)
        for k in range(3):
            wanted = velocity[i, k] if k < 2 else 0.0
            pull[k] = c.position_gain * (pelvis_pos[i, k] - pelvis[k])
            pull[k] += c.velocity_gain * (wanted - lin_vel[i, _PELVIS, k])
            pull[k] = clip(pull[k], -c.force_limit, c.force_limit)
        force = (pull[0], pull[1], pull[2] + weight)
        # reference times measured transposed: what it has more on one side of the diagonal than on the other
        reference = columns_at(pelvis_rot, i, 0)
        turn = (0.0, 0.0, 0.0)
        for k in range(3):
            turn = add(turn, cross(rotation[k], reference[k]))
        spin = (-ang_vel[i, _PELVIS, 0], -ang_vel[i, _PELVIS, 1], velocity[i, 2] - ang_vel[i, _PELVIS, 2])
        stiffness = 1.0 - (1.0 - c.stepping_share) * moving[i]
        twist = np.empty(3)
        for k in range(3):
            twist[k] = (c.rotation_gain * 0.5 * turn[k] + c.rotation_damping * spin[k]) * stiffness
            twist[k] = clip(twist[k], -c.moment_limit, c.moment_limit)
        # gravity acts at the centre of mass, the wrench at the pelvis
        lever = sub(loaded_com_at(pos, rot, i, load[i]), pelvis)
        moment = (twist[0] + lever[1] * weight, twist[1] - lever[0] * weight, twist[2])

        shares = _load_shares(stance[i, 0], stance[i, 1], pos, i, pelvis, force, moment)
        for side in range(2):
            foot, share = vector_at(pos, i, _FOOT[side]), shares[side]
            foot_force, foot_moment = scaled(force, share), scaled(moment, share)
            arm = sub(pelvis, foot)
            sole = add(foot_moment, cross(arm, foot_force))
            # ankle moments the sole can carry, and the horizontal force that is then left (row by row of M + r x F)
            down = max(foot_force[2], 0.0)
            pitch = clip(sole[1], -c.sole_toe_m * down, c.sole_heel_m * down)
            roll = clip(sole[0], -c.sole_half_width_m * down, c.sole_half_width_m * down)
            height = max(arm[2], 0.3)
            force_x, force_y = foot_force[0] + (pitch - sole[1]) / height, foot_force[1] - (roll - sole[0]) / height
            foot_force = (force_x, force_y, foot_force[2])

            axes = leg_axes_at(rot, i, side)
            hip, knee = vector_at(pos, i, _THIGH[side]), vector_at(pos, i, _SHIN[side])
            for joint in range(7):
                origin = hip if joint < 3 else knee if joint == 3 else foot
                # moment that the leg above a joint must transmit about it: the pelvis wrench carried down to the joint
                about = add(foot_moment, cross(sub(pelvis, origin), foot_force))
                torque = -dot(axes[joint], about)
                torques[i, side, joint] = clip(torque, -c.sole_yaw_limit, c.sole_yaw_limit) if joint == 6 else torque


@numba.njit(cache=True)
def _load_shares(
    right: float, left: float, pos: Array, i: int, pelvis: Vector, force: Vector, moment: Vector
) -> tuple[float, float]:
    """Share of the wrench that each foot bears: where the wanted centre of pressure lies between them."""
    weight, height = max(force[2], 50.0), pelvis[2] - body.ANKLE_HEIGHT_M
    x = pelvis[0] - (moment[1] + height * force[0]) / weight
    y = pelvis[1] + (moment[0] - height * force[1]) / weight
    first, second = vector_at(pos, i, _FOOT[0]), vector_at(pos, i, _FOOT[1])
    line_x, line_y = second[0] - first[0], second[1] - first[1]
    along = ((x - first[0]) * line_x + (y - first[1]) * line_y) / max(line_x**2 + line_y**2, 1e-3)
    along = clip(along, 0.04, 0.96)
    right, left = right * (1 - along), left * along
    total = max(right + left, 1e-6)
    return right / total, left / total


@numba.njit(cache=True)
def _arm_hinges(pos: Array, rot: Array, i: int, side: int) -> tuple[tuple[Vector, ...], tuple[Vector, ...]]:
    """Directions and origins of an arm's four hinges."""
    shoulder, elbow = vector_at(pos, i, _UPPER_ARM[side]), vector_at(pos, i, _LOWER_ARM[side])
    upper, first = columns_at(rot, i, _UPPER_ARM[side]), column_at(rot, i, _TORSO, 0)
    second = unit(cross(upper[2], first), 0.05)
    # |z| < 90 degrees fixes the sign of the y hinge
    second = scaled(second, -1.0 if dot(second, upper[1]) < 0 else 1.0)
    return (first, second, upper[2], upper[1]), (shoulder, shoulder, shoulder, elbow)


@numba.njit(cache=True)
def _arm_weight(
    pos: Array, rot: Array, i: int, side: int, axes: tuple[Vector, ...], origins: tuple[Vector, ...], joint: int
) -> float:
    """Torque of one joint that bears the weight of upper arm, forearm and hand."""
    total = 0.0
    for part, link in enumerate((_UPPER_ARM[side], _LOWER_ARM[side], _HAND[side])):
        if part > 0 or joint < 3:  # the elbow bears nothing of the upper arm
            centre = add(vector_at(pos, i, link), times(columns_at(rot, i, link), _ARM_COM_M[part]))
            lever = cross(sub(centre, origins[joint]), scaled(_UP, _ARM_WEIGHT_N[part]))
            total += dot(axes[joint], lever)
    return total


@numba.njit(cache=True)
def _arm_torques(pos: Array, rot: Array, squeeze: Array, load: Array, torques: Array, squeeze_force: float) -> None:
    """Writes `torques` of `arm_torques`."""
    for i in range(len(load)):
        right, left = vector_at(pos, i, _HAND[0]), vector_at(pos, i, _HAND[1])
        press = scaled(unit(sub(left, right), 0.05), squeeze_force * squeeze[i])
        for side in range(2):
            axes, origins = _arm_hinges(pos, rot, i, side)
            force = add(scaled(press, 1.0 - 2.0 * side), scaled(_UP, 0.5 * load[i]))
            hand = left if side else right
            for joint in range(4):
                exerted = dot(axes[joint], cross(sub(hand, origins[joint]), force))
                torques[i, side, joint] = _arm_weight(pos, rot, i, side, axes, origins, joint) + exerted


@numba.njit(cache=True)
def _measure(rot: Array, angles: Array) -> None:
    """Replaces `angles` (N, 2, 4), which it stays near to, by those of `measured_arm_angles`."""
    for i in range(len(angles)):
        torso = columns_at(rot, i, _TORSO)
        for side in range(2):
            upper, lower = columns_at(rot, i, _UPPER_ARM[side]), columns_at(rot, i, _LOWER_ARM[side])
            x, y, z = hinge_angles(transposed_product(torso, upper))
            way = np.empty((2, 3))
            away = np.zeros(2)
            for k, options in enumerate(((x, x + math.pi), (y, math.pi - y), (z, z + math.pi))):
                near = np.float64(angles[i, side, k])
                for which in range(2):
                    off = (options[which] - near + math.pi) % (2 * math.pi) - math.pi
                    way[which, k] = near + off
                    away[which] += abs(off)
            for k in range(3):
                angles[i, side, k] = way[0 if away[0] <= away[1] else 1, k]
            bend = transposed_times(upper, lower[2])[0], transposed_times(upper, lower[0])[0]
            angles[i, side, 3] = math.atan2(bend[0], bend[1])


@numba.njit(cache=True)
def _estimate_load(
    pos: Array, rot: Array, before: Array, angles: Array, targets: Array, squeeze: Array, load: Array,
    config: BalanceConfig,
) -> None:  # fmt: skip
    """Moves `load` (N,) as `estimate_load` says; arm angles (N, 2, 4) of the last step and of now."""
    for i in range(len(load)):
        right, left = vector_at(pos, i, _HAND[0]), vector_at(pos, i, _HAND[1])
        # what the hands hold pulls them down and apart; along a stretched arm a free force could not be told from none
        between = unit(sub(left, right), 0.05)
        lift = 0.0
        for side in range(2):
            axes, origins = _arm_hinges(pos, rot, i, side)
            hand = left if side else right
            uu, ub, bb, ut, bt = 1e-3, 0.0, 1e-3, 0.0, 0.0
            for joint in range(4):
                gain = _KP[side, joint]
                speed = (angles[i, side, joint] - before[i, side, joint]) / body.CONTROL_DT_S
                exerted = gain * (targets[i, side, joint] - angles[i, side, joint] - body.DAMPING_TIME_S * speed)
                exerted -= _arm_weight(pos, rot, i, side, axes, origins, joint)
                jacobian = cross(axes[joint], sub(hand, origins[joint]))
                up, apart = jacobian[2], dot(jacobian, between)
                uu, ub, bb = uu + up * up, ub + up * apart, bb + apart * apart
                ut, bt = ut + up * exerted, bt + apart * exerted
            lift += (bb * ut - ub * bt) / (uu * bb - ub * ub)
        holds = squeeze[i] > 0.95  # whoever begins to let go has put it down
        change = (clip(lift, 0.0, config.load_limit) if holds else 0.0) - load[i]
        if holds:
            load[i] += (config.unload_gain if change < 0 else config.load_gain) * change
        else:
            load[i] += config.release_gain * change
