"""What stands in a warehouse."""

from __future__ import annotations

from hv_sim.furniture_kinds.kind import DARK, FurnitureKind, Size, cabinet, drawers, legs
from hv_sim.parts import COLORS, Color, Part, box, cylinder, rod, shade, tilt

_CARTON = (0.74, 0.58, 0.40)


def _pallet_rack(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    post, beam = 0.09, 0.10
    parts = [box((0, 0, z / 2), (x, y, z), color, collides=True, visible=False)]
    for sx in (-1, 1):
        for sy in (-1, 1):
            at = (sx * (x / 2 - post / 2), sy * (y / 2 - post / 2), z / 2)
            parts.append(box(at, (post, post, z), COLORS["blue"], "metal"))
    for level in (0.06, 0.38, 0.70):
        for sx in (-1, 1):
            parts.append(box((sx * (x / 2 - 0.03), 0, level * z), (0.05, y, beam), color, "metal"))
        parts.append(box((0, 0, level * z + 0.05), (x - 0.08, y - 0.1, 0.03), COLORS["silver"], "metal"))
        for i in range(3):
            tall = (0.24, 0.20, 0.26, 0.18)[(i + round(10 * level)) % 4] * z
            at = (0.02, (-0.31 + 0.31 * i) * y, level * z + 0.065 + tall / 2)
            parts.append(box(at, (0.7 * x, 0.26 * y, tall), shade(_CARTON, 0.85 + 0.1 * i), "cardboard"))
    return parts


def _shelving(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    parts = [box((0, 0, z / 2), (x, y, z), color, collides=True, visible=False)]
    for sx in (-1, 1):
        for sy in (-1, 1):
            parts.append(box((sx * (x / 2 - 0.02), sy * (y / 2 - 0.02), z / 2), (0.04, 0.04, z), color, "metal"))
    tones = ("blue", "red", "gray", "green", "yellow")
    for row, level in enumerate((0.05, 0.30, 0.55, 0.80)):
        parts.append(box((0, 0, level * z), (x, y, 0.025), shade(color, 1.2), "metal"))
        for i in range(2):
            at = (0, (-0.24 + 0.48 * i) * y, level * z + 0.15)
            parts.append(box(at, (0.72 * x, 0.40 * y, 0.26), COLORS[tones[(row + 2 * i) % 5]], "gloss"))
    return parts


def _workbench(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    steel = COLORS["charcoal"]
    parts = [
        box((0, 0, z - 0.03), (x, y, 0.06), color, "wood", collides=True),
        box((0, 0, 0.22), (x - 0.10, y - 0.10, 0.03), steel, "metal"),
        box((0, 0.3 * y, z - 0.18), (x - 0.12, 0.3 * y, 0.22), COLORS["red"], "metal"),
        box((x / 2 - 0.06, 0.3 * y, z - 0.14), (0.02, 0.26 * y, 0.02), COLORS["silver"], "metal"),
        box((x / 2 - 0.06, 0.3 * y, z - 0.23), (0.02, 0.26 * y, 0.02), COLORS["silver"], "metal"),
        box((0.02, -0.2 * y, 0.32), (0.3, 0.4, 0.18), _CARTON, "cardboard"),
    ]
    return parts + legs(x, y, z - 0.06, 0.05, 0.08, steel, "metal")


def _packing_table(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    steel = COLORS["silver"]
    parts = [
        box((0, 0, z - 0.025), (x, y, 0.05), color, "wood", collides=True),
        box((0, 0, 0.25), (x - 0.12, y - 0.12, 0.03), steel, "metal"),
        rod((-0.1, -0.36 * y, 0.36), (-0.1, 0.1 * y, 0.36), 0.09, _CARTON, "cardboard"),
        box((0.05, 0.32 * y, 0.36), (0.36, 0.3, 0.2), COLORS["blue"], "gloss"),
    ]
    return parts + legs(x, y, z - 0.05, 0.05, 0.06, steel, "metal")


def _pallet(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    parts = [box((0, 0, z / 2), (x, y, z), color, collides=True, visible=False)]
    for i in range(5):
        parts.append(box((0, (-0.42 + 0.21 * i) * y, z - 0.012), (x, 0.16 * y, 0.024), color, "wood"))
    for at in (-0.44, 0.0, 0.44):
        parts.append(box((at * x, 0, z / 2 - 0.012), (0.12 * x, y, z - 0.024), shade(color, 0.75), "wood"))
    return parts


def _pallet_stack(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    count = max(2, round(z / 0.145))
    tall = z / count
    parts = [box((0, 0, z / 2), (x, y, z), color, collides=True, visible=False)]
    for i in range(count):
        low = i * tall
        parts.append(box((0, 0, low + tall - 0.015), (x, y, 0.03), shade(color, 1.0 - 0.05 * (i % 2)), "wood"))
        for at in (-0.44, 0.0, 0.44):
            parts.append(
                box((at * x, 0, low + tall / 2 - 0.015), (0.12 * x, 0.98 * y, tall - 0.03), shade(color, 0.7), "wood")
            )
    return parts


def _conveyor(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    parts = [box((0, 0, z - 0.06), (x, y, 0.12), color, collides=True, visible=False)]
    for side in (-1, 1):
        parts.append(box((side * (x / 2 - 0.025), 0, z - 0.07), (0.05, y, 0.10), color, "metal"))
    for i in range(12):
        at = (-0.46 + 0.92 * i / 11) * y
        parts.append(
            rod((-x / 2 + 0.07, at, z - 0.035), (x / 2 - 0.07, at, z - 0.035), 0.035, COLORS["silver"], "metal")
        )
    return parts + legs(x, y, z - 0.12, 0.05, 0.07, COLORS["charcoal"], "metal")


def _forklift(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    iron = COLORS["charcoal"]
    parts = [
        box((-0.13 * x, 0, 0.24 * z), (0.72 * x, y, 0.40 * z), color, collides=True, visible=False),
        box((0.26 * x, 0, z / 2), (0.12, 0.7 * y, z), iron, collides=True, visible=False),
        box((0.38 * x, 0, 0.05), (0.24 * x, 0.6 * y, 0.1), iron, collides=True, visible=False),
        box((-0.20 * x, 0, 0.6 * z), (0.5 * x, 0.8 * y, 0.6 * z), color, collides=True, visible=False),
        box((-0.12 * x, 0, 0.20 * z), (0.66 * x, 0.9 * y, 0.16 * z), color, "gloss"),
        box((-0.36 * x, 0, 0.32 * z), (0.22 * x, 0.9 * y, 0.26 * z), shade(color, 0.85), "gloss"),
        box((-0.16 * x, 0, 0.38 * z), (0.2 * x, 0.5 * y, 0.08), DARK),
        box((-0.26 * x, 0, 0.48 * z), (0.06, 0.5 * y, 0.22 * z), DARK),
        box((-0.13 * x, 0, z - 0.04), (0.5 * x, 0.86 * y, 0.05), iron),
        rod((0.06 * x, 0, 0.36 * z), (0.0, 0, 0.52 * z), 0.02, DARK),
    ]
    for side in (-1, 1):
        parts.append(box((0.26 * x, side * 0.24 * y, z / 2), (0.09, 0.08, z), iron, "metal"))
        parts.append(box((0.40 * x, side * 0.2 * y, 0.06), (0.24 * x, 0.1 * y, 0.04), COLORS["silver"], "metal"))
        for front, r in ((0.14, 0.17), (-0.34, 0.14)):
            parts.append(cylinder((front * x, side * 0.45 * y, r * 1.02), r, 0.12, DARK, quat=tilt(1.5708, 0)))
        for front in (0.1, -0.36):
            parts.append(
                rod((front * x, side * 0.4 * y, 0.4 * z), (front * 0.9 * x, side * 0.4 * y, z - 0.05), 0.022, iron)
            )
    return parts


def _crate_stack(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    parts = [box((0, 0, z / 2), (x, y, z), color, collides=True, visible=False)]
    for row in range(2):
        for side in (-1, 1):
            at = (0, side * y / 4, (row + 0.5) * z / 2)
            tone = shade(color, 0.85 + 0.1 * ((row + side) % 3))
            parts.append(box(at, (x, y / 2 - 0.01, z / 2 - 0.01), tone, "wood"))
            parts.append(box((x / 2, at[1], at[2]), (0.02, 0.4 * y, 0.05), shade(tone, 0.6), "wood", quat=tilt(0.6, 0)))
            for edge in (-1, 1):
                up = at[2] + edge * (z / 4 - 0.04)
                parts.append(box((x / 2, at[1], up), (0.024, y / 2 - 0.02, 0.06), shade(tone, 0.7), "wood"))
    return parts


def _barrel_group(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    r = min(x, y / 2) / 2
    parts = []
    for side, tone in ((-1, color), (1, COLORS["red"])):
        at = (0, side * r, z / 2)
        parts.append(cylinder(at, r, z, tone, collides=True, visible=False))
        parts.append(cylinder(at, 0.96 * r, z, tone, "gloss"))
        for level in (0.02, 0.33, 0.66, 0.98):
            parts.append(cylinder((0, side * r, level * z), r, 0.03, shade(tone, 0.75), "gloss"))
        parts.append(cylinder((0.4 * r, side * r, z), 0.12 * r, 0.02, COLORS["silver"], "metal"))
    return parts


def _tool_cabinet(size: Size, color: Color) -> list[Part]:
    return drawers(size, color, 5, 1)


def _platform_trolley(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    parts = [
        box((0, 0, z / 2), (x, y, z), color, collides=True, visible=False),
        box((0, 0, z - 0.03), (x, y, 0.06), color, "gloss"),
        box((0, 0, z - 0.07), (x - 0.08, y - 0.08, 0.04), DARK),
    ]
    for sx in (-1, 1):
        for sy in (-1, 1):
            wheel = cylinder((sx * 0.38 * x, sy * 0.38 * y, 0.07), 0.07, 0.04, DARK, quat=tilt(1.5708, 0))
            parts.append(wheel)
    return parts


def _locker(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    parts = cabinet(size, color, doors=3)
    for i in range(3):
        for level in (0.84, 0.87, 0.90):
            parts.append(box((x / 2, (-0.33 + 0.33 * i) * y, level * z), (0.012, 0.16 * y, 0.012), DARK))
    return parts


def _ladder(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    parts = [box((0, 0, z / 2), (x, y, z), color, collides=True, visible=False)]
    for side in (-1, 1):
        parts.append(
            rod((x / 2 - 0.03, side * (y / 2 - 0.03), 0.03), (0.02, side * 0.36 * y, z - 0.03), 0.028, color, "metal")
        )
        parts.append(
            rod((-x / 2 + 0.03, side * (y / 2 - 0.03), 0.03), (-0.02, side * 0.36 * y, z - 0.03), 0.024, color, "metal")
        )
    for i in range(1, 6):
        share = i / 6
        at, wide = (x / 2 - 0.03) * (1 - share), (y / 2 - 0.03) * (1 - 0.25 * share)
        parts.append(box((at, 0, share * z), (0.09, 2 * wide, 0.03), shade(color, 0.8), "metal"))
    parts.append(box((0, 0, z - 0.02), (0.14, 0.7 * y, 0.04), COLORS["orange"]))
    return parts


def _traffic_cone(size: Size, color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    parts = [
        cylinder((0, 0, z / 2), 0.6 * r, z, color, collides=True, visible=False),
        box((0, 0, 0.015), (1.6 * r, 1.6 * r, 0.03), shade(color, 0.7), collides=True),
    ]
    for i in range(8):
        tone = COLORS["white"] if i in (3, 5) else color
        parts.append(cylinder((0, 0, 0.03 + (i + 0.5) * (z - 0.03) / 8), (0.66 - 0.07 * i) * r, (z - 0.03) / 8, tone))
    return parts


WAREHOUSE: dict[str, FurnitureKind] = {
    "pallet_rack": FurnitureKind(_pallet_rack, (1.00, 2.40, 2.20), "orange", has_front=False, noun="pallet rack",
                                 other_nouns=("storage rack",), rooms=("warehouse",), colors=("orange", "yellow")),
    "shelving_unit": FurnitureKind(_shelving, (0.50, 1.20, 1.90), "gray", noun="shelving unit",
                                   other_nouns=("metal shelves",), rooms=("warehouse",), colors=("gray", "charcoal")),
    "workbench": FurnitureKind(_workbench, (0.70, 1.60, 0.86), "oak", holds_objects=True, noun="workbench",
                               other_nouns=("work table",), rooms=("warehouse",), colors=("oak", "walnut")),
    "packing_table": FurnitureKind(_packing_table, (0.80, 1.70, 0.80), "tan", has_front=False, holds_objects=True,
                                   noun="packing table", other_nouns=("packing station",), rooms=("warehouse",),
                                   colors=("tan", "white")),
    "pallet": FurnitureKind(_pallet, (0.80, 1.20, 0.145), "oak", has_front=False, holds_objects=True, noun="pallet",
                            other_nouns=("wooden pallet", "skid"), rooms=("warehouse",), colors=("oak", "tan")),
    "pallet_stack": FurnitureKind(_pallet_stack, (0.80, 1.20, 0.58), "oak", has_front=False, holds_objects=True,
                                  noun="stack of pallets", other_nouns=("pile of pallets",), rooms=("warehouse",),
                                  colors=("oak", "tan")),
    "conveyor": FurnitureKind(_conveyor, (0.60, 2.40, 0.75), "gray", has_front=False,
                              holds_objects=True, noun="conveyor",
                              other_nouns=("roller conveyor", "conveyor belt"), rooms=("warehouse",),
                              colors=("gray", "blue", "green")),
    "forklift": FurnitureKind(_forklift, (2.20, 1.05, 2.00), "yellow", noun="forklift", other_nouns=("fork truck",),
                              rooms=("warehouse",), colors=("yellow", "orange", "red")),
    "crate_stack": FurnitureKind(_crate_stack, (0.80, 1.20, 1.20), "oak", has_front=False, noun="stack of crates",
                                 other_nouns=("pile of crates",), rooms=("warehouse",), colors=("oak", "tan")),
    "barrel_group": FurnitureKind(_barrel_group, (0.58, 1.16, 0.88), "blue", has_front=False, noun="pair of drums",
                                  other_nouns=("two barrels",), rooms=("warehouse",), colors=("blue", "green")),
    "tool_cabinet": FurnitureKind(_tool_cabinet, (0.50, 0.80, 0.88), "red", holds_objects=True, noun="tool cabinet",
                                  other_nouns=("roller cabinet",), rooms=("warehouse",), colors=("red", "blue")),
    "platform_trolley": FurnitureKind(_platform_trolley, (0.65, 1.10, 0.32), "blue", has_front=False,
                                      holds_objects=True,
                                      noun="platform trolley", other_nouns=("flat cart",), rooms=("warehouse",),
                                      colors=("blue", "green", "red")),
    "locker": FurnitureKind(_locker, (0.50, 1.00, 1.80), "gray", noun="locker", other_nouns=("steel locker",),
                            rooms=("warehouse",), colors=("gray", "blue")),
    "ladder": FurnitureKind(_ladder, (0.70, 0.50, 1.60), "silver", has_front=False,
                            noun="ladder", other_nouns=("stepladder",),
                            rooms=("warehouse",), colors=("silver", "yellow")),
    "traffic_cone": FurnitureKind(_traffic_cone, (0.36, 0.36, 0.60), "orange", has_front=False, noun="traffic cone",
                                  other_nouns=("safety cone",), rooms=("warehouse",), colors=("orange",)),
}  # fmt: skip
