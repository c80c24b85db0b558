"""Furniture: what stands still in a room, made of upright boxes and cylinders for contact and finer parts to look at.

A piece's frame lies on the floor under the middle of its footprint; its front faces +x and its width runs along y.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hv_sim.parts import COLORS, Color, Part, box, cylinder, ellipsoid, rod, shade, tilt

Size = tuple[float, float, float]

_DARK = (0.09, 0.09, 0.10)


@dataclass(frozen=True)
class FurnitureKind:
    """A kind of furniture.

    Attributes:
        build: (full size (depth, width, height) in metres, colour) -> parts in the piece's frame.
        size_m: usual full size.
        color: usual colour, a name in `COLORS`.
        solid: False for what lies flat and is walked over.
        holds_objects: its top is meant for putting things on.
    """

    build: Callable[[Size, Color], list[Part]]
    size_m: Size
    color: str
    solid: bool = True
    holds_objects: bool = False


def build_furniture(kind: str, size_m: Size | None = None, color: str | None = None) -> list[Part]:
    """Parts of a piece of a kind in `FURNITURE_KINDS`; what is left out takes the kind's usual value.

    Raises:
        ValueError: `size_m: ...` less than half or more than twice the kind's usual size along some axis.
        KeyError: an unknown kind or colour.
    """
    spec = FURNITURE_KINDS[kind]
    size = spec.size_m if size_m is None else (float(size_m[0]), float(size_m[1]), float(size_m[2]))
    if not all(0.5 * usual - 1e-9 <= s <= 2.0 * usual + 1e-9 for s, usual in zip(size, spec.size_m, strict=True)):
        usual = ", ".join(f"{0.5 * s:g} to {2.0 * s:g}" for s in spec.size_m)
        raise ValueError(f"size_m: {list(size)} is not a {kind}'s size (depth, width, height); valid: {usual}")
    return spec.build(size, COLORS[spec.color if color is None else color])


def _legs(
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


def _seating(size: Size, color: Color, seats: int, pillows: tuple[str, ...]) -> list[Part]:
    x, y, z = size
    arm, back = 0.10 * max(y, 0.9) if seats == 1 else 0.16, 0.22 * x
    seat_top, arm_top, foot = 0.54 * z, 0.72 * z, 0.07
    inner = y - 2 * arm
    dark = shade(color, 0.85)
    parts = [
        box((0, 0, (foot + 0.34 * z) / 2), (x, y, 0.34 * z - foot), dark, "fabric", collides=True),
        box(
            (back / 2, 0, (0.34 * z + seat_top) / 2),
            (x - back, inner, seat_top - 0.34 * z),
            color,
            "fabric",
            collides=True,
            visible=False,
        ),
        box((-x / 2 + back / 2, 0, z * 0.5 + 0.02), (back, y, z - 0.04), dark, "fabric", collides=True),
        rod(
            (-x / 2 + back / 2, -y / 2 + back / 2, z - 0.05),
            (-x / 2 + back / 2, y / 2 - back / 2, z - 0.05),
            back / 2,
            dark,
            "fabric",
        ),
    ]
    for side in (-1, 1):
        at = side * (y / 2 - arm / 2)
        parts.append(
            box((0.02, at, (foot + arm_top) / 2), (x - 0.04, arm, arm_top - foot), dark, "fabric", collides=True)
        )
        parts.append(
            rod((-x / 2 + arm / 2, at, arm_top - 0.01), (x / 2 - arm / 2, at, arm_top - 0.01), arm / 2, dark, "fabric")
        )
    width = inner / seats
    for i in range(seats):
        at = -inner / 2 + (i + 0.5) * width
        parts.append(
            box(
                (back / 2, at, (0.34 * z + seat_top) / 2),
                (x - back, width - 0.012, seat_top - 0.34 * z),
                color,
                "fabric",
            )
        )
        cushion = (0.13, width - 0.03, z - seat_top + 0.02)
        parts.append(
            box(
                (-x / 2 + back + 0.055, at, (seat_top + z) / 2),
                cushion,
                shade(color, 1.08),
                "fabric",
                quat=tilt(0, -0.12),
            )
        )
    for i, name in enumerate(pillows):
        at = (-1 if i == 0 else 1) * (inner / 2 - 0.20)
        pos = (-x / 2 + back + 0.20, at, seat_top + 0.17)
        turn = tilt(0, -0.35, 0.25 if i == 0 else -0.25)
        parts.append(box(pos, (0.11, 0.38, 0.36), COLORS[name], "fabric", quat=turn))
    for sx in (-1, 1):
        for sy in (-1, 1):
            parts.append(cylinder((sx * (x / 2 - 0.08), sy * (y / 2 - 0.08), foot / 2), 0.025, foot, COLORS["walnut"]))
    return parts


def _sofa(size: Size, color: Color) -> list[Part]:
    return _seating(size, color, 3 if size[1] > 1.7 else 2, ("orange", "cream"))


def _armchair(size: Size, color: Color) -> list[Part]:
    return _seating(size, color, 1, ())


def _coffee_table(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    top = 0.045
    parts = [
        box((0, 0, z - top / 2), (x, y, top), color, "wood", collides=True),
        box((0, 0, z - top - 0.03), (x - 0.10, y - 0.10, 0.06), shade(color, 0.85), "wood"),
        box((0, 0, 0.35 * z), (x - 0.10, y - 0.10, 0.025), shade(color, 0.9), "wood"),
        box((0.02, 0.18 * y, 0.35 * z + 0.025), (0.22, 0.30, 0.03), COLORS["red"]),
        box((0.02, 0.17 * y, 0.35 * z + 0.050), (0.20, 0.27, 0.02), COLORS["cream"]),
    ]
    return parts + _legs(x, y, z - top, 0.05, 0.055, shade(color, 0.8))


def _table(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    top = 0.04
    parts = [
        box((0, 0, z - top / 2), (x, y, top), color, "wood", collides=True),
        box((0, 0, z - top - 0.04), (x - 0.16, y - 0.16, 0.08), shade(color, 0.82), "wood"),
    ]
    return parts + _legs(x, y, z - top, 0.07, 0.065, shade(color, 0.8))


def _console_table(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    top, apron = 0.035, 0.12
    parts = [
        box((0, 0, z - top / 2), (x, y, top), color, "wood", collides=True),
        box((0, 0, z - top - apron / 2), (x - 0.05, y - 0.06, apron), shade(color, 0.9), "wood"),
        box((0, 0, 0.16), (x - 0.06, y - 0.06, 0.025), shade(color, 0.9), "wood"),
    ]
    for side in (-1, 1):
        front = x / 2 - 0.022
        parts.append(
            box((front, side * y / 4, z - top - apron / 2), (0.012, y / 2 - 0.08, apron - 0.025), color, "wood")
        )
        parts.append(
            ellipsoid((front + 0.015, side * y / 4, z - top - apron / 2), (0.03, 0.03, 0.03), COLORS["yellow"], "metal")
        )
    return parts + _legs(x, y, z - top, 0.035, 0.045, shade(color, 0.8))


def _cabinet_front(x: float, y: float, low: float, high: float, doors: int, color: Color) -> list[Part]:
    parts: list[Part] = []
    width = y / doors
    for i in range(doors):
        at = -y / 2 + (i + 0.5) * width
        parts.append(box((x / 2, at, (low + high) / 2), (0.012, width - 0.02, high - low - 0.02), color, "wood"))
        handle = at + (width / 2 - 0.05) * (1 if i % 2 == 0 else -1)
        parts.append(box((x / 2 + 0.012, handle, (low + high) / 2), (0.014, 0.014, 0.12), COLORS["silver"], "metal"))
    return parts


def _cabinet(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    top, foot = 0.03, 0.10
    parts = [
        box((0, 0, z / 2), (x, y, z), color, collides=True, visible=False),
        box((0, 0, z - top / 2), (x, y, top), shade(color, 0.8), "wood"),
        box((-0.01, 0, (foot + z - top) / 2), (x - 0.02, y - 0.02, z - top - foot), shade(color, 0.75), "wood"),
        box((-0.03, 0, foot / 2), (x - 0.10, y - 0.10, foot), _DARK),
    ]
    return parts + _cabinet_front(x - 0.02, y - 0.02, foot, z - top, max(2, round(y / 0.45)), color)


def _tv_stand(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    parts = _cabinet(size, color)
    wide, tall, low = min(1.0, 0.58 * y), 0.58, z + 0.06
    at = -x / 2 + 0.06
    parts += [
        box((at, 0, low + tall / 2), (0.05, wide, tall), _DARK, "gloss", collides=True),
        box((at + 0.026, 0, low + tall / 2), (0.002, wide - 0.04, tall - 0.04), (0.10, 0.13, 0.18), "gloss"),
        box((at, 0, z + 0.03), (0.04, 0.10, 0.06), _DARK),
        box((at, 0, z + 0.008), (0.11, 0.40 * wide, 0.016), _DARK),
    ]
    return parts


def _bookshelf(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    side, shelves = 0.03, max(3, round(z / 0.38))
    gap = (z - 0.08 - side) / shelves
    parts = [
        box((0, 0, z / 2), size, color, collides=True, visible=False),
        box((-x / 2 + 0.01, 0, z / 2), (0.02, y, z), shade(color, 0.6), "wood"),
        box((0, y / 2 - side / 2, z / 2), (x, side, z), color, "wood"),
        box((0, -y / 2 + side / 2, z / 2), (x, side, z), color, "wood"),
        box((0, 0, 0.04), (x - 0.02, y - 2 * side, 0.08), shade(color, 0.85), "wood"),
    ]
    for i in range(shelves + 1):
        parts.append(box((0, 0, 0.08 + i * gap + side / 2), (x, y - 2 * side, side), color, "wood"))
    turned = (0.7071067811865476, 0.0, 0.0, 0.7071067811865476)  # the book texture varies along local x
    for i in range(shelves):
        length = (y - 2 * side) * (0.96, 0.60, 0.86, 0.70, 0.92)[i % 5]
        height = gap * (0.72, 0.66, 0.78)[i % 3]
        at = (-1 if i % 2 else 1) * ((y - 2 * side) - length) / 2
        center = (-0.02, at, 0.08 + i * gap + side + height / 2)
        half = (length / 2, 0.36 * x, height / 2)
        parts.append(Part("box", half, center, (1.0, 1.0, 1.0), "books", quat=turned))
    return parts


def _rug(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    return [box((0, 0, z / 2), (x, y, z), color, "rug")]


def _side_table(size: Size, color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    top = 0.03
    return [
        cylinder((0, 0, z - top / 2), r, top, color, "wood", collides=True),
        cylinder((0, 0, z - 0.5 * top), 1.01 * r, 0.010, shade(color, 0.7)),
        cylinder((0, 0, (z - top) / 2), 0.035, z - top, shade(color, 0.7), "wood", collides=True),
        cylinder((0, 0, 0.0125), 0.72 * r, 0.025, shade(color, 0.7), "wood", collides=True),
    ]


def _dining_chair(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    seat, rail = 0.46, 0.035
    parts = [
        box((0, 0, seat - 0.02), (x, y, 0.04), shade(color, 0.9), "wood", collides=True),
        box((0.01, 0, seat + 0.015), (x - 0.06, y - 0.05, 0.03), COLORS["cream"], "fabric"),
        box((-x / 2 + rail / 2, 0, (seat + z) / 2), (rail, y, z - seat), color, collides=True, visible=False),
        box((-x / 2 + rail / 2, 0, z - 0.05), (rail, y, 0.10), color, "wood"),
        box((-x / 2 + rail / 2, 0, (seat + z) / 2), (rail * 0.7, y, 0.06), color, "wood"),
    ]
    for side in (-1, 1):
        parts.append(
            box((-x / 2 + rail / 2, side * (y / 2 - rail / 2), (seat + z) / 2), (rail, rail, z - seat), color, "wood")
        )
    return parts + _legs(x, y, seat - 0.04, 0.03, 0.04, shade(color, 0.85))


def _floor_lamp(size: Size, color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    warm = (1.0, 0.93, 0.75)
    return [
        cylinder((0, 0, 0.015), 0.75 * r, 0.03, color, "metal", collides=True),
        cylinder((0, 0, z / 2 - 0.1), 0.016, z - 0.2, color, "metal", collides=True),
        cylinder((0, 0, z - 0.17), r, 0.30, warm, "glow", collides=True, visible=False),
        cylinder((0, 0, z - 0.24), r, 0.16, warm, "glow"),
        cylinder((0, 0, z - 0.10), 0.88 * r, 0.16, warm, "glow"),
        cylinder((0, 0, z - 0.32), 1.01 * r, 0.012, color),
        cylinder((0, 0, z - 0.02), 0.89 * r, 0.012, color),
    ]


def _potted_tree(size: Size, color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    pot, radius = 0.22 * z, 0.55 * r
    leaf = (0.18, 0.44, 0.20)
    parts = [
        cylinder((0, 0, pot / 2), radius, pot, color, collides=True),
        cylinder((0, 0, pot - 0.02), 1.08 * radius, 0.04, shade(color, 1.1)),
        cylinder((0, 0, pot), 0.9 * radius, 0.01, (0.15, 0.10, 0.07)),
        cylinder((0, 0, pot + 0.5 * (z - pot)), 0.022, z - pot - 0.2, COLORS["brown"], "wood"),
        cylinder((0, 0, 0.74 * z), 0.7 * r, 0.52 * z, leaf, collides=True, visible=False),
    ]
    for i in range(9):
        angle, level = i * 2.4, 0.52 + 0.05 * i
        at = (0.55 * r * np.cos(angle), 0.55 * r * np.sin(angle), level * z)
        size_leaf = (1.0 * r, 0.42 * r, 0.09 * z)
        tone = shade(leaf, 0.8 + 0.15 * (i % 3))
        parts.append(ellipsoid(at, size_leaf, tone, quat=tilt(0, -0.6, angle)))
    parts.append(ellipsoid((0, 0, 0.93 * z), (0.7 * r, 0.7 * r, 0.14 * z), shade(leaf, 1.1)))
    return parts


def _bench(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    cushion = 0.10
    parts = [
        box((0, 0, z - cushion / 2), (x, y, cushion), color, "fabric", collides=True),
        box((0, 0, z - cushion / 2), (x + 0.004, y + 0.004, 0.012), shade(color, 0.7), "fabric"),
        box((0, 0, z - cushion - 0.03), (x - 0.04, y - 0.04, 0.06), COLORS["walnut"], "wood"),
    ]
    return parts + _legs(x, y, z - cushion, 0.05, 0.05, COLORS["walnut"])


FURNITURE_KINDS: dict[str, FurnitureKind] = {
    "sofa": FurnitureKind(_sofa, (0.90, 2.00, 0.80), "blue"),
    "armchair": FurnitureKind(_armchair, (0.80, 0.82, 0.80), "teal"),
    "coffee_table": FurnitureKind(_coffee_table, (0.60, 1.10, 0.42), "oak", holds_objects=True),
    "tv_stand": FurnitureKind(_tv_stand, (0.42, 1.80, 0.50), "walnut", holds_objects=True),
    "console_table": FurnitureKind(_console_table, (0.40, 1.20, 0.78), "oak", holds_objects=True),
    "bookshelf": FurnitureKind(_bookshelf, (0.32, 0.95, 1.90), "oak"),
    "rug": FurnitureKind(_rug, (1.80, 2.40, 0.008), "red", solid=False),
    "side_table": FurnitureKind(_side_table, (0.50, 0.50, 0.52), "walnut", holds_objects=True),
    "dining_table": FurnitureKind(_table, (0.90, 1.50, 0.75), "oak", holds_objects=True),
    "dining_chair": FurnitureKind(_dining_chair, (0.44, 0.42, 0.90), "oak"),
    "cabinet": FurnitureKind(_cabinet, (0.42, 1.10, 0.80), "white", holds_objects=True),
    "bench": FurnitureKind(_bench, (0.42, 1.10, 0.45), "green", holds_objects=True),
    "floor_lamp": FurnitureKind(_floor_lamp, (0.40, 0.40, 1.60), "charcoal"),
    "potted_tree": FurnitureKind(_potted_tree, (0.70, 0.70, 1.50), "white"),
}
"""Kinds that a task file may name."""
