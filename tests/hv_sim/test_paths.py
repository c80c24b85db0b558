"""Paths against a slow Dijkstra, brute-force rasterising and sampled clearances."""

import itertools

import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from hv_sim.parts import box, moved, prisms
from hv_sim.paths import (
    ASIDE_M,
    EASY_PATH_M,
    LOOKAHEAD_M,
    NARROW_COST,
    WAYPOINT_M,
    OccupancyGrid,
    _a_star,
    lookahead,
    occupancy_grid,
    plan_path,
    resampled,
)
from hv_sim.scene import compile_scene
from hv_sim.task import available_tasks, load_task

GRAY = (0.5, 0.5, 0.5)


@pytest.fixture(scope="module")
def scenes():
    return [compile_scene(load_task(name)) for name in available_tasks()]


def test_a_star_ways_are_as_short_as_dijkstras():
    rng = np.random.default_rng(1)
    for _ in range(25):
        taken = rng.random((14, 17)) < 0.3
        start, goal = (tuple(int(v) for v in rng.integers(0, 14, 2)) for _ in range(2))
        taken[start] = taken[goal] = False
        index = np.arange(taken.size).reshape(taken.shape)
        rows, cols, cost = [], [], []
        for i, j in np.argwhere(~taken):
            for di in (-1, 0, 1):
                for dj in (-1, 0, 1):
                    a, b = i + di, j + dj
                    if (di or dj) and 0 <= a < 14 and 0 <= b < 17 and not (taken[a, b] or taken[a, j] or taken[i, b]):
                        rows.append(index[i, j])
                        cols.append(index[a, b])
                        cost.append(np.hypot(di, dj))
        graph = coo_matrix((cost, (rows, cols)), shape=(taken.size, taken.size)).tocsr()
        shortest = dijkstra(graph, indices=index[start])
        path = _a_star(taken, start, goal)
        assert path[0] == start
        assert not any(taken[c] for c in path)
        length = np.linalg.norm(np.diff(path, axis=0), axis=-1).sum() if len(path) > 1 else 0.0
        assert length == pytest.approx(shortest[index[path[-1]]])
        if np.isfinite(shortest[index[goal]]):
            assert path[-1] == goal
        else:
            assert path[-1] != goal


def test_occupancy_covers_what_stands_on_the_floor():
    parts = moved([box((0, 0, 0.4), (1.0, 0.6, 0.8), GRAY, collides=True)], (0.5, -0.3), 0.6)
    rug = box((-1, 1, 0.004), (1, 1, 0.008), GRAY, collides=True)
    shelf = box((1.5, 1.5, 2.2), (0.5, 0.5, 0.2), GRAY, collides=True)
    grid = occupancy_grid(prisms([*parts, rug, shelf]), (4.0, 4.0))
    c, s = np.cos(0.6), np.sin(0.6)
    local = (grid.centers_m() - [0.5, -0.3]) @ np.array([[c, -s], [s, c]])
    inside = (np.abs(local) <= [0.5, 0.3]).all(-1)
    near = (np.abs(local) <= [0.53, 0.33]).all(-1)
    wall = (np.abs(grid.centers_m()) > 2.0).any(-1)
    assert grid.cells[inside].all()
    assert not grid.cells[~near & ~wall].any()
    assert grid.cells[wall].all()


def test_clearance_is_the_distance_to_the_nearest_taken_cell():
    rng = np.random.default_rng(0)
    grid = OccupancyGrid(np.zeros(2), 0.05, rng.random((20, 30)) < 0.02)
    taken = np.argwhere(grid.cells)
    clearance = grid.clearance_m()
    for cell in rng.integers(0, 20, (50, 2)):
        slow = np.linalg.norm(taken - cell, axis=-1).min() * 0.05 - 0.025
        assert clearance[tuple(cell)] == pytest.approx(max(slow, 0.0))
    np.testing.assert_array_equal(grid.inflated(0.2).cells, clearance < 0.2)


def _dense(points, step=0.01):
    pieces = [np.linspace(a, b, max(2, int(np.linalg.norm(b - a) / step))) for a, b in itertools.pairwise(points)]
    return np.concatenate(pieces)


def test_paths_keep_clear_and_are_not_much_longer_than_needed(scenes):
    rng = np.random.default_rng(0)
    for scene in scenes:
        grid, clearance = scene.occupancy.inflated(), scene.occupancy.clearance_m()
        free = np.argwhere(~grid.cells)
        for _ in range(8):
            a, b = (grid.centers_m()[tuple(free[k])] for k in rng.integers(0, len(free), 2))
            path = np.vstack([a, plan_path(grid, a, b)])
            wide = np.vstack([a, plan_path(grid, a, b, clearance)])
            if np.linalg.norm(path[-1] - b) > 0.01:
                continue  # closed off by furniture
            cells = [grid.cell_of(p) for p in _dense(path)]
            assert np.mean([grid.cells[c] for c in cells]) < 0.02  # corners of cells at most
            walked = np.linalg.norm(np.diff(path, axis=0), axis=-1).sum()
            steps = _a_star(grid.cells, grid.cell_of(a), grid.cell_of(b))
            assert walked <= np.linalg.norm(np.diff(steps, axis=0), axis=-1).sum() * grid.cell_m + 0.08
            assert walked >= np.linalg.norm(a - b) - 1e-9
            assert np.linalg.norm(np.diff(path, axis=0), axis=-1).max() < WAYPOINT_M + 1e-9
            rooms = [[min(clearance[grid.cell_of(p)], EASY_PATH_M) for p in _dense(way)] for way in (path, wide)]
            near, far = map(np.mean, rooms)
            assert far > near - 0.02, "where it may choose it keeps off furniture"
            longer = np.linalg.norm(np.diff(wide, axis=0), axis=-1).sum()
            assert longer < NARROW_COST * walked + 0.2


def test_taken_ends_move_to_the_nearest_free_cell():
    grid = OccupancyGrid(np.zeros(2), 0.1, np.zeros((30, 30), dtype=bool))
    grid.cells[10:20, 10:20] = True
    path = plan_path(grid, (0.55, 1.5), (1.05, 1.5))
    np.testing.assert_allclose(path[-1], [0.95, 1.55], atol=0.11)
    escape = plan_path(grid, (1.05, 1.5), (0.2, 1.5))
    assert not grid.cells[grid.cell_of(escape[0])]
    np.testing.assert_allclose(escape[-1], [0.2, 1.5])


def test_closed_off_goal_gives_the_nearest_reachable_place():
    grid = OccupancyGrid(np.zeros(2), 0.1, np.zeros((30, 30), dtype=bool))
    grid.cells[15] = True
    path = plan_path(grid, (0.5, 0.5), (2.5, 0.5))
    np.testing.assert_allclose(path[-1], [1.45, 0.55], atol=1e-9)
    np.testing.assert_allclose(plan_path(grid, (0.5, 0.5), (0.5, 0.5)), [[0.5, 0.5]])


def test_one_looks_ahead_only_as_far_as_one_may_walk_straight():
    grid = OccupancyGrid(np.zeros(2), 0.05, np.zeros((80, 80), dtype=bool))
    grid.cells[38:42, :50] = True  # a wall to walk around
    clearance, free = grid.clearance_m(), grid.inflated(0.3)
    points = plan_path(free, (1.0, 1.0), (3.0, 1.0), clearance)
    ahead = lookahead(points, clearance, grid)
    assert (ahead > np.arange(len(points)))[:-1].all()
    assert ahead[-1] == len(points) - 1
    for i, j in enumerate(ahead):
        assert np.linalg.norm(points[j] - points[i]) <= LOOKAHEAD_M + 1e-6
        line = points[i] + np.linspace(0, 1, 50)[:, None] * (points[j] - points[i])
        least = min(clearance[grid.cell_of(p)] for p in points[i : j + 1])
        assert min(clearance[grid.cell_of(p)] for p in line) >= least - ASIDE_M - 0.03
    straight = plan_path(grid.inflated(0.3), (0.5, 0.5), (0.5, 3.5))
    steps = lookahead(straight, clearance, grid) - np.arange(len(straight))
    assert steps[0] == round(LOOKAHEAD_M / WAYPOINT_M)


def test_resampled_points_lie_on_the_line():
    line = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.55]])
    points = resampled(line)
    np.testing.assert_allclose(points[[0, -1]], line[[0, -1]])
    assert np.linalg.norm(np.diff(points, axis=0), axis=-1).max() <= WAYPOINT_M + 1e-9
    assert ((np.abs(points[:, 1]) < 1e-9) | (np.abs(points[:, 0] - 1.0) < 1e-9) | (points[:, 0] > 0.9)).all()
