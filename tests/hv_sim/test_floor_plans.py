"""Floor plans: always the same, valid, connected, and other ones for the unseen tasks."""

import numpy as np
import pytest

from hv_sim.floor_plans import HELD_OUT, STAND_M, can_stand_before, floor_plan, standing_room
from hv_sim.parts import prisms, support_height_m
from hv_sim.rooms import ROOM_KINDS
from hv_sim.task import ObjectPlacement, RobotStart, SubTask, Task, check_task, furniture_parts

PLANS = [(kind, index) for kind in ROOM_KINDS for index in (0, 1, 2, *HELD_OUT[:2], HELD_OUT.stop)]


@pytest.mark.parametrize(("kind", "index"), PLANS)
def test_a_plan_is_a_valid_room_in_which_every_top_can_be_used(kind, index):
    plan = floor_plan(kind, index)
    free = standing_room(plan)
    places = free.centers_m()[~free.cells]
    robot = places[np.argmin(np.abs(places).sum(-1))]
    surface = plan.surfaces[0]
    there = (*surface.position_m, surface.height_m + 0.14)
    check_task(
        Task(
            name="plan",
            room=plan.room,
            robot=RobotStart((float(robot[0]), float(robot[1])), 0.0),
            furniture=plan.furniture,
            objects=(ObjectPlacement("box", "box", there),),
            subtasks=(SubTask("box", there, 0.0, "Leave the box."),),
        )
    )
    assert len(plan.surfaces) >= 3
    for surface in plan.surfaces:
        sides = can_stand_before(surface, free)
        assert sides, surface.furniture
        for yaw, reach, _, _ in sides:
            stand = np.asarray(surface.position_m) + (reach + STAND_M) * np.array([np.cos(yaw), np.sin(yaw)])
            assert np.linalg.norm(places - stand, axis=1).min() < 0.05


@pytest.mark.parametrize(("kind", "index"), PLANS)
def test_surfaces_lie_on_the_furniture(kind, index):
    plan = floor_plan(kind, index)
    solids = prisms(p for f in plan.furniture for p in furniture_parts(f))
    for surface in plan.surfaces:
        for ahead in (-0.3, 0.0, 0.3):
            for left in (-0.3, 0.0, 0.3):
                at = surface.point_m(ahead * surface.depth_m, left * surface.width_m)
                assert support_height_m(at, 3.0, solids) == pytest.approx(surface.height_m, abs=0.011)


def test_the_same_number_gives_the_same_plan_and_another_one_another():
    assert floor_plan("bedroom", 3) == floor_plan("bedroom", 3)
    assert floor_plan("bedroom", 3) != floor_plan("bedroom", 4)


def test_held_out_plans_differ_in_their_floors_and_furniture():
    for kind in ROOM_KINDS:
        seen, unseen = ([floor_plan(kind, start + i) for i in range(3)] for start in (0, HELD_OUT.start))
        assert not {p.room.floor for p in seen} & {p.room.floor for p in unseen}
        assert not {p.furniture for p in seen} & {p.furniture for p in unseen}


def test_what_does_not_exist_is_refused():
    with pytest.raises(ValueError, match=r"kind: 'attic' is not a room; valid: bedroom"):
        floor_plan("attic", 0)
    with pytest.raises(ValueError, match="index: -1"):
        floor_plan("bedroom", -1)
