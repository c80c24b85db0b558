"""From an intent to a full-body reference pose: a walking, bending, reaching body that answers to the real one.

All planar quantities are kept in the robot's current heading frame and carried from step to step by its measured
motion,
so nothing here needs a world position. The pelvis reference leads the real pelvis by a filtered, bounded amount;
footholds
are re-planned during the swing from the measured velocity (capture point), never while a foot stands.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import torch
from torch import Tensor

from hv_policy.motor import embodiment as body
from hv_policy.motor.kinematics import (
    arm_inverse_kinematics,
    hip_positions,
    leg_inverse_kinematics,
    rotate_xy,
    rotation_y,
    rotation_z,
    shoulder_positions,
    side_sign,
)
from hv_policy.motor.proprioception import BodyState

INTENT_DIM = 14
VELOCITY, HEIGHT, PITCH = slice(0, 3), 3, 4
LEFT_HAND, RIGHT_HAND, SQUEEZE, GAZE = slice(5, 8), slice(8, 11), 11, slice(12, 14)
INTENT_LOW = (-0.6, -0.5, -1.5, 0.3, -0.3, -0.3, -0.5, 0.0, -0.3, -0.9, 0.0, 0.0, -0.8, -0.7)
INTENT_HIGH = (1.2, 0.5, 1.5, 0.92, 1.6, 1.0, 0.9, 1.9, 1.0, 0.5, 1.9, 1.0, 0.8, 1.0)
"""Least and greatest value of each number of an intent, in its own unit."""

PELVIS_PITCH_SHARE = 0.42
"""Share of the torso pitch that the pelvis takes; the abdomen takes the rest."""


@dataclass(frozen=True)
class GaitConfig:
    """Timing and bounds of the reference. The defaults were chosen by survival without learning
    (docs/motor_prior.md)."""

    step_duration_s: float = 0.36
    double_support: float = 0.2
    half_stance_m: float = 0.095
    clearance_m: float = 0.06
    closest_feet_m: float = 0.13
    sway_m: float = 0.008
    sole_centre_m: float = 0.035
    capture_gain_s: float = 0.18
    swing_lead_s: float = 0.05
    step_ahead: float = 0.4
    travel_share: float = 0.5
    max_acceleration: tuple[float, float, float] = (1.6, 1.2, 4.0)
    anchor_rate: float = 8.0
    anchor_bound_m: float = 0.12
    yaw_bound_rad: float = 0.35
    stand_rate: float = 8.0
    com_gain: float = 0.5
    joint_speed_limit: float = 8.0
    walk_height_m: float = 0.74
    walk_pitch_rad: float = 0.5
    rising_m_s: float = 0.2


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
    foot_pos: Tensor  # (N, 2, 2) where the feet stand, or where the swinging one will
    foot_yaw: Tensor  # (N, 2)
    swing_start: Tensor  # (N, 3) x, y and yaw of the swinging foot at lift-off
    com: Tensor  # (N, 2) filtered centre of mass relative to the pelvis
    last_velocity: Tensor  # (N, 3) measured planar velocity and heading rate at the last step
    joints: Tensor  # (N, 28) last reference pose
    load: Tensor  # (N,) estimated weight between the hands, N
    arm_angles: Tensor  # (N, 2, 4) measured at the last step
    arm_targets: Tensor  # (N, 2, 4) servo targets of the last step

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


def neutral_intent(num: int) -> Tensor:
    """(num, 14): stand upright, arms hanging, looking ahead and a little down."""
    intent = torch.zeros(num, INTENT_DIM)
    intent[:, HEIGHT] = 0.84
    intent[:, LEFT_HAND] = torch.tensor([0.10, 0.24, 0.86])
    intent[:, RIGHT_HAND] = torch.tensor([0.10, -0.24, 0.86])
    intent[:, GAZE] = torch.tensor([0.0, 0.3])
    return intent


def preferred_arm_angles(pitch: Tensor) -> Tensor:
    """(N,) torso pitch -> (N, 2, 4): elbows out and bent, so that forearms come down steeply beside an object."""
    sign = side_sign(pitch)
    angles = pitch.new_zeros(len(pitch), 2, 4)
    angles[..., 0] = sign * 0.35
    angles[..., 1] = -0.25 - 0.6 * pitch[:, None]
    angles[..., 3] = -1.0
    return angles


def split_hands(intent: Tensor) -> Tensor:
    """(N, 14) -> (N, 2, 3) hand targets, right then left."""
    return torch.stack([intent[:, RIGHT_HAND], intent[:, LEFT_HAND]], 1)


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
    pitch = torch.atan2(-torso_forward[:, 2], torso_forward[:, 0])
    shoulder = shoulder_positions(state.pos[:, body.TORSO], state.rot[:, body.TORSO])
    arms = preferred_arm_angles(pitch)
    arms = arm_inverse_kinematics(shoulder, state.rot[:, body.TORSO], hands, arms, arms, iterations=12)
    joints = intent.new_zeros(n, 28)
    joints[:, 1] = pitch * (1 - PELVIS_PITCH_SHARE)
    joints[:, 6:14] = arms.flatten(1)
    hips = hip_positions(state.pos[:, body.PELVIS], state.rot[:, body.PELVIS])
    foot_yaw = torch.atan2(forward[..., 1], forward[..., 0])
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
    dt = body.CONTROL_DT_S
    _carry_along(ref, state, config, dt)
    _filter_intent(ref, intent, config, dt)
    _step_clock(ref, state, config, dt)

    swinging = torch.stack([ref.swing == 0, ref.swing == 1], 1) & (ref.moving > 0)[:, None]
    margin = config.double_support / 2
    progress = ((ref.phase - margin) / (1 - config.double_support)).clamp(0, 1)
    in_air = swinging & (progress > 0)[:, None] & (progress < 1)[:, None]
    stance = 1.0 - in_air.to(intent.dtype)

    # the pelvis sways over the standing foot: raised cosine over the step, toward the stance side
    stance_side = torch.where(ref.swing == 0, 1.0, -1.0).to(intent)
    sway = ref.moving * stance_side * config.sway_m * (torch.pi * ref.phase).sin()
    omega = torch.pi / config.step_duration_s
    sway_velocity = ref.moving * stance_side * config.sway_m * omega * (torch.pi * ref.phase).cos()
    _move_anchor(ref, config, sway, dt)
    left = torch.stack([-ref.yaw.sin(), ref.yaw.cos()], -1)
    pelvis_xy = ref.anchor + left * sway[:, None]
    pelvis_pos = torch.cat([pelvis_xy, ref.posture[:, :1]], -1)
    pelvis_rot = rotation_z(ref.yaw) @ rotation_y(ref.posture[:, 1] * PELVIS_PITCH_SHARE)
    velocity = torch.cat(
        [rotate_xy(ref.yaw, ref.velocity[:, :2]) + left * sway_velocity[:, None], ref.velocity[:, 2:]], -1
    )

    foothold, foothold_yaw = _plan_foothold(ref, state, config, sway_velocity, stance_side)
    # the servos lag behind a swinging leg's inertia: ask for where the foot should be a little later
    progress = (
        (ref.phase + config.swing_lead_s / config.step_duration_s - margin) / (1 - config.double_support)
    ).clamp(0, 1)
    smooth = progress * progress * (3 - 2 * progress)
    swing_xy = ref.swing_start[:, :2] + (foothold - ref.swing_start[:, :2]) * smooth[:, None]
    swing_yaw = ref.swing_start[:, 2] + (foothold_yaw - ref.swing_start[:, 2]) * smooth
    lift = config.clearance_m * (torch.pi * progress).sin() ** 2
    foot_xy = torch.where(in_air[..., None], swing_xy[:, None], ref.foot_pos)
    foot_yaw = torch.where(in_air, swing_yaw[:, None], ref.foot_yaw)
    foot_z = body.ANKLE_HEIGHT_M + torch.where(in_air, lift[:, None], torch.zeros_like(foot_yaw))
    foot_target = torch.cat([foot_xy, foot_z[..., None]], -1)
    ref.foot_pos, ref.foot_yaw = foot_xy, foot_yaw

    # standing legs hold the reference pelvis over the feet; a swinging leg hangs from the pelvis as it really is
    hips_reference = hip_positions(pelvis_pos, pelvis_rot)
    hips_measured = hip_positions(
        state.pos[:, body.PELVIS] + state.lin_vel[:, body.PELVIS] * dt, state.rot[:, body.PELVIS]
    )
    legs = leg_inverse_kinematics(hips_reference, foot_target, pelvis_rot, foot_yaw)
    swung = leg_inverse_kinematics(hips_measured, foot_target, state.rot[:, body.PELVIS], foot_yaw)
    legs = torch.where(in_air[..., None], swung, legs)

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
    return Reference(
        joints, joint_velocity, pelvis_pos, pelvis_rot, velocity, stance, ref.moving, foot_target, foothold
    )


def loaded_com(state: BodyState, load: Tensor) -> Tensor:
    """(N, 3) centre of mass of the robot and of what it holds, whose weight is `load` (N,) in N, between its hands."""
    mass = (load / body.GRAVITY)[:, None]
    held = state.pos[:, body.HANDS].mean(1)
    return (body.TOTAL_MASS_KG * state.com + mass * held) / (body.TOTAL_MASS_KG + mass)


def _carry_along(ref: ReferenceState, state: BodyState, config: GaitConfig, dt: float) -> None:
    """Re-expresses what is remembered in the heading frame after the robot's motion of one step."""
    now = torch.cat([state.lin_vel[:, body.PELVIS, :2], state.heading_rate[:, None]], -1)
    turned = 0.5 * (now[:, 2] + ref.last_velocity[:, 2]) * dt
    moved = 0.5 * (now[:, :2] + rotate_xy(-turned, ref.last_velocity[:, :2])) * dt
    ref.anchor = rotate_xy(-turned, ref.anchor) - moved
    ref.foot_pos = rotate_xy(-turned[:, None], ref.foot_pos) - moved[:, None]
    ref.foot_yaw = ref.foot_yaw - turned[:, None]
    start = rotate_xy(-turned, ref.swing_start[:, :2]) - moved
    ref.swing_start = torch.cat([start, ref.swing_start[:, 2:] - turned[:, None]], -1)
    ref.com = rotate_xy(-turned, ref.com)
    ref.yaw = ref.yaw - turned
    ref.last_velocity = now
    # feet that stand are seen: correct the drift of the dead reckoning
    feet = state.pos[:, body.FEET]
    forward = state.rot[:, body.FEET, :, 0]
    yaw = torch.atan2(forward[..., 1], forward[..., 0])
    swinging = torch.stack([ref.swing == 0, ref.swing == 1], 1) & (ref.moving > 0)[:, None]
    seen = (~swinging) & (feet[..., 2] < 0.09)
    gain = 0.25 * seen.to(feet.dtype)
    ref.foot_pos = ref.foot_pos + gain[..., None] * (feet[..., :2] - ref.foot_pos)
    ref.foot_yaw = ref.foot_yaw + gain * (yaw - ref.foot_yaw)
    ref.com = ref.com + config.com_gain * (loaded_com(state, ref.load)[:, :2] - ref.com)


def _filter_intent(ref: ReferenceState, intent: Tensor, config: GaitConfig, dt: float) -> None:
    limit = torch.tensor(config.max_acceleration, dtype=intent.dtype, device=intent.device) * dt
    change = (intent[:, VELOCITY] - ref.velocity).clamp(-limit, limit)
    ref.velocity = ref.velocity + change
    # no bending while stepping: the feet come to rest first (and from a bend the body rises before it walks off)
    height = torch.where(ref.moving > 0, intent[:, HEIGHT].clamp(min=config.walk_height_m), intent[:, HEIGHT])
    pitch = torch.where(ref.moving > 0, intent[:, PITCH].clamp(max=config.walk_pitch_rad), intent[:, PITCH])
    wanted = torch.stack([height, pitch], -1)
    rate = torch.tensor([0.5, 1.4], dtype=intent.dtype, device=intent.device)
    ref.posture = ref.posture + (5.0 * (wanted - ref.posture)).clamp(-rate, rate) * dt
    gap = split_hands(intent) - ref.hands
    speed = (10.0 * gap.norm(dim=-1, keepdim=True)).clamp(min=1e-6)
    ref.hands = ref.hands + gap * (speed.clamp(max=1.2) / speed) * (10.0 * dt)
    ref.squeeze = ref.squeeze + (intent[:, SQUEEZE] - ref.squeeze).clamp(-3.0 * dt, 3.0 * dt)
    ref.gaze = ref.gaze + (intent[:, GAZE] - ref.gaze).clamp(-3.0 * dt, 3.0 * dt)


def _step_clock(ref: ReferenceState, state: BodyState, config: GaitConfig, dt: float) -> None:
    """Advances the gait phase, changes feet, starts and stops stepping."""
    commanded = (ref.velocity[:, :2].norm(dim=-1) > 0.06) | (ref.velocity[:, 2].abs() > 0.12)
    between = rotate_xy(-ref.yaw, ref.foot_pos[:, 1] - ref.foot_pos[:, 0])
    awry = (between[:, 0].abs() > 0.10) | ((between[:, 1] - 2 * config.half_stance_m).abs() > 0.08)
    awry = awry | ((ref.foot_yaw - ref.yaw[:, None]).abs().amax(-1) > 0.35)
    velocity = state.lin_vel[:, body.PELVIS, :2]
    support = ref.foot_pos.mean(1) + rotate_xy(
        ref.yaw, ref.com.new_tensor([config.sole_centre_m, 0.0]).expand_as(ref.com)
    )
    capture = rotate_xy(-ref.yaw, ref.com + velocity * 0.28 - support)
    tipping = (capture[:, 0].abs() > 0.11) | (capture[:, 1].abs() > 0.13)
    bent = (ref.posture[:, 0] < config.walk_height_m - 0.05) | (ref.posture[:, 1] > config.walk_pitch_rad + 0.1)
    # whoever still rises would leave the ground with the first step
    rising = (state.lin_vel[:, body.PELVIS, 2] > config.rising_m_s) & (ref.moving < 0.5)
    want = ((commanded | awry) & ~bent & ~rising) | tipping

    ref.phase = ref.phase + ref.moving * dt / config.step_duration_s
    landed = ref.phase >= 1.0
    stop = landed & ~want
    starting = want & (ref.moving < 0.5)
    # begin with the foot on the side one moves or tips to
    sideways = ref.velocity[:, 1] + 0.3 * ref.velocity[:, 2] + capture[:, 1]
    first = torch.where(sideways > 0, 1, 0)
    ref.swing = torch.where(starting, first, torch.where(landed, 1 - ref.swing, ref.swing))
    ref.phase = torch.where(
        starting | stop, torch.zeros_like(ref.phase), torch.where(landed, ref.phase - 1.0, ref.phase)
    )
    ref.moving = torch.where(
        stop, torch.zeros_like(ref.moving), torch.where(starting, torch.ones_like(ref.moving), ref.moving)
    )
    lifting = starting | (landed & ~stop)
    rows = torch.arange(len(ref.swing), device=ref.swing.device)
    start = torch.cat([ref.foot_pos[rows, ref.swing], ref.foot_yaw[rows, ref.swing, None]], -1)
    ref.swing_start = torch.where(lifting[:, None], start, ref.swing_start)


def _move_anchor(ref: ReferenceState, config: GaitConfig, sway: Tensor, dt: float) -> None:
    """Standing: the centre of mass goes over the feet. Walking: the commanded velocity, leaking toward the
    real pelvis."""
    left = torch.stack([-ref.yaw.sin(), ref.yaw.cos()], -1)
    ahead = torch.stack([ref.yaw.cos(), ref.yaw.sin()], -1)
    over_feet = ref.foot_pos.mean(1) + ahead * config.sole_centre_m - ref.com
    standing = ref.anchor + config.stand_rate * dt * (over_feet - ref.anchor)
    real = -left * sway[:, None]
    walking = ref.anchor + rotate_xy(ref.yaw, ref.velocity[:, :2]) * dt + config.anchor_rate * dt * (real - ref.anchor)
    anchor = torch.where(ref.moving[:, None] > 0, walking, standing)
    ref.anchor = anchor.clamp(-config.anchor_bound_m, config.anchor_bound_m)
    stand_yaw = ref.foot_yaw.mean(1)
    yaw_walk = ref.yaw + ref.velocity[:, 2] * dt - config.anchor_rate * dt * ref.yaw
    yaw_stand = ref.yaw + config.stand_rate * dt * (stand_yaw - ref.yaw)
    ref.yaw = torch.where(ref.moving > 0, yaw_walk, yaw_stand).clamp(-config.yaw_bound_rad, config.yaw_bound_rad)


def _plan_foothold(
    ref: ReferenceState, state: BodyState, config: GaitConfig, sway_velocity: Tensor, stance_side: Tensor
) -> tuple[Tensor, Tensor]:
    """Where the swinging foot should land, (N, 2) and its yaw (N,): half a step ahead plus a capture-point
    correction."""
    remaining = (1 - ref.phase) * config.step_duration_s
    left = torch.stack([-ref.yaw.sin(), ref.yaw.cos()], -1)
    command = rotate_xy(ref.yaw, ref.velocity[:, :2])
    measured = state.lin_vel[:, body.PELVIS, :2]
    error = (measured - command - left * sway_velocity[:, None]).clamp(-0.8, 0.8)
    travel = (command + config.travel_share * error) * remaining[:, None]
    yaw = ref.yaw + ref.velocity[:, 2] * (remaining + 0.25 * config.step_duration_s)
    ahead = torch.stack([yaw.cos(), yaw.sin()], -1)
    side = torch.stack([-yaw.sin(), yaw.cos()], -1)
    swing_side = -stance_side
    # a foot that closes up sideways must still land beside the other one: sidestepping needs a wider stance
    width = 0.5 * (config.closest_feet_m + ref.velocity[:, 1].abs() * config.step_duration_s)
    width = width.clamp(min=config.half_stance_m)
    hold = ref.com - ahead * config.sole_centre_m + side * (swing_side * width)[:, None] + travel
    hold = hold + command * (config.step_ahead * config.step_duration_s) + config.capture_gain_s * error
    rows = torch.arange(len(yaw), device=yaw.device)
    stance_foot = ref.foot_pos[rows, 1 - ref.swing]
    offset = hold - stance_foot
    along = (offset * ahead).sum(-1).clamp(-0.45, 0.65)
    across = (offset * side).sum(-1) * swing_side
    across = across.clamp(config.closest_feet_m, 0.50) * swing_side
    return stance_foot + ahead * along[:, None] + side * across[:, None], yaw
