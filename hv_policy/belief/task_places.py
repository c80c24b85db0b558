"""From a view of a task to its places, and back: what the networks learn to see, and what is decided from."""

from __future__ import annotations

import math

import numba
import numpy as np
import torch
from torch import Tensor

from hv_policy.belief.places import (
    AWAY,
    CLEARANCE,
    DEPTH,
    GOAL,
    IS_LAST,
    LEG_IS_DONE,
    MAY_BACK,
    MIDDLE,
    OBJECT,
    PICK,
    PLACE,
    SPAN,
    WAYPOINT,
    to_frame,
    turned,
)  # fmt: skip
from hv_policy.decision.view import TaskView, to_heading
from hv_policy.motor import embodiment
from hv_policy.motor.kinematics import Array, as_arrays
from hv_policy.motor.proprioception import BodyState

_OBJECT, _SPAN, _MIDDLE, _PICK, _PLACE = (part.start for part in (OBJECT, SPAN, MIDDLE, PICK, PLACE))
_WAYPOINT, _AWAY = WAYPOINT.start, AWAY.start


def places_of(view: TaskView) -> Tensor:
    """(N, 21) the places of a view, heading frame (`hv_policy.belief.places`)."""
    obj = to_heading(view, view.object_pos[:, None])[:, 0]
    goal = to_heading(view, view.goal_pos[:, None])[:, 0]
    right, left = to_heading(view, view.grasp).unbind(1)
    stands = []
    for stand in (view.pick_stand, view.place_stand):
        xy = to_heading(view, torch.cat([stand[:, :2], torch.zeros_like(stand[:, :1])], -1)[:, None])[:, 0, :2]
        turn = stand[:, 2:] - view.root_yaw[:, None]
        stands += [xy, turn.cos(), turn.sin()]
    middle = (right + left) / 2 - obj
    return torch.cat([obj, goal, (left - right) / 2, middle, *stands, view.depth_m[:, None]], 1)


def way_of(view: TaskView, leg_is_done: Tensor) -> Tensor:
    """(N, 8) what else a view says about the way (`hv_policy.belief.places`).

    Args:
        view: what there is to see.
        leg_is_done: (N,) bool: the waypoint is the last one of its leg.
    """
    waypoint = torch.cat([view.waypoint, torch.zeros_like(view.waypoint[:, :1])], -1)
    xy = to_heading(view, waypoint[:, None])[:, 0, :2]
    away = turned(view.away, view.root_yaw.cos()[:, None], -view.root_yaw.sin()[:, None])
    flags = torch.stack([view.waypoint_is_last, view.may_back, leg_is_done], -1)
    return torch.cat([xy, away, view.clearance_m[:, None], flags.to(xy)], 1)


def view_of(places_h: Tensor, way: Tensor, body: BodyState, pose: Tensor) -> TaskView:
    """The view that places (N, 21) and way (N, 8, flags 0 or 1) amount to, both in the heading frame.

    Args:
        places_h, way: see `hv_policy.belief.places`.
        body: of the robot.
        pose: (N, 3) x, y, yaw of the robot, in the frame that the view shall be in.
    """
    n = len(places_h)
    feet, hands, grasp = torch.empty(n, 2), torch.empty(n, 2, 3), torch.empty(n, 2, 3)
    pick, place, waypoint, away = torch.empty(n, 3), torch.empty(n, 3), torch.empty(n, 2), torch.empty(n, 2)
    places = to_frame(places_h, pose)
    links = body.pos[:, embodiment.FEET], body.pos[:, embodiment.HANDS]
    outputs = (value.numpy() for value in (feet, hands, grasp, pick, place, waypoint, away))
    _fill_view(*as_arrays(places, way, *links, pose), *outputs)
    return TaskView(
        root_xy=pose[:, :2],
        root_yaw=pose[:, 2],
        feet_xy=feet,
        hands=hands,
        object_pos=places[:, OBJECT],
        grasp=grasp,
        depth_m=places[:, DEPTH][:, 0].clamp(min=0.05),
        goal_pos=places[:, GOAL],
        pick_stand=pick,
        place_stand=place,
        waypoint=waypoint,
        waypoint_is_last=way[:, IS_LAST] > 0.5,
        may_back=way[:, MAY_BACK] > 0.5,
        clearance_m=way[:, CLEARANCE][:, 0],
        away=away,
    )


@numba.njit(cache=True)
def _fill_view(
    places: Array,
    way: Array,
    feet_h: Array,
    hands_h: Array,
    pose: Array,
    feet: Array,
    hands: Array,
    grasp: Array,
    pick: Array,
    place: Array,
    waypoint: Array,
    away: Array,
) -> None:
    """What `view_of` says that is not in places (N, 21) as it is; feet_h, hands_h: (N, 2, 3), heading frame."""
    for i in range(len(places)):
        x, y, yaw = np.float64(pose[i, 0]), np.float64(pose[i, 1]), np.float64(pose[i, 2])
        cos, sin = math.cos(yaw), math.sin(yaw)
        ahead, aside = (feet_h[i, 0, 0] + feet_h[i, 1, 0]) / 2, (feet_h[i, 0, 1] + feet_h[i, 1, 1]) / 2
        feet[i, 0], feet[i, 1] = cos * ahead - sin * aside + x, sin * ahead + cos * aside + y
        ahead, aside = way[i, _WAYPOINT], way[i, _WAYPOINT + 1]
        waypoint[i, 0], waypoint[i, 1] = cos * ahead - sin * aside + x, sin * ahead + cos * aside + y
        ahead, aside = way[i, _AWAY], way[i, _AWAY + 1]
        away[i, 0], away[i, 1] = cos * ahead - sin * aside, sin * ahead + cos * aside
        for k in range(2):
            ahead, aside = hands_h[i, k, 0], hands_h[i, k, 1]
            hands[i, k, 0], hands[i, k, 1] = cos * ahead - sin * aside + x, sin * ahead + cos * aside + y
            hands[i, k, 2] = hands_h[i, k, 2]
            for d in range(3):
                middle = places[i, _OBJECT + d] + places[i, _MIDDLE + d]
                grasp[i, k, d] = middle + (2 * k - 1) * places[i, _SPAN + d]
        for d in range(2):
            pick[i, d], place[i, d] = places[i, _PICK + d], places[i, _PLACE + d]
        pick[i, 2] = math.atan2(places[i, _PICK + 3], places[i, _PICK + 2])
        place[i, 2] = math.atan2(places[i, _PLACE + 3], places[i, _PLACE + 2])


def leg_is_done(way: Tensor) -> Tensor:
    """(N,) bool of way (N, 8)."""
    return way[:, LEG_IS_DONE] > 0.5
