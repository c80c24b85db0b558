"""What a kind of furniture is, and the parts that many kinds share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from hv_sim.parts import COLORS, Color, Part, box, shade

Size = tuple[float, float, float]

WHOLE_TOP = (-0.5, 0.5, -0.5, 0.5)
ROUND_TOP = (-0.34, 0.34, -0.34, 0.34)
DARK = (0.09, 0.09, 0.10)


@dataclass(frozen=True)
class FurnitureKind:
    """A kind of furniture.

    Attributes:
        build: (full size (depth, width, height) in metres, colour) -> parts in the piece's frame.
        size_m: usual full size.
        color: usual colour, a name in `COLORS`.
        solid: False for what lies flat and is walked over.
        holds_objects: its top is meant for putting things on.
        has_front: anybody sees which side is its front, so that its left, right and back mean something.
        top: the free part of that top, as shares of the footprint: back, front, right, left end.
        noun: what English calls it.
        other_nouns: further words for it; the last one is used only where the instructions are unseen.
        rooms: where it belongs.
        colors: other colours that suit it.
    """

    build: Callable[[Size, Color], list[Part]]
    size_m: Size
    color: str
    solid: bool = True
    holds_objects: bool = False
    has_front: bool = True
    top: tuple[float, float, float, float] = WHOLE_TOP
    noun: str = ""
    other_nouns: tuple[str, ...] = ()
    rooms: tuple[str, ...] = ()
    colors: tuple[str, ...] = ()


def legs(
    x: float, y: float, height: float, inset: float, width: float, color: Color, material: str = "wood"
) -> list[Part]:
    return [
        box(
            (sx * (x / 2 - inset), sy * (y / 2 - inset), height / 2),
            (width, width, height),
            color,
            material,
            collides=True,
        )
        for sx in (-1, 1)
        for sy in (-1, 1)
    ]


def cabinet_front(x: float, y: float, low: float, high: float, doors: int, color: Color) -> list[Part]:
    parts: list[Part] = []
    width = y / doors
    for i in range(doors):
        at = -y / 2 + (i + 0.5) * width
        parts.append(box((x / 2, at, (low + high) / 2), (0.012, width - 0.02, high - low - 0.02), color, "wood"))
        handle = at + (width / 2 - 0.05) * (1 if i % 2 == 0 else -1)
        parts.append(box((x / 2 + 0.012, handle, (low + high) / 2), (0.014, 0.014, 0.12), COLORS["silver"], "metal"))
    return parts


def cabinet(size: Size, color: Color, doors: int = 0, top_color: Color | None = None) -> list[Part]:
    """A closed body with doors in front, a top and a recessed foot."""
    x, y, z = size
    top, foot = 0.03, 0.10
    parts = [
        box((0, 0, z / 2), (x, y, z), color, collides=True, visible=False),
        box((0, 0, z - top / 2), (x, y, top), shade(color, 0.8) if top_color is None else top_color, "wood"),
        box((-0.01, 0, (foot + z - top) / 2), (x - 0.02, y - 0.02, z - top - foot), shade(color, 0.75), "wood"),
        box((-0.03, 0, foot / 2), (x - 0.10, y - 0.10, foot), DARK),
    ]
    return parts + cabinet_front(x - 0.02, y - 0.02, foot, z - top, doors or max(2, round(y / 0.45)), color)


def drawers(size: Size, color: Color, rows: int, columns: int) -> list[Part]:
    """A chest of drawers."""
    x, y, z = size
    top, foot = 0.03, 0.08
    parts = [
        box((0, 0, z / 2), (x, y, z), color, collides=True, visible=False),
        box((0, 0, z - top / 2), (x, y, top), shade(color, 0.8), "wood"),
        box((-0.01, 0, (foot + z - top) / 2), (x - 0.02, y, z - top - foot), shade(color, 0.78), "wood"),
        box((-0.03, 0, foot / 2), (x - 0.08, y - 0.08, foot), DARK),
    ]
    tall, wide = (z - top - foot) / rows, y / columns
    for i in range(rows):
        for j in range(columns):
            at = (x / 2 - 0.012, -y / 2 + (j + 0.5) * wide, foot + (i + 0.5) * tall)
            parts.append(box(at, (0.018, wide - 0.025, tall - 0.02), color, "wood"))
            parts.append(box((x / 2 + 0.004, at[1], at[2]), (0.016, 0.10, 0.014), COLORS["silver"], "metal"))
    return parts


def table(size: Size, color: Color, top: float = 0.04, leg: float = 0.06) -> list[Part]:
    """A top on four legs."""
    x, y, z = size
    parts = [
        box((0, 0, z - top / 2), (x, y, top), color, "wood", collides=True),
        box((0, 0, z - top - 0.035), (x - 0.12, y - 0.12, 0.07), shade(color, 0.82), "wood"),
    ]
    return parts + legs(x, y, z - top, 0.06, leg, shade(color, 0.8))
