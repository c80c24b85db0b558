"""Where to stand to take an object, and to put it down: worked out from where it is, how it is turned, and the map.

The rules are those of the routes that teachers are shown (a side with room to stand and to step back, and little to
walk), on a map that may be wrong. The side is the robot's own choice; asked for it, a network says the mean of two.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hv_policy.belief.ways import UNSEEN, Reach

LOW_M = 0.43
"""An object whose middle is lower stands on the floor: the robot squats, and stands farther back for that. (Chairs are
0.41 m high in their middle; of what stands on anything from 0.3 m up it is at 0.44 m and higher.)"""
STAND_CLEARANCE_M, EASY_CLEARANCE_M = 0.1, 0.22
"""Room that a stand needs; where there is less than the second, it may be up to 0.16 m farther back."""
RETREAT_M, RETREAT_CLEARANCE_M = 0.7, 0.25
WIDEST_M = 0.52
"""Most between the hands."""
_BACK_M = np.arange(0.0, 0.161, 0.04)
_LACKING_COST, _WIDE_COST, _UNSEEN_COST, _HINT_COST, _CHANGE_COST, _FAILED_COST = 30.0, 5.0, 1.0, 1.5, 0.7, 1.5
"""In metres of walking: a metre of missing room, an object too wide, a stand that was not seen yet, half a turn from
what the network believes the side to be, another side than before, and each time that it failed from there."""
_FAR = 40.0
"""No walk counts for more: the map may be wrong."""


def is_same_side(yaw_rad: float, other_rad: float) -> bool:
    """Whether two ways to face are less than 45 degrees apart."""
    return math.cos(yaw_rad - other_rad) >= math.cos(math.pi / 4)


def stand_distance_m(depth_m: float, is_low: bool) -> float:
    """From the middle of an object to the pelvis, where its extent along the view is `depth_m`."""
    return max(0.45, 0.27 + depth_m / 2) if is_low else max(0.34, 0.2 + depth_m / 2)


@dataclass(frozen=True)
class Stand:
    """Where to stand before a place."""

    xy_yaw: np.ndarray  # (3,)
    number: int
    """Which of the sides that there were to choose from."""
    back_m: float
    """How much farther back than it might be, for the room there."""

    @property
    def yaw_rad(self) -> float:
        """Which way the robot faces."""
        return float(self.xy_yaw[2])


def choose_stand(
    reach: Reach,
    at: np.ndarray,
    yaws_rad: np.ndarray,
    depths_m: np.ndarray,
    widths_m: np.ndarray,
    hint_rad: float | None,
    before: Stand | None,
    keeps: bool,
    failed_rad: Sequence[float] = (),
) -> Stand:
    """The best of C stands before a place.

    Args:
        reach: of the robot, around the place.
        at: (3,) the place.
        yaws_rad, depths_m, widths_m: (C,) which way the robot would face, and the object's extents along and across.
        hint_rad: yaw that is likely by itself.
        before: what was chosen before.
        keeps: whether it is as far back as that; a robot that aligns with a stand must not see it move to and fro.
        failed_rad: which way it faced when it did not work out.
    """
    window = reach.window
    backs = np.array([before.back_m]) if keeps and before is not None else _BACK_M
    best: tuple[float, Stand] | None = None
    for number, (yaw, depth, width) in enumerate(zip(yaws_rad, depths_m, widths_m, strict=True)):
        ahead = np.array([np.cos(yaw), np.sin(yaw)])
        places = at[:2] - (stand_distance_m(float(depth), at[2] < LOW_M) + backs)[:, None] * ahead
        enough = window.room(places) >= EASY_CLEARANCE_M
        chosen = int(enough.argmax()) if enough.any() else 0
        place = places[chosen]
        behind = place - RETREAT_M * ahead
        lacking = 3 * max(0.0, STAND_CLEARANCE_M - float(window.room(place)))
        lacking += max(0.0, RETREAT_CLEARANCE_M - float(window.room(behind)))
        cost = _LACKING_COST * lacking + min(float(reach.to(behind)), _FAR)
        cost += _WIDE_COST * (width > WIDEST_M)
        cost += _UNSEEN_COST * float(abs(window.evidence[window.cells(place)]) < UNSEEN)
        if hint_rad is not None:
            cost += _HINT_COST * (1 - np.cos(yaw - hint_rad)) / 2
        if before is not None:
            cost += _CHANGE_COST * (not is_same_side(float(yaw), before.yaw_rad))
        cost += _FAILED_COST * sum(is_same_side(float(yaw), other) for other in failed_rad)
        if best is None or cost < best[0]:
            best = float(cost), Stand(np.array([*place, yaw]), number, float(backs[chosen]))
    assert best is not None
    return best[1]
