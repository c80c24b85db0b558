"""Where the hands go at the next try, after a thing slipped out of them.

Most things are best held near their top. What is narrower there than below (a plant in a pot, a bottle, a box with a
handle) is not, and of a kind that was never seen a picture does not tell. So who could not lift it, or closed the hands
on next to nothing, holds it lower and wider the next time.
"""

from __future__ import annotations

import math

import numba
import torch
from torch import Tensor

from hv_policy.belief.places import MIDDLE, OBJECT, SPAN
from hv_policy.belief.stands import LOW_M
from hv_policy.decision.view import Phase
from hv_policy.motor.embodiment import HAND_RADIUS_M, HANDS
from hv_policy.motor.kinematics import Array, as_arrays
from hv_policy.motor.proprioception import BodyState

_ABOVE, _HEIGHT, _SPAN = MIDDLE.stop - 1, OBJECT.stop - 1, SPAN.start
LEVELS = 3
"""After so many tries it begins again from where the network believes that it should be held."""
LOWER_M, WIDER_M = 0.09, 0.05
"""How much lower, and how much farther apart, the hands are with each try."""
FAR_BELOW_TOP_M, WIDE_M = 0.12, 0.42
"""Who held what stands on the floor so far below where it might be held, near its top, tries there before it goes lower
(a stool on one leg), with the hands so far apart at least."""
BELOW_TOP_M, ABOVE_BOTTOM_M = 0.045, 0.07
"""The hands' centres are so far below a thing's top at least, and so far above its bottom."""
LYING_M = 0.11
"""At the last try the hands are this high above the floor, if it stands there: what has fallen over lies lower than it
is seen."""
NARROWEST_M = 0.18
CLOSED_M, CLOSED_SHARE = 0.22, 0.75
"""Hands whose centres are nearer than this, or than this share of the thing's width, when they squeeze hold no thing
that could be lifted, but its handle, its leaves or nothing: the narrowest things are 0.15 m wide, and a hand is 0.04 m
thick on either side."""
TOUCHING_M = 0.12
"""Hands whose centres are nearer than this have nothing between them: what is carried is wider, and pressed on nothing
they meet at 0.08 m."""
EMPTY_SHARE, HELD_SHARE = 0.8, 0.93
"""Of how far apart hands were when they began to lift: nearer than the first they have lost it, farther than the second
they have it still. (Of 10,900 steps in which they carried something 99 % were above the second.)"""


def next_try(slips: Tensor, closed: Tensor, dropped: Tensor) -> Tensor:
    """(N,) slips (N,) after this step: one more for who `closed` (N,) the hands on next to nothing or could not lift
    it. What was `dropped` (N,) on the way lies on its side now, lower and mostly wider than it stood: it is held lowest
    at once."""
    to_lowest = (LEVELS - 1 - slips % LEVELS).clamp(min=1)
    return torch.where(dropped, slips + to_lowest, slips + closed)


def closed_on_little(body: BodyState, phase: Tensor, coming: Tensor, width_m: Tensor) -> Tensor:
    """(N,) bool: who squeezes (`phase` (N,)) and would lift (`coming` (N,)) has next to nothing between the hands, of a
    thing `width_m` (N,) wide."""
    narrow = _apart_m(body.pos[:, HANDS]) < (CLOSED_SHARE * width_m).clamp(min=CLOSED_M)
    return (phase == Phase.SQUEEZE) & (coming == Phase.LIFT) & narrow


def still_held(body: BodyState, phase: Tensor, from_hands: Tensor) -> tuple[Tensor, Tensor]:
    """(N,) bool who lifts or carries (`phase` (N,)) and has lost what was between the hands, and who has it for sure.

    Args:
        body: of the robots.
        phase: of the work.
        from_hands: (N, 2, 3) hands when they began to lift, heading frame.
    """
    apart = _apart_m(body.pos[:, HANDS])
    share = apart / _apart_m(from_hands).clamp(min=1e-3)
    holds = (phase >= Phase.LIFT) & (phase <= Phase.ALIGN_PLACE)
    empty = (share < EMPTY_SHARE) | (apart < TOUCHING_M)
    return holds & empty, holds & ~empty & (share > HELD_SHARE)


def as_wide_as_felt(places: Tensor, body: BodyState, phase: Tensor) -> Tensor:
    """(N, 21) places in which the object is not wider than there is room for between the hands that press or hold it.

    How wide a thing is of a kind that was never seen is a guess; hands that press where it should end, and is not,
    press too little.
    """
    presses = (phase >= Phase.SQUEEZE) & (phase <= Phase.LOWER)
    if not bool(presses.any()):
        return places
    room_m = (_apart_m(body.pos[:, HANDS]) - 2 * HAND_RADIUS_M).clamp(min=NARROWEST_M - 2 * HAND_RADIUS_M)
    share = (room_m / (2 * places[:, SPAN].norm(dim=-1)).clamp(min=1e-3)).clamp(max=1.0)
    out = places.clone()
    out[:, SPAN] = out[:, SPAN] * torch.where(presses, share, 1.0)[:, None]
    return out


def _apart_m(hands: Tensor) -> Tensor:
    """(N,) distance of the hands (N, 2, 3)."""
    return (hands[:, 1] - hands[:, 0]).norm(dim=-1)


def regripped(places: Tensor, slips: Tensor, lies: Tensor) -> Tensor:
    """(N, 21) places in which the hands hold the object as is best after it slipped `slips` (N,) times.

    What `lies` (N,) bool on its side is often round there: every other time it is held by its middle, as hands slide
    down a round thing that they press higher up.
    """
    out = places.clone(memory_format=torch.contiguous_format)
    _regrip(out.numpy(), *as_arrays(slips, lies))
    return out


@numba.njit(cache=True)
def _regrip(places: Array, slips: Array, lies: Array) -> None:
    """Changes places (N, 21) after slips (N,) of things that lie, or stand, (N,)."""
    for i in range(len(places)):
        level = 0 if lies[i] else slips[i] % LEVELS
        above, height = places[i, _ABOVE], places[i, _HEIGHT]
        # the middle of what stands on the floor is as far from its top as from the floor
        if height < LOW_M:
            above = min(above, height - BELOW_TOP_M)
        if lies[i] and slips[i] % 2:
            above = min(above, 0.0)
        # held below its top, it reaches about so far below its middle as its top is above it
        lowest = min(above, ABOVE_BOTTOM_M - BELOW_TOP_M - above)
        x, y, z = places[i, _SPAN], places[i, _SPAN + 1], places[i, _SPAN + 2]
        width = 2 * math.sqrt(x * x + y * y + z * z)
        reached = max(width, NARROWEST_M) + WIDER_M * level
        if level == 1 and height < LOW_M and height - BELOW_TOP_M - above > FAR_BELOW_TOP_M:
            places[i, _ABOVE] = height - BELOW_TOP_M
            reached = max(reached, WIDE_M)
        else:
            places[i, _ABOVE] = max(above - LOWER_M * level, lowest)
        if level == LEVELS - 1 and height < LOW_M:
            places[i, _ABOVE] = min(places[i, _ABOVE], LYING_M - height)
        wider = reached / max(width, 1e-3)
        places[i, _SPAN], places[i, _SPAN + 1], places[i, _SPAN + 2] = wider * x, wider * y, wider * z
