"""Where the middle of the room is: half way between its walls, as far as the map of the floor shows them.

From one picture a network guesses it; who has been about the room knows where its floor ends.
"""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor

from hv_policy.belief.floor_map import CELL_M, ORIGIN_M
from hv_policy.motor.vectors import turned_xy

FREE, TAKEN = -1.0, 1.0
"""Evidence (`hv_policy.belief.floor_map`) below which a cell counts as free, and above which as taken."""
LEAST_CELLS = 4
"""So many free cells side by side are floor, fewer a mistake; and so many taken ones beyond them, a wall."""
_BEYOND = 4


def room_middle(evidence: Tensor, compass: Tensor) -> Tensor | None:
    """(2,) the middle of the room, m, in the frame of the map; None while some side of it has not been seen.

    Args:
        evidence: (X, Y) of a `FloorMap`.
        compass: (2,) which way the walls run, four times the angle (`hv_policy.belief.compass`), in the same frame.
    """
    yaw = float(torch.atan2(compass[1], compass[0])) / 4
    along = np.array([np.cos(yaw), np.sin(yaw)])
    free, taken = (
        (np.argwhere(cells.numpy()) + 0.5) * CELL_M + ORIGIN_M for cells in (evidence < FREE, evidence > TAKEN)
    )
    middle = []
    for axis in (along, np.array([-along[1], along[0]])):
        low, high = _ends(free @ axis, taken @ axis)
        if low is None or high is None:
            return None
        middle.append((low + high) / 2)
    x, y = middle
    return torch.tensor(turned_xy(yaw, x, y), dtype=torch.float32)


def _ends(free_m: np.ndarray, taken_m: np.ndarray) -> tuple[float | None, float | None]:
    """Where the floor ends on either side along an axis, None where nothing is known to stand beyond it."""
    ends: list[float | None] = []
    for sign in (-1, 1):
        cells, counts = np.unique(np.floor(sign * free_m / CELL_M), return_counts=True)
        floor = cells[counts >= LEAST_CELLS]
        if not len(floor):
            return None, None
        end = float(floor.max()) + 1
        beyond = sign * taken_m / CELL_M - end
        is_wall = np.count_nonzero((beyond >= 0) & (beyond < _BEYOND)) >= LEAST_CELLS
        ends.append(sign * end * CELL_M if is_wall else None)
    return ends[0], ends[1]
