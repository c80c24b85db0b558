"""What is believed goes where most pictures say, and a picture that says otherwise does not count."""

from types import SimpleNamespace

import pytest
import torch

from hv_policy.belief.belief import UNKNOWN, Belief
from hv_policy.belief.landmark_head import GAP_M, Piece
from hv_policy.belief.perception import Measurement, Sight
from hv_policy.belief.places import GOAL, OBJECT, PLACES_DIM
from hv_policy.belief.refusals import IGNORED_M
from hv_policy.belief.whereabouts import ELSEWHERE_M, SURE, Looked, Whereabouts

HALF_M = torch.tensor([0.3, 0.6, 0.4])


def network(seen: float) -> SimpleNamespace:
    """Finds every piece of furniture at (2, 1), its front toward -y."""

    def find_pieces(sight: Sight, named: torch.Tensor) -> Piece:
        n = len(named)
        logit = torch.logit(torch.full((n, 1), seen))
        front = torch.tensor([0.0, -1.0]).expand(n, 1, 2)
        return Piece(torch.tensor([2.0, 1.0]).expand(n, 1, 2), HALF_M.expand(n, 1, 3), front, -3 + 0 * logit, logit)

    perception = SimpleNamespace(
        find_pieces=find_pieces, text=lambda texts: (torch.zeros(1, 1, 4), None), named=lambda words, _: words[0]
    )
    goals = {"beside": ("left_of", "sofa"), "floor": ("floor", "")}
    return SimpleNamespace(perception=perception, reworder=SimpleNamespace(goal=goals.__getitem__))


def look(at: dict[slice, tuple[float, float]], p: float, deviation: float = 0.2) -> Looked:
    """One picture in which things seem to be `at` places."""
    places, spread = torch.zeros(1, PLACES_DIM), torch.full((1, PLACES_DIM), deviation)
    for place, xy in at.items():
        places[0, place][:2] = torch.tensor(xy)
    pointing = torch.full((1, 4, 5), 1 - p).log()
    empty = torch.zeros(1, 0)
    seen = Measurement(places, spread, pointing, empty, empty, empty)
    sight = Sight(*(torch.zeros(1, 1, 1) for _ in range(4)))
    return Looked(sight, seen, torch.zeros(1), places, spread, torch.zeros(1, 2))


def see(
    whereabouts: Whereabouts, belief: Belief, looked: Looked, instruction: str = "floor", piece_seen: float = 0.99
) -> Looked:
    counts = torch.ones(1, 2, dtype=torch.bool)
    whereabouts.see(network(piece_seen), belief, torch.tensor([0]), [instruction], counts, torch.ones(1, 2), looked)
    return looked


@pytest.mark.parametrize("place", [OBJECT, GOAL])
def test_a_belief_that_is_wrong_goes_where_pictures_say(place):
    whereabouts, belief = Whereabouts(1), Belief(1)
    belief.places[0, place][:2] = torch.tensor([-2.0, 1.0])
    belief.variance[0, 0 if place == OBJECT else 2] = 0.01
    for _ in range(10):
        looked = see(whereabouts, belief, look({place: (2.0, 0.5)}, 0.98))
    torch.testing.assert_close(belief.places[0, place][:2], torch.tensor([2.0, 0.5]), atol=0.2, rtol=0)
    assert belief.deviation_m(0, place) > 0.3
    assert float(looked.spread.max()) < 1.0
    assert float(looked.elsewhere_m[0, int(place == GOAL)]) == 0.0
    assert whereabouts.mean[0, int(place == GOAL)] > 0.8


def test_a_picture_that_says_otherwise_does_not_count():
    whereabouts, belief = Whereabouts(1), Belief(1)
    for _ in range(10):
        see(whereabouts, belief, look({OBJECT: (2.0, 0.5), GOAL: (1.0, 0.0)}, 0.98))
    before = belief.places.clone()
    looked = see(whereabouts, belief, look({OBJECT: (2.0, -1.5), GOAL: (1.0, 0.1)}, 0.6))
    assert torch.equal(belief.places, before)
    assert looked.spread[0, OBJECT].tolist() == [IGNORED_M] * 3
    assert looked.spread[0, GOAL].tolist() == pytest.approx([0.2] * 3)


def test_what_is_half_likely_may_be_elsewhere():
    whereabouts, belief = Whereabouts(1), Belief(1)
    for _ in range(30):
        looked = see(whereabouts, belief, look({OBJECT: (2.0, 0.5)}, 0.5))
    share = whereabouts.maps[0].likeliest(0).share
    assert share < SURE
    assert float(looked.elsewhere_m[0, 0]) == pytest.approx(ELSEWHERE_M * (1 - share))


def test_a_goal_beside_a_piece_is_where_the_piece_says():
    whereabouts, belief = Whereabouts(1), Belief(1)
    for _ in range(10):
        looked = see(whereabouts, belief, look({GOAL: (-1.0, -1.0)}, 0.1), "beside")
    left = 2.0 - HALF_M[1] - 0.1 - GAP_M  # who looks at the front has the left at -x
    torch.testing.assert_close(looked.places[0, GOAL][:2], torch.tensor([float(left), 1.0]), atol=0.05, rtol=0)
    assert float(looked.seen.pointing[0, 1, 0].exp()) < 0.02, "it is in the picture"
    before = whereabouts.maps[1].likeliest(0).mean
    for _ in range(20):
        see(whereabouts, belief, look({GOAL: (-1.0, -1.0)}, 0.1), "beside", 0.05)
    assert whereabouts.maps[1].likeliest(0).mean < 0.5 * before, "it turned out not to be there"


def test_what_is_forgotten_rejected_and_copied():
    whereabouts, belief = Whereabouts(1), Belief(1)
    for _ in range(10):
        see(whereabouts, belief, look({OBJECT: (2.0, 0.5), GOAL: (1.0, 0.0)}, 0.98))
    copied = whereabouts.copy()
    whereabouts.forget(0, OBJECT)
    assert float(whereabouts.mean[0, 0]) == 0.0
    assert float(whereabouts.mean[0, 1]) > 0.7
    assert float(copied.maps[0].said.sum()) > 0
    copied.reject(0, OBJECT, torch.tensor([2.0, 0.5]))
    assert copied.maps[0].likeliest(0).mean < 0.3
    whereabouts.begin_at(0, OBJECT, torch.tensor([0.5, 0.5]), 0.3)
    torch.testing.assert_close(whereabouts.maps[0].likeliest(0).xy, torch.tensor([0.5, 0.5]), atol=0.05, rtol=0)


def test_nothing_is_believed_of_what_was_never_seen():
    belief = Belief(1)
    see(Whereabouts(1), belief, look({OBJECT: (2.0, 0.5)}, 0.02))
    assert bool((belief.variance == UNKNOWN).all())
