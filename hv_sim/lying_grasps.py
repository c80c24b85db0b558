"""Where two hands press an object that lies on its side or on its head: what of it faces them, found with rays."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hv_sim.parts import Part

STEP_M = 0.015
"""Between the places that are tried; a hand needs as much all round it."""
SLOPE_M = 0.006
"""How much a face may turn away over `STEP_M`."""
FLOOR_ROOM_M = 0.06
"""Between the middle of a hand and what the object lies on."""
WIDTH_M = (0.1, 0.5)
"""Between the hands."""
ABOVE_M, AHEAD_M = 0.04, 0.03
"""How far above the centre of mass, and beyond it as the robot sees it, the hands should press (hands roll back while
an object is lowered)."""
HIGHER_SHARE, HIGHEST_M = 0.2, 0.1


def press_points(
    parts: Sequence[Part], com_m: np.ndarray, ahead_o: np.ndarray, up_o: np.ndarray, half_extents_m: np.ndarray
) -> tuple[np.ndarray, float] | None:
    """The best places for the hands of a robot that faces along `ahead_o`.

    Args:
        parts: the object's; those that collide count.
        com_m: (3,) its centre of mass.
        ahead_o, up_o: (3,) unit vectors at right angles, level and upward; like everything here in the object's frame.
        half_extents_m: (3,) of its bounding box.

    Returns:
        (2, 3) contact points of the (left, right) hand, and how far they are from where they should be, m; None where
        nothing can be pressed from both sides.
    """
    left_o = np.cross(up_o, ahead_o)
    reach = float(np.linalg.norm(half_extents_m)) + STEP_M
    along = np.arange(-reach, reach, STEP_M)
    height = np.arange(-reach, reach, STEP_M)
    grid = np.stack(np.meshgrid(along, height, indexing="ij"), -1)
    on_plane = grid[..., :1] * ahead_o + grid[..., 1:] * up_o
    sides = [
        side * (reach - first_hit_m(parts, (on_plane + side * reach * left_o).reshape(-1, 3), -side * left_o))
        for side in (1.0, -1.0)
    ]
    left, right = (s.reshape(grid.shape[:2]) for s in sides)
    width = left - right
    low = -float(np.abs(up_o) @ half_extents_m)
    over = grid[..., 1] - float(up_o @ com_m)
    fits = _level(left) & _level(right) & (width >= WIDTH_M[0]) & (width <= WIDTH_M[1])
    fits &= grid[..., 1] >= low + FLOOR_ROOM_M
    if not fits.any():
        return None
    off = np.abs(grid[..., 0] - float(ahead_o @ com_m) - AHEAD_M) + np.maximum(ABOVE_M - over, 0.0)
    cost = np.where(fits, off - HIGHER_SHARE * np.minimum(over, HIGHEST_M), np.inf)
    i, j = np.unravel_index(int(cost.argmin()), cost.shape)
    points = on_plane[i, j] + np.stack([left[i, j] * left_o, right[i, j] * left_o])
    return points, float(off[i, j])


def first_hit_m(parts: Sequence[Part], origins: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """(M,) how far rays from (M, 3) outside, all in one (3,) unit direction, go to the first part that collides;
    infinite where there is none."""
    first = np.full(len(origins), np.inf)
    for part in parts:
        if part.collides:
            first = np.minimum(first, _enters(part, origins, direction))
    return first


def _level(surface: np.ndarray) -> np.ndarray:
    """Where a face (A, H) goes on to all four sides without turning away; not at the rim."""
    fits = np.zeros(surface.shape, dtype=bool)
    middle = surface[1:-1, 1:-1]
    with np.errstate(invalid="ignore"):
        near = [
            np.abs(other - middle) <= SLOPE_M
            for other in (surface[:-2, 1:-1], surface[2:, 1:-1], surface[1:-1, :-2], surface[1:-1, 2:])
        ]
    fits[1:-1, 1:-1] = np.isfinite(middle) & np.logical_and.reduce(near)
    return fits


def _enters(part: Part, origins: np.ndarray, direction: np.ndarray) -> np.ndarray:
    c, s = 1 - 2 * part.quat[3] ** 2, 2 * part.quat[0] * part.quat[3]
    to_part = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    o, d = (origins - np.asarray(part.pos_m)) @ to_part.T, to_part @ direction
    if part.shape == "box":
        spans = [_slab(o[:, axis], d[axis], part.size_m[axis]) for axis in range(3)]
    else:
        spans = [_round(o, d, part.size_m[0]), _slab(o[:, 2], d[2], part.size_m[1])]
    enters = np.max([span[0] for span in spans], axis=0)
    leaves = np.min([span[1] for span in spans], axis=0)
    return np.where(enters <= leaves, enters, np.inf)


def _slab(o: np.ndarray, d: float, half: float) -> tuple[np.ndarray, np.ndarray]:
    if abs(d) < 1e-9:
        inside = np.abs(o) <= half
        return np.where(inside, -np.inf, np.inf), np.where(inside, np.inf, -np.inf)
    a, b = (-half - o) / d, (half - o) / d
    return np.minimum(a, b), np.maximum(a, b)


def _round(o: np.ndarray, d: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray]:
    squared = d[0] ** 2 + d[1] ** 2
    if squared < 1e-12:
        inside = np.hypot(o[:, 0], o[:, 1]) <= radius
        return np.where(inside, -np.inf, np.inf), np.where(inside, np.inf, -np.inf)
    middle = -(o[:, 0] * d[0] + o[:, 1] * d[1]) / squared
    nearest = (o[:, 0] + middle * d[0]) ** 2 + (o[:, 1] + middle * d[1]) ** 2
    half = np.sqrt(np.maximum(radius**2 - nearest, 0.0) / squared)
    inside = nearest <= radius**2
    return np.where(inside, middle - half, np.inf), np.where(inside, middle + half, -np.inf)
