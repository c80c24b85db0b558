import numpy as np
import pytest
import torch

from hv_policy.belief.places import GOAL, OBJECT
from hv_policy.motor import embodiment
from hv_sim.observations import Heading
from hv_sim.suites import load_suite
from hv_teachers.expert import PlannerExpert
from hv_teachers.glances import VIEWS_PER_PLACE, glance_around
from hv_teachers.recording import RecordingConfig, roll_glances

TASKS = load_suite("seen")[:2]


def test_what_is_known_is_what_mujoco_says_from_many_free_places():
    standing, turns, indices = set(), [], []
    for world, knowledge in glance_around(TASKS, [3, 4], 4 * VIEWS_PER_PLACE):
        state, rows = world.state, torch.arange(2)
        heading = Heading.of(state)
        heading.origin_w = torch.cat([state.link_pos_w[:, 0, :2], torch.zeros(2, 1)], -1)
        index = world.object_index
        torch.testing.assert_close(
            knowledge.places[:, OBJECT], heading.relative(state.object_pos_w[rows, index]), atol=1e-4, rtol=1e-4
        )
        goal = world.goal_pos_w[rows, world.subtask_index]
        torch.testing.assert_close(knowledge.places[:, GOAL], heading.relative(goal), atol=1e-4, rtol=1e-4)
        standing.add(tuple(np.round(state.link_pos_w[0, 0, :2].tolist(), 3)))
        turns.append(float(heading.cos[0]))
        indices.append(int(world.subtask_index[0]))
        for env, scene in enumerate(world.scenes):
            x, y = scene.occupancy.cell_of(state.link_pos_w[env, 0, :2].numpy())
            assert scene.occupancy.clearance_m()[x, y] > 0.15
    assert len(standing) == 4
    assert np.std(turns) > 0.2
    assert indices == sorted(indices)
    assert set(indices) == {0, 1}


def test_in_some_views_the_object_is_between_the_hands():
    held = []
    for number, (world, knowledge) in enumerate(glance_around(TASKS, [3, 4], 8 * VIEWS_PER_PLACE)):
        hands = Heading.of(world.state).relative(world.state.link_pos_w[:, embodiment.HANDS])
        apart = (hands.mean(1) - knowledge.places[:, OBJECT])[:, :2].norm(dim=1)
        held += [(number % VIEWS_PER_PLACE == 0, bool(near)) for near in apart < 0.12]
    assert 0.1 < np.mean([near for first, near in held if not first]) < 0.7
    assert not any(near for first, near in held if first)


def test_sometimes_the_object_lies_on_its_side_on_the_floor():
    world, _ = next(glance_around(TASKS, [3, 4], VIEWS_PER_PLACE, beginning_share=0.0, lying_share=1.0))
    rows, state = torch.arange(2), world.state
    assert (state.object_rot_w[rows, world.object_index, 2, 2].abs() < 1e-5).all(), "its own up is level"
    for env in range(2):
        data, model = world.physics.data(env), world.physics.model(env)
        row = int(world.object_index[env])
        body = model.body_dofadr.tolist().index(6 + 28 + 6 * row)
        lowest = min(_lowest_m(model, data, g) for g in np.flatnonzero(model.geom_bodyid == body))
        assert lowest == pytest.approx(0.0, abs=0.02), "it lies on the floor"
        away = np.linalg.norm(data.xpos[body, :2] - data.qpos[:2])
        assert 0.3 < away < 1.7


def test_sometimes_the_robot_stands_where_it_is_told_the_subtask():
    told, facing = set(), []
    for world, _ in glance_around(TASKS, [3, 4], 8 * VIEWS_PER_PLACE, beginning_share=1.0):
        told.update(int(i) for i in world.subtask_index)
        for env, task in enumerate(TASKS):
            state, subtask, heading = world.state, int(world.subtask_index[env]), Heading.of(world.state)
            at = state.link_pos_w[env, 0, :2].numpy()
            if subtask == 0:
                shift = np.abs(at - task.robot.position_m)
                assert shift.max() < 0.06, "the task's start, and five centimetres"
                ahead = np.cos(task.robot.yaw_rad), np.sin(task.robot.yaw_rad)
                facing.append(float(heading.cos[env]) * ahead[0] + float(heading.sin[env]) * ahead[1])
            else:
                before = world.scenes[env].goal_pos_w[subtask - 1][:2]
                assert 0.4 < np.linalg.norm(at - before) < 1.6
    assert told == {0, 1}
    assert np.mean(np.array(facing) > 0.55) > 0.45, "half of the time about as it is turned then"


def _lowest_m(model, data, geom: int) -> float:
    """The bottom of a geom's own bounding box, in the world."""
    centre, half = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
    rotation = data.geom_xmat[geom].reshape(3, 3)
    return float((data.geom_xpos[geom] + rotation @ centre)[2] - np.abs(rotation[2]) @ half)


def test_glances_follow_from_the_task_and_the_seed_alone():
    config = RecordingConfig(seed=1, image_size_px=32, glances=4)
    (_, first), (_, second) = roll_glances([(TASKS[0], 0), (TASKS[1], 0)], config)
    [(attempt, alone)] = roll_glances([(TASKS[1], 0)], config)
    assert attempt.num_frames == len(alone) == 4
    assert first[0]["task"] != second[0]["task"]
    for a, b in zip(second, alone, strict=True):
        assert a["task"] == b["task"]
        for key in set(a) - {"task"}:
            np.testing.assert_array_equal(a[key], b[key])


def test_an_experts_columns_and_those_of_glances_are_the_same():
    from hv_teachers.recording import roll_attempts

    [(_, glances)] = roll_glances([(TASKS[0], 0)], RecordingConfig(image_size_px=32, glances=1))
    [(_, frames)] = roll_attempts(
        [(TASKS[0], 0)], PlannerExpert, RecordingConfig(image_size_px=32, max_episode_steps=2)
    )
    assert {k: np.shape(v) for k, v in glances[0].items()} == {k: np.shape(v) for k, v in frames[0].items()}
