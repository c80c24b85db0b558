"""The scripted planner, state by state."""

import math

import pytest
import torch

from hv_policy.decision.view import Phase, TaskView
from hv_teachers.planner import ScriptedPlanner, _to_heading, _to_world


def view(num=1, **changes):
    """A box on the floor .42 m ahead of a robot that stands where it should, arms hanging."""
    values = {
        "root_xy": torch.zeros(num, 2),
        "root_yaw": torch.zeros(num),
        "feet_xy": torch.zeros(num, 2),
        "hands": torch.tensor([[[0.1, -0.24, 0.86], [0.1, 0.24, 0.86]]]).repeat(num, 1, 1),
        "object_pos": torch.tensor([[0.42, 0.0, 0.15]]).repeat(num, 1),
        "grasp": torch.tensor([[[0.42, -0.15, 0.2], [0.42, 0.15, 0.2]]]).repeat(num, 1, 1),
        "depth_m": torch.full((num,), 0.3),
        "goal_pos": torch.tensor([[2.0, 0.0, 0.75]]).repeat(num, 1),
        "pick_stand": torch.zeros(num, 3),
        "place_stand": torch.tensor([[1.6, 0.0, 0.0]]).repeat(num, 1),
        "waypoint": torch.zeros(num, 2),
        "waypoint_is_last": torch.ones(num, dtype=torch.bool),
        "may_back": torch.ones(num, dtype=torch.bool),
        "clearance_m": torch.ones(num),
        "away": torch.zeros(num, 2),
    }
    return TaskView(**{**values, **changes})


def run(planner, seen, seconds):
    for _ in range(round(seconds * 30)):
        intent = planner(seen)
    return intent


def test_walks_to_a_far_waypoint_and_turns_to_one_aside():
    planner = ScriptedPlanner(3)
    far = view(
        3, waypoint=torch.tensor([[3.0, 0.0], [0.0, 3.0], [-0.6, 0.0]]), pick_stand=torch.tensor([[4.0, 0, 0]] * 3)
    )
    far.waypoint_is_last[:] = False
    intent = run(planner, far, 0.1)
    assert (planner.phase == Phase.APPROACH).all()
    assert intent[0, 0] > 0.5
    assert intent[0, 2] == 0
    assert intent[1, 2] > 0.5
    assert intent[1, 0] < 0.1
    assert intent[2, 0] < -0.2, "a near waypoint behind is reached walking backward"


def test_the_phases_of_a_lift():
    planner = ScriptedPlanner(1)
    run(planner, view(), 0.1)
    assert planner.phase.item() == Phase.ALIGN
    run(planner, view(), 0.5)
    assert planner.phase.item() == Phase.REACH
    intent = run(planner, view(), 1.5)
    assert planner.phase.item() == Phase.REACH, "the hands are not there yet"
    assert intent[0, 3] < 0.5
    assert intent[0, 4] > 1.0
    assert intent[0, 11] == 0
    ready = torch.stack([intent[:, 8:11], intent[:, 5:8]], 1)
    assert (ready[0, :, 1].abs() > 0.15 + 0.04).all(), "beside the box, not in it"
    run(planner, view(hands=ready), 0.1)
    assert planner.phase.item() == Phase.SQUEEZE
    pressed = torch.tensor([[[0.42, -0.19, 0.2], [0.42, 0.19, 0.2]]])
    intent = run(planner, view(hands=pressed), 0.5)
    assert intent[0, 11] == 1
    run(planner, view(hands=pressed), 0.4)
    assert planner.phase.item() == Phase.LIFT
    up = torch.tensor([[0.42, 0.0, 0.5]])
    intent = run(planner, view(hands=pressed + torch.tensor([0, 0, 0.35]), object_pos=up), 1.0)
    assert planner.phase.item() == Phase.LIFT
    run(planner, view(hands=pressed + torch.tensor([0, 0, 0.35]), object_pos=up), 1.2)
    assert planner.phase.item() == Phase.ALIGN_PLACE or planner.phase.item() == Phase.CARRY


def test_an_object_that_slips_away_or_does_not_rise_is_fetched_again():
    pressed = torch.tensor([[[0.42, -0.19, 0.2], [0.42, 0.19, 0.2]]])
    for seen in (
        view(hands=pressed + torch.tensor([0, 0, 0.6])),  # the hands went up without it
        view(hands=pressed),  # it never rose
    ):
        planner = ScriptedPlanner(1)
        planner.reset(phase=Phase.SQUEEZE)
        planner(view(hands=pressed))
        planner.clock_s[:] = 1.0
        planner(view(hands=pressed))
        assert planner.phase.item() == Phase.LIFT
        lost = False
        for _ in range(90):
            planner(seen)
            lost |= bool(planner.lost)
            if lost:
                break
        assert lost
        assert planner.phase.item() == Phase.APPROACH


def test_a_miss_is_noticed_and_a_hit_is_left_alone():
    planner = ScriptedPlanner(2)
    planner.reset(phase=Phase.IDLE)
    seen = view(2)
    seen.object_pos[1] = seen.goal_pos[1]
    seen.waypoint_is_last[:] = False
    run(planner, seen, 1.5)
    assert planner.phase.tolist() == [Phase.APPROACH, Phase.IDLE]


@pytest.mark.parametrize("start", [1.8, -1.8, 3.0, -3.0])
@pytest.mark.parametrize("wall", [None, 0.9, -0.9])
def test_who_cannot_turn_one_way_turns_the_other_way_round(start, wall):
    """It meets a wall at one heading (rad from where it should face), from either side."""
    planner = ScriptedPlanner(1)
    planner.reset(phase=Phase.ALIGN)
    yaw = start

    def beyond(angle):
        return math.remainder(angle - wall, math.tau)

    for _ in range(30 * 45):
        rate = float(planner(view(root_yaw=torch.tensor([yaw])))[0, 2])
        if planner.phase[0] != Phase.ALIGN:
            break
        turned = yaw + rate / 30
        if wall is None or abs(beyond(turned)) > 1 or (beyond(yaw) > 0) == (beyond(turned) > 0):
            yaw = turned
    assert planner.phase[0] == Phase.REACH
    assert abs(math.remainder(yaw, math.tau)) < 0.25


def test_frames_are_each_others_inverse():
    seen = view(5, root_xy=torch.randn(5, 2), root_yaw=torch.randn(5))
    points = torch.randn(5, 3)
    torch.testing.assert_close(_to_world(seen, _to_heading(seen, points[:, None])[:, 0]), points)


@pytest.mark.parametrize("rows", [[0], [1, 2]])
def test_reset_touches_only_its_rows(rows):
    planner = ScriptedPlanner(3)
    run(planner, view(3), 0.6)
    before = planner.phase.clone()
    planner.reset(torch.tensor(rows))
    others = [i for i in range(3) if i not in rows]
    assert (planner.phase[rows] == Phase.APPROACH).all()
    assert (planner.phase[others] == before[others]).all()
