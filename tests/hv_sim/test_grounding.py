"""Sentences that a person wrote, and what they may mean in a scene."""

from dataclasses import replace

import pytest

from hv_sim.grounding import fits, ground
from hv_sim.places import Place, layout_at
from hv_sim.task import FurniturePlacement, ObjectPlacement, RobotStart, Room, SubTask, Task

GOAL = (0.0, -2.2, 0.72)


@pytest.fixture(scope="module")
def scene():
    """Two vases of different colours, two crates of different sizes, a console table and a coffee table."""
    furniture = (
        FurniturePlacement("coffee_table", "coffee_table", (-1.5, 1.0)),
        FurniturePlacement("tv_stand", "tv_stand", (0.0, -2.2), 1.5708),
        FurniturePlacement("record", "record_cabinet", (2.5, 0.0), 3.1416),
        FurniturePlacement("cabinet", "cabinet", (2.5, 1.6), 3.1416),
    )
    objects = (
        ObjectPlacement("red", "vase", (-1.5, 1.0, 0.6), color="teal"),
        ObjectPlacement("blue", "vase", (1.0, 1.0, 0.18), color="navy"),
        ObjectPlacement("small", "crate", (0.5, -0.5, 0.11), size_m=(0.25, 0.28, 0.22), color="oak"),
        ObjectPlacement("large", "crate", (-0.5, -0.5, 0.15), color="oak"),
    )
    task = Task("t", Room(), RobotStart((0.0, 1.8), -1.57), furniture, objects, (SubTask("red", GOAL, 0.0, "x"),))
    return layout_at(task, 0)


@pytest.mark.parametrize(
    ("sentence", "objects", "goals"),
    [
        ("Put the vase on the TV stand.", {"red", "blue"}, {Place("on", "tv_stand")}),
        ("Put the teal vase on the TV stand.", {"red"}, {Place("on", "tv_stand")}),
        ("Take the vase from the coffee table and put it on the TV stand.", {"red"}, {Place("on", "tv_stand")}),
        (
            "Take the vase that is on the floor and set it just to the left of the TV stand.",
            {"blue"},
            {Place("left_of", "tv_stand")},
        ),
        (
            "There is a dark blue vase on the floor; move it to the very middle of the room.",
            {"blue"},
            {Place("room_middle")},
        ),
        ("Could you move the small crate onto the coffee table?", {"small"}, {Place("on", "coffee_table")}),
        ("Move the large crate onto the right side of the TV stand.", {"large"}, {Place("on_right", "tv_stand")}),
        ("On top of the low table is where the crate should be.", {"small", "large"}, {Place("on", "coffee_table")}),
        ("Put the teal vase on the cabinet.", {"red"}, {Place("on", "cabinet"), Place("on", "record")}),
        ("Put the toaster on the TV stand.", set(), {Place("on", "tv_stand")}),
        ("Dance!", set(), set()),
    ],
)
def test_what_sentences_may_mean(scene, sentence, objects, goals):
    meant = ground(sentence, scene)
    assert meant.objects == objects
    if objects:
        assert set(meant.goals) == goals


def test_only_what_means_one_thing_fits(scene):
    assert fits("Put the teal vase on the middle of the TV stand.", scene, "red", GOAL)
    assert not fits("Put the teal vase on the TV stand.", scene, "red", GOAL), "it is 1.8 m long"
    assert not fits("Put the vase on the middle of the TV stand.", scene, "red", GOAL), "two vases"
    assert not fits("Put the teal vase on the middle of the TV stand.", scene, "blue", GOAL), "the other vase"
    assert not fits("Put the teal vase on the left side of the TV stand.", scene, "red", GOAL), "another part of it"
    assert not fits("Put the teal vase on the coffee table.", scene, "red", GOAL), "another place"
    assert not fits("Put the teal vase on the cabinet.", scene, "red", GOAL), "a record cabinet is a cabinet too"


def test_things_whose_colours_may_be_taken_for_each_other_are_not_told_apart_by_colour_alone(scene):
    brown, light = (ObjectPlacement(c, "box", (x, -1.0, 0.14), color=c) for c, x in (("brown", 1.5), ("tan", -2.0)))
    here = layout_at(replace(scene.task, objects=(*scene.task.objects, brown, light)), 0)
    for words in ("brown", "light brown"):
        assert ground(f"Put the {words} box on the coffee table.", here).objects == {"brown", "tan"}
    assert ground("Put the dark blue vase on the coffee table.", here).objects == {"blue"}, "the other one is teal"


def test_which_side_something_is_on_is_read_as_where_it_is(scene):
    near = layout_at(replace(scene.task, robot=RobotStart((0.0, 0.3), -1.57)), 0)
    meant = ground("Put the crate that is on your left on the middle of the TV stand.", near)
    assert meant.objects == {"small"}
    assert set(meant.goals) == {Place("on_middle", "tv_stand")}
