import math

import torch

from hv_policy.belief.attitude import STANDS
from hv_policy.belief.places import (
    DEPTH,
    GOAL,
    IS_LAST,
    LEG_IS_DONE,
    MAY_BACK,
    OBJECT,
    PICK,
    PICK_TURN,
    PLACE,
    SPAN,
    WAYPOINT,
)
from hv_policy.belief.wayfinder import LET_LIE_M, LOOKS_BACK, Leg, Wayfinder
from hv_policy.decision.view import Phase


def places(pick=(2.0, 0.0), place=(0.0, 3.0)) -> torch.Tensor:
    known = torch.zeros(21)
    known[PICK], known[PLACE] = torch.tensor(pick), torch.tensor(place)
    known[14] = known[19] = 1.0  # one faces along x, the other along y
    known[0] = pick[0] + 0.5
    return known


def pose(x: float, y: float, yaw: float = 0.0) -> torch.Tensor:
    return torch.tensor([x, y, yaw])


def test_legs_follow_each_other_as_the_work_goes_on():
    finder = Wayfinder(2)
    finder.floor.evidence[:] = -4.0
    finder.go_on(0, pose(0, 0), places(), Phase.APPROACH, None)
    assert finder._legs[0] == Leg.TO_OBJECT
    assert not finder.way[0, IS_LAST]
    assert 0.2 < float(finder.way[0, 0]) < 1.0
    finder.go_on(0, pose(1.95, 0), places(), Phase.ALIGN, None)
    torch.testing.assert_close(finder.way[0, WAYPOINT], torch.tensor([2.0, 0.0]))
    assert finder.way[0, [IS_LAST, MAY_BACK, LEG_IS_DONE]].tolist() == [1, 1, 1]
    finder.go_on(0, pose(2, 0), places(), Phase.LIFT, None)
    assert finder._legs[0] == Leg.BACK
    assert finder.way[0, 0] < 1.9
    assert finder.way[0, [IS_LAST, MAY_BACK, LEG_IS_DONE]].tolist() == [0, 1, 0]
    finder.go_on(0, pose(1.99, 0), places(), Phase.CARRY, None)
    assert finder._legs[0] == Leg.BACK
    finder.go_on(0, pose(1.8, 0), places(), Phase.CARRY, None)
    assert finder._legs[0] == Leg.TO_GOAL
    finder.go_on(0, pose(0, 2.9, math.pi / 2), places(), Phase.CARRY, None)
    torch.testing.assert_close(finder.way[0, WAYPOINT], torch.tensor([0.0, 3.0]), atol=1e-5, rtol=0)
    assert finder.way[0, IS_LAST] == 1
    assert (finder.way[1] == 0).all()


def test_who_dropped_something_first_walks_back_from_it_and_not_for_ever():
    finder = Wayfinder(2)
    finder.floor.evidence[:] = -4.0
    finder.go_on(0, pose(2, 0), places(), Phase.LIFT, None)
    finder.step_back(0)
    assert finder.steps_back.tolist() == [True, False]
    finder.go_on(0, pose(2, 0), places(), Phase.APPROACH, None)
    assert finder._legs[0] == Leg.BACK
    torch.testing.assert_close(finder.way[0, WAYPOINT], torch.tensor([2.0 - LET_LIE_M, 0.0]), atol=1e-5, rtol=0)
    finder.go_on(0, pose(2.05 - LET_LIE_M, 0), places(), Phase.APPROACH, None)
    assert finder._legs[0] == Leg.TO_OBJECT
    assert not finder.steps_back.any()
    finder.step_back(0)
    for _ in range(LOOKS_BACK):  # something is in the way
        assert finder.steps_back[0]
        finder.go_on(0, pose(2, 0), places(), Phase.APPROACH, None)
    assert finder._legs[0] == Leg.TO_OBJECT
    finder.step_back(1)
    finder.forget(1)
    assert not finder.steps_back.any()


def test_a_place_to_look_round_from_is_walked_to_instead():
    finder = Wayfinder(1)
    finder.go_on(0, pose(0, 0), places(), Phase.APPROACH, torch.tensor([-1.5, 0.0]))
    assert finder._legs[0] == Leg.TO_LOOK
    assert finder.way[0, 0] < -0.2
    assert finder.way[0, [IS_LAST, MAY_BACK, LEG_IS_DONE]].tolist() == [0, 0, 0]


def test_a_path_is_kept_until_it_is_old_or_its_end_has_moved():
    finder = Wayfinder(1)
    finder.go_on(0, pose(0, 0), places(), Phase.APPROACH, None)
    first = finder._paths[0]
    finder.go_on(0, pose(0.1, 0), places((2.05, 0.05)), Phase.APPROACH, None)
    assert finder._paths[0] is first
    finder.go_on(0, pose(0.1, 0), places((2.0, 0.5)), Phase.APPROACH, None)
    second = finder._paths[0]
    assert second is not first
    for _ in range(5):
        finder.go_on(0, pose(0.1, 0), places((2.0, 0.5)), Phase.APPROACH, None)
    assert finder._paths[0] is not second


def test_stands_follow_from_where_things_are_and_a_side_is_kept_once_it_is_faced():
    finder, known = Wayfinder(1), places((9.0, 9.0), (9.0, 9.0))
    finder.floor.evidence[:] = -4.0
    known[OBJECT], known[GOAL] = torch.tensor([2.0, 0.0, 0.9]), torch.tensor([0.0, 3.0, 0.9])
    known[14:16] = torch.tensor([0.9, 0.1])
    square, compass = torch.tensor([0.45, 0.0, 0.45]), torch.tensor([1.0, 0.0])  # 0.3 m wide, as the walls run
    settled = finder.settle(0, pose(0, 0.3), known, square, STANDS, compass, Phase.APPROACH)
    torch.testing.assert_close(settled[PICK], torch.tensor([1.65, 0.0]), atol=1e-4, rtol=0)
    torch.testing.assert_close(settled[PICK_TURN], torch.tensor([1.0, 0.0]), atol=1e-4, rtol=0)
    torch.testing.assert_close(settled[SPAN], torch.tensor([0.0, 0.15, 0.0]), atol=1e-4, rtol=0)
    torch.testing.assert_close(settled[DEPTH], torch.tensor([0.3]), atol=1e-4, rtol=0)
    assert torch.equal(settled[PLACE], known[PLACE])
    later = finder.settle(0, pose(2.1, -0.9), known, square, STANDS, compass, Phase.ALIGN)
    torch.testing.assert_close(later[PICK_TURN], torch.tensor([1.0, 0.0]), atol=1e-4, rtol=0)
    carried = finder.settle(0, pose(0.0, 0.0), settled, square, STANDS, compass, Phase.CARRY)
    assert abs(float((carried[PLACE] - known[GOAL][:2]).norm()) - 0.35) < 1e-3
    assert carried[PLACE][1] < 3.0
    assert torch.equal(carried[PICK], settled[PICK])


def test_what_lies_is_faced_as_it_is_turned():
    known = places((9.0, 9.0), (9.0, 9.0))
    known[OBJECT] = torch.tensor([2.0, 0.0, 0.15])
    compass, c, s = torch.tensor([1.0, 0.0]), math.cos(0.5), math.sin(0.5)
    known[PICK_TURN] = torch.tensor([c, s])
    spread, wide = 0.45, 0.45 / 4  # half as wide in one direction as in the other
    turned = [spread * s * s + wide * c * c, (wide - spread) * c * s, spread * c * c + wide * s * s]
    faces = [math.cos(4 * 0.5), math.sin(4 * 0.5)]
    for attitude, yaw in (([*faces, 0.1], 0.5), ([*faces, 1.0], 0.5), ([0.1, 0.1, 0.1], 0.0)):
        finder = Wayfinder(1)
        finder.floor.evidence[:] = -4.0
        shape = torch.tensor(turned), torch.tensor(attitude), compass
        settled = finder.settle(0, pose(0, 0), known, *shape, Phase.APPROACH)
        ahead = torch.tensor([math.cos(yaw), math.sin(yaw)])
        torch.testing.assert_close(settled[PICK_TURN], ahead, atol=1e-3, rtol=0)
        if yaw:
            torch.testing.assert_close(settled[SPAN].norm(), torch.tensor(0.15), atol=1e-3, rtol=0)
            torch.testing.assert_close(settled[DEPTH], torch.tensor([0.15]), atol=1e-3, rtol=0)


def test_a_side_that_failed_is_left_until_there_is_something_else_to_do():
    finder, known = Wayfinder(2), places((9.0, 9.0), (9.0, 9.0))
    finder.floor.evidence[:] = -4.0
    known[OBJECT] = torch.tensor([2.0, 0.0, 0.9])
    known[14:16] = torch.tensor([0.9, 0.1])
    square, compass = torch.tensor([0.45, 0.0, 0.45]), torch.tensor([1.0, 0.0])

    def faces(phase: Phase) -> list[int]:
        turn = finder.settle(0, pose(0, 0.3), known, square, STANDS, compass, phase)[PICK_TURN]
        return turn.round().int().tolist()

    assert finder.fail(0) == 0  # it stands nowhere yet
    assert faces(Phase.APPROACH) == [1, 0]
    assert finder.fail(0) == 1
    assert finder.fail(0) == 2
    assert finder.fail(1) == 0
    assert faces(Phase.ALIGN) == [1, 0]
    assert faces(Phase.APPROACH) == [0, -1]
    assert finder.fail(0) == 1
    assert faces(Phase.APPROACH) == [0, 1]
    finder.forget(0)
    assert faces(Phase.APPROACH) == [1, 0]


def test_a_copy_goes_its_own_way():
    finder = Wayfinder(1)
    finder.go_on(0, pose(0, 0), places(), Phase.APPROACH, None)
    other = finder.copy()
    other.floor.evidence[:] = 4.0
    other.go_on(0, pose(1, 1), places((0.0, 2.0)), Phase.CARRY, None)
    assert (finder.floor.evidence != 4.0).all()
    assert finder._legs[0] == Leg.TO_OBJECT
    assert not torch.equal(finder.way, other.way)


def test_who_shall_walk_away_does_so_until_it_is_there():
    finder = Wayfinder(1)
    finder.floor.evidence[:] = -4.0
    finder.walk_away(0, pose(1.0, 1.0), 1.5)
    there = finder._away_to[0]
    finder.go_on(0, pose(1.0, 1.0), places(), Phase.APPROACH, None)
    assert finder._legs[0] == Leg.TO_LOOK
    ahead = finder.way[0, WAYPOINT] - torch.tensor([1.0, 1.0])
    assert float(ahead @ (there - 1.0)) > 0
    assert finder.copy()._away_to[0] is not None
    finder.go_on(0, pose(*there.tolist()), places(), Phase.APPROACH, None)
    assert finder._legs[0] == Leg.TO_OBJECT
    finder.walk_away(0, pose(1.0, 1.0), 1.5)
    finder.forget(0)
    assert finder._away_to[0] is None
