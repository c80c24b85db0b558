"""Navigation against a slow Dijkstra, brute-force rasterising, and the geometry of standing before an object."""

import itertools

import numpy as np
import pytest
import torch
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from hv_sim.navigation import (
    EASY_CLEARANCE_M,
    RETREAT_CLEARANCE_M,
    RETREAT_M,
    ROBOT_RADIUS_M,
    STAND_CLEARANCE_M,
    STEP_BACK_M,
    Navigator,
    OccupancyGrid,
    _a_star,
    occupancy_grid,
    plan_path,
    plan_subtask,
    stand_distance_m,
)
from hv_sim.parts import box, moved, prisms
from hv_sim.scene import compile_scene, rotation_about_z
from hv_sim.task import available_tasks, load_task

GRAY = (0.5, 0.5, 0.5)


@pytest.fixture(scope="module")
def scenes():
    return [compile_scene(load_task(name)) for name in available_tasks()]


def _starts(scene):
    return np.array([o.position_m for o in scene.task.objects])


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
        grid = scene.occupancy.inflated()
        free = np.argwhere(~grid.cells)
        for _ in range(8):
            a, b = (grid.centers_m()[tuple(free[k])] for k in rng.integers(0, len(free), 2))
            path = np.vstack([a, plan_path(grid, a, b)])
            if np.linalg.norm(path[-1] - b) > 0.01:
                continue  # closed off by furniture
            cells = [grid.cell_of(p) for p in _dense(path)]
            assert np.mean([grid.cells[c] for c in cells]) < 0.02  # corners of cells at most
            walked = np.linalg.norm(np.diff(path, axis=0), axis=-1).sum()
            steps = _a_star(grid.cells, grid.cell_of(a), grid.cell_of(b))
            assert walked <= np.linalg.norm(np.diff(steps, axis=0), axis=-1).sum() * grid.cell_m + 0.08
            assert walked >= np.linalg.norm(a - b) - 1e-9


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


def test_stand_distance():
    assert stand_distance_m(0.2, 0.8) == 0.34
    assert stand_distance_m(0.4, 0.8) == pytest.approx(0.4)
    assert stand_distance_m(0.4, 0.0) == pytest.approx(0.47)


def test_routes_of_packaged_tasks_can_be_walked(scenes):
    """Every pick and place has room to stand, room to step back, and a way between."""
    for scene in scenes:
        robot, positions = np.array(scene.task.robot.position_m), _starts(scene)
        for i in range(scene.num_subtasks):
            k = scene.subtask_object[i]
            route = plan_subtask(scene, i, robot, positions)
            others = [j for j in range(scene.num_objects) if j != k]
            radii = np.linalg.norm(scene.half_extents_m[others, :2], axis=-1)
            clearance = scene.occupancy.with_discs(positions[others], radii).clearance_m()
            ends = ((route.pick_stand_xy_yaw, positions[k]), (route.place_stand_xy_yaw, scene.goal_pos_w[i]))
            for stand, target in ends:
                cell = scene.occupancy.cell_of(stand)
                assert clearance[cell] >= STAND_CLEARANCE_M
                back = stand[:2] - RETREAT_M * np.array([np.cos(stand[2]), np.sin(stand[2])])
                assert clearance[scene.occupancy.cell_of(back)] >= RETREAT_CLEARANCE_M
                ahead = target[:2] - stand[:2]
                facing = [np.cos(stand[2]), np.sin(stand[2])]
                np.testing.assert_allclose(ahead / np.linalg.norm(ahead), facing, atol=1e-9)
                depth = 2 * scene.half_extents_m[k, route.grasp_index % 2]
                height = target[2] - scene.half_extents_m[k, 2]
                farther = np.linalg.norm(ahead) - stand_distance_m(depth, height)
                assert -1e-9 <= farther <= STEP_BACK_M + 1e-9
                assert farther < 1e-9 or clearance[cell] >= EASY_CLEARANCE_M, "it steps back for room only"
            np.testing.assert_allclose(route.waypoints_to_object[-1], route.pick_stand_xy_yaw[:2])
            np.testing.assert_allclose(route.waypoints_to_goal[-1], route.place_stand_xy_yaw[:2])
            for way in (np.vstack([robot, route.waypoints_to_object[:-1]]), route.waypoints_to_goal[:-1]):
                middle = _dense(way)[20:-20]
                cells = np.array([scene.occupancy.cell_of(p) for p in middle]).reshape(-1, 2)
                assert (clearance[cells[:, 0], cells[:, 1]] >= ROBOT_RADIUS_M - 0.06).all()
            positions[k] = scene.goal_pos_w[i]
            robot = route.place_stand_xy_yaw[:2]


def test_grasp_left_hand_is_on_the_robots_left_at_both_ends(scenes):
    for scene in scenes:
        for i in range(scene.num_subtasks):
            k = scene.subtask_object[i]
            route = plan_subtask(scene, i, (0.0, 0.0), _starts(scene))
            start = rotation_about_z(scene.task.objects[k].yaw_rad)
            for stand, rotation in ((route.pick_stand_xy_yaw, start), (route.place_stand_xy_yaw, scene.goal_rot_w[i])):
                left, right = scene.grasps_o[k, route.grasp_index] @ rotation.T
                to_left = np.array([-np.sin(stand[2]), np.cos(stand[2]), 0.0])
                np.testing.assert_allclose((left - right) / np.linalg.norm(left - right), to_left, atol=1e-4)


def test_turned_object_is_taken_from_its_turned_side(scenes):
    scene = scenes[0]
    k = scene.subtask_object[0]
    rotations = np.tile(np.eye(3), (scene.num_objects, 1, 1))
    rotations[k] = rotation_about_z(0.4)
    route = plan_subtask(scene, 0, (0.0, 0.0), _starts(scene), rotations)
    turn = (route.pick_stand_xy_yaw[2] - 0.4) / (np.pi / 2)
    assert turn == pytest.approx(round(turn), abs=1e-6)
    assert round(turn) % 4 == route.grasp_index


def test_navigator_follows_its_routes(scenes):
    navigator = Navigator(scenes)
    n, most = len(scenes), max(s.num_objects for s in scenes)
    objects = torch.zeros(n, most, 3)
    for i, scene in enumerate(scenes):
        objects[i, : scene.num_objects] = torch.as_tensor(_starts(scene))
    robot = torch.tensor([[*s.task.robot.position_m, 0.9] for s in scenes])
    index = torch.zeros(n, dtype=torch.int64)
    routes = navigator.plan(range(n), index, robot, objects)
    current = torch.stack([objects[i, s.subtask_object[0]] for i, s in enumerate(scenes)])
    carried = current + torch.tensor([0.0, 0.0, 0.3])
    assert navigator.current_waypoint.shape == (n, 3)
    for held, leg in ((current, "waypoints_to_object"), (carried, "waypoints_to_goal")):
        for _ in range(200):  # walk 0.25 m at a time towards the current waypoint
            navigator.update(robot, held)
            step = navigator.current_waypoint[:, :2] - robot[:, :2]
            robot[:, :2] += step * (0.25 / step.norm(dim=-1, keepdim=True).clamp(min=0.25))
        ends = torch.as_tensor(np.stack([getattr(r, leg)[-1] for r in routes]), dtype=torch.float32)
        torch.testing.assert_close(navigator.current_waypoint[:, :2], ends)
        assert (navigator.picked_up == (leg == "waypoints_to_goal")).all()


def test_navigator_environments_do_not_touch_each_other(scenes):
    a, b = Navigator(scenes[:2]), Navigator([scenes[0]])
    objects = torch.stack([torch.as_tensor(_starts(s)[:2], dtype=torch.float32) for s in scenes[:2]])
    robot = torch.tensor([[*s.task.robot.position_m, 0.9] for s in scenes[:2]])
    index = torch.tensor([1, 0])
    a.plan([0, 1], index, robot, objects)
    b.plan([0], index[:1], robot[:1], objects[:1])
    torch.testing.assert_close(a.current_waypoint[:1], b.current_waypoint, rtol=0, atol=0)
    before = a.current_waypoint.clone()
    a.plan([1], torch.tensor([0, 1]), robot, objects)
    torch.testing.assert_close(a.current_waypoint[0], before[0], rtol=0, atol=0)
    assert a.routes[1].grasp_index in range(4)
