from dataclasses import replace

import numpy as np
import pytest
import torch

from hv_live.live_world import LiveWorld
from hv_sim.task import load_task
from hv_sim.world import RearrangeWorld
from hv_teachers.expert import PlannerExpert


@pytest.fixture(scope="module")
def task():
    return load_task("living_room_1")


def test_left_alone_it_is_the_world_bit_for_bit(task):
    """The same episode as `RearrangeWorld`'s, as long as nothing else is said."""
    live, plain = LiveWorld(task), RearrangeWorld([task], num_threads=1)
    live.restart(7)
    plain.reset(seeds=[7])
    experts = PlannerExpert(1), PlannerExpert(1)
    for _ in range(25):
        for world, expert in zip((live, plain), experts, strict=True):
            world.step(expert(world)[1])
    assert torch.equal(live.state.joint_pos, plain.state.joint_pos)
    assert live.instructions() == plain.instructions()
    assert torch.equal(live.progress(), plain.progress())


def test_a_new_instruction_changes_object_goal_and_route(task):
    live = LiveWorld(task)
    live.restart(0)
    route = live.navigator.routes[0]
    second = task.subtasks[1]
    live.give(second)
    assert live.instructions() == [second.instruction]
    assert int(live.subtask_index[0]) == 1
    assert live.object_index.tolist() == [live.whole_scene.object_names.index(second.object)]
    assert torch.allclose(live.goal_pos_w[0, -1], torch.tensor(second.goal_position_m))
    assert live.navigator.routes[0] is not route
    observed = live.observe()
    live.step(torch.zeros(1, 28))
    assert observed.goal.shape == (1, 9)
    assert not bool(live.finished[0])


def test_words_without_a_goal_are_never_found_done(task):
    """Even where the object lies at the goal and the robot is away: those are not what was asked for."""
    here = task.objects[0]
    resting = replace(task.subtasks[0], object=here.name, goal_position_m=here.position_m, goal_yaw_rad=here.yaw_rad)
    live = LiveWorld(replace(task, subtasks=(resting, task.subtasks[1])))
    live.restart(0)
    live.give_words("wave at me")
    for _ in range(70):
        live.step(torch.zeros(1, 28))
    assert live.instructions() == ["wave at me"]
    assert not bool(live.finished[0])
    live.give(resting)
    for _ in range(70):
        live.step(torch.zeros(1, 28))
    assert bool(live.finished[0])
    assert not bool(live.done[0]), "it goes on"


def test_restart_begins_with_the_tasks_first_instruction(task):
    live = LiveWorld(task)
    live.give_words("hello")
    live.restart(3)
    assert live.goal_known
    assert live.current.object == task.subtasks[0].object
    assert int(live.subtask_index[0]) == 0
    assert int(live.episode_step[0]) == 0


def test_a_push_moves_the_robot(task):
    moved = []
    for push in (0.0, 0.6):
        live = LiveWorld(task)
        live.restart(0)
        live.push(np.array([push, 0.0, 0.0]))
        live.step(torch.zeros(1, 28))
        moved.append(float(live.state.link_pos_w[0, 0, 0]))
    assert moved[1] - moved[0] > 0.01


def test_the_layout_is_as_things_now_are(task):
    live = LiveWorld(task)
    live.restart(0)
    for _ in range(5):
        live.step(torch.zeros(1, 28))
    layout = live.layout()
    for placed in task.objects:
        assert np.allclose(layout.poses[placed.name][0], placed.position_m, atol=0.03)
    assert np.allclose(layout.task.robot.position_m, live.robot_xy_yaw()[:2])
