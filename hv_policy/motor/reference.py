"""From an intent to a full-body reference pose: a walking, bending, reaching body that answers to the real one.

All planar quantities are kept in the robot's current heading frame and carried from step to step by its measured
motion, so nothing here needs a world position. The pelvis reference leads the real pelvis by a filtered, bounded
amount; footholds are re-planned during the swing from the measured velocity (capture point), never while a foot stands.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import torch
from torch import Tensor

from hv_policy.batch_invariant import atan2
from hv_policy.motor import embodiment as body
from hv_policy.motor.gait import PELVIS_PITCH_SHARE, PLAN_SHAPES, GaitConfig, Plan, Remembered, advance_gait, gait_of
from hv_policy.motor.intent import GAZE, SQUEEZE, VELOCITY, split_hands
from hv_policy.motor.kinematics import (
    arm_inverse_kinematics,
    as_arrays,
    hip_positions,
    leg_inverse_kinematics,
    rotation_y,
    shoulder_positions,
    side_sign,
)
from hv_policy.motor.proprioception import BodyState


@dataclass
class ReferenceState:
    """What the reference remembers, one row per robot; planar values in its current heading frame."""

    velocity: Tensor  # (N, 3) filtered command: m/s forward, m/s left, rad/s
    posture: Tensor  # (N, 2) filtered pelvis height in m and torso pitch in rad
    hands: Tensor  # (N, 2, 3) filtered targets, right then left; z above the floor
    squeeze: Tensor  # (N,)
    gaze: Tensor  # (N, 2)
    phase: Tensor  # (N,) progress of the current step, 0..1
    swing: Tensor  # (N,) 0: the right foot swings, 1: the left one
    moving: Tensor  # (N,) 1 while stepping
    anchor: Tensor  # (N, 2) reference of the pelvis, relative to the pelvis
    yaw: Tensor  # (N,) reference yaw relative to the heading
    foot_pos: Tensor  # (N, 2, 2) where the feet stand, and where the swinging one should be now
    foot_yaw: Tensor  # (N, 2)
    swing_start: Tensor  # (N, 3) x, y and yaw of the swinging foot at lift-off
    com: Tensor  # (N, 2) filtered centre of mass relative to the pelvis
    last_velocity: Tensor  # (N, 3) measured planar velocity and heading rate at the last step
    joints: Tensor  # (N, 28) last reference pose
    load: Tensor  # (N,) estimated weight between the hands, N
    arm_angles: Tensor  # (N, 2, 4) measured at the last step
    arm_targets: Tensor  # (N, 2, 4) servo targets of the last step

    def __post_init__(self) -> None:
        for f in fields(self):  # compiled code writes into them
            setattr(self, f.name, getattr(self, f.name).contiguous())

    def select(self, ids: Tensor) -> ReferenceState:
        """The rows `ids` as a state of their own."""
        return ReferenceState(**{f.name: getattr(self, f.name)[ids] for f in fields(self)})

    def assign(self, ids: Tensor, rows: ReferenceState) -> None:
        """Overwrites the rows `ids`."""
        for f in fields(self):
            getattr(self, f.name)[ids] = getattr(rows, f.name)


@dataclass
class Reference:
    """The pose to be tracked now; heading frame, origin on the floor under the pelvis."""

    joints: Tensor  # (N, 28)
    joint_velocity: Tensor  # (N, 28), bounded
    pelvis_pos: Tensor  # (N, 3)
    pelvis_rot: Tensor  # (N, 3, 3)
    velocity: Tensor  # (N, 3) planar velocity and yaw rate wanted now, sway included
    stance: Tensor  # (N, 2) 1 where the foot bears load
    moving: Tensor  # (N,) 1 while stepping
    foot_target: Tensor  # (N, 2, 3) ankle positions wanted now
    foothold: Tensor  # (N, 2) planned landing place of the swinging foot


def preferred_arm_angles(pitch: Tensor) -> Tensor:
    """(N,) torso pitch -> (N, 2, 4): elbows out and bent, so that forearms come down steeply beside an object."""
    sign = side_sign(pitch)
    angles = pitch.new_zeros(len(pitch), 2, 4)
    angles[..., 0] = sign * 0.35
    angles[..., 1] = -0.25 - 0.6 * pitch[:, None]
    angles[..., 3] = -1.0
    return angles


def feet_ahead(height: Tensor, pitch: Tensor) -> Tensor:
    """(n,) m that the ankles stand before the pelvis when the centre of mass is over the soles (fitted by
    kinematics)."""
    return 0.1018 - 0.0985 * height + 0.1151 * pitch - 0.0157 * pitch**2 + 0.0019 * height * pitch


def standing_pose(height: Tensor, pitch: Tensor, hands: Tensor) -> tuple[Tensor, Tensor]:
    """A balanced pose on two feet with the hands at given places, to begin a simulation in.

    Args:
        height: (n,) pelvis height in m. pitch: (n,) torso pitch in rad. hands: (n, 2, 3) right, left, in the heading
            frame with its origin on the floor under the pelvis.

    Returns:
        joints (n, 28) in rad and the pelvis' own pitch (n,) in rad.
    """
    n = len(height)
    zero = torch.zeros_like(height)
    lean = pitch * PELVIS_PITCH_SHARE
    pelvis_rot, torso_rot = rotation_y(lean), rotation_y(pitch)
    pelvis = torch.stack([zero, zero, height], -1)
    torso = pelvis + pelvis_rot[:, :, 2] * body.TORSO_OFFSET_M[2]
    ahead = feet_ahead(height, pitch)
    sign = side_sign(height)
    feet = torch.stack(
        [ahead[:, None].expand(n, 2), 0.095 * sign.expand(n, 2), torch.full((n, 2), body.ANKLE_HEIGHT_M)], -1
    )
    preferred = preferred_arm_angles(pitch)
    arms = arm_inverse_kinematics(
        shoulder_positions(torso, torso_rot), torso_rot, hands, preferred, preferred, iterations=25
    )
    joints = height.new_zeros(n, 28)
    joints[:, 1] = pitch - lean
    joints[:, 6:14] = arms.flatten(1)
    joints[:, 14:] = leg_inverse_kinematics(
        hip_positions(pelvis, pelvis_rot), feet, pelvis_rot, zero[:, None].expand(n, 2)
    ).flatten(1)
    return joints.clamp(body.JOINT_LOW.to(joints), body.JOINT_HIGH.to(joints)), lean


def start_reference(state: BodyState, intent: Tensor, config: GaitConfig) -> ReferenceState:
    """A reference for robots that stand on both feet as measured, with their hands on the way to the intent's
    targets."""
    n = len(intent)
    feet = state.pos[:, body.FEET]
    forward = state.rot[:, body.FEET, :, 0]
    hands = split_hands(intent)
    torso_forward = state.rot[:, body.TORSO, :, 0]
    pitch = atan2(-torso_forward[:, 2], torso_forward[:, 0])
    shoulder = shoulder_positions(state.pos[:, body.TORSO], state.rot[:, body.TORSO])
    arms = preferred_arm_angles(pitch)
    arms = arm_inverse_kinematics(shoulder, state.rot[:, body.TORSO], hands, arms, arms, iterations=12)
    joints = intent.new_zeros(n, 28)
    joints[:, 1] = pitch * (1 - PELVIS_PITCH_SHARE)
    joints[:, 6:14] = arms.flatten(1)
    hips = hip_positions(state.pos[:, body.PELVIS], state.rot[:, body.PELVIS])
    foot_yaw = atan2(forward[..., 1], forward[..., 0])
    joints[:, 14:] = leg_inverse_kinematics(hips, feet, state.rot[:, body.PELVIS], foot_yaw).flatten(1)
    zero = intent.new_zeros(n)
    return ReferenceState(
        velocity=intent[:, VELOCITY].clone() * 0,
        posture=torch.stack([state.pos[:, body.PELVIS, 2], pitch], -1),
        hands=hands.clone(),
        squeeze=intent[:, SQUEEZE].clone(),
        gaze=intent[:, GAZE].clone(),
        phase=zero.clone(),
        swing=torch.zeros(n, dtype=torch.long, device=intent.device),
        moving=zero.clone(),
        anchor=intent.new_zeros(n, 2),
        yaw=zero.clone(),
        foot_pos=feet[..., :2].clone(),
        foot_yaw=foot_yaw,
        swing_start=intent.new_zeros(n, 3),
        com=state.com[:, :2].clone(),
        last_velocity=torch.cat([state.lin_vel[:, body.PELVIS, :2], state.heading_rate[:, None]], -1),
        joints=joints,
        load=zero.clone(),
        arm_angles=arms.clone(),
        arm_targets=arms.clone(),
    )


def advance_reference(ref: ReferenceState, state: BodyState, intent: Tensor, config: GaitConfig) -> Reference:
    """One control step: carries `ref` (in place) along with the robot and gives the pose to be tracked next."""
    n, dt = len(intent), body.CONTROL_DT_S
    plan = Plan(*(intent.new_empty(n, *shape) for shape in PLAN_SHAPES))
    advance_gait(
        Remembered(*as_arrays(*(getattr(ref, name) for name in Remembered._fields))),
        Plan(*as_arrays(*plan)),
        *as_arrays(state.pos, state.rot, state.lin_vel, state.ang_vel, intent),
        gait_of(config),
    )
    # standing legs hold the reference pelvis over the feet; a swinging leg hangs from the pelvis as it really is
    swings = plan.stance == 0
    hips_reference = hip_positions(plan.pelvis_pos, plan.pelvis_rot)
    hips_measured = hip_positions(
        state.pos[:, body.PELVIS] + state.lin_vel[:, body.PELVIS] * dt, state.rot[:, body.PELVIS]
    )
    legs = leg_inverse_kinematics(hips_reference, plan.foot_target, plan.pelvis_rot, ref.foot_yaw)
    swung = leg_inverse_kinematics(hips_measured, plan.foot_target, state.rot[:, body.PELVIS], ref.foot_yaw)
    legs = torch.where(swings[..., None], swung, legs)

    torso_pos, torso_rot = state.pos[:, body.TORSO], state.rot[:, body.TORSO]
    arms = arm_inverse_kinematics(
        shoulder_positions(torso_pos, torso_rot),
        torso_rot,
        ref.hands,
        ref.joints[:, 6:14].unflatten(-1, (2, 4)),
        preferred_arm_angles(ref.posture[:, 1]),
    )
    joints = torch.zeros_like(ref.joints)
    joints[:, 1] = ref.posture[:, 1] * (1 - PELVIS_PITCH_SHARE)
    joints[:, 4] = ref.gaze[:, 1] - 0.35 - ref.posture[:, 1]
    joints[:, 5] = ref.gaze[:, 0]
    joints[:, 6:14] = arms.flatten(1)
    joints[:, 14:] = legs.flatten(1)
    joints = joints.clamp(body.JOINT_LOW.to(joints), body.JOINT_HIGH.to(joints))
    joint_velocity = ((joints - ref.joints) / dt).clamp(-config.joint_speed_limit, config.joint_speed_limit)
    ref.joints = joints
    return Reference(joints, joint_velocity, moving=ref.moving.clone(), **plan._asdict())
