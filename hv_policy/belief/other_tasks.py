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

SHAPES = (
    "put {thing} {spot}.",
    "place {thing} {spot}.",
    "set {thing} {spot}.",
    "please put {thing} {spot}.",
    "could you place {thing} {spot}, please?",
    "can you put {thing} {spot} for me?",
    "pick up {thing} and put it {spot}.",
    "lift {thing} and set it {spot}.",
    "go and get {thing}, then place it {spot}.",
    "{thing} goes {spot}.",
    "{thing} belongs {spot}.",
    "i want {thing} {spot}.",
    "i would like {thing} {spot}, please.",
    "now put {thing} {spot}.",
    "get {thing} and stand it {spot}.",
    "would you put {thing} {spot}?",
    "hey, could you carry {thing} over and put it {spot}?",
    "your job is to put {thing} {spot}.",
    "the task: get {thing} to stand {spot}.",
    "i'd love to see {thing} {spot}.",
    "i'd like you to pick up {thing} and to place it {spot}, thank you.",
    "we want {thing} {spot} now.",
    "try to get {thing} {spot}.",
    "go ahead and put {thing} {spot}.",
    "walk to {thing}, pick it up and put it {spot}.",
    "find {thing} and take it with you; it goes {spot}.",
    "look for {thing}; it has to stand {spot}.",
    "see {thing}? i want that {spot}.",
    "{thing} should stand {spot}.",
    "{thing} has to go {spot}.",
    "{thing} must be put {spot}.",
    "{thing} ought to be {spot}.",
    "{thing} can be placed {spot}.",
    "{thing} is to be brought {spot}, please.",
    "{thing} would look good {spot}.",
    "{thing} is not where it belongs, put it {spot}.",
    "{thing} comes first; please place it {spot}.",
    "{thing} still has to be carried {spot}.",
    "what about putting {thing} {spot}?",
    "i am looking for {thing}. put it {spot} when you have it.",
    "somebody put {thing} here; carry it back, it stands {spot}.",
    "tidy up {thing} and put it {spot}.",
    "it is time that {thing} was {spot}.",
    "be so kind as to place {thing} {spot}.",
    "i need {thing} {spot}.",
    "have {thing} placed {spot}.",
    "bring me {thing}; put it down {spot}.",
    "move on to {thing}: it goes {spot}.",
    "ok, take {thing} with both hands and set it {spot}.",
    "when you are done, put {thing} {spot}.",
    "{spot} i want {thing}.",
    "{spot} there is room for {thing}.",
    "{spot} please put {thing}.",
    "{spot} is the place of {thing}.",
    "{spot} is where {thing} belongs.",
    "i would like to have {spot} {thing}.",
    "what should be {spot} is {thing}; bring it there.",
    "somewhere {spot} i would put {thing}.",
    "{spot} would be a good place for {thing}.",
    "walk up {spot} with {thing} in your hands and put it down.",
    "{spot} you can put {thing}.",
)
"""A thing and a spot in a sentence; in some the spot comes first."""
FROM_SHAPES = (
    "take {thing} from where it is, {other}, and put it {spot}.",
    "{thing} is {other} now; it has to stand {spot}.",
    "you see {thing} {other}; i want it {spot}.",
    "{thing} must not stay {other}, put it {spot}.",
    "not {other} but {spot} is the place of {thing}.",
    "put {thing} {spot}, not {other}.",
    "pick up {thing} that is {other} and place it {spot}.",
    "somebody has put {thing} {other}, but it belongs {spot}.",
    "what stands {other} is {thing}; it goes {spot}.",
    "{spot}, please, not {other}: there i want {thing}.",
    "it was {other} that {thing} stood, now it stands {spot}.",
    "walk to {thing} {other} and carry it until it is {spot}.",
)
"""The same, and another spot beside it where the thing is, or does not go: which is the goal, the words decide. None of
all these is a shape of the tasks that are kept as unseen."""
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
    kinds = torch.where(spot_exists.sum(1) > 1, len(ALL_SHAPES), len(SHAPES))
    shape = (torch.rand(len(has_name), device=has_name.device) * kinds).long()
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
