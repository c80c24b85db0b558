"""What was refused is not believed a second time, there alone."""

import torch

from hv_policy.belief.places import GOAL, OBJECT, PICK, PLACE, PLACES_DIM, SPAN
from hv_policy.belief.refusals import AGREE_M, AROUND_M, SURE, Refusals
from hv_policy.decision.view import Phase


def missed_once(num: int) -> Refusals:
    refusals = Refusals(num)
    assert [refusals.refuse(env, believed()) for env in range(num)] == [GOAL] * num
    return refusals


def believed(object_xy=(2.0, 1.0), goal_xy=(2.1, 1.0)) -> torch.Tensor:
    places = torch.zeros(PLACES_DIM)
    places[:2], places[3:5] = torch.tensor(object_xy), torch.tensor(goal_xy)
    return places


def test_a_thing_that_did_not_get_there_is_not_the_wrong_thing():
    refusals = Refusals(1)
    assert refusals.refuse(0, believed(goal_xy=(2.0 + AGREE_M + 0.05, 1.0))) is None
    spread = torch.ones(1, PLACES_DIM)
    assert refusals.applied(torch.tensor([0]), torch.zeros(1, 3), believed()[None], spread) is spread


def test_the_goal_is_refused_first_where_it_was_seldom_seen_then_the_thing():
    refusals = missed_once(2)
    refusals.seen[0, 1] = SURE - 0.1
    assert [refusals.refuse(0, believed()) for _ in range(3)] == [GOAL, OBJECT, GOAL]
    assert refusals.refuse(1, believed()) == OBJECT
    refusals.forget(0)
    assert [refusals.refuse(0, believed()) for _ in range(2)] == [GOAL, OBJECT]


def test_the_first_time_the_goal_is_looked_at_again_where_it_was():
    refusals, spread = missed_once(1), torch.ones(1, PLACES_DIM)
    assert refusals.applied(torch.tensor([0]), torch.zeros(1, 3), believed()[None], spread) is spread


def test_only_what_is_seen_where_it_was_refused_tells_nothing():
    refusals, ids = missed_once(3), torch.tensor([2, 0])
    refusals.refuse(2, believed())
    pose = torch.tensor([[1.0, 1.0, torch.pi / 2], [0.0, 0.0, 0.0]])  # the first one looks along +y
    seen, spread = torch.zeros(2, PLACES_DIM), torch.full((2, PLACES_DIM), 0.1)
    seen[0, :2] = torch.tensor([0.0, -1.0 + AROUND_M - 0.05])
    seen[1, :2] = torch.tensor([2.0, 1.0])
    out = refusals.applied(ids, pose, seen, spread)
    assert (out[0, OBJECT] > 100).all()
    assert (out[0, SPAN] > 100).all()
    assert (out[0, PICK] > 100).all()
    assert (out[0, GOAL] == 0.1).all()
    assert (out[0, PLACE] == 0.1).all()
    assert (out[1] == 0.1).all(), "another environment's"
    assert (spread == 0.1).all()
    seen[0, :2] = torch.tensor([0.0, -1.0 + AROUND_M + 0.05])
    assert (refusals.applied(ids, pose, seen, spread) == 0.1).all()


def test_what_counts_are_the_pictures_on_the_way_to_each():
    refusals, ids = Refusals(2), torch.tensor([1])
    for _ in range(50):
        refusals.see(ids, torch.tensor([[0.2, 0.3]]), torch.tensor([int(Phase.APPROACH)]))
    torch.testing.assert_close(refusals.seen, torch.tensor([[1.0, 1.0], [0.2, 1.0]]), atol=0.02, rtol=0)
    for _ in range(50):
        refusals.see(ids, torch.tensor([[0.9, 0.3]]), torch.tensor([int(Phase.CARRY)]))
    torch.testing.assert_close(refusals.seen, torch.tensor([[1.0, 1.0], [0.2, 0.3]]), atol=0.02, rtol=0)
