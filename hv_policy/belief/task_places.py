"""From a view of a task to its places, and back: what the networks learn to see, and what is decided from."""

from __future__ import annotations

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
    PICK_TURN,
    PLACE,
    PLACE_TURN,
    SPAN,
    WAYPOINT,
    to_frame,
    turned,
)  # fmt: skip
from hv_policy.decision.view import TaskView, to_heading
from hv_policy.motor import embodiment
from hv_policy.motor.proprioception import BodyState


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
    places = to_frame(places_h, pose)
    cos, sin = pose[:, 2].cos()[:, None], pose[:, 2].sin()[:, None]

    def moved(points_h: Tensor) -> Tensor:
        n, count = points_h.shape[:2]
        xy = turned(points_h[..., :2].flatten(0, 1), cos.repeat_interleave(count, 0), sin.repeat_interleave(count, 0))
        return torch.cat([xy.unflatten(0, (n, count)) + pose[:, None, :2], points_h[..., 2:]], -1)

    def stand(place: slice, turn: slice) -> Tensor:
        return torch.cat([places[:, place], torch.atan2(places[:, turn][:, 1:], places[:, turn][:, :1])], 1)

    middle = places[:, OBJECT] + places[:, MIDDLE]
    span = places[:, SPAN]
    return TaskView(
        root_xy=pose[:, :2],
        root_yaw=pose[:, 2],
        feet_xy=moved(body.pos[:, embodiment.FEET])[..., :2].mean(1),
        hands=moved(body.pos[:, embodiment.HANDS]),
        object_pos=places[:, OBJECT],
        grasp=torch.stack([middle - span, middle + span], 1),
        depth_m=places[:, DEPTH][:, 0].clamp(min=0.05),
        goal_pos=places[:, GOAL],
        pick_stand=stand(PICK, PICK_TURN),
        place_stand=stand(PLACE, PLACE_TURN),
        waypoint=turned(way[:, WAYPOINT], cos, sin) + pose[:, :2],
        waypoint_is_last=way[:, IS_LAST] > 0.5,
        may_back=way[:, MAY_BACK] > 0.5,
        clearance_m=way[:, CLEARANCE][:, 0],
        away=turned(way[:, AWAY], cos, sin),
    )


def leg_is_done(way: Tensor) -> Tensor:
    """(N,) bool of way (N, 8)."""
    return way[:, LEG_IS_DONE] > 0.5
