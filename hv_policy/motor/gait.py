"""How a walking body is planned, one robot after the other, compiled (numba): steps, sway, anchor and footholds.

Planar quantities are in the robot's heading frame and are carried along by its measured motion.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numba
import numpy as np

from hv_policy.motor import embodiment as body
from hv_policy.motor.intent import GAZE, HEIGHT, LEFT_HAND, PITCH, RIGHT_HAND, SQUEEZE
from hv_policy.motor.kinematics import Array
from hv_policy.motor.vectors import (
    Vector,
    about_y,
    about_z,
    add,
    clip,
    columns_at,
    norm,
    product,
    scaled,
    sub,
    times,
    turned_xy,
    vector_at,
)

PELVIS_PITCH_SHARE = 0.42
"""Share of the torso pitch that the pelvis takes; the abdomen takes the rest."""


@dataclass(frozen=True)
class GaitConfig:
    """Timing and bounds of the reference. The defaults were chosen by survival without learning
    (docs/motor_prior.md)."""

    step_duration_s: float = 0.30
    double_support: float = 0.2
    half_stance_m: float = 0.095
    clearance_m: float = 0.06
    closest_feet_m: float = 0.13
    sway_m: float = 0.008
    sole_centre_m: float = 0.035
    capture_gain_s: float = 0.18
    swing_lead_s: float = 0.05
    step_ahead: float = 0.28
    travel_share: float = 0.7
    max_acceleration: tuple[float, float, float] = (1.6, 1.2, 4.0)
    anchor_rate: float = 10.0
    anchor_bound_m: float = 0.12
    yaw_bound_rad: float = 0.35
    stand_rate: float = 8.0
    com_gain: float = 0.5
    joint_speed_limit: float = 8.0
    walk_height_m: float = 0.74
    walk_pitch_rad: float = 0.5
    rising_m_s: float = 0.2


class Remembered(NamedTuple):
    """What the compiled part changes of a `ReferenceState`, as arrays."""

    velocity: Any
    posture: Any
    hands: Any
    squeeze: Any
    gaze: Any
    phase: Any
    swing: Any
    moving: Any
    anchor: Any
    yaw: Any
    foot_pos: Any
    foot_yaw: Any
    swing_start: Any
    com: Any
    last_velocity: Any
    load: Any


class Plan(NamedTuple):
    """What it says of a `Reference`."""

    pelvis_pos: Any
    pelvis_rot: Any
    velocity: Any
    stance: Any
    foot_target: Any
    foothold: Any


PLAN_SHAPES = ((3,), (3, 3), (3,), (2,), (2, 3), (2,))
_Gait = NamedTuple("_Gait", [(f.name, Any) for f in fields(GaitConfig)])  # type: ignore[misc]
_MASS, _OFFSET = body.BODY_MASS_KG.double().numpy(), body.BODY_COM_M.double().numpy()
_TOTAL_MASS = float(_MASS.sum())
_PELVIS, _RIGHT_HAND, _LEFT_HAND = body.PELVIS, *body.HANDS
_FOOT = tuple(body.FEET)
_FIRST_OF_LEFT_HAND, _FIRST_OF_RIGHT_HAND, _FIRST_OF_GAZE = LEFT_HAND.start, RIGHT_HAND.start, GAZE.start


@functools.cache
def gait_of(config: GaitConfig) -> Any:
    """The configuration as compiled code can read it, with the same fields."""
    return _Gait(*(getattr(config, f.name) for f in fields(config)))


@numba.njit(cache=True)
def advance_gait(
    ref: Remembered, plan: Plan, pos: Array, rot: Array, lin_vel: Array, ang_vel: Array, intent: Array,
    gait: GaitConfig,
) -> None:  # fmt: skip
    """One control step of every robot: what is remembered, in place, and the plan.

    Args:
        ref: rows of a `ReferenceState`, as arrays. plan: to be written.
        pos, rot, lin_vel, ang_vel: of a `BodyState`.
        intent: (N, 14).
        gait: of `gait_of`.
    """
    dt, margin = body.CONTROL_DT_S, gait.double_support / 2
    for i in range(len(intent)):
        _carry_along(ref, i, pos, rot, lin_vel, ang_vel, gait, dt)
        _filter_intent(ref, i, lin_vel, intent, gait, dt)
        _step_clock(ref, i, lin_vel, gait, dt)

        # the pelvis sways over the standing foot: raised cosine over the step, toward the stance side
        phase, moving, swing = np.float64(ref.phase[i]), np.float64(ref.moving[i]), ref.swing[i]
        stance_side = 1.0 if swing == 0 else -1.0
        sway = moving * stance_side * gait.sway_m * math.sin(math.pi * phase)
        omega = math.pi / gait.step_duration_s
        sway_velocity = moving * stance_side * gait.sway_m * omega * math.cos(math.pi * phase)
        _move_anchor(ref, i, gait, sway, dt)
        yaw, pitch = np.float64(ref.yaw[i]), np.float64(ref.posture[i, 1])
        left_x, left_y = -math.sin(yaw), math.cos(yaw)
        plan.pelvis_pos[i, 0] = ref.anchor[i, 0] + left_x * sway
        plan.pelvis_pos[i, 1] = ref.anchor[i, 1] + left_y * sway
        plan.pelvis_pos[i, 2] = ref.posture[i, 0]
        turned = product(about_z(yaw), about_y(pitch * PELVIS_PITCH_SHARE))
        for row in range(3):
            for column in range(3):
                plan.pelvis_rot[i, row, column] = turned[column][row]
        forward, leftward = turned_xy(yaw, ref.velocity[i, 0], ref.velocity[i, 1])
        plan.velocity[i, 0] = forward + left_x * sway_velocity
        plan.velocity[i, 1] = leftward + left_y * sway_velocity
        plan.velocity[i, 2] = ref.velocity[i, 2]

        hold_x, hold_y, hold_yaw = _plan_foothold(ref, i, lin_vel, gait, sway_velocity, stance_side)
        plan.foothold[i, 0], plan.foothold[i, 1] = hold_x, hold_y
        in_air = moving > 0.0 and 0.0 < (phase - margin) / (1 - gait.double_support) < 1.0
        # the servos lag behind a swinging leg's inertia: ask for where the foot should be a little later
        lead = gait.swing_lead_s / gait.step_duration_s
        progress = clip((phase + lead - margin) / (1 - gait.double_support), 0.0, 1.0)
        smooth = progress * progress * (3 - 2 * progress)
        for foot in range(2):
            lift = 0.0
            if in_air and foot == swing:
                start_x, start_y, start_yaw = ref.swing_start[i, 0], ref.swing_start[i, 1], ref.swing_start[i, 2]
                ref.foot_pos[i, foot, 0] = start_x + (hold_x - start_x) * smooth
                ref.foot_pos[i, foot, 1] = start_y + (hold_y - start_y) * smooth
                ref.foot_yaw[i, foot] = start_yaw + (hold_yaw - start_yaw) * smooth
                lift = gait.clearance_m * math.sin(math.pi * progress) ** 2
            plan.stance[i, foot] = 0.0 if in_air and foot == swing else 1.0
            plan.foot_target[i, foot, 0] = ref.foot_pos[i, foot, 0]
            plan.foot_target[i, foot, 1] = ref.foot_pos[i, foot, 1]
            plan.foot_target[i, foot, 2] = body.ANKLE_HEIGHT_M + lift


@numba.njit(cache=True)
def loaded_com_at(pos: Array, rot: Array, i: int, load: float) -> Vector:
    """Centre of mass of robot i and of what it holds, whose weight is `load` in N, between its hands."""
    total = (0.0, 0.0, 0.0)
    for link in range(len(_MASS)):
        offset = (_OFFSET[link, 0], _OFFSET[link, 1], _OFFSET[link, 2])
        centre = add(vector_at(pos, i, link), times(columns_at(rot, i, link), offset))
        total = add(total, scaled(centre, _MASS[link]))
    held = scaled(add(vector_at(pos, i, _RIGHT_HAND), vector_at(pos, i, _LEFT_HAND)), 0.5)
    mass, whole = load / body.GRAVITY, body.TOTAL_MASS_KG
    return scaled(add(scaled(total, whole / _TOTAL_MASS), scaled(held, mass)), 1.0 / (whole + mass))


@numba.njit(cache=True)
def _carry_along(
    ref: Remembered, i: int, pos: Array, rot: Array, lin_vel: Array, ang_vel: Array, gait: GaitConfig, dt: float
) -> None:
    """Re-expresses what is remembered in the heading frame after the robot's motion of one step."""
    # rate of the yaw of the pelvis' x axis, not its angular velocity's z component when it is pitched
    rate = ang_vel[i, _PELVIS, 2] - ang_vel[i, _PELVIS, 0] * rot[i, _PELVIS, 2, 0] / max(rot[i, _PELVIS, 0, 0], 0.2)
    now_x, now_y = np.float64(lin_vel[i, _PELVIS, 0]), np.float64(lin_vel[i, _PELVIS, 1])
    last = ref.last_velocity
    turn = 0.5 * (rate + last[i, 2]) * dt
    last_x, last_y = turned_xy(-turn, last[i, 0], last[i, 1])
    moved_x, moved_y = 0.5 * (now_x + last_x) * dt, 0.5 * (now_y + last_y) * dt
    x, y = turned_xy(-turn, ref.anchor[i, 0], ref.anchor[i, 1])
    ref.anchor[i, 0], ref.anchor[i, 1] = x - moved_x, y - moved_y
    x, y = turned_xy(-turn, ref.swing_start[i, 0], ref.swing_start[i, 1])
    ref.swing_start[i, 0], ref.swing_start[i, 1] = x - moved_x, y - moved_y
    ref.swing_start[i, 2] -= turn
    ref.com[i, 0], ref.com[i, 1] = turned_xy(-turn, ref.com[i, 0], ref.com[i, 1])
    ref.yaw[i] -= turn
    last[i, 0], last[i, 1], last[i, 2] = now_x, now_y, rate
    for foot in range(2):
        x, y = turned_xy(-turn, ref.foot_pos[i, foot, 0], ref.foot_pos[i, foot, 1])
        ref.foot_pos[i, foot, 0], ref.foot_pos[i, foot, 1] = x - moved_x, y - moved_y
        ref.foot_yaw[i, foot] -= turn
        # feet that stand are seen: correct the drift of the dead reckoning
        link = _FOOT[foot]
        swinging = ref.moving[i] > 0 and ref.swing[i] == foot
        if not swinging and pos[i, link, 2] < 0.09:
            yaw = math.atan2(rot[i, link, 1, 0], rot[i, link, 0, 0])
            ref.foot_pos[i, foot, 0] += 0.25 * (pos[i, link, 0] - ref.foot_pos[i, foot, 0])
            ref.foot_pos[i, foot, 1] += 0.25 * (pos[i, link, 1] - ref.foot_pos[i, foot, 1])
            ref.foot_yaw[i, foot] += 0.25 * (yaw - ref.foot_yaw[i, foot])
    com = loaded_com_at(pos, rot, i, ref.load[i])
    ref.com[i, 0] += gait.com_gain * (com[0] - ref.com[i, 0])
    ref.com[i, 1] += gait.com_gain * (com[1] - ref.com[i, 1])


@numba.njit(cache=True)
def _filter_intent(ref: Remembered, i: int, lin_vel: Array, intent: Array, gait: GaitConfig, dt: float) -> None:
    # who cannot step yet does not gather speed: the first step would be one at full speed
    held = ref.moving[i] < 0.5 and (_is_bent(ref, i, gait) or lin_vel[i, _PELVIS, 2] > gait.rising_m_s)
    for k in range(3):
        limit = gait.max_acceleration[k] * dt
        goal = 0.0 if held else np.float64(intent[i, k])
        ref.velocity[i, k] += clip(goal - ref.velocity[i, k], -limit, limit)
    # no bending while stepping: the feet come to rest first (and from a bend the body rises before it walks off)
    stepping = ref.moving[i] > 0
    height = max(np.float64(intent[i, HEIGHT]), gait.walk_height_m if stepping else -np.inf)
    pitch = min(np.float64(intent[i, PITCH]), gait.walk_pitch_rad if stepping else np.inf)
    ref.posture[i, 0] += clip(5.0 * (height - ref.posture[i, 0]), -0.5, 0.5) * dt
    ref.posture[i, 1] += clip(5.0 * (pitch - ref.posture[i, 1]), -1.4, 1.4) * dt
    for hand, first in enumerate((_FIRST_OF_RIGHT_HAND, _FIRST_OF_LEFT_HAND)):
        wanted = (np.float64(intent[i, first]), np.float64(intent[i, first + 1]), np.float64(intent[i, first + 2]))
        gap = sub(wanted, vector_at(ref.hands, i, hand))
        speed = max(10.0 * norm(gap), 1e-6)
        share = min(speed, 1.2) / speed * (10.0 * dt)
        for k in range(3):
            ref.hands[i, hand, k] += gap[k] * share
    ref.squeeze[i] += clip(intent[i, SQUEEZE] - ref.squeeze[i], -3.0 * dt, 3.0 * dt)
    for k in range(2):
        ref.gaze[i, k] += clip(intent[i, _FIRST_OF_GAZE + k] - ref.gaze[i, k], -3.0 * dt, 3.0 * dt)


@numba.njit(cache=True)
def _is_bent(ref: Remembered, i: int, gait: GaitConfig) -> bool:
    """The body has been told to be lower, or more bent, than one can walk."""
    return ref.posture[i, 0] < gait.walk_height_m - 0.05 or ref.posture[i, 1] > gait.walk_pitch_rad + 0.1


@numba.njit(cache=True)
def _step_clock(ref: Remembered, i: int, lin_vel: Array, gait: GaitConfig, dt: float) -> None:
    """Advances the gait phase, changes feet, starts and stops stepping."""
    forward, leftward, turning = ref.velocity[i, 0], ref.velocity[i, 1], ref.velocity[i, 2]
    commanded = math.sqrt(forward**2 + leftward**2) > 0.06 or abs(turning) > 0.12
    yaw, feet, yaws = np.float64(ref.yaw[i]), ref.foot_pos, ref.foot_yaw
    apart_x, apart_y = turned_xy(-yaw, feet[i, 1, 0] - feet[i, 0, 0], feet[i, 1, 1] - feet[i, 0, 1])
    awry = abs(apart_x) > 0.10 or abs(apart_y - 2 * gait.half_stance_m) > 0.08
    awry = awry or max(abs(yaws[i, 0] - yaw), abs(yaws[i, 1] - yaw)) > 0.35
    sole_x, sole_y = turned_xy(yaw, gait.sole_centre_m, 0.0)
    capture_x, capture_y = turned_xy(
        -yaw,
        ref.com[i, 0] + 0.28 * lin_vel[i, _PELVIS, 0] - (0.5 * (feet[i, 0, 0] + feet[i, 1, 0]) + sole_x),
        ref.com[i, 1] + 0.28 * lin_vel[i, _PELVIS, 1] - (0.5 * (feet[i, 0, 1] + feet[i, 1, 1]) + sole_y),
    )
    tipping = abs(capture_x) > 0.11 or abs(capture_y) > 0.13
    bent = _is_bent(ref, i, gait)
    # whoever still rises would leave the ground with the first step
    rising = lin_vel[i, _PELVIS, 2] > gait.rising_m_s and ref.moving[i] < 0.5
    want = ((commanded or awry) and not bent and not rising) or tipping

    ref.phase[i] += ref.moving[i] * dt / gait.step_duration_s
    landed = ref.phase[i] >= 1.0
    stop, starting = landed and not want, want and ref.moving[i] < 0.5
    if starting:  # with the foot on the side one moves or tips to
        ref.swing[i] = 1 if leftward + 0.3 * turning + capture_y > 0 else 0
    elif landed:
        ref.swing[i] = 1 - ref.swing[i]
    if starting or stop:
        ref.phase[i] = 0.0
    elif landed:
        ref.phase[i] -= 1.0
    if stop:
        ref.moving[i] = 0.0
    elif starting:
        ref.moving[i] = 1.0
    if starting or (landed and not stop):
        foot = ref.swing[i]
        ref.swing_start[i, 0], ref.swing_start[i, 1] = feet[i, foot, 0], feet[i, foot, 1]
        ref.swing_start[i, 2] = yaws[i, foot]


@numba.njit(cache=True)
def _move_anchor(ref: Remembered, i: int, gait: GaitConfig, sway: float, dt: float) -> None:
    """Standing: the centre of mass goes over the feet. Walking: the commanded velocity, leaking to the real pelvis."""
    yaw, feet, bound = np.float64(ref.yaw[i]), ref.foot_pos, gait.anchor_bound_m
    ahead, left = (math.cos(yaw), math.sin(yaw)), (-math.sin(yaw), math.cos(yaw))
    step = turned_xy(yaw, ref.velocity[i, 0], ref.velocity[i, 1])
    for k in range(2):
        anchor = np.float64(ref.anchor[i, k])
        if ref.moving[i] > 0:
            anchor += step[k] * dt + gait.anchor_rate * dt * (-left[k] * sway - anchor)
        else:
            over_feet = 0.5 * (feet[i, 0, k] + feet[i, 1, k]) + ahead[k] * gait.sole_centre_m - ref.com[i, k]
            anchor += gait.stand_rate * dt * (over_feet - anchor)
        ref.anchor[i, k] = clip(anchor, -bound, bound)
    if ref.moving[i] > 0:
        yaw += ref.velocity[i, 2] * dt - gait.anchor_rate * dt * yaw
    else:
        yaw += gait.stand_rate * dt * (0.5 * (ref.foot_yaw[i, 0] + ref.foot_yaw[i, 1]) - yaw)
    ref.yaw[i] = clip(yaw, -gait.yaw_bound_rad, gait.yaw_bound_rad)


@numba.njit(cache=True)
def _plan_foothold(
    ref: Remembered, i: int, lin_vel: Array, gait: GaitConfig, sway_velocity: float, stance_side: float
) -> tuple[float, float, float]:
    """Where the swinging foot should land, x, y and yaw: half a step ahead plus a capture-point correction."""
    remaining, now = (1 - ref.phase[i]) * gait.step_duration_s, np.float64(ref.yaw[i])
    command_x, command_y = turned_xy(now, ref.velocity[i, 0], ref.velocity[i, 1])
    error_x = clip(lin_vel[i, _PELVIS, 0] - command_x + math.sin(now) * sway_velocity, -0.8, 0.8)
    error_y = clip(lin_vel[i, _PELVIS, 1] - command_y - math.cos(now) * sway_velocity, -0.8, 0.8)
    yaw = now + ref.velocity[i, 2] * (remaining + 0.25 * gait.step_duration_s)
    ahead_x, ahead_y = math.cos(yaw), math.sin(yaw)
    swing_side = -stance_side
    # a foot that closes up sideways must still land beside the other one: sidestepping needs a wider stance
    width = 0.5 * (gait.closest_feet_m + abs(ref.velocity[i, 1]) * gait.step_duration_s)
    width = swing_side * max(width, gait.half_stance_m)
    further, correction = gait.step_ahead * gait.step_duration_s + remaining, gait.capture_gain_s
    correction += gait.travel_share * remaining
    hold_x = ref.com[i, 0] - ahead_x * gait.sole_centre_m - ahead_y * width + command_x * further + correction * error_x
    hold_y = ref.com[i, 1] - ahead_y * gait.sole_centre_m + ahead_x * width + command_y * further + correction * error_y
    foot = 1 - ref.swing[i]
    stance_x, stance_y = np.float64(ref.foot_pos[i, foot, 0]), np.float64(ref.foot_pos[i, foot, 1])
    offset_x, offset_y = hold_x - stance_x, hold_y - stance_y
    along = clip(offset_x * ahead_x + offset_y * ahead_y, -0.45, 0.65)
    across = (offset_y * ahead_x - offset_x * ahead_y) * swing_side
    across = clip(across, gait.closest_feet_m, 0.50) * swing_side
    return stance_x + ahead_x * along - ahead_y * across, stance_y + ahead_y * along + ahead_x * across, yaw
