"""Furniture of a living room."""

from __future__ import annotations

import numpy as np

from hv_sim.furniture_kinds.kind import DARK, ROUND_TOP, FurnitureKind, Size, cabinet, legs, table
from hv_sim.parts import COLORS, Color, Part, box, cylinder, ellipsoid, rod, shade, tilt


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
    return parts + legs(x, y, z - top, 0.05, 0.055, shade(color, 0.8))


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
    return parts + legs(x, y, z - top, 0.035, 0.045, shade(color, 0.8))


def _tv_stand(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    parts = cabinet(size, color)
    wide, tall, low = min(1.0, 0.58 * y), 0.58, z + 0.06
    at = -x / 2 + 0.06
    parts += [
        box((at, 0, low + tall / 2), (0.05, wide, tall), DARK, "gloss", collides=True),
        box((at + 0.026, 0, low + tall / 2), (0.002, wide - 0.04, tall - 0.04), (0.10, 0.13, 0.18), "gloss"),
        box((at, 0, z + 0.03), (0.04, 0.10, 0.06), DARK),
        box((at, 0, z + 0.008), (0.11, 0.40 * wide, 0.016), DARK),
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
    return parts + legs(x, y, seat - 0.04, 0.03, 0.04, shade(color, 0.85))


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
    return parts + legs(x, y, z - cushion, 0.05, 0.05, COLORS["walnut"])


def _round_coffee_table(size: Size, color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    return [
        cylinder((0, 0, z - 0.02), r, 0.04, color, "wood", collides=True),
        cylinder((0, 0, z - 0.02), 1.01 * r, 0.012, shade(color, 0.7)),
        cylinder((0, 0, (z - 0.04) / 2), 0.5 * r, z - 0.04, shade(color, 0.75), "wood", collides=True),
        cylinder((0, 0, 0.02), 0.7 * r, 0.04, shade(color, 0.6), "wood"),
    ]


def _sideboard(size: Size, color: Color) -> list[Part]:
    return cabinet(size, color, doors=4, top_color=COLORS["walnut"])


def _record_cabinet(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    parts = cabinet(size, color, doors=2)
    turned = (0.7071067811865476, 0.0, 0.0, 0.7071067811865476)
    parts.append(Part("box", (0.42 * y, 0.1 * x, 0.13 * z), (0.43 * x, 0, 0.72 * z), (1, 1, 1), "books", quat=turned))
    return parts


def _piano(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    keys = 0.62 * z
    parts = [
        box((-0.22 * x, 0, z / 2), (0.56 * x, y, z), color, "gloss", collides=True),
        box((0.2 * x, 0, keys - 0.06), (0.6 * x, y, 0.12), color, "gloss", collides=True),
        box((0.26 * x, 0, keys + 0.005), (0.34 * x, 0.88 * y, 0.015), COLORS["white"]),
        box((0.08 * x, 0, 0.82 * z), (0.02, 0.6 * y, 0.2 * z), shade(color, 1.6)),
        box((0.085 * x, 0, 0.84 * z), (0.02, 0.34 * y, 0.2 * z), COLORS["cream"]),
    ]
    for i in range(14):
        at = (0.2 * x, (-0.42 + 0.064 * i) * y, keys + 0.018)
        parts.append(box(at, (0.18 * x, 0.02, 0.016), DARK))
    for side in (-1, 1):
        parts.append(box((0.42 * x, side * 0.46 * y, keys / 2 - 0.06), (0.06, 0.06, keys - 0.12), color, collides=True))
    return parts


def _fireplace(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    parts = [
        box((0, 0, z / 2), (x, y, z), color, collides=True, visible=False),
        box((-0.1 * x, 0, z / 2 - 0.03), (0.8 * x, 0.96 * y, z - 0.06), color),
        box((0, 0, z - 0.03), (x, y, 0.06), COLORS["walnut"], "wood"),
        box((0.3 * x, 0, 0.33 * z), (0.05, 0.56 * y, 0.62 * z), DARK),
        ellipsoid((0.34 * x, 0, 0.16 * z), (0.12, 0.36 * y, 0.26 * z), COLORS["orange"], "glow"),
        ellipsoid((0.36 * x, 0.03, 0.13 * z), (0.12, 0.22 * y, 0.18 * z), COLORS["yellow"], "glow"),
    ]
    for side in (-1, 1):
        parts.append(box((0.33 * x, side * 0.36 * y, 0.45 * z), (0.1, 0.12 * y, 0.9 * z), shade(color, 1.1)))
        parts.append(rod((0.4 * x, -0.2 * y, 0.06), (0.4 * x, 0.2 * y, 0.06), 0.04, COLORS["brown"], "wood"))
    return parts


def _display_cabinet(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    parts = [
        box((0, 0, z / 2), size, color, collides=True, visible=False),
        box((-x / 2 + 0.01, 0, z / 2), (0.02, y, z), shade(color, 0.7), "wood"),
        box((0, 0, 0.15 * z), (x, y, 0.3 * z), color, "wood"),
        box((0, 0, z - 0.03), (x, y, 0.06), shade(color, 0.8), "wood"),
    ]
    for side in (-1, 1):
        parts.append(box((0, side * (y / 2 - 0.02), z / 2), (x, 0.04, z), color, "wood"))
    for level in (0.48, 0.66, 0.82):
        parts.append(box((0, 0, level * z), (x - 0.03, y - 0.08, 0.015), COLORS["silver"], "gloss"))
        for i in range(3):
            at = (0.05, (-0.28 + 0.28 * i) * y, level * z + 0.07)
            tone = ("red", "teal", "yellow", "blue", "orange")[(i + round(level * 10)) % 5]
            parts.append(ellipsoid(at, (0.10, 0.10, 0.14), COLORS[tone], "gloss"))
    return parts


def _dining_table(size: Size, color: Color) -> list[Part]:
    return table(size, color, leg=0.065)


LIVING: dict[str, FurnitureKind] = {
    "sofa": FurnitureKind(_sofa, (0.90, 2.00, 0.80), "blue", noun="sofa", other_nouns=("couch", "settee"),
                          rooms=("living_room",), colors=("blue", "gray", "teal", "red")),
    "armchair": FurnitureKind(_armchair, (0.80, 0.82, 0.80), "teal", noun="armchair", other_nouns=("easy chair",),
                              rooms=("living_room", "bedroom"), colors=("teal", "orange", "gray", "navy")),
    "coffee_table": FurnitureKind(_coffee_table, (0.60, 1.10, 0.42), "oak", has_front=False,
                                  holds_objects=True, noun="coffee table",
                                  other_nouns=("low table",), rooms=("living_room",),
                                  colors=("oak", "walnut", "white")),
    "tv_stand": FurnitureKind(_tv_stand, (0.42, 1.80, 0.50), "walnut", holds_objects=True, top=(-0.2, 0.5, -0.5, 0.5),
                              noun="TV stand", other_nouns=("television stand",), rooms=("living_room",),
                              colors=("walnut", "white", "black")),
    "console_table": FurnitureKind(_console_table, (0.40, 1.20, 0.78), "oak", holds_objects=True,
                                   noun="console table", other_nouns=("hall table",), rooms=("living_room", "bedroom"),
                                   colors=("oak", "walnut", "white")),
    "bookshelf": FurnitureKind(_bookshelf, (0.32, 0.95, 1.90), "oak", noun="bookshelf", other_nouns=("bookcase",),
                               rooms=("living_room", "bedroom"), colors=("oak", "walnut", "white")),
    "rug": FurnitureKind(_rug, (1.80, 2.40, 0.008), "red", has_front=False,
                         solid=False, noun="rug", other_nouns=("carpet",),
                         rooms=("living_room", "bedroom"), colors=("red", "navy", "teal", "beige")),
    "side_table": FurnitureKind(_side_table, (0.50, 0.50, 0.52), "walnut", has_front=False,
                                holds_objects=True, top=ROUND_TOP,
                                noun="side table", other_nouns=("end table",), rooms=("living_room", "bedroom"),
                                colors=("walnut", "oak", "white")),
    "dining_table": FurnitureKind(_dining_table, (0.90, 1.50, 0.75), "oak", has_front=False,
                                  holds_objects=True, noun="dining table",
                                  other_nouns=("dinner table",), rooms=("kitchen", "living_room"),
                                  colors=("oak", "walnut", "white")),
    "dining_chair": FurnitureKind(_dining_chair, (0.44, 0.42, 0.90), "oak", noun="chair", other_nouns=("dining chair",),
                                  rooms=("kitchen", "living_room"), colors=("oak", "walnut", "white")),
    "cabinet": FurnitureKind(cabinet, (0.42, 1.10, 0.80), "white", holds_objects=True, noun="cabinet",
                             other_nouns=("cupboard",), rooms=("living_room", "kitchen", "bedroom"),
                             colors=("white", "oak", "teal")),
    "bench": FurnitureKind(_bench, (0.42, 1.10, 0.45), "green", holds_objects=True, noun="bench",
                           other_nouns=("upholstered bench",), rooms=("bedroom", "living_room"),
                           colors=("green", "navy", "beige")),
    "floor_lamp": FurnitureKind(_floor_lamp, (0.40, 0.40, 1.60), "charcoal", has_front=False, noun="floor lamp",
                                other_nouns=("standard lamp",), rooms=("living_room", "bedroom"),
                                colors=("charcoal", "silver", "oak")),
    "potted_tree": FurnitureKind(_potted_tree, (0.70, 0.70, 1.50), "white", has_front=False, noun="potted tree",
                                 other_nouns=("indoor tree",), rooms=("living_room", "kitchen"),
                                 colors=("white", "charcoal", "terracotta")),
    "round_coffee_table": FurnitureKind(_round_coffee_table, (0.80, 0.80, 0.40), "walnut", has_front=False,
                                        holds_objects=True,
                                        top=ROUND_TOP, noun="round coffee table", other_nouns=("cocktail table",),
                                        rooms=("living_room",), colors=("walnut", "oak", "white")),
    "sideboard": FurnitureKind(_sideboard, (0.45, 1.60, 0.75), "white", holds_objects=True, noun="sideboard",
                               other_nouns=("credenza", "buffet"), rooms=("living_room", "kitchen"),
                               colors=("white", "oak", "navy")),
    "record_cabinet": FurnitureKind(_record_cabinet, (0.42, 0.90, 0.65), "oak", holds_objects=True,
                                    noun="record cabinet", other_nouns=("record stand",), rooms=("living_room",),
                                    colors=("oak", "walnut")),
    "piano": FurnitureKind(_piano, (0.60, 1.45, 1.15), "black", noun="piano", other_nouns=("upright piano",),
                           rooms=("living_room",), colors=("black", "walnut", "white")),
    "fireplace": FurnitureKind(_fireplace, (0.40, 1.30, 1.10), "cream", noun="fireplace", other_nouns=("hearth",),
                               rooms=("living_room",), colors=("cream", "white", "gray")),
    "display_cabinet": FurnitureKind(_display_cabinet, (0.40, 0.90, 1.80), "walnut", noun="display cabinet",
                                     other_nouns=("glass cabinet",), rooms=("living_room",),
                                     colors=("walnut", "white")),
}  # fmt: skip
