"""What was seen of the floor, remembered: for each cell of a map how much speaks for its being taken.

The map stands in the frame in which odometry counts (`Belief.pose`), one for each environment, and outlasts
instructions. It holds logarithms of odds: pictures add to them (Moravec & Elfes 1985), 0 is what was never seen.
"""

from __future__ import annotations

import functools

import torch
from torch import Tensor

from hv_policy.belief.places import turned

CELL_M, CELLS = 0.1, 240
ORIGIN_M = -CELL_M * CELLS / 2
"""World of the map's corner along both axes: an episode begins in its middle."""
MOST_EVIDENCE, LOOK_WEIGHT, MOST_OF_A_LOOK = 4.0, 0.35, 3.0
"""Most that is remembered of a cell, and what a picture adds at most: pictures that follow each other err alike."""
STANDING_M, STANDING_EVIDENCE = 0.2, -3.0
"""So far around its middle the robot knows the floor to be free, having come there."""
SEEN_FROM_M, SEEN_TO_M = 0.4, 4.5
_STANDING = torch.cartesian_prod(*2 * [torch.arange(-2, 3)])
_STANDING = _STANDING[(_STANDING * CELL_M).float().norm(dim=-1) <= STANDING_M]


@functools.cache
def points_to_look_at() -> Tensor:
    """(P, 2) points of the floor about a map's cell apart, in front of and beside the robot, m, heading frame."""
    reach = torch.arange(-SEEN_TO_M + CELL_M / 2, SEEN_TO_M, CELL_M)
    points = torch.cartesian_prod(reach, reach)
    distance = points.norm(dim=-1)
    return points[(distance > SEEN_FROM_M) & (distance < SEEN_TO_M)]


class FloorMap:
    """Maps of N environments."""

    def __init__(self, num: int) -> None:
        self.evidence = torch.zeros(num, CELLS, CELLS)
        """(N, X, Y) logarithm of the odds that a cell is taken."""

    def see(self, env: int, pose: Tensor, points_h: Tensor, logits: Tensor) -> None:
        """Environment `env` at `pose` (3,) saw points (P, 2), heading frame, which are taken with the odds' logarithms
        `logits` (P,)."""
        cos, sin = pose[2:].cos()[None], pose[2:].sin()[None]
        cell = cells_of(turned(points_h, cos, sin) + pose[:2])
        flat, told = cell[:, 0] * CELLS + cell[:, 1], LOOK_WEIGHT * logits.clamp(-MOST_OF_A_LOOK, MOST_OF_A_LOOK)
        seen = torch.zeros(CELLS * CELLS).index_add_(0, flat, told)
        count = torch.zeros(CELLS * CELLS).index_add_(0, flat, torch.ones_like(told))
        known = self.evidence[env] + (seen / count.clamp(min=1)).view(CELLS, CELLS)
        self.evidence[env] = known.clamp(-MOST_EVIDENCE, MOST_EVIDENCE)

    def stand(self, env: int, xy: Tensor) -> None:
        """Environment `env`'s robot is at `xy` (2,): nothing else is."""
        here = (cells_of(xy[None]) + _STANDING).clamp(0, CELLS - 1)
        self.evidence[env, here[:, 0], here[:, 1]] = STANDING_EVIDENCE


def cells_of(xy: Tensor) -> Tensor:
    """(P, 2) int64 cells of points (P, 2), the nearest ones of the map."""
    return ((xy - ORIGIN_M) / CELL_M).floor().long().clamp(0, CELLS - 1)
