"""Navigation against a slow Dijkstra, brute-force rasterising, and the geometry of standing before an object."""

import itertools

import numpy as np
import pytest
import torch

from hv_sim.navigation import (
    EASY_CLEARANCE_M,
    REACH_M,
    RETREAT_CLEARANCE_M,
    RETREAT_M,
    ROBOT_RADIUS_M,
    SPURNED_M,
    STAND_CLEARANCE_M,
    STEP_BACK_M,
    Navigator,
    plan_subtask,
    stand_distance_m,
)
from hv_sim.scene import compile_scene, rotation_about_z
from hv_sim.task import available_tasks, load_task

GRAY = (0.5, 0.5, 0.5)


@pytest.fixture(scope="module")
def scenes():
    return [compile_scene(load_task(name)) for name in available_tasks()]


def _starts(scene):
    return np.array([o.position_m for o in scene.task.objects])


def _dense(points, step=0.01):
    pieces = [np.linspace(a, b, max(2, int(np.linalg.norm(b - a) / step))) for a, b in itertools.pairwise(points)]
    return np.concatenate(pieces)


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
                depth = route.depth_m
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
                left, right = route.grasp_o @ rotation.T
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
    np.testing.assert_array_equal(route.grasp_o, scene.grasps_o[k, round(turn) % 4])


def test_what_lies_is_before_the_hands(scenes):
    """Each object on each of its sides: the robot stands where the hands are as far to either side, and near."""
    reached = []
    for scene in scenes:
        robot, positions = np.array(scene.task.robot.position_m), _starts(scene)
        for i in range(scene.num_subtasks):
            k = scene.subtask_object[i]
            for axis, sign, turn in itertools.product((0, 1), (-1, 1), (0.0, 1.1)):
                tip = np.eye(3)
                other = 1 - axis
                tip[[other, other, 2, 2], [other, 2, other, 2]] = 0, -sign, sign, 0
                rotations = np.stack([np.eye(3)] * scene.num_objects)
                rotations[k] = rotation_about_z(turn) @ tip
                lying = positions.copy()
                lying[k, 2] = scene.half_extents_m[k, other]
                route = plan_subtask(scene, i, robot, lying, rotations)
                yaw = route.pick_stand_xy_yaw[2]
                hands = (lying[k] + route.grasp_o @ rotations[k].T)[:, :2] - route.pick_stand_xy_yaw[:2]
                ahead, left = np.cos(yaw) * hands[:, 0] + np.sin(yaw) * hands[:, 1], hands @ [-np.sin(yaw), np.cos(yaw)]
                assert left[0] > 0 > left[1]
                assert left.sum() == pytest.approx(0, abs=1e-6)
                assert ahead.mean() > REACH_M[0] - 0.02
                reached.append(ahead.mean() < REACH_M[1] + STEP_BACK_M)
    assert np.mean(reached) > 0.9, "what offers nothing nearer is left"


def test_who_stands_over_an_object_steps_off_first_and_walks_round_it(scenes):
    stepped = 0
    for scene in scenes:
        positions, k = _starts(scene), scene.subtask_object[0]
        if positions[k, 2] > 0.5:
            continue
        far = plan_subtask(scene, 0, positions[k, :2] + [2.0, 0.0], positions)
        assert far.steps_off == 0
        yaw = far.pick_stand_xy_yaw[2] + np.pi / 2  # on another side
        robot = positions[k, :2] - 0.25 * np.array([np.cos(yaw), np.sin(yaw)])
        route = plan_subtask(scene, 0, robot, positions)
        if not route.steps_off:
            continue
        stepped += 1
        points, off = route.waypoints_to_object, route.steps_off
        away = np.linalg.norm(points - positions[k, :2], axis=-1)
        assert (np.diff(np.append(0.25, away[:off])) > 0).all()
        straight = (points[:off] - robot) / np.linalg.norm(points[:off] - robot, axis=-1, keepdims=True)
        np.testing.assert_allclose(straight, np.tile((robot - positions[k, :2]) / 0.25, (off, 1)), atol=1e-6)
        assert (route.ahead[: off - 1] == off - 1).all(), "off first"
        for i in range(off, len(points)):
            line = _dense(points[[i, route.ahead[i]]]) if route.ahead[i] > i else points[[i]]
            nearest = np.linalg.norm(line - positions[k, :2], axis=-1).min()
            assert nearest > away[i : route.ahead[i] + 1].min() - 0.1, "no short cut over the object"

        navigator = Navigator([scene])
        navigator.plan([0], torch.zeros(1, dtype=torch.long), torch.tensor(robot)[None], torch.tensor(positions)[None])
        backs = []
        for point in np.vstack([robot, points]):
            navigator.update(torch.tensor(point)[None].float(), torch.tensor(positions[[k]]).float())
            backs.append(bool(navigator.stepping_back[0]))
            if backs[-1]:
                assert navigator.waypoint_index[0] == off - 1
        assert backs[:off] == [off > 1] * off
        assert not any(backs[off:])
    assert stepped >= 3


def test_another_side_is_preferred_to_one_that_was_tried_in_vain(scenes):
    others = 0
    for scene in scenes:
        robot, positions = np.array(scene.task.robot.position_m), _starts(scene)
        first = plan_subtask(scene, 0, robot, positions)
        nothing = plan_subtask(scene, 0, robot, positions, None, np.full(6, np.nan))
        assert np.array_equal(first.pick_stand_xy_yaw, nothing.pick_stand_xy_yaw)
        yaw = first.pick_stand_xy_yaw[2]
        second = plan_subtask(scene, 0, robot, positions, None, np.array([yaw, yaw + 0.2, np.nan]))
        if np.cos(second.pick_stand_xy_yaw[2] - yaw) < 0.8:
            others += 1
            assert second.lacking_m <= first.lacking_m + 2 * SPURNED_M / 100, "not where there is no room"
        else:
            assert np.array_equal(first.pick_stand_xy_yaw, second.pick_stand_xy_yaw)
    assert len(scenes) > others >= 2


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
    assert a.routes[1].grasp_o.shape == (2, 3)
