"""Furniture of a kitchen."""

from __future__ import annotations

from hv_sim.furniture_kinds.kind import DARK, ROUND_TOP, FurnitureKind, Size, cabinet, legs
from hv_sim.parts import COLORS, Color, Part, box, cylinder, ellipsoid, rod, shade, tilt

_STONE = (0.36, 0.37, 0.39)


def _counter(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    parts = cabinet(size, color, top_color=_STONE)
    parts.append(box((0.01, 0, z - 0.02), (x + 0.02, y, 0.04), _STONE, "gloss"))
    return parts


def _sink_counter(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    steel = COLORS["silver"]
    at = 0.24 * y
    return [
        *_counter(size, color),
        box((0, at, z + 0.002), (0.7 * x, 0.40 * y, 0.012), steel, "metal"),
        box((0.02, at, z + 0.006), (0.54 * x, 0.32 * y, 0.008), (0.30, 0.32, 0.34), "metal"),
        rod((-0.36 * x, at, z), (-0.36 * x, at, z + 0.26), 0.016, steel, "metal"),
        rod((-0.36 * x, at, z + 0.26), (-0.08 * x, at, z + 0.22), 0.014, steel, "metal"),
        cylinder((-0.36 * x, at, z + 0.13), 0.03, 0.26, steel, collides=True, visible=False),
    ]


def _stove(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    parts = [
        box((0, 0, z / 2), (x, y, z), color, "gloss", collides=True),
        box((0, 0, z + 0.002), (0.96 * x, 0.96 * y, 0.01), DARK, "gloss"),
        box((x / 2, 0, 0.42 * z), (0.02, 0.84 * y, 0.5 * z), DARK, "gloss"),
        box((x / 2 + 0.006, 0, 0.40 * z), (0.02, 0.64 * y, 0.32 * z), (0.16, 0.12, 0.10), "gloss"),
        rod((x / 2 + 0.04, -0.36 * y, 0.70 * z), (x / 2 + 0.04, 0.36 * y, 0.70 * z), 0.012, COLORS["silver"], "metal"),
    ]
    for i in range(4):
        at = (x / 2 + 0.01, (-0.3 + 0.2 * i) * y, 0.9 * z)
        parts.append(cylinder(at, 0.022, 0.03, COLORS["silver"], "metal", quat=tilt(0, 1.5708)))
        spot = ((-0.22 if i % 2 else 0.22) * x, (-0.22 if i < 2 else 0.22) * y, z + 0.008)
        parts.append(cylinder(spot, (0.09, 0.07, 0.08, 0.1)[i], 0.006, COLORS["red"], "glow"))
    return parts


def _fridge(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    steel = shade(color, 0.7)
    return [
        box((0, 0, z / 2), (x, y, z), color, "gloss", collides=True, visible=False),
        box((-0.02, 0, z / 2), (x - 0.04, y, z), shade(color, 0.85), "gloss"),
        box((x / 2 - 0.02, 0, 0.34 * z), (0.04, 0.98 * y, 0.64 * z), color, "gloss"),
        box((x / 2 - 0.02, 0, 0.83 * z), (0.04, 0.98 * y, 0.32 * z), color, "gloss"),
        rod((x / 2 + 0.03, 0.38 * y, 0.40 * z), (x / 2 + 0.03, 0.38 * y, 0.62 * z), 0.014, steel, "metal"),
        rod((x / 2 + 0.03, 0.38 * y, 0.72 * z), (x / 2 + 0.03, 0.38 * y, 0.86 * z), 0.014, steel, "metal"),
        box((x / 2 + 0.003, -0.16 * y, 0.88 * z), (0.006, 0.10, 0.12), COLORS["yellow"]),
        box((x / 2 + 0.003, -0.02 * y, 0.80 * z), (0.006, 0.12, 0.09), COLORS["pink"]),
    ]


def _island(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    parts = cabinet((x - 0.10, y - 0.10, z), color, top_color=_STONE)
    parts.append(box((0, 0, z - 0.025), (x, y, 0.05), _STONE, "gloss", collides=True))
    return parts


def _dishwasher(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    return [
        box((0, 0, z / 2), (x, y, z), color, "gloss", collides=True),
        box((0, 0, z - 0.015), (x + 0.01, y, 0.03), _STONE, "gloss"),
        box((x / 2, 0, 0.48 * z), (0.02, 0.96 * y, 0.72 * z), COLORS["silver"], "metal"),
        box((x / 2 + 0.004, 0, 0.90 * z), (0.02, 0.96 * y, 0.10 * z), DARK, "gloss"),
        rod((x / 2 + 0.04, -0.36 * y, 0.80 * z), (x / 2 + 0.04, 0.36 * y, 0.80 * z), 0.012, COLORS["gray"], "metal"),
        box((x / 2 + 0.012, 0.3 * y, 0.90 * z), (0.02, 0.06, 0.02), (0.4, 0.9, 0.5), "glow"),
    ]


def _washing_machine(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    face = tilt(0, 1.5708)
    return [
        box((0, 0, z / 2), (x, y, z), color, "gloss", collides=True),
        cylinder((x / 2, 0, 0.44 * z), 0.34 * y, 0.04, COLORS["silver"], "metal", quat=face),
        cylinder((x / 2 + 0.012, 0, 0.44 * z), 0.26 * y, 0.04, (0.22, 0.32, 0.42), "gloss", quat=face),
        ellipsoid((x / 2 + 0.026, 0, 0.38 * z), (0.03, 0.30 * y, 0.14 * z), COLORS["teal"], "fabric"),
        box((x / 2, -0.28 * y, 0.90 * z), (0.02, 0.36 * y, 0.12 * z), COLORS["gray"]),
        cylinder((x / 2 + 0.01, 0.26 * y, 0.90 * z), 0.035, 0.04, COLORS["silver"], "metal", quat=face),
    ]


def _tall_cupboard(size: Size, color: Color) -> list[Part]:
    return cabinet(size, color, doors=1 if size[1] < 0.7 else 2)


def _breakfast_table(size: Size, color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    return [
        cylinder((0, 0, z - 0.02), r, 0.04, color, "wood", collides=True),
        cylinder((0, 0, z - 0.02), 1.01 * r, 0.014, shade(color, 0.7)),
        cylinder((0, 0, (z - 0.04) / 2), 0.05, z - 0.04, shade(color, 0.6), "wood", collides=True),
        cylinder((0, 0, 0.02), 0.6 * r, 0.04, shade(color, 0.6), "wood", collides=True),
    ]


def _trolley(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    parts = [
        box((0, 0, z - 0.02), (x, y, 0.04), COLORS["oak"], "wood", collides=True),
        box((0, 0, 0.40 * z), (x - 0.04, y - 0.04, 0.02), color, "metal"),
        box((0, 0, 0.14 * z), (x - 0.04, y - 0.04, 0.02), color, "metal"),
        ellipsoid((0, 0.2 * y, 0.47 * z), (0.22, 0.22, 0.10), COLORS["red"], "gloss"),
        cylinder((0, -0.2 * y, 0.48 * z), 0.07, 0.13, COLORS["white"], "gloss"),
    ]
    return parts + legs(x, y, z - 0.04, 0.02, 0.03, color, "metal")


KITCHEN: dict[str, FurnitureKind] = {
    "kitchen_counter": FurnitureKind(_counter, (0.60, 1.20, 0.88), "white", holds_objects=True, noun="countertop",
                                     other_nouns=("kitchen counter", "worktop"), rooms=("kitchen",),
                                     colors=("white", "oak", "navy", "teal")),
    "sink_counter": FurnitureKind(_sink_counter, (0.60, 1.60, 0.88), "white", holds_objects=True,
                                  top=(-0.5, 0.5, -0.5, 0.02), noun="sink counter", other_nouns=("sink unit",),
                                  rooms=("kitchen",), colors=("white", "oak", "navy", "teal")),
    "stove": FurnitureKind(_stove, (0.60, 0.62, 0.89), "silver", noun="stove", other_nouns=("cooker", "oven"),
                           rooms=("kitchen",), colors=("silver", "white", "black")),
    "fridge": FurnitureKind(_fridge, (0.68, 0.74, 1.80), "silver", noun="fridge", other_nouns=("refrigerator",),
                            rooms=("kitchen",), colors=("silver", "white", "red")),
    "kitchen_island": FurnitureKind(_island, (0.80, 1.50, 0.88), "navy", holds_objects=True, noun="kitchen island",
                                    other_nouns=("island counter",), rooms=("kitchen",),
                                    colors=("navy", "white", "green")),
    "dishwasher": FurnitureKind(_dishwasher, (0.60, 0.62, 0.87), "white", holds_objects=True, noun="dishwasher",
                                other_nouns=("dishwashing machine",), rooms=("kitchen",), colors=("white", "gray")),
    "washing_machine": FurnitureKind(_washing_machine, (0.58, 0.60, 0.85), "white", holds_objects=True,
                                     noun="washing machine", other_nouns=("washer",), rooms=("kitchen",),
                                     colors=("white", "gray")),
    "tall_cupboard": FurnitureKind(_tall_cupboard, (0.60, 0.62, 2.00), "white", noun="tall cupboard",
                                   other_nouns=("pantry",), rooms=("kitchen",), colors=("white", "oak", "navy")),
    "breakfast_table": FurnitureKind(_breakfast_table, (0.90, 0.90, 0.74), "white", has_front=False,
                                     holds_objects=True, top=ROUND_TOP,
                                     noun="breakfast table", other_nouns=("bistro table",), rooms=("kitchen",),
                                     colors=("white", "oak", "walnut")),
    "kitchen_trolley": FurnitureKind(_trolley, (0.46, 0.80, 0.82), "silver", has_front=False, holds_objects=True,
                                     noun="kitchen trolley", other_nouns=("serving cart",), rooms=("kitchen",),
                                     colors=("silver", "white", "black")),
}  # fmt: skip
