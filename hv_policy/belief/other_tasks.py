"""Other things that one might be asked to do in a recorded picture: any thing in it, and any spot, by their names.

A frame belongs to one instruction, and names one object and one goal. The room that it shows holds a dozen things and
forty spots with names (`hv_policy.belief.labels.Landmarks`), each of which could be an object's or a goal's; where they
are is known.
"""

from __future__ import annotations

import itertools
import re

import torch
from torch import Tensor

SHAPES = ("put {thing} {spot}.",)
FROM_SHAPES = ("take {thing} that is {other} and put it {spot}.",)
"""The shapes of `hv_policy.rewording`: a thing and a spot; and another spot, where the thing is or may be said to be,
beside the one that is the goal."""
FROM_SHARE = 0.2
ALL_SHAPES = SHAPES + FROM_SHAPES
SLOTS = ("thing", "spot", "other")
LARGEST_M = 0.45
"""Half extent up to which a thing is asked for rather than others."""


def choose_tasks(
    has_name: Tensor, in_view: Tensor, half_extents_m: Tensor, spot_exists: Tensor
) -> tuple[Tensor, Tensor, Tensor, Tensor, Tensor]:
    """A thing, a spot, another spot and a shape for each of B pictures, numbers (B,) each, and (B,) bool whether there
    is a thing and a spot. Where there is one spot only, no shape names another.

    Args:
        has_name, in_view: (B, T) bool of things.
        half_extents_m: (B, T, 3) of them.
        spot_exists: (B, S) bool.
    """
    small = half_extents_m.amax(-1) < LARGEST_M
    likely = torch.rand(has_name.shape, device=has_name.device) + 0.7 * in_view + 0.5 * small
    thing = likely.masked_fill(~has_name, -1.0).argmax(1)
    drawn = torch.rand(spot_exists.shape, device=has_name.device).masked_fill(~spot_exists, -1.0)
    spot = drawn.argmax(1)
    other = drawn.scatter(1, spot[:, None], -2.0).argmax(1)
    from_another = (torch.rand(len(has_name), device=has_name.device) < FROM_SHARE) & (spot_exists.sum(1) > 1)
    shape = from_another.long()
    return thing, spot, other, shape, has_name.any(1) & spot_exists.any(1)


def parts_of(shape: str) -> tuple[list[str], list[str]]:
    """What stands before, between and after the slots of a shape, and the slots in their order."""
    pieces = re.split(r"{(\w+)}", shape)
    return [text.strip() for text in pieces[::2]], pieces[1::2]


def sentence(shape: int, **filling: str) -> str:
    """The instruction; what fills the slots that the shape has, by their names (`SLOTS`)."""
    texts, slots = parts_of(ALL_SHAPES[shape])
    between = [filling[slot] for slot in slots]
    return " ".join(part for pair in itertools.zip_longest(texts, between, fillvalue="") for part in pair if part)
