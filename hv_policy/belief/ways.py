"""Ways over the floor as it is believed to be: a shortest path that keeps off furniture, and how far ahead to walk.

The counterpart, for a map that may be wrong, of the routes that the teachers are shown: nothing is forbidden, what is
probably taken only costs more.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import distance_transform_edt
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import dijkstra

from hv_policy.belief.floor_map import CELL_M, CELLS, ORIGIN_M

TAKEN, UNSEEN = 0.4, 0.2
"""Evidence from which a cell counts as taken; and below which, either way, as not seen yet."""
RADIUS_M, EASY_M = 0.3, 0.7
"""Clearance that ways keep, and that they keep where they can."""
_TIGHT_M = 0.12
_NARROW_COST, _SCRAPING_COST, _BLOCKED_COST, _UNSEEN_COST = 4.0, 15.0, 60.0, 1.4
_MARGIN_M = 2.5
SPACING_M, LOOKAHEAD_M, ASIDE_M = 0.1, 0.8, 0.05
"""Distance of waypoints, how far ahead the current one lies at most, and how much nearer to furniture than the path the
straight line to it may lead."""
LEAST_AHEAD = 3
"""Waypoints that the current one lies ahead at least: the map is not fine enough to thread one's way by."""
BACK_OFF_M = np.arange(0.2, 1.0 + 1e-9, 0.05)
TOE_ROOM_M = 0.5
"""The way to an object keeps off it by this at most, so that the robot does not kick what it is to lift."""
ON_THE_LINE_M = 0.2


@dataclass
class Way:
    """A path in the frame of odometry."""

    points: np.ndarray  # (W, 2)
    ahead: np.ndarray  # (W,) index of the waypoint to make for from each

    def waypoint(self, xy: np.ndarray) -> tuple[np.ndarray, bool]:
        """(2,) the waypoint to make for from `xy` (2,), and whether it is the last one."""
        nearest = int(np.square(self.points - xy).sum(-1).argmin())
        chosen = int(self.ahead[nearest])
        return self.points[chosen], chosen == len(self.points) - 1


@dataclass
class Window:
    """A part of a map."""

    corner: np.ndarray  # (2,) m
    evidence: np.ndarray  # (X, Y)
    clearance_m: np.ndarray  # (X, Y) distance to the nearest cell that counts as taken

    @staticmethod
    def around(evidence: np.ndarray, points: np.ndarray, margin_m: float = _MARGIN_M) -> Window:
        """The part of a map (X, Y) that holds points (P, 2) and what is around them."""
        low = np.clip(((points.min(0) - margin_m - ORIGIN_M) / CELL_M).astype(int), 0, CELLS - 1)
        high = np.clip(((points.max(0) + margin_m - ORIGIN_M) / CELL_M).astype(int), 0, CELLS - 1) + 1
        part = evidence[low[0] : high[0], low[1] : high[1]]
        taken = part > TAKEN
        clearance = np.full(part.shape, 5.0)
        if taken.any():
            clearance = np.maximum(distance_transform_edt(~taken) - 0.5, 0.0) * CELL_M
        return Window(low * CELL_M + ORIGIN_M, part, clearance)

    def cells(self, xy: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rows and columns of points (..., 2), the nearest ones of the window."""
        cell = ((xy - self.corner) / CELL_M).astype(int)
        cell = np.clip(cell, 0, np.array(self.evidence.shape) - 1)
        return cell[..., 0], cell[..., 1]

    def room(self, xy: np.ndarray) -> np.ndarray:
        """(...) clearance at points (..., 2), m."""
        return self.clearance_m[self.cells(xy)]

    def cost(self, keep_off: np.ndarray | None = None) -> np.ndarray:
        """(X, Y) what a metre costs in each cell, where a disc `keep_off` (3,) x, y, radius is not to be entered."""
        narrow = np.clip((EASY_M - self.clearance_m) / (EASY_M - RADIUS_M), 0.0, 1.0)
        cost = 1.0 + (_NARROW_COST - 1.0) * narrow**2
        cost = np.where(self.clearance_m < RADIUS_M, _SCRAPING_COST, cost)
        cost = np.where(self.clearance_m < _TIGHT_M, _BLOCKED_COST, cost)
        cost = np.where(np.abs(self.evidence) < UNSEEN, _UNSEEN_COST * cost, cost)
        if keep_off is not None:
            x, y = (self.corner[k] + (np.arange(self.evidence.shape[k]) + 0.5) * CELL_M for k in range(2))
            near = np.hypot(x[:, None] - keep_off[0], y[None] - keep_off[1]) < keep_off[2]
            cost = np.where(near, np.maximum(cost, _SCRAPING_COST), cost)
        return cost


@dataclass
class Reach:
    """What it costs to walk from one place to everywhere around."""

    window: Window
    cost: np.ndarray  # (X, Y), metres of easy walking

    @staticmethod
    def of(evidence: np.ndarray, xy: np.ndarray, at: np.ndarray, keep_off_m: float) -> Reach:
        """From `xy` (2,) to what is around `at` (2,), off which one keeps by `keep_off_m`; `evidence` (X, Y) is a
        `FloorMap`'s."""
        window = Window.around(evidence, np.stack([xy, at]))
        graph = _graph(window.cost(np.array([*at, keep_off_m])))
        cost = dijkstra(graph, indices=_number(window, xy)).reshape(window.evidence.shape)
        return Reach(window, cost)

    def to(self, xy: np.ndarray) -> np.ndarray:
        """(...) to points (..., 2)."""
        return self.cost[self.window.cells(xy)]


def way_to_stand(evidence: np.ndarray, xy: np.ndarray, stand: np.ndarray, thing_xy: np.ndarray | None) -> Way:
    """From `xy` (2,) to a stand (3,) x, y, yaw, the last part of it straight ahead.

    Args:
        evidence: (X, Y) of a `FloorMap`.
        xy: of the robot.
        stand: where it shall stand.
        thing_xy: (2,) of what stands there and must not be kicked.
    """
    window = Window.around(evidence, np.stack([xy, stand[:2]]))
    before = step_back(window, stand)
    straight = _straight(before, stand[:2])
    along = stand[:2] - before
    length = float(np.linalg.norm(along))
    passed = (xy - before) @ along / max(length, 1e-6)
    aside = abs(float((xy - before) @ np.array([-along[1], along[0]]))) / max(length, 1e-6)
    if 0.0 < passed and aside < ON_THE_LINE_M and np.linalg.norm(xy - stand[:2]) < length + 0.1:
        return _looking_ahead(window, _straight(xy, stand[:2]))
    keep_off = None
    if thing_xy is not None:
        radius = min(TOE_ROOM_M, float(np.linalg.norm(stand[:2] - thing_xy)) - 0.05)
        keep_off = np.array([*thing_xy, radius])
    path = _shortest(window, window.cost(keep_off), xy, before)
    return _looking_ahead(window, np.vstack([path, straight[1:]]))


def way_to(evidence: np.ndarray, xy: np.ndarray, goal: np.ndarray) -> Way:
    """From `xy` (2,) to `goal` (2,)."""
    window = Window.around(evidence, np.stack([xy, goal]))
    return _looking_ahead(window, _shortest(window, window.cost(), xy, goal))


def step_back(window: Window, stand: np.ndarray, least_m: float = 0.0) -> np.ndarray:
    """(2,) the first place straight behind a stand (3,) that has room, within a metre and no nearer than `least_m`,
    else the one with most."""
    distances = BACK_OFF_M[BACK_OFF_M >= least_m - 1e-9, None]
    points = stand[:2] - distances * np.array([np.cos(stand[2]), np.sin(stand[2])])
    room = window.room(points)
    enough = room >= RADIUS_M
    return points[int(enough.argmax()) if enough.any() else int(room.argmax())]


def place_to_look_from(
    evidence: np.ndarray, xy: np.ndarray, reach_m: float, before: Sequence[np.ndarray]
) -> np.ndarray:
    """(2,) where to look round next: `reach_m` from `xy` (2,), where the way is open and far from the places `before`
    that the robot looked round from."""
    angles = np.arange(0.0, 2 * np.pi, np.pi / 8)
    places = xy + reach_m * np.stack([np.cos(angles), np.sin(angles)], -1)
    window = Window.around(evidence, places)
    along = xy + np.linspace(0.2, 1.0, 9)[:, None, None] * (places - xy)
    room = np.minimum(window.room(along).min(0), EASY_M)
    away = np.min([np.linalg.norm(places - b, axis=-1) for b in (xy, *before)], axis=0)
    return places[int((2 * room + away).argmax())]


def room_here(evidence: np.ndarray, xy: np.ndarray) -> tuple[float, np.ndarray]:
    """How far the next thing on the floor is from `xy` (2,), m, and (2,) the direction away from it."""
    window = Window.around(evidence, xy[None], 1.5)
    step = 2 * CELL_M * np.eye(2)
    slope = window.room(xy + step) - window.room(xy - step)
    return float(window.room(xy)), slope / max(float(np.linalg.norm(slope)), 1e-3)


def _shortest(window: Window, cost: np.ndarray, start: np.ndarray, goal: np.ndarray) -> np.ndarray:
    """(W, 2) from start to goal along the cheapest cells (Dijkstra), smoothed."""
    first, last = (_number(window, xy) for xy in (start, goal))
    _, before = dijkstra(_graph(cost), indices=first, return_predecessors=True)
    path = [last]
    while path[-1] != first:
        path.append(int(before[path[-1]]))
    cells = np.stack(np.unravel_index(path[::-1], cost.shape), -1)
    points = window.corner + (cells + 0.5) * CELL_M
    points = np.vstack([start, _smoothed(points), goal])
    return _resampled(points)


def _graph(cost: np.ndarray) -> csr_matrix:
    """What it costs to go from each cell of (X, Y) costs of a metre to its 8 neighbours."""
    shape = cost.shape
    number = np.arange(cost.size).reshape(shape)
    sources, targets, weights = [], [], []
    for di, dj in ((0, 1), (1, 0), (1, 1), (1, -1)):
        one = (slice(0, shape[0] - di), slice(max(0, -dj), shape[1] - max(0, dj)))
        other = (slice(di, shape[0]), slice(max(0, dj), shape[1] + min(0, dj)))
        weight = (cost[one] + cost[other]).ravel() * (0.5 * CELL_M * np.hypot(di, dj))
        sources += [number[one].ravel(), number[other].ravel()]
        targets += [number[other].ravel(), number[one].ravel()]
        weights += [weight, weight]
    edges = (np.concatenate(weights), (np.concatenate(sources), np.concatenate(targets)))
    return coo_matrix(edges, shape=(cost.size, cost.size)).tocsr()


def _number(window: Window, xy: np.ndarray) -> int:
    """Of the cell of a point (2,), row by row."""
    row, column = window.cells(xy)
    return int(row * window.evidence.shape[1] + column)


def _smoothed(points: np.ndarray, reach: int = 2) -> np.ndarray:
    padded = np.vstack([np.repeat(points[:1], reach, 0), points, np.repeat(points[-1:], reach, 0)])
    sums = np.vstack([np.zeros(2), padded.cumsum(0)])
    return (sums[2 * reach + 1 :] - sums[: -2 * reach - 1]) / (2 * reach + 1)


def _straight(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    return _resampled(np.stack([start, end]))


def _resampled(points: np.ndarray) -> np.ndarray:
    """(W, 2) points at most `SPACING_M` apart along a polyline (P, 2), both ends kept."""
    along = np.concatenate([[0.0], np.linalg.norm(np.diff(points, axis=0), axis=-1).cumsum()])
    places = np.linspace(0.0, along[-1], max(1, int(np.ceil(along[-1] / SPACING_M - 1e-9))) + 1)
    return np.stack([np.interp(places, along, points[:, k]) for k in range(2)], -1)


def _looking_ahead(window: Window, points: np.ndarray) -> Way:
    """A path, and from each of its points the farthest one within `LOOKAHEAD_M` to which one may walk straight: the
    line leads no nearer to furniture than the path does, less `ASIDE_M`."""
    count, most = len(points), round(LOOKAHEAD_M / SPACING_M)
    room = window.room(points)
    farthest = np.minimum(np.arange(count) + LEAST_AHEAD, count - 1)
    is_open, least = np.ones(count, dtype=bool), room.copy()
    share = np.linspace(0.0, 1.0, 2 * most + 1)[:, None, None]
    for step in range(1, most + 1):
        ends = np.minimum(np.arange(count) + step, count - 1)
        least = np.minimum(least, room[ends])
        along = window.room(points + share * (points[ends] - points)).min(0)
        is_open &= along >= least - ASIDE_M
        farthest = np.where(is_open, np.maximum(farthest, ends), farthest)
    return Way(points, farthest)
