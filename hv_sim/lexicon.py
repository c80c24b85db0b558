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
    "terracotta": ("terracotta", "brick-red"), "oak": ("light oak", "pale wood"), "walnut": ("walnut", "dark wood"),
}  # fmt: skip
"""Colour name -> adjectives; where there are two, the last one is used only where the instructions are unseen."""

SIZE_WORDS: dict[str, tuple[str, ...]] = {"small": ("small", "little"), "large": ("large", "big")}
"""Which of two that are alike -> adjectives; the last one is used only where the instructions are unseen."""
SIZE_RATIO = 1.15
"""From this ratio of heights on, one of two things is the large one."""

ALIKE_COLORS: tuple[frozenset[str], ...] = tuple(
    frozenset(group.split())
    for group in (
        "brown tan walnut", "brown walnut terracotta", "tan oak beige", "beige cream white", "blue navy", "blue teal",
        "green teal", "navy black", "gray silver charcoal", "charcoal black", "silver white", "red terracotta",
        "orange terracotta", "orange red", "purple pink", "tan cream", "yellow oak",
    )
)  # fmt: skip
"""Colours that somebody may take for each other: what has one of them is not told from what has another by it."""

PLACE_WORDS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "on": (("on {}",), ("on top of {}",)),
    "on_left": (("on the left side of {}",), ("on the left-hand end of {}",)),
    "on_middle": (("on the middle of {}", "on the middle part of {}"), ("on the centre of {}",)),
    "on_right": (("on the right side of {}",), ("on the right-hand end of {}",)),
    "left_of": (
        ("just to the left of {}", "directly to the left of {}"),
        ("immediately to the left of {}", "a few inches to the left of {}"),
    ),
    "right_of": (
        ("just to the right of {}", "directly to the right of {}"),
        ("immediately to the right of {}", "a few inches to the right of {}"),
    ),
    "in_front_of": (
        ("just in front of {}", "directly in front of {}"),
        ("immediately in front of {}", "a few inches in front of {}"),
    ),
    "front_middle": (
        ("just in front of the middle of {}", "directly in front of the middle of {}"),
        ("immediately in front of the centre of {}",),
    ),
    "behind": (("just behind {}", "directly behind {}"), ("immediately behind {}", "a few inches behind {}")),
    "back_middle": (
        ("just behind the middle of {}", "directly behind the middle of {}"),
        ("immediately behind the centre of {}",),
    ),
    "floor": (("on the floor",), ("down on the ground",)),
    "room_middle": (
        ("exactly in the middle of the room", "in the very middle of the room"),
        ("in the exact centre of the room",),
    ),
    "your_left": (("on your left",), ("to your left",)),
    "your_right": (("on your right",), ("to your right",)),
}
"""Relation -> how a place is called among the seen and among the unseen tasks; `{}` is the landmark.

All of them leave no more open than `hv_sim.places.Layout.spot_m` allows: "just" and "directly" mean close by.
"""

MOTION_WORDS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "on": (("onto {}",), ("to the top of {}",)),
    "on_left": (("onto the left side of {}",), ("onto the left-hand end of {}",)),
    "on_middle": (("onto the middle of {}",), ("onto the centre of {}",)),
    "on_right": (("onto the right side of {}",), ("onto the right-hand end of {}",)),
    "left_of": (("to the spot just to the left of {}",), ("to a spot immediately to the left of {}",)),
    "right_of": (("to the spot just to the right of {}",), ("to a spot immediately to the right of {}",)),
    "in_front_of": (("to the spot just in front of {}",), ("to a spot immediately in front of {}",)),
    "front_middle": (
        ("to the spot just in front of the middle of {}",),
        ("to a spot immediately in front of the centre of {}",),
    ),
    "behind": (("to the spot just behind {}",), ("to a spot immediately behind {}",)),
    "back_middle": (
        ("to the spot just behind the middle of {}",),
        ("to a spot immediately behind the centre of {}",),
    ),
    "room_middle": (("to the very middle of the room",), ("to the exact centre of the room",)),
}
"""The same after verbs of motion."""

EVERYDAY_WORDS: dict[str, tuple[str, ...]] = {
    "left_of": ("to the left of {}", "on the left of {}", "left of {}"),
    "right_of": ("to the right of {}", "on the right of {}", "right of {}"),
    "in_front_of": ("in front of {}",),
    "behind": ("behind {}", "at the back of {}"),
    "on_left": ("onto the left of {}", "on the left end of {}"),
    "on_right": ("onto the right of {}", "on the right end of {}"),
    "on_middle": ("in the middle of {}", "in the centre of {}", "in the center of {}"),
    "floor": ("on the ground", "onto the floor", "to the floor"),
    "room_middle": (
        *("in the middle of the room", "to the middle of the room", "in the centre of the room"),
        *("to the centre of the room", "in the center of the room", "to the center of the room"),
    ),
}
"""What people say too, and is understood; tasks are not written with it, it leaves more open than they may."""

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


def alike_in_color(a: str, b: str) -> bool:
    """Whether two colours may be taken for each other."""
    return a == b or any(a in group and b in group for group in ALIKE_COLORS)


def color_fits(word: str, color: str) -> bool:
    """Whether an adjective may be said of a thing of that colour: "brown" of what is light brown, too."""
    return any(word in words and alike_in_color(c, color) for c, words in COLOR_WORDS.items())


def size_word(look: Look, others: Iterable[Look]) -> str:
    """ "small" or "large" where an object is the one or the other of all that it might be taken for, else ""."""
    height = [other[2][2] for other in others]
    if height and look[2][2] > SIZE_RATIO * max(height):
        return "large"
    if height and look[2][2] * SIZE_RATIO < min(height):
        return "small"
    return ""
