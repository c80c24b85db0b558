"""Standing up before walking, step by step."""

import itertools

import torch

from hv_policy.decision.rising import RISE_S, Rising
from hv_policy.decision.view import Phase


def test_who_gives_up_stands_up_bit_by_bit_before_it_walks():
    rising = Rising(2)
    rising(torch.zeros(2, 14))
    rising.begin(torch.tensor([True, False]))
    rising.left_s[0] = 0.1
    steps = [rising(torch.ones(2, 14)).clone() for _ in range(4)]
    assert all((step[1] == 1).all() for step in steps)
    heights = [float(step[0, 5]) for step in steps]
    assert 0 < heights[0] < heights[1] < heights[2] <= heights[3] == 1.0
    assert [float(step[0, 0]) for step in steps] == [0.0, 0.0, 0.0, 1.0]


def test_who_was_walking_comes_to_a_stop():
    rising = Rising(1)
    rising(torch.full((1, 14), 0.6))
    rising.begin(torch.ones(1, dtype=torch.bool))
    speeds = [float(rising(torch.ones(1, 14))[0, 0]) for _ in range(round(30 * RISE_S) + 2)]
    assert all(later <= sooner for sooner, later in itertools.pairwise(speeds[:-2]))
    assert speeds[-3] < 0.02
    assert speeds[-1] == 1.0


def test_rising_begins_where_a_bent_phase_ends_too_soon():
    cases = [
        (Phase.REACH, Phase.ALIGN, True), (Phase.LIFT, Phase.APPROACH, True), (Phase.RELEASE, Phase.APPROACH, True),
        (Phase.REACH, Phase.SQUEEZE, False), (Phase.RELEASE, Phase.RETREAT, False),
        (Phase.ALIGN, Phase.APPROACH, False), (Phase.RETREAT, Phase.APPROACH, False),
    ]  # fmt: skip
    rising = Rising(len(cases))
    rising.begin_where_given_up(*(torch.tensor([int(c[k]) for c in cases]) for k in (0, 1)))
    assert (rising.left_s > 0).tolist() == [c[2] for c in cases]
    rising.reset(torch.tensor([0, 1]))
    assert (rising.left_s > 0).tolist()[:3] == [False, False, True]
