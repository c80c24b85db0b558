"""Ways over a floor: what of it is free, paths (A*) that keep off furniture, and how far ahead to walk straight."""

from __future__ import annotations

import heapq
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numba
import numpy as np
from scipy.ndimage import distance_transform_edt

from hv_sim.parts import Prism, inside_polygon

Point = Sequence[float] | np.ndarray
CELL_M = 0.05
ROBOT_RADIUS_M = 0.32
"""Clearance that paths keep (shoulders and elbows)."""
OVERHEAD_M = 2.0
"""What begins above this height is walked under."""
EASY_PATH_M = 0.7
NARROW_COST = 4.0
"""Paths keep so far from furniture where they can: a metre along an obstacle counts as so many metres in the open."""
WAYPOINT_M = 0.1
"""Distance of the waypoints along a path."""
LOOKAHEAD_M = 0.8
"""The current waypoint lies at most so far ahead along the path; nearer where the straight line there is narrower."""
ASIDE_M = 0.05
"""How much nearer to furniture than the path itself the straight line to the current waypoint may lead."""
_DIAGONAL = 2.0**0.5
_NEIGHBORS = ((-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (-1, 1), (1, -1), (1, 1))


@dataclass(frozen=True)
class OccupancyGrid:
    """Which cells of the floor are taken. Cell (i, j) covers origin_m + cell_m * [i, i+1) x [j, j+1).

    Attributes:
        origin_m: (2,) world position of the grid's corner.
        cell_m: width of a cell.
        cells: (X, Y) bool, True where something stands.
    """

    origin_m: np.ndarray
    cell_m: float
    cells: np.ndarray

    def cell_of(self, xy_m: Point) -> tuple[int, int]:
        """The cell that holds a point, or the nearest one of the grid."""
        i, j = self.cells_of(np.asarray(xy_m, dtype=float)[:2]).tolist()
        return i, j

    def cells_of(self, points_m: np.ndarray) -> np.ndarray:
        """(..., 2) int64 the cells that hold points (..., 2), or the nearest ones of the grid."""
        index = np.floor((points_m - self.origin_m) / self.cell_m).astype(int)
        return np.minimum(np.maximum(index, 0), np.array(self.cells.shape) - 1)

    def is_taken(self, points_m: np.ndarray) -> np.ndarray:
        """(P,) bool whether points (P, 2) lie in taken cells; what is beyond the grid is taken."""
        index = np.floor((points_m - self.origin_m) / self.cell_m).astype(int)
        inside = ((index >= 0) & (index < np.array(self.cells.shape))).all(-1)
        taken = ~inside
        taken[inside] = self.cells[index[inside, 0], index[inside, 1]]
        return taken

    def centers_m(self) -> np.ndarray:
        """(X, Y, 2) world positions of the cells' centres."""
        axes = [self.origin_m[k] + (np.arange(self.cells.shape[k]) + 0.5) * self.cell_m for k in range(2)]
        return np.stack(np.meshgrid(*axes, indexing="ij"), -1)

    def clearance_m(self) -> np.ndarray:
        """(X, Y) distance from each cell's centre to the nearest taken cell's edge, 0 in taken cells."""
        if not self.cells.any():
            return np.full(self.cells.shape, np.inf)
        return np.maximum(distance_transform_edt(~self.cells) - 0.5, 0.0) * self.cell_m

    def inflated(self, radius_m: float = ROBOT_RADIUS_M) -> OccupancyGrid:
        """The grid in which a disc of the radius is a point."""
        return OccupancyGrid(self.origin_m, self.cell_m, self.clearance_m() < radius_m)

    def with_discs(self, centers_m: Iterable[Sequence[float]], radii_m: Iterable[float]) -> OccupancyGrid:
        """The grid with discs taken as well, for movable objects."""
        cells = self.cells.copy()
        for center, radius in zip(centers_m, radii_m, strict=True):
            middle = np.asarray(center, dtype=float)[:2]
            (i, j), (k, m) = self.cells_of(middle + np.array([[-radius], [radius]])).tolist()
            x, y = (
                self.origin_m[axis] + (np.arange(low, high + 1) + 0.5) * self.cell_m - middle[axis]
                for axis, low, high in ((0, i, k), (1, j, m))
            )
            cells[i : k + 1, j : m + 1] |= x[:, None] ** 2 + y**2 <= radius**2
        return OccupancyGrid(self.origin_m, self.cell_m, cells)


def occupancy_grid(solids: Iterable[Prism], room_size_m: Sequence[float], cell_m: float = CELL_M) -> OccupancyGrid:
    """The floor of a room, middle at the origin, with a ring of taken cells for its walls.

    Args:
        solids: what stands in it; what begins above `OVERHEAD_M` or does not rise 2 cm above the floor is left out.
        room_size_m: along x and y.
        cell_m: width of a cell.
    """
    half = np.ceil(np.asarray(room_size_m, dtype=float) / 2 / cell_m).astype(int) + 1
    grid = OccupancyGrid(-half * cell_m, cell_m, np.zeros(2 * half, dtype=bool))
    points = grid.centers_m()
    cells = (np.abs(points) > np.asarray(room_size_m) / 2).any(-1)
    for solid in solids:
        if solid.z_low_m < OVERHEAD_M and solid.z_high_m > 0.02:
            cells |= inside_polygon(points, solid.polygon_m, cell_m / 2)
    return OccupancyGrid(grid.origin_m, cell_m, cells)


def plan_path(
    grid: OccupancyGrid, start_xy_m: Point, goal_xy_m: Point, clearance_m: np.ndarray | None = None
) -> np.ndarray:
    """(W, 2) waypoints, `WAYPOINT_M` apart, from just after the start to the goal: A* over 8 neighbours, then smoothed.

    The grid must be inflated already. A start or goal in a taken cell is replaced by the nearest free one; when no way
    leads to the goal, the path ends at the cell nearest to it that can be reached.

    Args:
        grid: inflated.
        start_xy_m: world.
        goal_xy_m: world.
        clearance_m: (X, Y) of the floor before it was inflated; where it is given, the path keeps away from
            furniture where there is room.
    """
    start, goal = nearest_free(grid, start_xy_m), nearest_free(grid, goal_xy_m)
    weight = None
    if clearance_m is not None:
        narrow = ((EASY_PATH_M - clearance_m) / (EASY_PATH_M - ROBOT_RADIUS_M)).clip(0.0, 1.0)
        weight = 1.0 + (NARROW_COST - 1.0) * narrow**2
    path = _a_star(grid.cells, start, goal, weight)
    points = grid.origin_m + (np.asarray(path) + 0.5) * grid.cell_m
    if not grid.cells[grid.cell_of(goal_xy_m)] and path[-1] == goal:
        points[-1] = np.asarray(goal_xy_m, dtype=float)[:2]
    if not grid.cells[grid.cell_of(start_xy_m)]:
        points[0] = np.asarray(start_xy_m, dtype=float)[:2]
    return resampled(_smoothed(grid, points))[1:] if len(points) > 1 else points


def resampled(points: np.ndarray, spacing_m: float = WAYPOINT_M) -> np.ndarray:
    """(W, 2) points at most `spacing_m` apart along a polyline (P, 2), both ends kept."""
    along = np.concatenate([[0.0], np.linalg.norm(np.diff(points, axis=0), axis=-1).cumsum()])
    if along[-1] == 0.0:
        return points[[0, -1]]
    places = np.linspace(0.0, along[-1], max(1, int(np.ceil(along[-1] / spacing_m - 1e-9))) + 1)
    return np.stack([np.interp(places, along, points[:, k]) for k in range(2)], -1)


def lookahead(points: np.ndarray, clearance_m: np.ndarray, grid: OccupancyGrid) -> np.ndarray:
    """(W,) index of the farthest point of a path (W, 2), at most `LOOKAHEAD_M` on, to which one may walk straight.

    May: the line comes no nearer to furniture than the path does there, less `ASIDE_M`.
    """
    count, most = len(points), round(LOOKAHEAD_M / WAYPOINT_M)
    at = grid.cells_of(points)
    room = clearance_m[at[:, 0], at[:, 1]]
    farthest = np.minimum(np.arange(count) + 1, count - 1)
    open_so_far = np.ones(count, dtype=bool)
    least = room.copy()
    share = np.linspace(0.0, 1.0, 2 * most + 1)[:, None, None]
    for ahead in range(1, most + 1):
        ends = np.minimum(np.arange(count) + ahead, count - 1)
        least = np.minimum(least, room[ends])
        line = points + share * (points[ends] - points)
        index = grid.cells_of(line)
        along = clearance_m[index[..., 0], index[..., 1]].min(0)
        open_so_far &= along >= least - ASIDE_M
        farthest = np.where(open_so_far, np.maximum(farthest, ends), farthest)
    return farthest


def path_length_m(points: np.ndarray) -> float:
    """Length of a polyline (P, 2)."""
    return float(np.linalg.norm(np.diff(points, axis=0), axis=-1).sum())


def nearest_free(grid: OccupancyGrid, xy_m: Point) -> tuple[int, int]:
    """The cell of a point, or the free one nearest to it."""
    cell = grid.cell_of(xy_m)
    if not grid.cells[cell]:
        return cell
    free = np.argwhere(~grid.cells)
    if len(free) == 0:
        return cell
    nearest = free[np.square(free - np.array(cell)).sum(-1).argmin()]
    return int(nearest[0]), int(nearest[1])


def _a_star(
    taken: np.ndarray, start: tuple[int, int], goal: tuple[int, int], weight: np.ndarray | None = None
) -> list[tuple[int, int]]:
    """Cells of a shortest way that cuts no taken corner; to the nearest cell that can be reached if the goal cannot.

    A step counts as its length times the `weight` (X, Y), at least 1, of the cell that it leads to.
    """
    rows, width = taken.shape
    di, dj = np.abs(np.arange(rows)[:, None] - goal[0]), np.abs(np.arange(width) - goal[1])
    # a ring of taken cells around everything, so that no neighbour has to be looked for outside
    left = np.pad(np.maximum(di, dj) + (_DIAGONAL - 1.0) * np.minimum(di, dj), 1).ravel()
    blocked = np.pad(taken, 1, constant_values=True).ravel()
    counts = np.pad(np.ones(taken.shape) if weight is None else weight, 1).ravel()
    width += 2
    first, last = ((cell[0] + 1) * width + cell[1] + 1 for cell in (start, goal))
    nodes = _search(blocked, counts, left, width, first, last)
    return [(node // width - 1, node % width - 1) for node in nodes.tolist()]


@numba.njit(cache=True)
def _search(
    blocked: np.ndarray, counts: np.ndarray, left: np.ndarray, width: int, first: int, last: int
) -> np.ndarray:  # pragma: no cover, it runs compiled
    """Nodes of the way, numbered along rows of `width`; `left` is what a way from there costs at least."""
    cost, parent = np.full(len(blocked), np.inf), np.full(len(blocked), -1)
    cost[first] = 0.0
    closed = blocked.copy()
    closed[first] = False  # also where it is taken
    heap = [(left[first], first)]
    nearest = first
    while len(heap):
        node = heapq.heappop(heap)[1]
        if closed[node]:
            continue
        closed[node] = True
        if left[node] < left[nearest]:
            nearest = node
        if node == last:
            break
        for di, dj in _NEIGHBORS:
            neighbor = node + di * width + dj
            if closed[neighbor] or (di and dj and (blocked[node + di * width] or blocked[node + dj])):
                continue
            reached = cost[node] + (_DIAGONAL if di and dj else 1.0) * counts[neighbor]
            if reached < cost[neighbor]:
                cost[neighbor], parent[neighbor] = reached, node
                heapq.heappush(heap, (reached + left[neighbor], neighbor))
    length, node = 1, nearest
    while node != first:
        length, node = length + 1, parent[node]
    way = np.empty(length, dtype=np.int64)
    node = nearest
    for i in range(length - 1, -1, -1):
        way[i], node = node, parent[node]
    return way


def _smoothed(grid: OccupancyGrid, points: np.ndarray, reach: int = 6) -> np.ndarray:
    """(P, 2) a path of cells without its staircase: running means, kept where they are free; both ends stay."""
    padded = np.vstack([np.repeat(points[:1], reach, 0), points, np.repeat(points[-1:], reach, 0)])
    sums = np.vstack([np.zeros(2), padded.cumsum(0)])
    means = (sums[2 * reach + 1 :] - sums[: -2 * reach - 1]) / (2 * reach + 1)
    index = grid.cells_of(means)
    free = ~grid.cells[index[:, 0], index[:, 1]]
    free[[0, -1]] = False
    return np.where(free[:, None], means, points)
