"""What makes a task unsolvable is found, and what is solvable passes."""

from dataclasses import replace

import numpy as np
import pytest

from hv_sim.suites import load_suite
from hv_sim.task import FurniturePlacement, ObjectPlacement, RobotStart, Room, SubTask, Task
from hv_teachers.task_verification import CHECKS, reaching_error_m, verify_task


def task(**changes):
    """A box to be brought from the floor to a coffee table."""
    box = ObjectPlacement("box", "box", (1.5, 0.0, 0.14))
    table = FurniturePlacement("table", "coffee_table", (-1.5, 0.0))
    goal = SubTask("box", (-1.42, 0.0, 0.56), 0.0, "Put the box on the middle of the coffee table.")
    values = {"robot": RobotStart((0.0, 1.0)), "furniture": (table,), "objects": (box,), "subtasks": (goal,)}
    return Task("t", Room(), **{**values, **changes})


def test_a_plain_task_is_solvable():
    verdict = verify_task(task())
    assert verdict.solvable
    assert 3.0 < verdict.walk_m < 8.0


@pytest.mark.parametrize("name", ["seen", "unseen", "single", "chain3", "chain5"])
def test_packaged_tasks_are_solvable(name):
    for packaged in load_suite(name)[5::53]:
        verdict = verify_task(packaged)
        assert verdict.solvable, verdict


def test_what_is_wrong_is_named():
    box = task().objects[0]
    high = FurniturePlacement("shelf", "bookshelf", (-1.5, 0.0))
    walls = tuple(
        FurniturePlacement(f"w{i}", "wardrobe", (1.5 + x, y), yaw)
        for i, (x, y, yaw) in enumerate(
            [(0.65, 0.0, np.pi), (-0.65, 0.0, 0.0), (0.0, 1.05, -np.pi / 2), (0.0, -1.05, np.pi / 2)]
        )
    )
    wrong = {
        "says": task(subtasks=(replace(task().subtasks[0], instruction="Put the lamp on the coffee table."),)),
        "settles": task(objects=(replace(box, position_m=(1.5, 0.0, 0.4)),)),
        "reaches": task(
            furniture=(high,), subtasks=(SubTask("box", (-1.5, 0.0, 2.05), 0.0, "Put the box on the bookshelf."),)
        ),
        "stands": task(furniture=(*task().furniture, *walls)),
        "goal_stays": task(subtasks=(replace(task().subtasks[0], goal_position_m=(-1.18, 0.0, 0.56)),)),
    }
    for check, broken in wrong.items():
        verdict = verify_task(broken, ambiguity=check == "says")
        assert verdict.failed == check, verdict
        assert verdict.reason
        assert "\n" not in verdict.reason
        assert check in CHECKS


def test_a_locked_room_has_no_way():
    row = tuple(FurniturePlacement(f"w{i}", "bookshelf", (0.0, -2.0 + 0.97 * i)) for i in range(5))
    verdict = verify_task(task(furniture=(*task().furniture, *row), robot=RobotStart((1.5, 1.5))), ambiguity=False)
    assert verdict.failed in ("walks", "stands")


def test_reach_grows_worse_with_distance():
    grasp = np.array([[0.0, 0.15, 0.05], [0.0, -0.15, 0.05]])
    near, far = (np.array([x, 0.0, 0.8, 1.0, 0.0, 0.0, 0.0]) for x in (0.4, 1.2))
    assert reaching_error_m(grasp, near, (0.0, 0.0, 0.0)) < 0.02
    assert reaching_error_m(grasp, far, (0.0, 0.0, 0.0)) > 0.2
    # the same seen from elsewhere
    turned = np.array([0.0, 0.4, 0.8, np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)])
    assert reaching_error_m(grasp, turned, (0.0, 0.0, np.pi / 2)) == pytest.approx(
        reaching_error_m(grasp, near, (0.0, 0.0, 0.0)), abs=1e-4
    )
