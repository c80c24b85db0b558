"""The places that a task is about, as 21 numbers in the heading frame, and what else about the way there (8).

The heading frame turns with the yaw of the pelvis, its origin is on the floor below it; z is height above it.
"""

from __future__ import annotations

import math

import numba
import numpy as np
import torch
from torch import Tensor

from hv_policy.motor.kinematics import Array, as_arrays

OBJECT, GOAL = slice(0, 3), slice(3, 6)
"""Where the object asked for and its goal are, m."""
GOAL_XY = slice(3, 5)
"""Where the goal is on the floor."""
SPAN, MIDDLE = slice(6, 9), slice(9, 12)
"""Half the way from where the right hand should hold the object to where the left one should, and where the middle
between the two is relative to the object, m."""
PICK, PICK_TURN = slice(12, 14), slice(14, 16)
"""Where to stand to pick the object up, m, and the cosine and sine of the heading there."""
PLACE, PLACE_TURN = slice(16, 18), slice(18, 20)
"""The same for putting it down."""
DEPTH = slice(20, 21)
"""The object's extent along the robot's view, m."""
PLACES_DIM = 21

WAYPOINT, AWAY, CLEARANCE = slice(0, 2), slice(2, 4), slice(4, 5)
"""Where to walk next, m; the direction away from walls and furniture; how far they are, m."""
IS_LAST, MAY_BACK, LEG_IS_DONE = 5, 6, 7
"""0 or 1: the waypoint is a stand; it may be reached walking backward; it is the last one of its leg."""
WAY_DIM = 8

GROUPS = (
    slice(0, 2), slice(2, 3),  # object
    slice(3, 5), slice(5, 6),  # goal
    slice(6, 8), slice(8, 9),  # span
    slice(9, 11), slice(11, 12),  # middle
    PICK, PICK_TURN, PLACE, PLACE_TURN, DEPTH,
)  # fmt: skip
"""Numbers that are equally uncertain, whichever way the robot has turned."""
_POINTS = (slice(0, 2), slice(3, 5), PICK, PLACE)
_DIRECTIONS = (slice(6, 8), slice(9, 11), PICK_TURN, PLACE_TURN)
_POINT_STARTS, _DIRECTION_STARTS = (tuple(part.start for part in parts) for parts in (_POINTS, _DIRECTIONS))

PRIOR_SPREAD = torch.tensor([
    1.7, 1.7, 0.6, 1.9, 1.9, 0.6, 0.4, 0.4, 0.1, 0.3, 0.3, 0.7, 1.7, 1.7, 0.75, 0.75, 1.8, 1.8, 0.75, 0.75, 0.5
])  # fmt: skip
"""(21,) deviation of squashed places over all places of all rooms: what is known without looking."""

_FAR_M = 0.5
_IS_FAR = torch.zeros(PLACES_DIM, dtype=torch.bool)
for _part in _POINTS:
    _IS_FAR[_part] = True
_SCALE = torch.tensor([1, 1, 0.5, 1, 1, 0.5, *[0.2] * 3, *[0.1] * 3, 1, 1, 1, 1, 1, 1, 1, 1, 0.2])


def squash(places: Tensor) -> Tensor:
    """(..., 21) m -> numbers of the size of one in which near things are finer than far ones: asinh(x / 0.5 m) for
    points, a multiple for the rest."""
    return torch.where(_IS_FAR.to(places.device), torch.asinh(places / _FAR_M), places / _SCALE.to(places))


def unsquash(numbers: Tensor) -> Tensor:
    """The inverse of `squash`."""
    far = _FAR_M * torch.sinh(numbers.clamp(-5.0, 5.0))
    return torch.where(_IS_FAR.to(numbers.device), far, numbers * _SCALE.to(numbers))


def stretch(places: Tensor) -> Tensor:
    """(..., 21) by how much a small change of a squashed number changes the place, at `places` (..., 21)."""
    far = torch.sqrt(places * places + _FAR_M * _FAR_M)
    return torch.where(_IS_FAR.to(places.device), far, _SCALE.to(places).expand_as(places))


def to_frame(places_h: Tensor, pose: Tensor) -> Tensor:
    """(N, 21) from the heading frame of a robot at `pose` (N, 3: x, y, yaw) to the frame that the pose is given in."""
    out = places_h.detach().clone(memory_format=torch.contiguous_format)
    _to_frame(out.numpy(), *as_arrays(pose))
    return out


def from_frame(places: Tensor, pose: Tensor) -> Tensor:
    """The inverse of `to_frame`."""
    out = places.detach().clone(memory_format=torch.contiguous_format)
    _from_frame(out.numpy(), *as_arrays(pose))
    return out


@numba.njit(cache=True)
def _to_frame(places: Array, pose: Array) -> None:
    for i in range(len(places)):
        cos, sin = math.cos(pose[i, 2]), math.sin(pose[i, 2])
        for at in _POINT_STARTS:
            x, y = np.float64(places[i, at]), np.float64(places[i, at + 1])
            places[i, at], places[i, at + 1] = cos * x - sin * y + pose[i, 0], sin * x + cos * y + pose[i, 1]
        for at in _DIRECTION_STARTS:
            x, y = np.float64(places[i, at]), np.float64(places[i, at + 1])
            places[i, at], places[i, at + 1] = cos * x - sin * y, sin * x + cos * y


@numba.njit(cache=True)
def _from_frame(places: Array, pose: Array) -> None:
    for i in range(len(places)):
        cos, sin = math.cos(pose[i, 2]), math.sin(pose[i, 2])
        for at in _POINT_STARTS:
            x, y = np.float64(places[i, at]) - pose[i, 0], np.float64(places[i, at + 1]) - pose[i, 1]
            places[i, at], places[i, at + 1] = cos * x + sin * y, cos * y - sin * x
        for at in _DIRECTION_STARTS:
            x, y = np.float64(places[i, at]), np.float64(places[i, at + 1])
            places[i, at], places[i, at + 1] = cos * x + sin * y, cos * y - sin * x


def turned(xy: Tensor, cos: Tensor, sin: Tensor) -> Tensor:
    """(N, 2) vectors turned by an angle, given as its cosine and sine (N, 1)."""
    x, y = xy[:, :1], xy[:, 1:]
    return torch.cat([cos * x - sin * y, sin * x + cos * y], 1)


def squash_waypoint(xy_m: Tensor) -> Tensor:
    """(..., 2) as points in `squash`."""
    return torch.asinh(xy_m / _FAR_M)


def unsquash_waypoint(numbers: Tensor) -> Tensor:
    """The inverse of `squash_waypoint`."""
    return _FAR_M * torch.sinh(numbers.clamp(-5.0, 5.0))
