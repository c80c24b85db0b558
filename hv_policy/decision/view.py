"""What the work at one object is decided by: where everything is, and which part of the work it is."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import torch
from torch import Tensor


class Phase(IntEnum):
    """What is being done."""

    APPROACH = 0
    ALIGN = 1
    REACH = 2
    SQUEEZE = 3
    LIFT = 4
    CARRY = 5
    ALIGN_PLACE = 6
    LOWER = 7
    RELEASE = 8
    RETREAT = 9
    IDLE = 10


@dataclass
class TaskView:
    """What the work at one object is decided by, one row per environment.

    In the world frame, or in any other one that is level and has its origin on the floor; nothing depends on which.
    """

    root_xy: Tensor  # (N, 2)
    root_yaw: Tensor  # (N,)
    feet_xy: Tensor  # (N, 2) midpoint of the ankles
    hands: Tensor  # (N, 2, 3) right, left
    object_pos: Tensor  # (N, 3)
    grasp: Tensor  # (N, 2, 3) where the hands should touch the object now, right, left
    depth_m: Tensor  # (N,) extent of the object along the robot's view
    goal_pos: Tensor  # (N, 3)
    pick_stand: Tensor  # (N, 3) x, y, yaw
    place_stand: Tensor  # (N, 3)
    waypoint: Tensor  # (N, 2)
    waypoint_is_last: Tensor  # (N,) bool: it is the stand of this leg
    may_back: Tensor  # (N,) bool: a waypoint behind the robot is reached walking backward
    clearance_m: Tensor  # (N,) how far walls and furniture are
    away: Tensor  # (N, 2) the direction away from them


def to_heading(view: TaskView, points_w: Tensor) -> Tensor:
    """(N, P, 3) world points -> heading frame with its origin on the floor below the pelvis."""
    c, s = view.root_yaw.cos()[:, None], view.root_yaw.sin()[:, None]
    x, y = (points_w[..., :2] - view.root_xy[:, None]).unbind(-1)
    return torch.stack([c * x + s * y, c * y - s * x, points_w[..., 2]], -1)
