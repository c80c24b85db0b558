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
from hv_policy.motor.embodiment import HANDS
from hv_policy.motor.kinematics import Array, as_arrays
from hv_policy.motor.proprioception import BodyState

_ABOVE, _HEIGHT, _SPAN = MIDDLE.stop - 1, OBJECT.stop - 1, SPAN.start
LEVELS = 3
"""After so many tries it begins again from where the network believes that it should be held."""
LOWER_M, WIDER_M = 0.09, 0.05
"""How much lower, and how much farther apart, the hands are with each try."""
BELOW_TOP_M, ABOVE_BOTTOM_M = 0.045, 0.07
"""The hands' centres are so far below a thing's top at least, and so far above its bottom."""
NARROWEST_M = 0.18
CLOSED_M = 0.22
"""Hands whose centres are nearer than this when they squeeze hold no thing that could be lifted, but its handle, its
leaves or nothing: the narrowest things are 0.15 m wide, and a hand is 0.04 m thick on either side."""


def closed_on_little(body: BodyState, phase: Tensor, coming: Tensor) -> Tensor:
    """(N,) bool: who squeezes (`phase` (N,)) and would lift (`coming` (N,)) has next to nothing between the hands."""
    right, left = body.pos[:, HANDS].unbind(1)
    apart = (left - right).norm(dim=-1)
    return (phase == Phase.SQUEEZE) & (coming == Phase.LIFT) & (apart < CLOSED_M)


def regripped(places: Tensor, slips: Tensor) -> Tensor:
    """(N, 21) places in which the hands hold the object as is best after it slipped `slips` (N,) times."""
    out = places.clone(memory_format=torch.contiguous_format)
    _regrip(out.numpy(), *as_arrays(slips))
    return out


@numba.njit(cache=True)
def _regrip(places: Array, slips: Array) -> None:
    """Changes places (N, 21) after slips (N,)."""
    for i in range(len(places)):
        level = slips[i] % LEVELS
        above, height = places[i, _ABOVE], places[i, _HEIGHT]
        # the middle of what stands on the floor is as far from its top as from the floor
        if height < LOW_M:
            above = min(above, height - BELOW_TOP_M)
        # held below its top, it reaches about so far below its middle as its top is above it
        lowest = min(above, ABOVE_BOTTOM_M - BELOW_TOP_M - above)
        places[i, _ABOVE] = max(above - LOWER_M * level, lowest)
        x, y, z = places[i, _SPAN], places[i, _SPAN + 1], places[i, _SPAN + 2]
        width = 2 * math.sqrt(x * x + y * y + z * z)
        wider = (max(width, NARROWEST_M) + WIDER_M * level) / max(width, 1e-3)
        places[i, _SPAN], places[i, _SPAN + 1], places[i, _SPAN + 2] = wider * x, wider * y, wider * z
