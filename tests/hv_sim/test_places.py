"""Places, by hand: what is left of a piece, on the left part of its top, before it."""

import math
from dataclasses import replace

import pytest

from hv_sim.places import GAP_M, Place, layout_at
from hv_sim.task import FurniturePlacement, ObjectPlacement, RobotStart, Room, SubTask, Task


def layout(yaw=0.0):
    """An island in the middle of a kitchen with a toaster on it; its front looks along +x turned by `yaw`."""
    objects = (
        ObjectPlacement("toaster", "toaster", (0.0, 0.0, 0.99)),
        ObjectPlacement("kettle", "kettle", (2.0, 2.0, 0.13)),
    )
    task = Task(
        "t",
        Room("kitchen"),
        RobotStart((-2.0, 0.0), 0.0),
        (FurniturePlacement("island", "kitchen_island", (0.0, 0.0), yaw),),
        objects,
        (SubTask("toaster", (2.0, -2.0, 0.11), 0.0, "x"),),
    )
    return layout_at(task, 0)


def turned(x, y, z, yaw):
    return (math.cos(yaw) * x - math.sin(yaw) * y, math.sin(yaw) * x + math.cos(yaw) * y, z)


@pytest.mark.parametrize("yaw", [0.0, 1.3, -math.pi / 2])
def test_left_and_right_are_those_of_somebody_who_faces_the_front(yaw):
    here = layout(yaw)
    # the viewer stands at +x and looks along -x: -y is at the left
    spots = {
        (0.0, -1.1, 0.13): "left_of",
        (0.0, 1.1, 0.13): "right_of",
        (0.9, 0.0, 0.13): "in_front_of",
        (-0.9, 0.0, 0.13): "behind",
    }
    for spot, relation in spots.items():
        at = turned(*spot, yaw)
        found = [
            r
            for r in ("left_of", "right_of", "in_front_of", "behind")
            if here.contains(Place(r, "island"), "kettle", at)
        ]
        assert found == [relation]
    tops = {(0.0, -0.5): "on_left", (0.0, 0.0): "on_middle", (0.0, 0.5): "on_right"}
    for spot, relation in tops.items():
        at = turned(*spot, 1.01, yaw)
        found = [r for r in ("on_left", "on_middle", "on_right") if here.contains(Place(r, "island"), "kettle", at)]
        assert found == [relation]
        assert here.contains(Place("on", "island"), "kettle", at)
    assert here.contains(Place("left_of", "toaster"), "kettle", turned(0.0, -0.4, 1.01, yaw))
    assert not here.contains(Place("right_of", "toaster"), "kettle", turned(0.0, -0.4, 1.01, yaw))


def test_what_is_too_far_or_too_high_is_not_there():
    here = layout()
    assert not here.contains(Place("left_of", "island"), "kettle", (0.0, -2.0, 0.13))
    assert not here.contains(Place("left_of", "island"), "kettle", (0.0, -1.1, 0.6)), "in the air"
    assert not here.contains(Place("on", "island"), "kettle", (0.0, 0.0, 0.13)), "under the top"
    assert here.contains(Place("floor"), "kettle", (2.0, 2.0, 0.13))


def test_sides_of_the_robot_hold_only_before_it_has_moved():
    here = layout()
    assert here.contains(Place("your_left"), "kettle", (-2.0, 2.0, 0.13))
    assert here.contains(Place("your_right"), "kettle", (-2.0, -2.0, 0.13))
    assert not here.contains(Place("your_left"), "kettle", (1.0, 0.1, 0.13)), "straight ahead"
    later = layout_at(here.task, 1)
    assert later.poses["toaster"][0] == (2.0, -2.0, 0.11)
    assert not later.contains(Place("your_left"), "kettle", (-2.0, 2.0, 0.13))


def test_places_lists_what_contains_says():
    here = layout()
    found = here.places("kettle", (0.0, -1.1, 0.13))
    assert Place("left_of", "island") in found
    assert Place("floor") in found
    assert all(here.contains(p, "kettle", (0.0, -1.1, 0.13)) for p in found)


@pytest.mark.parametrize("yaw", [0.0, 1.3])
def test_a_goal_is_one_spot_close_to_the_middle_of_its_place(yaw):
    here = layout(yaw)
    # the island is 0.8 m deep and 1.5 m wide, the kettle 0.2 m
    spots = {
        "left_of": (0.0, -0.75 - 0.1 - GAP_M),
        "right_of": (0.0, 0.75 + 0.1 + GAP_M),
        "front_middle": (0.4 + 0.1 + GAP_M, 0.0),
        "back_middle": (-0.4 - 0.1 - GAP_M, 0.0),
        "on_middle": (0.0, 0.0),
        "on_left": (0.0, -0.27 * 1.5),
        "on_right": (0.0, 0.27 * 1.5),
    }
    for relation, spot in spots.items():
        place, z = Place(relation, "island"), 1.01 if relation.startswith("on") else 0.13
        assert here.spot_m(place, "kettle") == pytest.approx(turned(*spot, 0.0, yaw)[:2])
        assert here.is_goal(place, "kettle", turned(*spot, z, yaw))
        assert not here.is_goal(place, "kettle", turned(spot[0] + 0.26, spot[1], z, yaw)), "too far from the spot"
    for wide in ("on", "in_front_of", "behind"):
        assert here.spot_m(Place(wide, "island"), "kettle") is None, "its front is too long and its top too wide"
    beside = here.spot_m(Place("left_of", "toaster"), "kettle")
    assert beside == pytest.approx(turned(0.0, -0.16 - 0.1 - GAP_M, 0.0, yaw)[:2])
    assert here.spot_m(Place("room_middle"), "kettle") == (0.0, 0.0)


def test_what_has_no_front_has_no_sides():
    there = layout_at(replace(layout().task, furniture=(FurniturePlacement("island", "dining_table", (0.0, 0.0)),)), 0)
    for x, y in ((0.0, -1.1), (0.0, 1.1), (0.9, 0.0), (-0.9, 0.0)):
        assert not [p for p in there.places("kettle", (x, y, 0.13)) if p.landmark == "island"]
    on_top = [p.relation for p in there.places("kettle", (0.0, -0.5, 0.88)) if p.landmark == "island"]
    assert on_top == ["on"]
    assert there.spot_m(Place("left_of", "island"), "kettle") is None
    assert there.spot_m(Place("on_left", "island"), "kettle") is None
    assert there.spot_m(Place("on_middle", "island"), "kettle") == (0.0, 0.0)
