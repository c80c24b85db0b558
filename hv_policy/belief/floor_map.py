"""What was seen of the floor, remembered: for each cell of a map how much speaks for its being taken.

The map stands in the frame in which odometry counts (`Belief.pose`), one for each environment, and outlasts
instructions. It holds logarithms of odds: pictures add to them (Moravec & Elfes 1985), 0 is what was never seen.
"""

from __future__ import annotations

import functools
import math

import numba
import numpy as np
import torch
from torch import Tensor

from hv_policy.motor.kinematics import Array, as_arrays
from hv_policy.motor.vectors import clip, turned_xy

CELL_M, CELLS = 0.1, 240
ORIGIN_M = -CELL_M * CELLS / 2
"""World of the map's corner along both axes: an episode begins in its middle."""
MOST_EVIDENCE, LOOK_WEIGHT, MOST_OF_A_LOOK = 4.0, 0.55, 3.0
"""Most that is remembered of a cell, and what a picture adds at most: pictures that follow each other err alike."""
STANDING_M, STANDING_EVIDENCE = 0.2, -3.0
"""So far around its middle the robot knows the floor to be free, having come there."""
SEEN_FROM_M, SEEN_TO_M = 0.4, 4.5
IN_TURN_FROM_M = 1.8
_STANDING = torch.cartesian_prod(*2 * [torch.arange(-2, 3)])
_STANDING = _STANDING[(_STANDING * CELL_M).float().norm(dim=-1) <= STANDING_M]


@functools.cache
def points_to_look_at(turn: int) -> Tensor:
    """(P, 2) points of the floor about a map's cell apart, in front of and beside the robot, m, heading frame. Of those
    far away, which many pictures show, every other one: in turn 1 those that turn 0 leaves out."""
    count = round(2 * SEEN_TO_M / CELL_M)
    reach = CELL_M * (torch.arange(count) + 0.5) - SEEN_TO_M
    points = torch.cartesian_prod(reach, reach)
    is_even = torch.cartesian_prod(*2 * [torch.arange(count)]).sum(1) % 2 == turn
    distance = points.norm(dim=-1)
    return points[(distance > SEEN_FROM_M) & (distance < SEEN_TO_M) & (is_even | (distance < IN_TURN_FROM_M))]


class FloorMap:
    """Maps of N environments."""

    def __init__(self, num: int) -> None:
        self.evidence = torch.zeros(num, CELLS, CELLS)
        """(N, X, Y) logarithm of the odds that a cell is taken."""
        self.looks = [0] * num
        """How often each has seen something."""

    def points_to_look_at(self, env: int) -> Tensor:
        """(P, 2) what environment `env` looks at next, heading frame."""
        return points_to_look_at(self.looks[env] % 2)

    def see(self, env: int, pose: Tensor, points_h: Tensor, logits: Tensor) -> None:
        """Environment `env` at `pose` (3,) saw points (P, 2), heading frame, which are taken with the odds' logarithms
        `logits` (P,)."""
        _add_evidence(self.evidence[env].numpy(), *as_arrays(pose, points_h, logits))
        self.looks[env] += 1

    def forget(self, env: int) -> None:
        """Nothing is known of environment `env`'s floor."""
        self.evidence[env] = 0.0

    def stand(self, env: int, xy: Tensor) -> None:
        """Environment `env`'s robot is at `xy` (2,): nothing else is."""
        here = (cells_of(xy[None]) + _STANDING).clamp(0, CELLS - 1)
        self.evidence[env, here[:, 0], here[:, 1]] = STANDING_EVIDENCE


def cells_of(xy: Tensor) -> Tensor:
    """(P, 2) int64 cells of points (P, 2), the nearest ones of the map."""
    return ((xy - ORIGIN_M) / CELL_M).floor().long().clamp(0, CELLS - 1)


@numba.njit(cache=True)
def _add_evidence(evidence: Array, pose: Array, points_h: Array, logits: Array) -> None:
    """`FloorMap.see` of one map (X, Y): each cell gains the mean of what its points say."""
    total, count = np.zeros(evidence.shape), np.zeros(evidence.shape, np.int32)
    cells = np.empty((len(points_h), 2), np.int64)
    for k in range(len(points_h)):
        x, y = turned_xy(pose[2], np.float64(points_h[k, 0]), np.float64(points_h[k, 1]))
        i = int(clip(math.floor((x + pose[0] - ORIGIN_M) / CELL_M), 0, CELLS - 1))
        j = int(clip(math.floor((y + pose[1] - ORIGIN_M) / CELL_M), 0, CELLS - 1))
        cells[k, 0], cells[k, 1] = i, j
        total[i, j] += LOOK_WEIGHT * clip(np.float64(logits[k]), -MOST_OF_A_LOOK, MOST_OF_A_LOOK)
        count[i, j] += 1
    for k in range(len(points_h)):
        i, j = cells[k, 0], cells[k, 1]
        if count[i, j]:
            known = evidence[i, j] + total[i, j] / count[i, j]
            evidence[i, j] = clip(known, -MOST_EVIDENCE, MOST_EVIDENCE)
            count[i, j] = 0
