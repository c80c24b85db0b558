import re
from pathlib import Path

import numpy as np
import pytest
from live_cast import SpyCast

from hv_live.simulation import Simulation
from hv_live.understanding import NotUnderstoodError

OTHER = "Put the toaster on the console table."


@pytest.fixture
def live():
    with Simulation("living_room_1", SpyCast()) as live:
        yield live


def test_an_instruction_reaches_the_policy_at_the_next_control_step(live):
    live.run(0.2)
    first = live.instruction
    live.instruct(OTHER)
    live.step()
    assert live.cast.actors["reader"].told == [first] * 6 + [OTHER]
    assert live.last_told == OTHER
    assert [(s.text, s.by, s.status) for s in live.said] == [(first, "task", "left"), (OTHER, "you", "now")]


def test_who_reads_is_told_any_words_who_needs_a_goal_is_not(live):
    live.instruct("wave at me")
    live.step()
    assert live.cast.actors["reader"].told == ["wave at me"]
    assert live.progress is None
    assert live.distance_m is None
    with pytest.raises(ValueError, match="needs an object and a place"):
        live.set_policy("teacher")
    live.instruct(OTHER)
    live.set_policy("teacher")
    assert live.cast.actors["teacher"].resets == 1
    with pytest.raises(NotUnderstoodError, match="the teacher needs"):
        live.instruct("wave at me")
    assert live.instruction == OTHER, "what was refused changes nothing"
    with pytest.raises(ValueError, match="nobody"):
        live.set_policy("nobody")


def finish(live):
    """Puts the object of the instruction in force at its goal, and the robot far off, until it is accepted."""
    world = live.world
    subtask = world.current
    qpos = world.physics.data(0).qpos.copy()
    k = world.whole_scene.object_names.index(subtask.object)
    qpos[35 + 7 * k : 38 + 7 * k] = subtask.goal_position_m
    world.physics.reset([0], [qpos])
    for _ in range(80):
        live.step()
        if (live.said[-1].text != subtask.instruction and live.said[-1].status == "now") or live.done:
            return


def test_algorithm_3_gives_the_tasks_instructions_in_turn(live):
    live.set_instructor(True)
    assert len(live.said) == 1, "the one in force is left in force"
    finish(live)
    assert [(s.by, s.status) for s in live.said] == [("task", "done"), ("instructor", "now")]
    assert live.instruction == live.task_instruction(1)
    finish(live)
    assert live.done
    assert live.progress == 1.0
    assert live.stage == "done"
    assert not live.instructor, "nothing is left to say"
    with pytest.raises(ValueError, match="every instruction"):
        live.set_instructor(True)


def test_who_speaks_takes_over_from_algorithm_3(live):
    live.set_instructor(True)
    live.instruct("Put the toaster on the TV stand.")
    assert not live.instructor
    finish(live)
    assert live.done, "nobody else speaks"
    live.set_instructor(True)
    assert live.instruction == live.task_instruction(0), "which was left undone"


def test_reset_begins_anew_with_another_start(live):
    before = live.world.physics.data(0).qpos.copy()
    live.run(0.3)
    live.instruct(OTHER)
    live.reset()
    assert live.time_s == 0.0
    assert [s.by for s in live.said] == ["task"]
    assert live.seed == 1
    assert not np.array_equal(live.world.physics.data(0).qpos, before)
    live.reset(0)
    assert np.array_equal(live.world.physics.data(0).qpos, before)


def test_only_who_sees_is_shown_a_picture(live):
    live.step()
    actor = live.cast.actors["reader"]
    assert actor.pictures == [None]
    actor.sees = True
    live.step()
    assert actor.pictures[-1].shape == (128, 128, 3)
    assert actor.pictures[-1].std() > 5


def test_a_push_is_in_the_robots_own_directions(live):
    live.reset(0)
    yaw = live.world.robot_xy_yaw()[2]
    live.push(np.pi / 2, 0.6)
    live.step()
    velocity = live.world.state.link_lin_vel_w[0, 0, :2].numpy()
    left = np.array([-np.sin(yaw), np.cos(yaw)])
    assert velocity @ left > 0.2


def test_the_planner_carries_on_after_being_interrupted():
    with Simulation("living_room_1", "planner") as live:
        live.run(2.0)
        live.instruct(OTHER)
        before = float(live.world.state.link_pos_w[0, 0, :2].sub(live.world.state.object_pos_w[0, 1, :2]).norm())
        live.run(4.0)
        after = float(live.world.state.link_pos_w[0, 0, :2].sub(live.world.state.object_pos_w[0, 1, :2]).norm())
        assert not live.fallen
        assert after < before - 0.3, "it goes to the toaster now"


def test_the_example_of_the_docs_runs(monkeypatch, tmp_path):
    text = (Path(__file__).parents[2] / "docs" / "live.md").read_text()
    [example] = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert len(example.strip().splitlines()) <= 10
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    exec(compile(example, "docs/live.md", "exec"), names)
    assert names["live"].time_s > 1.0
    assert not names["live"].fallen
