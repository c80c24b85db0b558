"""Batched forward and inverse kinematics of the humanoid's arms and legs. Pairs of limbs are stacked (right, left).

What takes many small operations runs compiled, robot by robot, on the tensors' own memory.
"""

from __future__ import annotations

import math

import numba
import numpy as np
import torch
from torch import Tensor

from hv_policy.motor import embodiment as body
from hv_policy.motor.vectors import (
    Columns,
    Vector,
    about_y,
    about_z,
    add,
    clip,
    columns_at,
    cross,
    dot,
    hinge_angles,
    hinges_xyz,
    norm,
    product,
    scaled,
    sub,
    transposed_product,
    transposed_times,
    unit,
    vector_at,
)

Array = np.ndarray
ELBOW_OUT_GAIN = 0.4
"""rad/m: how strongly the arms' spare joint turns the elbows outward in one iteration."""

_SIDE = torch.tensor([-1.0, 1.0])
_THIGH, _SHIN, _FOOT = tuple(body.THIGHS), tuple(body.SHINS), tuple(body.FEET)
_ARM_LOW, _ARM_HIGH = (limit.numpy()[body.ARM_JOINTS] for limit in (body.JOINT_LOW, body.JOINT_HIGH))


def as_arrays(*tensors: Tensor) -> list[np.ndarray]:
    """What tensors on the CPU hold, in C order, for compiled code: their own memory where they are so already."""
    return [tensor.detach().contiguous().numpy() for tensor in tensors]


def rotation_y(angle: Tensor) -> Tensor:
    """Rotation about y, (...) rad -> (..., 3, 3)."""
    c, s, o = angle.cos(), angle.sin(), torch.zeros_like(angle)
    return torch.stack([c, o, s, o, o + 1, o, -s, o, c], -1).unflatten(-1, (3, 3))


def rotate_xy(angle: Tensor, vector: Tensor) -> Tensor:
    """Rotates (..., 2) planar vectors by (...) rad."""
    c, s = angle.cos(), angle.sin()
    x, y = vector[..., 0], vector[..., 1]
    return torch.stack([c * x - s * y, s * x + c * y], -1)


def hip_positions(pelvis_pos: Tensor, pelvis_rot: Tensor) -> Tensor:
    """(N, 3), (N, 3, 3) -> (N, 2, 3) hips in the frame of the inputs."""
    offset = pelvis_rot[:, :, 1] * body.HIP_WIDTH_M
    return torch.stack([pelvis_pos - offset, pelvis_pos + offset], 1)


def shoulder_positions(torso_pos: Tensor, torso_rot: Tensor) -> Tensor:
    """(N, 3), (N, 3, 3) -> (N, 2, 3) shoulders in the frame of the inputs."""
    x, y, z = body.SHOULDER_OFFSET_M
    centre = torso_pos + torso_rot[:, :, 0] * x + torso_rot[:, :, 2] * z
    return torch.stack([centre - torso_rot[:, :, 1] * y, centre + torso_rot[:, :, 1] * y], 1)


def leg_inverse_kinematics(hip: Tensor, ankle: Tensor, pelvis_rot: Tensor, foot_yaw: Tensor) -> Tensor:
    """Joint angles that bring the ankles to given places with flat soles.

    Analytic: the knee from the distance, the hip's x and y from the thigh's direction, its z from the leg's plane.
    Where the thigh points straight ahead of the pelvis (hip y = -90 degrees) x is not determined by the direction; it
    is damped there, so that a deep squat passes the singularity with a small sideways error instead of a jump.

    Args:
        hip, ankle: (N, 2, 3) in one frame. pelvis_rot: (N, 3, 3) in it. foot_yaw: (N, 2) rad in it.

    Returns:
        (N, 2, 7) hip xyz, knee, ankle xyz in rad.
    """
    angles = hip.new_empty(len(hip), 2, 7)
    _legs(*as_arrays(hip, ankle, pelvis_rot[:, None], foot_yaw, angles))
    return angles


@numba.njit(cache=True)
def _legs(hip: Array, ankle: Array, pelvis_rot: Array, foot_yaw: Array, angles: Array) -> None:
    """Writes `angles` of `leg_inverse_kinematics`; the pelvis' rotation is (N, 1, 3, 3)."""
    upper, lower = body.THIGH_M, body.SHIN_M
    for i in range(len(hip)):
        pelvis = columns_at(pelvis_rot, i, 0)
        for side in range(2):
            yaw = np.float64(foot_yaw[i, side])
            to_ankle = sub(vector_at(ankle, i, side), vector_at(hip, i, side))
            distance = max(norm(to_ankle), 1e-6)
            up = scaled(to_ankle, -1.0 / distance)
            length = clip(distance, 0.25, upper + lower - 0.003)
            knee = math.pi - math.acos(clip((upper**2 + lower**2 - length**2) / (2 * upper * lower), -1.0, 1.0))
            lead = math.acos(clip((upper**2 + length**2 - lower**2) / (2 * upper * length), -1.0, 1.0))
            across = unit(cross(up, (math.cos(yaw), math.sin(yaw), 0.0)), 1e-6)
            plane = (cross(across, up), across, up)
            thigh = transposed_product(pelvis, product(plane, about_y(-lead)))
            dx, dy, dz = -thigh[2][0], -thigh[2][1], -thigh[2][2]
            x = clip(dy * -dz / (dz * dz + 0.02), -1.0, 1.0)
            y = -math.atan2(dx, dy * math.sin(x) - dz * math.cos(x))
            forward = transposed_times(hinges_xyz(x, y, 0.0), thigh[0])
            z = math.atan2(forward[1], forward[0])
            shin = product(product(pelvis, hinges_xyz(x, y, z)), about_y(knee))
            foot = hinge_angles(transposed_product(shin, about_z(yaw)))
            for k, angle in enumerate((x, y, z, knee, foot[0], foot[1], foot[2])):
                angles[i, side, k] = angle


def arm_inverse_kinematics(
    shoulder: Tensor, torso_rot: Tensor, target: Tensor, angles: Tensor, preferred: Tensor, iterations: int = 2
) -> Tensor:
    """Moves arm angles toward hand targets: damped least squares, elbows out in its null space.

    Differential, from the angles given, because the shoulder's three hinges lock where the arm points ahead of the
    torso and an arm has one joint to spare: continuity and joint limits matter more than exactness in one step. The
    spare joint turns the elbow outward, so that hands that press an object's sides arrive before the forearms touch
    its edges.

    Args:
        shoulder, target: (N, 2, 3). torso_rot: (N, 3, 3). angles, preferred: (N, 2, 4) rad.

    Returns:
        (N, 2, 4) within the joint limits.
    """
    moved = angles.clone(memory_format=torch.contiguous_format)
    _arms(*as_arrays(shoulder, torso_rot[:, None], target, moved, preferred), iterations)
    return moved


def arm_forward_kinematics(
    shoulder: Tensor, torso_rot: Tensor, angles: Tensor
) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    """Hand and elbow positions with their Jacobians.

    Args:
        shoulder: (N, 2, 3). torso_rot: (N, 3, 3). angles: (N, 2, 4) shoulder xyz and elbow in rad.

    Returns:
        hand (N, 2, 3), its Jacobian (N, 2, 3, 4) in m/rad, elbow (N, 2, 3) and its Jacobian, in the frame of the
        inputs.
    """
    n = len(shoulder)
    found = [shoulder.new_empty(n, 2, *shape) for shape in ((3,), (3, 4), (3,), (3, 4))]
    _reach(*as_arrays(shoulder, torso_rot[:, None], angles, *found))
    return found[0], found[1], found[2], found[3]


@numba.njit(cache=True)
def _reach(
    shoulder: Array, torso_rot: Array, angles: Array, hand: Array, hand_jacobian: Array, elbow: Array,
    elbow_jacobian: Array,
) -> None:  # fmt: skip
    """Writes what `arm_forward_kinematics` returns; the torso's rotation is (N, 1, 3, 3)."""
    for i in range(len(shoulder)):
        torso = columns_at(torso_rot, i, 0)
        for side in range(2):
            to_elbow, to_hand, axes = _arm_at(torso, angles, i, side)
            of_hand, of_elbow = _hand_jacobian(to_elbow, to_hand, axes), _elbow_jacobian(to_elbow, axes)
            for k in range(3):
                elbow[i, side, k] = shoulder[i, side, k] + to_elbow[k]
                hand[i, side, k] = shoulder[i, side, k] + to_hand[k]
                for joint in range(4):
                    hand_jacobian[i, side, k, joint] = of_hand[joint][k]
                    elbow_jacobian[i, side, k, joint] = of_elbow[joint][k]


@numba.njit(cache=True)
def _arm_at(torso: Columns, angles: Array, i: int, side: int) -> tuple[Vector, Vector, tuple[Vector, ...]]:
    """Elbow and hand from the shoulder, and the directions of the four hinges: shoulder x, y, z, and the elbow."""
    x, bend = np.float64(angles[i, side, 0]), np.float64(angles[i, side, 3])
    upper = product(torso, hinges_xyz(x, np.float64(angles[i, side, 1]), np.float64(angles[i, side, 2])))
    to_elbow = scaled(upper[2], -body.UPPER_ARM_M)
    # the forearm points along -z turned by the elbow about y
    forearm = add(scaled(upper[0], -math.sin(bend)), scaled(upper[2], -math.cos(bend)))
    second = add(scaled(torso[1], math.cos(x)), scaled(torso[2], math.sin(x)))
    return to_elbow, add(to_elbow, scaled(forearm, body.FOREARM_M)), (torso[0], second, upper[2], upper[1])


@numba.njit(cache=True)
def _hand_jacobian(to_elbow: Vector, to_hand: Vector, axes: tuple[Vector, ...]) -> tuple[Vector, ...]:
    forearm = sub(to_hand, to_elbow)
    return cross(axes[0], to_hand), cross(axes[1], to_hand), cross(axes[2], to_hand), cross(axes[3], forearm)


@numba.njit(cache=True)
def _elbow_jacobian(to_elbow: Vector, axes: tuple[Vector, ...]) -> tuple[Vector, ...]:
    """The upper arm does not move the elbow by turning about itself, nor does the elbow."""
    zero = (0.0, 0.0, 0.0)
    return cross(axes[0], to_elbow), cross(axes[1], to_elbow), zero, zero


@numba.njit(cache=True)
def _arms(shoulder: Array, torso_rot: Array, target: Array, angles: Array, preferred: Array, iterations: int) -> None:
    """Moves `angles` of `arm_inverse_kinematics` in place; the torso's rotation is (N, 1, 3, 3)."""
    longest = body.UPPER_ARM_M + body.FOREARM_M - 0.01
    for i in range(len(shoulder)):
        torso = columns_at(torso_rot, i, 0)
        for side in range(2):
            at = vector_at(shoulder, i, side)
            # an arm cannot reach beyond its length: pull the target in so that the elbow stays a little bent
            reach = sub(vector_at(target, i, side), at)
            distance = max(norm(reach), 1e-6)
            goal = add(at, scaled(reach, clip(distance, 0.12, longest) / distance))
            outward = sub(scaled(torso[1], 2.0 * side - 1.0), scaled(torso[0], 0.3))
            for _ in range(iterations):
                to_elbow, to_hand, axes = _arm_at(torso, angles, i, side)
                jacobian, elbow_jacobian = _hand_jacobian(to_elbow, to_hand, axes), _elbow_jacobian(to_elbow, axes)
                wanted = sub(goal, add(at, to_hand))
                bias = np.empty(4)
                g0, g1, g2 = (0.0025, 0.0, 0.0), (0.0, 0.0025, 0.0), (0.0, 0.0, 0.0025)
                for k in range(4):
                    j = jacobian[k]
                    bias[k] = 0.03 * (preferred[i, side, k] - angles[i, side, k])
                    bias[k] += ELBOW_OUT_GAIN * dot(elbow_jacobian[k], outward)
                    wanted = sub(wanted, scaled(j, bias[k]))
                    g0, g1, g2 = add(g0, scaled(j, j[0])), add(g1, scaled(j, j[1])), add(g2, scaled(j, j[2]))
                # Cramer's rule: the matrix is symmetric and well away from singular
                c0, c1, c2 = cross(g1, g2), cross(g2, g0), cross(g0, g1)
                solution = scaled((dot(c0, wanted), dot(c1, wanted), dot(c2, wanted)), 1.0 / dot(g0, c0))
                for k in range(4):
                    change = clip(bias[k] + dot(jacobian[k], solution), -0.35, 0.35)
                    angles[i, side, k] = clip(angles[i, side, k] + change, _ARM_LOW[side, k], _ARM_HIGH[side, k])


@numba.njit(cache=True)
def leg_axes_at(rot: Array, i: int, side: int) -> tuple[Vector, ...]:
    """Directions of the seven hinges of robot i's leg (0: right, 1: left), from its links' rotations (N, 15, 3, 3)."""
    pelvis, thigh = columns_at(rot, i, body.PELVIS), columns_at(rot, i, _THIGH[side])
    shin, foot = columns_at(rot, i, _SHIN[side]), columns_at(rot, i, _FOOT[side])
    return (
        pelvis[0], _second_axis(pelvis, thigh[2]), thigh[2], thigh[1], shin[0], _second_axis(shin, foot[2]), foot[2]
    )  # fmt: skip


@numba.njit(cache=True)
def _second_axis(parent: Columns, child_z: Vector) -> Vector:
    """A y hinge: perpendicular to the parent's x and to the child's z; |x| < 90 degrees fixes its sign."""
    axis = unit(cross(child_z, parent[0]), 1e-4)
    return scaled(axis, -1.0 if dot(axis, parent[1]) < 0 else 1.0)


def side_sign(like: Tensor) -> Tensor:
    """(2,) -1 for right, +1 for left, of the dtype and device of `like`."""
    return _SIDE.to(like)
