"""What a kind of movable object is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from hv_sim.parts import Color, Part

Size = tuple[float, float, float]


@dataclass(frozen=True)
class ObjectKind:
    """A kind of movable object.

    Attributes:
        build: (full size (x, y, z) in metres, colour) -> parts in the object's frame.
        size_m: usual full size.
        mass_kg: usual mass.
        color: usual colour, a name in `COLORS`.
        round: stands on a round foot, so its sizes along x and y are the same.
        max_height_m: tallest that still looks and balances right.
        category: what it is, coarsely.
        noun: what English calls it.
        other_nouns: further words for it; the last one is used only where the instructions are unseen.
        colors: other colours that suit it.
        held_out: it occurs only among the unseen tasks.
        support: where such a thing is found: on the "floor", on a "surface", or "both".
        blocked: numbers of the grasps (`BuiltObject.grasps_o`) that a part of it, such as a back, is in the way of.
    """

    build: Callable[[Size, Color], list[Part]]
    size_m: Size
    mass_kg: float
    color: str
    round: bool = False
    max_height_m: float = 0.6
    category: str = ""
    noun: str = ""
    other_nouns: tuple[str, ...] = ()
    colors: tuple[str, ...] = ()
    held_out: bool = False
    support: str = "both"
    blocked: tuple[int, ...] = ()
