"""Where on the floor an object or its goal may be: how likely the pictures that show a place say that it is there.

A picture in which another thing is taken for the one that is meant says as surely where it is as one that is right, and
the next picture of the same thing says so again. So what pictures say of a place is not added up but averaged, over
those that show it, near ones above all; and the place with the highest mean counts, not a mean of places.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numba
import numpy as np
import torch
from torch import Tensor

from hv_policy.motor.kinematics import Array, as_arrays
from hv_policy.motor.vectors import turned_xy

CELL_M, CELLS = 0.2, 120
NEAR_M, FAR_M, VIEW_RAD = 0.6, 4.0, math.radians(40.0)
"""A picture shows what is so far from the robot, and so far to either side of where it looks; and what is found."""
HALF_WEIGHT_M = 1.0
"""Distance over which the weight of a picture falls to a quarter."""
DOUBT = 0.1
"""Weight of pictures, never taken, that show nothing at a place."""
MOST_WEIGHT = 1.5
"""Of all pictures together; later ones count at the cost of earlier ones."""
LEAST_DEVIATION_M, MOST_DEVIATION_M = 0.25, 1.0
WITHIN_M, PEAK_M, REJECTED_M = 1.5, 0.6, 0.7
"""What is so near to the likeliest place counts as there (pictures from afar are as vague), tells where that is, and
is rejected with a place."""
NOT_SEEN = 0.15
"""How likely it is where nobody has looked."""
KNOWN = 0.9
_REJECTED = 1e4


@dataclass
class Detections:
    """Where something is said to be, n times."""

    xy: Tensor  # (n, 2) m, heading frame
    deviation_m: Tensor  # (n,) if it is the right one
    seen: Tensor  # (n,) how likely it is in the picture

    @property
    def columns(self) -> tuple[Tensor, Tensor, Tensor]:
        """All of it."""
        return self.xy, self.deviation_m, self.seen

    def of(self, row: int, count: int) -> Detections:
        """The first ones of a row, where there are rows of them."""
        return Detections(*(column[row, :count] for column in self.columns))


@dataclass
class Likeliest:
    """Where something is likeliest."""

    xy: Tensor  # (2,) m
    mean: float  # how likely pictures say that it is there
    share: float  # how likely it is there and not elsewhere


class SpotMap:
    """Maps of N environments, in the frame of `Belief.pose`."""

    def __init__(self, num: int) -> None:
        self.said = torch.zeros(num, CELLS, CELLS)
        """(N, X, Y) how likely pictures said that it is there, times their weights."""
        self.weight = torch.zeros(num, CELLS, CELLS)
        """(N, X, Y) sum of the weights of the pictures that showed a cell."""

    def forget(self, env: int) -> None:
        """Nothing is known in environment `env`."""
        self.said[env], self.weight[env] = 0.0, 0.0

    def reject(self, env: int, xy: Tensor) -> None:
        """It is not around `xy` (2,) in environment `env`."""
        near = _away(xy) < REJECTED_M
        self.said[env][near], self.weight[env][near] = 0.0, _REJECTED

    def begin_at(self, env: int, xy: Tensor, deviation_m: float) -> None:
        """It is known to be around `xy` (2,) in environment `env`, give or take so much."""
        near = (-0.5 * (_away(xy) / deviation_m).square()).exp()
        self.said[env], self.weight[env] = KNOWN * MOST_WEIGHT * near, MOST_WEIGHT * near

    def see(self, env: int, pose: Tensor, gaze_rad: float, found: Detections) -> None:
        """Environment `env` took a look, at `pose` (3,), its camera turned so far to the left; what is `found` is all
        one and the same thing."""
        maps = self.said[env].numpy(), self.weight[env].numpy()
        _see(*maps, *as_arrays(pose), gaze_rad, *as_arrays(found.xy, found.deviation_m, found.seen))

    def likeliest(self, env: int) -> Likeliest:
        """Where it is in environment `env`."""
        x, y, mean, share = _likeliest(self.said[env].numpy(), self.weight[env].numpy())
        return Likeliest(torch.tensor([x, y], dtype=torch.float32), mean, share)


def _away(xy: Tensor) -> Tensor:
    """(X, Y) m from `xy` (2,)."""
    along = (torch.arange(CELLS) + 0.5) * CELL_M - CELL_M * CELLS / 2
    x, y = ((along - middle).square() for middle in xy.tolist())
    return (x[:, None] + y).sqrt()


@numba.njit(cache=True)
def _middle(cell: int) -> float:
    return (cell + 0.5) * CELL_M - CELL_M * CELLS / 2


@numba.njit(cache=True)
def _see(
    said: Array, weight: Array, pose: Array, gaze_rad: float, xy: Array, deviation_m: Array, seen: Array
) -> None:
    """`SpotMap.see` of one map (X, Y)."""
    count = len(seen)
    for i in range(CELLS):
        for j in range(CELLS):
            if weight[i, j] >= _REJECTED:
                continue
            x, y = turned_xy(-pose[2], _middle(i) - pose[0], _middle(j) - pose[1])
            away = math.hypot(x, y)
            ahead = math.cos(VIEW_RAD) * away < x * math.cos(gaze_rad) + y * math.sin(gaze_rad)
            shown = ahead and NEAR_M < away < FAR_M
            mean = 0.0
            for k in range(count):
                deviation = min(max(np.float64(deviation_m[k]), LEAST_DEVIATION_M), MOST_DEVIATION_M)
                square = ((x - xy[k, 0]) ** 2 + (y - xy[k, 1]) ** 2) / deviation**2
                if square < 9.0:
                    vague = max(1.0, deviation_m[k] / MOST_DEVIATION_M) ** 2
                    mean += seen[k] * math.exp(-0.5 * square) / (vague * count)
                    shown = True
            if shown:
                gain = 1 / (1 + away / HALF_WEIGHT_M) ** 2
                kept = min(1.0, MOST_WEIGHT / (weight[i, j] + gain))
                said[i, j] = kept * (said[i, j] + gain * mean)
                weight[i, j] = kept * (weight[i, j] + gain)


@numba.njit(cache=True)
def _likeliest(said: Array, weight: Array) -> tuple[float, float, float, float]:
    """`SpotMap.likeliest` of one map (X, Y): x, y and the other numbers."""
    best, at_i, at_j = -1.0, 0, 0
    for i in range(CELLS):
        for j in range(CELLS):
            mean = said[i, j] / (weight[i, j] + DOUBT)
            if mean > best:
                best, at_i, at_j = mean, i, j
    second = NOT_SEEN
    mass = x = y = 0.0
    for i in range(CELLS):
        for j in range(CELLS):
            mean = said[i, j] / (weight[i, j] + DOUBT)
            aside, ahead = (i - at_i) * CELL_M, (j - at_j) * CELL_M
            apart = math.hypot(aside, ahead)
            if apart >= WITHIN_M:
                second = max(second, mean)
            elif apart < PEAK_M:
                near = max(mean - 0.5 * best, 0.0)
                mass += near
                x += near * aside
                y += near * ahead
    odds, other = best / max(1 - best, 1e-3), second / max(1 - second, 1e-3)
    if mass > 0:
        x, y = x / mass, y / mass
    return _middle(at_i) + x, _middle(at_j) + y, best, odds / (odds + other)
