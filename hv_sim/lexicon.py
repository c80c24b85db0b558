"""The words of the instructions: for things, colours, sizes and places; some are kept for the unseen tasks."""

from __future__ import annotations

from collections.abc import Iterable

from hv_sim.furniture import FURNITURE_KINDS
from hv_sim.objects import OBJECT_KINDS
from hv_sim.places import Layout

COLOR_WORDS: dict[str, tuple[str, ...]] = {
    "red": ("red",), "orange": ("orange",), "yellow": ("yellow",), "green": ("green",), "teal": ("teal",),
    "blue": ("blue",), "navy": ("dark blue", "navy"), "purple": ("purple", "violet"), "pink": ("pink",),
    "brown": ("brown",), "tan": ("light brown", "tan"), "beige": ("beige", "sand-coloured"),
    "cream": ("cream", "cream-coloured"), "white": ("white",), "silver": ("silver", "silvery"),
    "gray": ("gray", "grey"), "charcoal": ("dark gray", "charcoal"), "black": ("black",),
    "terracotta": ("terracotta", "brick-red"), "oak": ("light oak", "pale"), "walnut": ("walnut", "dark wood"),
}  # fmt: skip
"""Colour name -> adjectives; where there are two, the last one is used only where the instructions are unseen."""

SIZE_WORDS: dict[str, tuple[str, ...]] = {"small": ("small", "little"), "large": ("large", "big")}
"""Which of two that are alike -> adjectives; the last one is used only where the instructions are unseen."""
SIZE_RATIO = 1.15
"""From this ratio of heights on, one of two things is the large one."""

PLACE_WORDS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "on": (("on {}",), ("on top of {}",)),
    "on_left": (("on the left side of {}",), ("at the left-hand end of {}",)),
    "on_middle": (("in the middle of {}",), ("at the centre of {}",)),
    "on_right": (("on the right side of {}",), ("at the right-hand end of {}",)),
    "left_of": (("to the left of {}",), ("just left of {}", "immediately left of {}")),
    "right_of": (("to the right of {}",), ("just right of {}", "immediately right of {}")),
    "in_front_of": (("in front of {}",), ("before {}",)),
    "behind": (("behind {}",), ("at the back of {}",)),
    "floor": (("on the floor",), ("on the ground",)),
    "room_middle": (("in the middle of the room",), ("at the centre of the room",)),
    "your_left": (("on your left",), ("at your left hand",)),
    "your_right": (("on your right",), ("at your right hand",)),
}
"""Relation -> how a place is called among the seen and among the unseen tasks; `{}` is the landmark."""

MOTION_WORDS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "on": (("onto {}", "over to {}", "to {}"), ("across to {}",)),
    "on_left": (("onto the left side of {}", "to the left side of {}"), ("to the left-hand end of {}",)),
    "on_middle": (("to the middle of {}", "onto the middle of {}"), ("to the centre of {}",)),
    "on_right": (("onto the right side of {}", "to the right side of {}"), ("to the right-hand end of {}",)),
    "left_of": (("to the left of {}",), ("to the spot just left of {}",)),
    "right_of": (("to the right of {}",), ("to the spot just right of {}",)),
    "in_front_of": (("to the front of {}", "to the space in front of {}"), ("to the spot before {}",)),
    "behind": (("to the space behind {}",), ("to the back of {}",)),
    "room_middle": (("to the middle of the room",), ("to the centre of the room",)),
}
"""The same after verbs of motion."""

Look = tuple[str, str, tuple[float, float, float]]


def looks(layout: Layout) -> dict[str, Look]:
    """Name -> kind, colour and size of every object of a scene."""
    found = {}
    for o in layout.task.objects:
        kind = OBJECT_KINDS[o.kind]
        found[o.name] = (o.kind, o.color or kind.color, o.size_m or kind.size_m)
    return found


def object_nouns(kind: str) -> tuple[str, ...]:
    """All words for a kind of object."""
    spec = OBJECT_KINDS[kind]
    return (spec.noun, *spec.other_nouns)


def furniture_nouns(kind: str) -> tuple[str, ...]:
    """All words for a kind of furniture."""
    spec = FURNITURE_KINDS[kind]
    return (spec.noun, *spec.other_nouns)


def usable(words: tuple[str, ...], unseen: bool) -> tuple[str, ...]:
    """Those of a word's variants that seen instructions use, or those that unseen ones should use."""
    if len(words) == 1:
        return words
    return words[-1:] if unseen else words[:-1]


def means(noun: str, nouns: Iterable[str]) -> bool:
    """Whether a thing with these nouns may be meant by `noun`: "cabinet" may mean a record cabinet."""
    return any(f" {n}".lower().endswith(f" {noun}".lower()) for n in nouns)


def called(layout: Layout, noun: str) -> tuple[list[str], list[str]]:
    """Names of the objects, and of the furniture, that a noun may mean in a scene."""
    objects = [o.name for o in layout.task.objects if means(noun, object_nouns(o.kind))]
    pieces = [f.name for f in layout.task.furniture if means(noun, furniture_nouns(f.kind))]
    return objects, pieces


def size_word(look: Look, others: Iterable[Look]) -> str:
    """ "small" or "large" where an object is the one or the other of all that it might be taken for, else ""."""
    height = [other[2][2] for other in others]
    if height and look[2][2] > SIZE_RATIO * max(height):
        return "large"
    if height and look[2][2] * SIZE_RATIO < min(height):
        return "small"
    return ""
