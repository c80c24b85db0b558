"""Lower and wider with each try, and never beyond what the thing can be."""

import pytest
import torch

from hv_policy.belief.places import MIDDLE, OBJECT, SPAN
from hv_policy.belief.regrip import (
    ABOVE_BOTTOM_M,
    BELOW_TOP_M,
    CLOSED_M,
    EMPTY_SHARE,
    HELD_SHARE,
    LEVELS,
    LOWER_M,
    LYING_M,
    NARROWEST_M,
    TOUCHING_M,
    WIDE_M,
    WIDER_M,
    as_wide_as_felt,
    closed_on_little,
    next_try,
    regripped,
    still_held,
)
from hv_policy.decision.view import Phase
from hv_policy.motor.embodiment import HAND_RADIUS_M, HANDS
from hv_policy.motor.proprioception import BodyState


def thing(height_m: float, grip_m: float, width_m: float, num: int = 1) -> torch.Tensor:
    places = torch.zeros(num, 21)
    places[:, OBJECT] = torch.tensor([0.5, 0.0, height_m])
    places[:, SPAN] = width_m / 2 * torch.tensor([0.6, 0.8, 0.0])
    places[:, MIDDLE.stop - 1] = grip_m
    return places


def standing(places: torch.Tensor, slips: torch.Tensor) -> torch.Tensor:
    return regripped(places, slips, torch.zeros(len(places), dtype=torch.bool))


def grip(places: torch.Tensor) -> torch.Tensor:
    return places[:, MIDDLE][:, 2]


def test_who_dropped_nothing_holds_it_as_it_is_believed():
    places = thing(0.9, 0.1, 0.3)
    assert torch.equal(standing(places, torch.zeros(1, dtype=torch.long)), places)


def test_each_try_is_lower_and_wider_then_it_begins_again():
    places, tries = thing(0.9, 0.15, 0.3, LEVELS + 1), torch.arange(LEVELS + 1)
    out = standing(places, tries)
    level = tries % LEVELS
    lowest = ABOVE_BOTTOM_M - BELOW_TOP_M - 0.15
    torch.testing.assert_close(grip(out), (0.15 - LOWER_M * level).clamp(min=lowest))
    torch.testing.assert_close(2 * out[:, SPAN].norm(dim=-1), 0.3 + WIDER_M * level)
    # the direction between the hands, and all else, stay
    torch.testing.assert_close(out[:, SPAN] / out[:, SPAN].norm(dim=-1, keepdim=True), places[:, SPAN] / 0.15)
    torch.testing.assert_close(out[:, OBJECT], places[:, OBJECT])
    assert torch.equal(out[0], out[LEVELS])


@pytest.mark.parametrize("slips", [0, 1, 2])
def test_hands_stay_on_what_stands_on_the_floor(slips):
    # 0.3 m high: its middle is at 0.15 m
    out = standing(thing(0.15, 0.25, 0.3), torch.tensor([slips]))
    assert grip(out).item() <= 0.15 - BELOW_TOP_M + 1e-6
    assert grip(out).item() >= ABOVE_BOTTOM_M - 0.15 - 1e-6


def test_a_flat_thing_is_not_held_below_its_middle_by_more_than_it_has():
    low = grip(standing(thing(0.9, 0.02, 0.3), torch.tensor([2]))).item()
    assert low == pytest.approx(ABOVE_BOTTOM_M - BELOW_TOP_M - 0.02)


def test_nothing_is_narrower_than_what_can_be_lifted():
    out = standing(thing(0.9, 0.1, 0.05), torch.tensor([0]))
    assert 2 * out[0, SPAN].norm().item() == pytest.approx(NARROWEST_M)


def test_who_would_lift_with_closed_hands_has_nothing_in_them():
    pos = torch.zeros(4, 15, 3)
    pos[:, HANDS[0], 1], pos[:, HANDS[1], 1] = -0.05, torch.tensor([0.05, 0.05, 0.05, CLOSED_M])
    body = BodyState(pos, torch.eye(3).expand(4, 15, 3, 3), torch.zeros(4, 15, 3), torch.zeros(4, 15, 3))
    now = torch.tensor([Phase.SQUEEZE, Phase.SQUEEZE, Phase.LIFT, Phase.SQUEEZE]).long()
    coming = torch.tensor([Phase.LIFT, Phase.SQUEEZE, Phase.LIFT, Phase.LIFT]).long()
    assert closed_on_little(body, now, coming, torch.full((4,), 0.2)).tolist() == [True, False, False, False]
    wide = torch.full((4,), 0.5)
    assert closed_on_little(body, now, coming, wide).tolist() == [True, False, False, True], "not around that"


def test_whose_hands_come_together_while_they_carry_has_lost_it():
    share = torch.tensor([EMPTY_SHARE - 0.05, EMPTY_SHARE + 0.02, HELD_SHARE + 0.02])
    pos, began = torch.zeros(3, 15, 3), torch.zeros(3, 2, 3)
    began[:, 1, 1] = 0.4
    pos[:, HANDS[1], 1] = 0.4 * share
    body = BodyState(pos, torch.eye(3).expand(3, 15, 3, 3), torch.zeros(3, 15, 3), torch.zeros(3, 15, 3))
    holds = (Phase.LIFT, Phase.CARRY, Phase.ALIGN_PLACE)
    for phase in Phase:
        empty, held = still_held(body, torch.full((3,), int(phase)), began)
        expected = ([True, False, False], [False, False, True]) if phase in holds else ([False] * 3, [False] * 3)
        assert (empty.tolist(), held.tolist()) == expected


def test_hands_that_meet_hold_nothing_however_near_they_were_when_they_began_to_lift():
    pos, began = torch.zeros(1, 15, 3), torch.zeros(1, 2, 3)
    pos[:, HANDS[1], 1] = began[:, 1, 1] = 2 * HAND_RADIUS_M
    body = BodyState(pos, torch.eye(3).expand(1, 15, 3, 3), torch.zeros(1, 15, 3), torch.zeros(1, 15, 3))
    empty, held = still_held(body, torch.full((1,), int(Phase.CARRY)), began)
    assert (empty.item(), held.item()) == (True, False)
    assert 2 * HAND_RADIUS_M < TOUCHING_M < CLOSED_M


def test_what_was_dropped_is_held_lowest_at_once():
    slips, never = torch.tensor([0, 1, 2, 3]), torch.zeros(4, dtype=torch.bool)
    assert next_try(slips, never, never).tolist() == slips.tolist()
    assert next_try(slips, ~never, never).tolist() == [1, 2, 3, 4]
    assert next_try(slips, never, ~never).tolist() == [2, 2, 3, 5]


def test_what_may_have_fallen_over_is_held_near_the_floor_but_on_a_table_it_is_not():
    out = standing(torch.cat([thing(0.35, 0.15, 0.3), thing(0.9, 0.15, 0.3)]), torch.full((2,), LEVELS - 1))
    assert 0.35 + grip(out)[0].item() == pytest.approx(LYING_M)
    assert 0.9 + grip(out)[1].item() > 0.75


def test_what_lies_is_held_by_its_middle_every_other_time():
    slips, lies = torch.arange(6), torch.ones(6, dtype=torch.bool)
    out = regripped(thing(0.13, 0.08, 0.3, 6), slips, lies)
    torch.testing.assert_close(grip(out), torch.tensor([0.08, 0.0] * 3))
    torch.testing.assert_close(2 * out[:, SPAN].norm(dim=-1), torch.full((6,), 0.3))


def test_a_stool_on_one_leg_is_held_at_its_top_before_it_is_held_lower():
    out = standing(thing(0.35, 0.1, 0.2, 3), torch.arange(3))
    assert 0.35 + grip(out)[1].item() == pytest.approx(0.7 - BELOW_TOP_M)
    assert 2 * out[1, SPAN].norm().item() == pytest.approx(WIDE_M)
    assert grip(out)[2].item() < grip(out)[0].item()
    near_the_top = standing(thing(0.15, 0.09, 0.2, 2), torch.arange(2))
    assert grip(near_the_top)[1].item() < grip(near_the_top)[0].item()


def test_hands_that_press_feel_how_wide_a_thing_is_at_most():
    width, apart = 0.3, torch.tensor([0.24, 0.24, 0.24, 0.5, 0.05])
    places = thing(0.3, 0.1, width, 5)
    pos = torch.zeros(5, 15, 3)
    pos[:, HANDS[1], 1] = apart
    body = BodyState(pos, torch.eye(3).expand(5, 15, 3, 3), torch.zeros(5, 15, 3), torch.zeros(5, 15, 3))
    phases = torch.tensor([Phase.SQUEEZE, Phase.CARRY, Phase.REACH, Phase.LIFT, Phase.LOWER]).long()
    out = as_wide_as_felt(places, body, phases)
    room, narrowest = 0.24 - 2 * HAND_RADIUS_M, NARROWEST_M - 2 * HAND_RADIUS_M
    torch.testing.assert_close(
        2 * out[:, SPAN].norm(dim=-1), torch.tensor([room, room, width, width, narrowest])
    )
    others = [i for i in range(21) if not SPAN.start <= i < SPAN.stop]
    assert torch.equal(out[:, others], places[:, others])
    assert torch.equal(as_wide_as_felt(places, body, torch.full((5,), int(Phase.REACH))), places)
