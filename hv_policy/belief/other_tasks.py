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
    ("get", "and stand it", "."),
    ("would you put", "", "?"),
    ("hey, could you carry", "over and put it", "?"),
    ("your job is to put", "", "."),
    ("the task: get", "to stand", "."),
    ("i'd love to see", "", "."),
    ("i'd like you to pick up", "and to place it", ", thank you."),
    ("we want", "", "now."),
    ("try to get", "", "."),
    ("go ahead and put", "", "."),
    ("walk to", ", pick it up and put it", "."),
    ("find", "and take it with you; it goes", "."),
    ("look for", "; it has to stand", "."),
    ("see", "? i want that", "."),
    ("", "should stand", "."),
    ("", "has to go", "."),
    ("", "must be put", "."),
    ("", "ought to be", "."),
    ("", "can be placed", "."),
    ("", "is to be brought", ", please."),
    ("", "would look good", "."),
    ("", "is not where it belongs, put it", "."),
    ("", "comes first; please place it", "."),
    ("", "still has to be carried", "."),
    ("what about putting", "", "?"),
    ("i am looking for", ". put it", "when you have it."),
    ("somebody put", "here; carry it back, it stands", "."),
    ("tidy up", "and put it", "."),
    ("it is time that", "was", "."),
    ("be so kind as to place", "", "."),
    ("i need", "", "."),
    ("have", "placed", "."),
    ("bring me", "; put it down", "."),
    ("move on to", ": it goes", "."),
    ("ok, take", "with both hands and set it", "."),
    ("when you are done, put", "", "."),
)
"""What comes before the thing, between it and the spot, and after that."""
SPOT_FIRST_SHAPES = (
    ("", "i want", "."),
    ("", "there is room for", "."),
    ("", "please put", "."),
    ("", "is the place of", "."),
    ("", "is where", "belongs."),
    ("i would like to have", "", "."),
    ("what should be", "is", "; bring it there."),
    ("somewhere", "i would put", "."),
    ("", "would be a good place for", "."),
    ("walk up", "with", "in your hands and put it down."),
    ("", "you can put", "."),
)
"""The same, but the spot comes first. None of all these is a shape of the tasks that are kept as unseen."""
ALL_SHAPES = SHAPES + SPOT_FIRST_SHAPES
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
    shape = torch.randint(len(ALL_SHAPES), (len(has_name),), device=has_name.device)
    return thing, spot, shape, has_name.any(1) & spot_exists.any(1)


def sentence(thing: str, spot: str, shape: int) -> str:
    """The instruction."""
    before, between, after = ALL_SHAPES[shape]
    first, second = (thing, spot) if shape < len(SHAPES) else (spot, thing)
    return " ".join(part for part in (before, first, between, second, after) if part)
