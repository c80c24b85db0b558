"""Other things that one might be asked to do in a recorded picture: any thing in it, and any spot, by their names.

A frame belongs to one instruction, and names one object and one goal. The room that it shows holds a dozen things and
forty spots with names (`hv_policy.belief.labels.Landmarks`), each of which could be an object's or a goal's; where they
are is known.
"""

from __future__ import annotations

import torch
from torch import Tensor

SHAPES = (
    ("put", "", "."),
    ("place", "", "."),
    ("set", "", "."),
    ("please put", "", "."),
    ("could you place", "", ", please?"),
    ("can you put", "", "for me?"),
    ("pick up", "and put it", "."),
    ("lift", "and set it", "."),
    ("go and get", ", then place it", "."),
    ("", "goes", "."),
    ("", "belongs", "."),
    ("i want", "", "."),
    ("i would like", "", ", please."),
    ("now put", "", "."),
)
"""What comes before the thing, between it and the spot, and after that."""
LARGEST_M = 0.45
"""Half extent up to which a thing is asked for rather than others."""


def choose_tasks(
    has_name: Tensor, in_view: Tensor, half_extents_m: Tensor, spot_exists: Tensor
) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    """A thing, a spot and a shape for each of B pictures, numbers (B,) each, and (B,) bool whether there are any.

    Args:
        has_name, in_view: (B, T) bool of things.
        half_extents_m: (B, T, 3) of them.
        spot_exists: (B, S) bool.
    """
    small = half_extents_m.amax(-1) < LARGEST_M
    likely = torch.rand(has_name.shape, device=has_name.device) + 0.7 * in_view + 0.5 * small
    thing = likely.masked_fill(~has_name, -1.0).argmax(1)
    drawn = torch.rand(spot_exists.shape, device=has_name.device)
    spot = drawn.masked_fill(~spot_exists, -1.0).argmax(1)
    shape = torch.randint(len(SHAPES), (len(has_name),), device=has_name.device)
    return thing, spot, shape, has_name.any(1) & spot_exists.any(1)


def sentence(thing: str, spot: str, shape: int) -> str:
    """The instruction."""
    before, between, after = SHAPES[shape]
    return " ".join(part for part in (before, thing, between, spot, after) if part)
