"""Chairs and stools."""

from __future__ import annotations

from hv_sim.object_kinds.kind import ObjectKind, Size
from hv_sim.parts import COLORS, Color, Part, box, cylinder, ellipsoid, rod, shade


def _stool(size: Size, color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    seat = min(0.14, 0.4 * z)
    leg = z - seat
    foot = 0.72 * r
    wood = COLORS["walnut"]
    parts = [
        cylinder((0, 0, z / 2 - seat / 2), r, seat, color, "fabric", collides=True, visible=False, mass_share=0.6),
        cylinder((0, 0, z / 2 - seat / 2), 0.985 * r, seat * 0.96, color, "fabric"),
        cylinder((0, 0, z / 2 - 0.02), r, 0.012, shade(color, 0.7), "fabric"),
        cylinder((0, 0, z / 2 - seat + 0.02), r, 0.012, shade(color, 0.7), "fabric"),
        ellipsoid((0, 0, z / 2), (0.04, 0.04, 0.02), shade(color, 0.6)),
    ]
    for sx in (-1, 1):
        for sy in (-1, 1):
            at = (sx * foot * 0.7071, sy * foot * 0.7071, -z / 2 + leg / 2)
            parts.append(cylinder(at, 0.02, leg, wood, "wood", collides=True, mass_share=0.1))
    rail, reach = -z / 2 + 0.35 * leg, foot * 0.7071
    for side in (-1, 1):
        parts.append(rod((-reach, side * reach, rail), (reach, side * reach, rail), 0.009, wood, "wood"))
    return parts


def _chair(size: Size, color: Color, wood: Color, cushion: bool) -> list[Part]:
    x, y, z = size
    seat_top, slab, leg = 0.54 * z, 0.09, 0.036
    seat_z = seat_top - slab / 2 - z / 2
    below = seat_top - slab
    parts = [box((0, 0, seat_z), (x, y, slab), wood, "wood", collides=True, visible=False, mass_share=0.6)]
    parts.append(box((0, 0, seat_z - 0.02), (0.97 * x, y, 0.05), wood, "wood"))
    top = box((0.01, 0, seat_z + 0.025), (0.94 * x, 0.97 * y, 0.045), color, "fabric" if cushion else "wood")
    parts.append(top)
    back = z - seat_top
    parts.append(box((-x / 2 + 0.02, 0, z / 2 - back / 2), (0.04, y, back), wood, "wood", collides=True, visible=False))
    for sx in (-1, 1):
        for sy in (-1, 1):
            at = (sx * (x / 2 - leg / 2), sy * (y / 2 - leg / 2), -z / 2 + below / 2)
            parts.append(box(at, (leg, leg, below), wood, "wood", collides=True, mass_share=0.1))
    for sy in (-1, 1):
        parts.append(box((-x / 2 + 0.02, sy * (y / 2 - leg / 2), z / 2 - back / 2), (leg, leg, back), wood, "wood"))
    if cushion:
        parts.append(box((-x / 2 + 0.025, 0, z / 2 - 0.42 * back), (0.035, 0.8 * y, 0.7 * back), color, "fabric"))
    else:
        for level in (0.12, 0.42, 0.72):
            parts.append(box((-x / 2 + 0.02, 0, z / 2 - level * back), (0.022, 0.86 * y, 0.16 * back), color, "wood"))
    return parts


def _dining_chair(size: Size, color: Color) -> list[Part]:
    return _chair(size, color, COLORS["walnut"], cushion=True)


def _kids_chair(size: Size, color: Color) -> list[Part]:
    return _chair(size, color, shade(color, 0.85), cushion=False)


def _bar_stool(size: Size, color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    seat, steel = 0.10, COLORS["silver"]
    foot = 0.04
    parts = [
        cylinder((0, 0, z / 2 - seat / 2), r, seat, color, "fabric", collides=True, mass_share=0.35),
        cylinder((0, 0, z / 2 - seat), 0.98 * r, 0.015, COLORS["charcoal"]),
        cylinder((0, 0, 0), 0.03, z - seat - foot, steel, "metal", collides=True, mass_share=0.1),
        cylinder((0, 0, -z / 2 + foot / 2), 0.95 * r, foot, steel, "metal", collides=True, mass_share=0.55),
        cylinder((0, 0, -0.12 * z), 0.07, 0.02, steel, "metal"),
    ]
    for side in (-1, 1):
        parts.append(rod((0.12, side * 0.1, -0.2 * z), (0, side * 0.02, -0.2 * z), 0.01, steel, "metal"))
    parts.append(rod((0.12, -0.1, -0.2 * z), (0.12, 0.1, -0.2 * z), 0.01, steel, "metal"))
    return parts


def _pouf(size: Size, color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    parts = [
        cylinder((0, 0, 0), r, z, color, collides=True, visible=False, mass_share=1),
        cylinder((0, 0, 0), r, 0.62 * z, color, "fabric"),
        ellipsoid((0, 0, 0.12 * z), (2 * r, 2 * r, 0.76 * z), color, "fabric"),
        ellipsoid((0, 0, -0.12 * z), (2 * r, 2 * r, 0.76 * z), shade(color, 0.9), "fabric"),
        ellipsoid((0, 0, z / 2), (0.06, 0.06, 0.03), shade(color, 0.6)),
    ]
    for level in (-0.2, 0.2):
        parts.append(cylinder((0, 0, level * z), 1.004 * r, 0.012, shade(color, 0.6), "fabric"))
    return parts


def _step_stool(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    top = 0.12 * z + 0.03
    parts = [
        box((0, 0, z / 2 - top / 2), (x, y, top), color, "wood", collides=True, mass_share=0.5),
        box((0, 0, z / 2), (0.8 * x, 0.85 * y, 0.004), COLORS["charcoal"]),
    ]
    for side in (-1, 1):
        at = (0, side * (y / 2 - 0.02), -top / 2)
        parts.append(box(at, (0.9 * x, 0.04, z - top), shade(color, 0.85), "wood", collides=True, mass_share=0.25))
    parts.append(box((0, 0, -0.1 * z), (0.03, y - 0.06, 0.1 * z), shade(color, 0.75), "wood"))
    return parts


SEATS: dict[str, ObjectKind] = {
    "stool": ObjectKind(_stool, (0.34, 0.34, 0.42), 2.5, "teal", round=True, category="stool",
                        noun="stool", other_nouns=("upholstered stool", "round stool"),
                        colors=("teal", "red", "gray", "navy"), support="floor"),
    "dining_chair": ObjectKind(_dining_chair, (0.40, 0.40, 0.82), 3.5, "navy", max_height_m=0.95,
                               category="chair", noun="dining chair", other_nouns=("chair", "upholstered chair"),
                               colors=("navy", "red", "gray", "green"), support="floor", blocked=(0,)),
    "kids_chair": ObjectKind(_kids_chair, (0.32, 0.32, 0.58), 2.0, "yellow", category="chair",
                             noun="children's chair", other_nouns=("kids' chair", "toddler's chair"),
                             colors=("yellow", "red", "blue", "green"), support="floor", blocked=(0,), held_out=True),
    "bar_stool": ObjectKind(_bar_stool, (0.36, 0.36, 0.68), 4.0, "red", round=True,
                            max_height_m=0.8, category="stool", noun="bar stool", other_nouns=("counter stool",),
                            colors=("red", "black", "cream"), support="floor"),
    "pouf": ObjectKind(_pouf, (0.42, 0.42, 0.34), 2.5, "orange", round=True, category="pouf",
                       noun="pouf", other_nouns=("floor cushion", "ottoman"),
                       colors=("orange", "teal", "pink", "gray"), support="floor"),
    "step_stool": ObjectKind(_step_stool, (0.28, 0.38, 0.26), 1.8, "oak", category="stool",
                             noun="step stool", other_nouns=("footstool",), colors=("oak", "white", "red"),
                             support="floor"),
}  # fmt: skip
