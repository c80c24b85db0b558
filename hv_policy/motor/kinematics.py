"""Batched forward and inverse kinematics of the humanoid's arms and legs. Pairs of limbs are stacked (right, left)."""

from __future__ import annotations

import torch
from torch import Tensor

from hv_policy.motor import embodiment as body

ELBOW_OUT_GAIN = 0.4
"""rad/m: how strongly the arms' spare joint turns the elbows outward in one iteration."""

_SIDE = torch.tensor([-1.0, 1.0])


def euler_matrix(angles: Tensor) -> Tensor:
    """Rotation of three serial hinges x, y, z: Rx(a) Ry(b) Rz(c). angles (..., 3) rad -> (..., 3, 3)."""
    (sx, sy, sz), (cx, cy, cz) = angles.sin().unbind(-1), angles.cos().unbind(-1)
    sxsy, cxsy = sx * sy, cx * sy
    rows = [
        cy * cz, -cy * sz, sy,
        cx * sz + sxsy * cz, cx * cz - sxsy * sz, -sx * cy,
        sx * sz - cxsy * cz, sx * cz + cxsy * sz, cx * cy,
    ]  # fmt: skip
    return torch.stack(rows, -1).unflatten(-1, (3, 3))


def euler_angles(rotation: Tensor) -> Tensor:
    """Serial hinge angles x, y, z of a rotation, |y| <= 90 degrees. (..., 3, 3) -> (..., 3) rad."""
    y = rotation[..., 0, 2].clamp(-1, 1).asin()
    x = torch.atan2(-rotation[..., 1, 2], rotation[..., 2, 2])
    z = torch.atan2(-rotation[..., 0, 1], rotation[..., 0, 0])
    return torch.stack([x, y, z], -1)


def rotation_y(angle: Tensor) -> Tensor:
    """Rotation about y, (...) rad -> (..., 3, 3)."""
    c, s, o = angle.cos(), angle.sin(), torch.zeros_like(angle)
    return torch.stack([c, o, s, o, o + 1, o, -s, o, c], -1).unflatten(-1, (3, 3))


def rotation_z(angle: Tensor) -> Tensor:
    """Rotation about z, (...) rad -> (..., 3, 3)."""
    c, s, o = angle.cos(), angle.sin(), torch.zeros_like(angle)
    return torch.stack([c, -s, o, s, c, o, o, o, o + 1], -1).unflatten(-1, (3, 3))


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
    Where
    the thigh points straight ahead of the pelvis (hip y = -90 degrees) x is not determined by the direction; it is
    damped
    there, so that a deep squat passes the singularity with a small sideways error instead of a jump.

    Args:
        hip, ankle: (N, 2, 3) in one frame. pelvis_rot: (N, 3, 3) in it. foot_yaw: (N, 2) rad in it.

    Returns:
        (N, 2, 7) hip xyz, knee, ankle xyz in rad.
    """
    to_ankle = ankle - hip
    distance = to_ankle.norm(dim=-1).clamp(min=1e-6)
    up = -to_ankle / distance[..., None]
    upper, lower = body.THIGH_M, body.SHIN_M
    length = distance.clamp(0.25, upper + lower - 0.003)
    knee = torch.pi - ((upper**2 + lower**2 - length**2) / (2 * upper * lower)).clamp(-1, 1).acos()
    lead = ((upper**2 + length**2 - lower**2) / (2 * upper * length)).clamp(-1, 1).acos()
    zero = torch.zeros_like(foot_yaw)
    forward = torch.stack([foot_yaw.cos(), foot_yaw.sin(), zero], -1)
    side = torch.linalg.cross(up, forward)
    side = side / side.norm(dim=-1, keepdim=True).clamp(min=1e-6)
    plane = torch.stack([torch.linalg.cross(side, up), side, up], -1)
    in_pelvis = pelvis_rot[:, None].mT @ (plane @ rotation_y(-lead))
    thigh = -in_pelvis[..., 2]
    dx, dy, dz = thigh.unbind(-1)
    x = (dy * -dz / (dz * dz + 0.02)).clamp(-1.0, 1.0)
    y = -torch.atan2(dx, dy * x.sin() - dz * x.cos())
    twist = euler_matrix(torch.stack([x, y, zero], -1)).mT @ in_pelvis
    z = torch.atan2(twist[..., 1, 0], twist[..., 0, 0])
    hip_angles = torch.stack([x, y, z], -1)
    shin_rot = pelvis_rot[:, None] @ euler_matrix(hip_angles) @ rotation_y(knee)
    ankle_angles = euler_angles(shin_rot.mT @ rotation_z(foot_yaw))
    return torch.cat([hip_angles, knee[..., None], ankle_angles], -1)


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
    upper_rot = torso_rot[:, None] @ euler_matrix(angles[..., :3])
    elbow = shoulder - upper_rot[..., 2] * body.UPPER_ARM_M
    bend = angles[..., 3:]
    # the forearm points along -z turned by the elbow about y
    forearm = -(upper_rot[..., 0] * bend.sin() + upper_rot[..., 2] * bend.cos())
    hand = elbow + forearm * body.FOREARM_M
    sx, cx = angles[..., :1].sin(), angles[..., :1].cos()
    axis_y = torso_rot[:, None, :, 1] * cx + torso_rot[:, None, :, 2] * sx
    axis_x = torso_rot[:, None, :, 0].expand_as(axis_y)
    zero = torch.zeros_like(axis_y)
    axes = torch.stack([axis_x, axis_y, upper_rot[..., 2], upper_rot[..., 1]], -2)
    arm = hand - shoulder
    levers = torch.stack([arm, arm, arm, hand - elbow], -2)
    upper = elbow - shoulder
    elbow_levers = torch.stack([upper, upper, zero, zero], -2)
    return hand, torch.linalg.cross(axes, levers).mT, elbow, torch.linalg.cross(axes, elbow_levers).mT


def arm_inverse_kinematics(
    shoulder: Tensor, torso_rot: Tensor, target: Tensor, angles: Tensor, preferred: Tensor, iterations: int = 2
) -> Tensor:
    """Moves arm angles toward hand targets: damped least squares, elbows out in its null space.

    Differential, from the angles given, because the shoulder's three hinges lock where the arm points ahead of the
    torso
    and an arm has one joint to spare: continuity and joint limits matter more than exactness in one step. The spare
    joint
    turns the elbow outward, so that hands that press an object's sides arrive before the forearms touch its edges.

    Args:
        shoulder, target: (N, 2, 3). torso_rot: (N, 3, 3). angles, preferred: (N, 2, 4) rad.

    Returns:
        (N, 2, 4) within the joint limits.
    """
    low = torch.stack([body.JOINT_LOW[j] for j in body.ARM_JOINTS]).to(angles)
    high = torch.stack([body.JOINT_HIGH[j] for j in body.ARM_JOINTS]).to(angles)
    # an arm cannot reach beyond its length: pull the target in so that the elbow stays a little bent
    reach = target - shoulder
    distance = reach.norm(dim=-1, keepdim=True).clamp(min=1e-6)
    target = shoulder + reach / distance * distance.clamp(0.12, body.UPPER_ARM_M + body.FOREARM_M - 0.01)
    damping = 0.0025 * torch.eye(3, dtype=angles.dtype, device=angles.device)
    outward = torso_rot[:, None, :, 1] * side_sign(angles)[:, None] - 0.3 * torso_rot[:, None, :, 0]
    for _ in range(iterations):
        hand, jacobian, _, elbow_jacobian = arm_forward_kinematics(shoulder, torso_rot, angles)
        gram = jacobian @ jacobian.mT + damping
        bias = 0.03 * (preferred - angles) + ELBOW_OUT_GAIN * (elbow_jacobian.mT @ outward[..., None])[..., 0]
        wanted = (target - hand)[..., None] - jacobian @ bias[..., None]
        solution = torch.linalg.solve(gram, wanted)
        change = bias + (jacobian.mT @ solution)[..., 0]
        angles = (angles + change.clamp(-0.35, 0.35)).clamp(low, high)
    return angles


def leg_axes(pelvis_rot: Tensor, thigh_rot: Tensor, shin_rot: Tensor, foot_rot: Tensor) -> Tensor:
    """Directions of the seven hinge axes of each leg, (N, 2, 7, 3), in the frame of the rotations.

    Args:
        pelvis_rot: (N, 3, 3). thigh_rot, shin_rot, foot_rot: (N, 2, 3, 3).
    """

    def second_axis(parent: Tensor, child: Tensor) -> Tensor:
        # the y hinge is perpendicular to the parent's x and to the child's z; |x| < 90 degrees fixes its sign
        axis = torch.linalg.cross(child[..., 2], parent[..., 0])
        axis = axis / axis.norm(dim=-1, keepdim=True).clamp(min=1e-4)
        return axis * torch.where((axis * parent[..., 1]).sum(-1, keepdim=True) < 0, -1.0, 1.0)

    parent = pelvis_rot[:, None].expand_as(thigh_rot)
    axes = [
        parent[..., 0], second_axis(parent, thigh_rot), thigh_rot[..., 2], thigh_rot[..., 1],
        shin_rot[..., 0], second_axis(shin_rot, foot_rot), foot_rot[..., 2],
    ]  # fmt: skip
    return torch.stack(axes, -2)


def side_sign(like: Tensor) -> Tensor:
    """(2,) -1 for right, +1 for left, of the dtype and device of `like`."""
    return _SIDE.to(like)
