"""What the networks that decide are shown: numbers, and the places for the hands that they may mix.

Compiled, one robot after the other: it is a few hundred numbers, each of them simple.
"""

from __future__ import annotations

import math
from typing import Protocol

import numba
import numpy as np
import torch
from torch import Tensor

from hv_policy.decision.view import TaskView
from hv_policy.motor.intent import LEFT_HAND, RIGHT_HAND, neutral_intent
from hv_policy.motor.kinematics import Array, as_arrays
from hv_policy.motor.vectors import Vector, clip, sub, turned_xy, vector_at

OBSERVATION_DIM = 223 + 15 + 9 + 3 + 3
ROUTE_DIM = 6 + 4 + 4 + 1 + 1 + 1
NEAR_DIM = 6 + 3 + 3 + 3 + 3 + 3 + 2 + 4
SIGHT_DIM = OBSERVATION_DIM + ROUTE_DIM + NEAR_DIM
ANCHORS = ("neutral", "hands", "grasp", "begun", "placed", "picked", "chest")
ANCHOR_DIM = 6 * len(ANCHORS)
_WAYPOINT = 223 + 15 + 9
_NEUTRAL = neutral_intent(1)[0]
_REST = torch.stack([_NEUTRAL[RIGHT_HAND], _NEUTRAL[LEFT_HAND]]).double().numpy()
_MOST = 2.0
"""What is near is told in fine units, up to so many of them."""


class Observed(Protocol):
    """The privileged observations of the paper (Tables 9 to 11), heading frame."""

    proprioception: Tensor  # (N, 223)
    object: Tensor  # (N, 15)
    goal: Tensor  # (N, 9)
    waypoint: Tensor  # (N, 3)
    half_extents: Tensor  # (N, 3)


def sight(observation: Observed, view: TaskView, leg_is_done: Tensor, picked_up: Tensor) -> Tensor:
    """(N, SIGHT_DIM) what is seen now: observations, route, and what is near in fine units.

    Beside section 3's observations (253 numbers and the geometry) the teacher sees what the planner sees and they do
    not determine: which side of the object the route takes it from (grasp points), where to stand for it at both ends,
    and whether the current waypoint is the last of its leg.
    """
    seen = torch.empty(len(view.root_xy), SIGHT_DIM)
    parts = (observation.proprioception, observation.object, observation.goal, observation.waypoint)
    torch.cat([*parts, observation.half_extents], -1, out=seen[:, :OBSERVATION_DIM])
    flags = as_arrays(leg_is_done, picked_up, view.may_back)
    route = as_arrays(view.depth_m, view.clearance_m, view.away, view.pick_stand, view.place_stand)
    _fill_sights(seen.numpy(), *_whereabouts(view), *route, *flags)
    return seen


def hand_anchors(view: TaskView, memory: Tensor) -> Tensor:
    """(N, 42) seven places for the (right, left) hand in the order of `ANCHORS`; heading frame, z above the floor.

    Args:
        view: what there is to see.
        memory: (N, 18), `TaskMemory.vector`.
    """
    anchors = torch.empty(len(memory), len(ANCHORS), 2, 3)
    _fill_anchors(anchors.numpy(), *_whereabouts(view), *as_arrays(view.depth_m, memory), _REST)
    return anchors.flatten(1)


def _whereabouts(view: TaskView) -> list[Array]:
    """Robot (xy, yaw), hands, grasp, object and goal of a view."""
    points = view.object_pos[:, None], view.goal_pos[:, None]
    return as_arrays(view.root_xy, view.root_yaw, view.hands, view.grasp, *points)


@numba.njit(cache=True)
def _robot_at(root_xy: Array, root_yaw: Array, i: int) -> Vector:
    """x, y and yaw of robot `i`."""
    return np.float64(root_xy[i, 0]), np.float64(root_xy[i, 1]), np.float64(root_yaw[i])


@numba.njit(cache=True)
def _to_heading(point: Vector, robot: Vector) -> Vector:
    """As `hv_policy.decision.view.to_heading`."""
    ahead, aside = turned_xy(-robot[2], point[0] - robot[0], point[1] - robot[1])
    return ahead, aside, point[2]


@numba.njit(cache=True)
def _near(value: float, unit: float) -> float:
    return clip(value / unit, -_MOST, _MOST)


@numba.njit(cache=True)
def _put(row: Array, at: int, values: Vector) -> int:
    """Writes three numbers; returns where the next one goes."""
    row[at], row[at + 1], row[at + 2] = values
    return at + 3


@numba.njit(cache=True)
def _put_near(row: Array, at: int, values: Vector, unit: float) -> int:
    return _put(row, at, (_near(values[0], unit), _near(values[1], unit), _near(values[2], unit)))


@numba.njit(cache=True)
def _fill_sights(
    out: Array,
    root_xy: Array,
    root_yaw: Array,
    hands: Array,
    grasp: Array,
    obj: Array,
    goal: Array,
    depth: Array,
    clearance: Array,
    away: Array,
    pick: Array,
    place: Array,
    leg_is_done: Array,
    picked_up: Array,
    may_back: Array,
) -> None:
    """Writes route and nearness into sights (N, SIGHT_DIM) whose observations are there."""
    for i in range(len(out)):
        row = out[i]
        robot = _robot_at(root_xy, root_yaw, i)
        o = _to_heading(vector_at(obj, i, 0), robot)
        g = _to_heading(vector_at(goal, i, 0), robot)
        right, left = vector_at(hands, i, 0), vector_at(hands, i, 1)
        right, left = _to_heading(right, robot), _to_heading(left, robot)
        at = OBSERVATION_DIM
        near = at + ROUTE_DIM
        for k, hand in ((0, right), (1, left)):
            touch = _to_heading(vector_at(grasp, i, k), robot)
            at = _put(row, at, touch)
            near = _put_near(row, near, sub(touch, hand), 0.15)
        near = _put_near(row, near, sub(o, g), 0.2)
        for stands in (pick, place):
            there = np.float64(stands[i, 0]), np.float64(stands[i, 1]), 0.0
            there = _to_heading(there, robot)
            turn = np.float64(stands[i, 2]) - robot[2]
            row[at], row[at + 1], row[at + 2], row[at + 3] = there[0], there[1], math.cos(turn), math.sin(turn)
            at += 4
            near = _put_near(row, near, (there[0], there[1], math.atan2(math.sin(turn), math.cos(turn))), 0.3)
        row[at], row[at + 1], row[at + 2] = depth[i], leg_is_done[i], picked_up[i]
        ahead, aside = np.float64(row[_WAYPOINT]), np.float64(row[_WAYPOINT + 1])
        distance = math.hypot(ahead, aside)
        least = max(distance, 1e-3)
        near = _put(row, near, (ahead / least, aside / least, min(distance, 1.0)))
        between = (right[0] + left[0]) / 2, (right[1] + left[1]) / 2, (right[2] + left[2]) / 2
        near = _put_near(row, near, sub(o, between), 0.25)
        row[near] = _near(math.hypot(o[0], o[1]) - 1.15, 0.3)
        row[near + 1] = _near(np.float64(obj[i, 0, 2]) - np.float64(goal[i, 0, 2]), 0.05)
        row[near + 2] = _near(np.float64(clearance[i]) - 0.34, 0.12)
        row[near + 3], row[near + 4] = turned_xy(-robot[2], np.float64(away[i, 0]), np.float64(away[i, 1]))
        row[near + 5] = may_back[i]


@numba.njit(cache=True)
def _fill_anchors(
    out: Array,
    root_xy: Array,
    root_yaw: Array,
    hands: Array,
    grasp: Array,
    obj: Array,
    goal: Array,
    depth: Array,
    memory: Array,
    rest: Array,
) -> None:
    """Writes anchors (N, 7, 2, 3)."""
    for i in range(len(out)):
        robot = _robot_at(root_xy, root_yaw, i)
        g = _to_heading(vector_at(goal, i, 0), robot)
        begun, offset, picked = memory[i, 2:8], memory[i, 8:14], memory[i, 14:17]
        ahead = max(0.2 + depth[i] / 2, 0.34)
        height = max(max(memory[i, 17], goal[i, 0, 2]) + 0.12, 1.0)
        middle_x, middle_y = (offset[0] + offset[3]) / 2, (offset[1] + offset[4]) / 2
        for k in range(2):
            hand = _to_heading(vector_at(hands, i, k), robot)
            touch = _to_heading(vector_at(grasp, i, k), robot)
            for d in range(3):
                from_object = offset[3 * k + d]
                out[i, 0, k, d] = rest[k, d]
                out[i, 1, k, d] = hand[d]
                out[i, 2, k, d] = touch[d]
                out[i, 3, k, d] = begun[3 * k + d]
                out[i, 4, k, d] = g[d] + from_object
                out[i, 5, k, d] = picked[d] + from_object
            out[i, 6, k, 0] = ahead + offset[3 * k] - middle_x
            out[i, 6, k, 1] = offset[3 * k + 1] - middle_y
            out[i, 6, k, 2] = height + offset[3 * k + 2]
