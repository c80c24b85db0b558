"""Practice grounds: boxes on supports, with room for the robot, against a brute-force look at where things stand."""

import mujoco
import numpy as np
import pytest

from hv_sim.humanoid import KP
from hv_teachers.motor_scenes import (
    PASSING_M,
    RETREAT_CLEARANCE_M,
    RETREAT_M,
    TABLE_HALF_M,
    LoadRange,
    behind,
    compile_ground,
    draw_carry_task,
    table_clearance_m,
    tables_of,
)


@pytest.fixture(scope="module")
def tasks():
    rng = np.random.default_rng(8)
    return [draw_carry_task(rng, LoadRange()) for _ in range(40)]


def test_draws_keep_to_their_ranges(tasks):
    load = LoadRange()
    for task in tasks:
        depth, width, height = 2 * task.half_extents_m
        assert load.depth_m[0] <= depth <= load.depth_m[1]
        assert load.width_m[0] <= width <= load.width_m[1]
        assert load.mass_kg[0] <= task.mass_kg <= load.mass_kg[1]
        assert all(s == 0 or load.support_m[0] <= s <= load.support_m[1] for s in task.support_m)
        assert abs(task.place_stand[2]) <= load.turn_rad
        assert 0 < task.grasp_height_m < height / 2
    assert {s == 0 for t in tasks for s in t.support_m} == {True, False}


def test_the_distance_to_a_table_is_that_of_its_nearest_point(tasks):
    rng = np.random.default_rng(0)
    u, v = np.meshgrid(np.linspace(-1, 1, 61), np.linspace(-1, 1, 101))
    for task in tasks[:10]:
        tables = tables_of(task)
        points = rng.uniform(-2, 2, (5, 2))
        nearest = np.inf
        for x, y, yaw, ahead in tables:
            local = np.stack([ahead + u * TABLE_HALF_M[0], v * TABLE_HALF_M[1]], -1).reshape(-1, 2)
            c, s = np.cos(yaw), np.sin(yaw)
            world = local @ np.array([[c, s], [-s, c]]) + [x, y]
            nearest = min(nearest, np.linalg.norm(world[:, None] - points[None], axis=-1).min())
        assert table_clearance_m(points, tables) == pytest.approx(nearest, abs=0.02) or not tables


def test_the_way_between_the_stands_is_free(tasks):
    for task in tasks:
        way = np.linspace(behind(task.pick_stand), behind(task.place_stand), 40)
        assert table_clearance_m(way, tables_of(task)) > PASSING_M
        back = behind(task.place_stand, RETREAT_M)
        assert table_clearance_m(back[None], tables_of(task)) > RETREAT_CLEARANCE_M


def test_a_range_without_a_way_is_refused():
    with pytest.raises(ValueError, match="walk_m"):
        draw_carry_task(np.random.default_rng(0), LoadRange(floor_share=0.0, walk_m=(0.1, 0.2)))


def test_the_box_rests_at_its_start_and_at_its_goal(tasks):
    for task in tasks[:8]:
        model = compile_ground(np.random.default_rng(1), task, randomize=False)
        for place, yaw in ((task.start_pos, 0.0), (task.goal_pos, task.place_stand[2])):
            data = mujoco.MjData(model)
            robot = data.qpos[:35].copy()
            robot[2] += 5.0
            data.qpos[35:] = [*place, np.cos(yaw / 2), 0, 0, np.sin(yaw / 2)]
            for _ in range(60):
                data.qpos[:35], data.qvel[:34] = robot, 0.0
                mujoco.mj_step(model, data)
            np.testing.assert_allclose(data.qpos[35:38], place, atol=0.01)


def test_randomised_grounds_differ_by_a_tenth():
    rng = np.random.default_rng(2)
    plain = compile_ground(rng, None, randomize=False)
    np.testing.assert_allclose(plain.actuator_gainprm[:, 0], KP)
    gains = np.array([compile_ground(rng, None).actuator_gainprm[:, 0] / KP for _ in range(10)])
    assert 0.9 <= gains.min() < 0.95
    assert 1.05 < gains.max() <= 1.1
    models = [compile_ground(rng, None) for _ in range(10)]
    heavy = np.array([m.body_mass[1:] / plain.body_mass[1:] for m in models])
    assert 0.9 <= heavy.min() < 0.95
    assert 1.05 < heavy.max() <= 1.1
    with pytest.raises(ValueError, match="physics_hz"):
        compile_ground(rng, None, physics_hz=100)


def test_what_touches_rubs_as_it_was_drawn(tasks):
    """By MuJoCo's own contacts: soles on the floor, hands on the box, the box on its support."""
    task = next(t for t in tasks if t.support_m[0] > 0.3)
    rubs = {"sole": [], "hand": [], "box": []}
    for seed in range(6):
        model = compile_ground(np.random.default_rng(seed), task, friction=(0.5, 0.9))
        data = mujoco.MjData(model)
        data.qpos[:3] = [-2.0, 0.0, 0.9]
        data.qpos[35:] = [*task.start_pos, 1, 0, 0, 0]
        data.qpos[37] -= 0.005
        mujoco.mj_forward(model, data)
        # stand on the floor, and bring the box into a hand
        low = min(float(data.geom(f"{side}_foot").xpos[2]) for side in ("left", "right"))
        data.qpos[2] -= low - 0.02
        mujoco.mj_forward(model, data)
        found = _frictions(model, data)
        rubs["sole"] += found["left_foot", "floor"]
        rubs["box"] += found["box", "support_0"]
        data.qpos[35:38] = data.geom("left_hand").xpos + np.array([0, 0, task.half_extents_m[2] + 0.03])
        mujoco.mj_forward(model, data)
        rubs["hand"] += _frictions(model, data)["box", "left_hand"]
    for name, values in rubs.items():
        assert len(values) >= 6, name
        assert 0.5 <= min(values) < 0.7 < max(values) <= 0.9, name
    assert rubs["hand"][0] != rubs["sole"][0]


def _frictions(model, data):
    found = {}
    for contact in data.contact:
        pair = tuple(sorted(model.geom(g).name for g in contact.geom))
        for key in (pair, pair[::-1]):
            found.setdefault(key, []).append(float(contact.friction[0]))
    return found
