"""Algorithm 3 against a slow, obvious loop over one environment at a time."""

import pytest
import torch

from hv_sim.instructor import Instructor, InstructorConfig


def slow_algorithm_3(speeds, goal_distances, robot_distances, num_subtasks, config):
    """Sub-tasks finished after each step, for one environment's history of measurements."""
    finished, steps, held, history = 0, 0, 0, []
    for s, d, r in zip(speeds, goal_distances, robot_distances, strict=True):
        if finished < num_subtasks:
            steps += 1
            if (
                s < config.max_object_speed_m_s
                and d < config.max_object_goal_distance_m
                and r > config.min_robot_object_distance_m
                and steps > config.min_steps
            ):
                held += 1
            else:
                held = 0
            if held >= config.hold_steps:
                finished, steps, held = finished + 1, 0, 0
        history.append(finished)
    return history


def placed(n):
    """Measurements that satisfy every condition of the default thresholds."""
    return torch.full((n,), 0.01), torch.full((n,), 0.1), torch.full((n,), 1.0)


def test_defaults_are_the_documented_ones():
    config = InstructorConfig()
    assert config.max_object_speed_m_s == 0.15
    assert config.max_object_goal_distance_m == 0.4
    assert config.min_robot_object_distance_m == 0.8
    assert (config.min_steps, config.hold_steps) == (45, 10)


def test_agrees_with_the_slow_loop_on_random_histories():
    config = InstructorConfig(min_steps=4, hold_steps=3)
    num_envs, num_steps = 40, 120
    generator = torch.Generator().manual_seed(0)
    # near the thresholds, and slowly changing, so that every condition turns on and off
    walk = torch.randn(3, num_steps, num_envs, generator=generator).cumsum(1) * 0.03
    speeds, goals, robots = (walk + torch.tensor([0.1, 0.35, 0.85]).view(3, 1, 1)).abs()
    num_subtasks = torch.arange(num_envs) % 4 + 1
    instructor = Instructor(num_subtasks, config)
    finished = []
    for t in range(num_steps):
        before = instructor.num_finished.clone()
        switched = instructor.update(speeds[t], goals[t], robots[t])
        assert torch.equal(instructor.num_finished - before, switched.long())
        finished.append(instructor.num_finished.clone())
    result = torch.stack(finished, 1)
    assert len(result[:, -1].unique()) >= 3, "the histories must exercise several outcomes"
    for i in range(num_envs):
        expected = slow_algorithm_3(speeds[:, i], goals[:, i], robots[:, i], int(num_subtasks[i]), config)
        assert result[i].tolist() == expected


def test_the_second_instruction_comes_after_the_hold_and_never_goes_back():
    instructor = Instructor([2])
    switch_step = None
    for step in range(1, 80):
        if instructor.update(*placed(1)).item():
            switch_step = step
            break
    assert switch_step == 45 + 10
    far = (torch.tensor([2.0]), torch.tensor([3.0]), torch.tensor([0.1]))
    for _ in range(100):
        instructor.update(*far)
    assert instructor.subtask_index.tolist() == [1]
    assert not instructor.finished.item()


@pytest.mark.parametrize(
    "broken",
    [
        (0.16, 0.1, 1.0),
        (0.01, 0.41, 1.0),
        (0.01, 0.1, 0.79),
    ],
    ids=["moving", "misplaced", "still_near"],
)
def test_each_condition_alone_holds_the_instruction_back(broken):
    instructor = Instructor([2])
    for _ in range(200):
        instructor.update(*(torch.tensor([value]) for value in broken))
    assert instructor.num_finished.tolist() == [0]


def test_one_bad_step_restarts_the_hold():
    instructor = Instructor([2])
    for _ in range(45 + 9):
        assert not instructor.update(*placed(1)).item()
    instructor.update(torch.tensor([1.0]), torch.tensor([0.1]), torch.tensor([1.0]))
    for _ in range(9):
        assert not instructor.update(*placed(1)).item()
    assert instructor.update(*placed(1)).item()


def test_a_condition_can_be_switched_off_for_the_ablations():
    moving = (torch.tensor([5.0]), torch.tensor([0.1]), torch.tensor([1.0]))
    instructor = Instructor([2], InstructorConfig(max_object_speed_m_s=None))
    for _ in range(55):
        instructor.update(*moving)
    assert instructor.num_finished.tolist() == [1]


def test_the_time_threshold_counts_from_the_current_instruction():
    instructor = Instructor([3])
    switches = [step for step in range(1, 200) if instructor.update(*placed(1)).item()]
    assert switches == [55, 110, 165]
    assert instructor.finished.item()
    assert instructor.subtask_index.tolist() == [2]


def test_environments_differ_in_number_of_subtasks_and_activity():
    instructor = Instructor([1, 2, 5])
    active = torch.tensor([True, True, False])
    for _ in range(200):
        instructor.update(*placed(3), active=active)
    assert instructor.num_finished.tolist() == [1, 2, 0]
    assert instructor.steps_since_instruction[2].item() == 0


def test_reset_of_some_environments_leaves_the_others():
    instructor = Instructor([2, 2])
    for _ in range(60):
        instructor.update(*placed(2))
    instructor.reset([1])
    assert instructor.num_finished.tolist() == [1, 0]
    assert instructor.steps_since_instruction.tolist() == [5, 0]


@pytest.mark.parametrize("field", ["max_object_speed_m_s", "min_steps", "hold_steps"])
@pytest.mark.parametrize("value", [-1, float("nan")])
def test_a_bad_threshold_is_named(field, value):
    with pytest.raises(ValueError, match=f"instructor.{field}: .* valid: "):
        InstructorConfig(**{field: value})


def test_every_environment_needs_a_subtask():
    with pytest.raises(ValueError, match="num_subtasks"):
        Instructor([2, 0])
