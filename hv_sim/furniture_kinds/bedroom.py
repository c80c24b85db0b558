"""Furniture of a bedroom."""

from __future__ import annotations

from hv_sim.furniture_kinds.kind import FurnitureKind, Size, cabinet, drawers, legs, table
from hv_sim.parts import COLORS, Color, Part, box, ellipsoid, rod, shade


def _bed(size: Size, color: Color, pillows: int) -> list[Part]:
    x, y, z = size
    wood, sheet = COLORS["walnut"], COLORS["white"]
    mattress = 0.5
    parts = [
        box((0, 0, 0.24), (x, y, 0.48), wood, collides=True, visible=False),
        box((-x / 2 + 0.03, 0, z / 2), (0.06, y, z), wood, "wood", collides=True),
        box((0, 0, 0.16), (x, y, 0.18), wood, "wood"),
        box((0.02, 0, 0.36), (x - 0.08, y - 0.06, 0.24), sheet, "fabric"),
        box((0.12 * x, 0, 0.40), (0.74 * x, y + 0.02, 0.20), color, "fabric"),
        box((-0.24 * x, 0, 0.505), (0.12 * x, y + 0.01, 0.02), shade(color, 1.25), "fabric"),
    ]
    for i in range(pillows):
        at = (-0.38 * x, (0.0 if pillows == 1 else (-0.24 + 0.48 * i)) * y, mattress + 0.03)
        parts.append(ellipsoid(at, (0.40, 0.66 * y / pillows + 0.1, 0.16), sheet, "fabric"))
    for side in (-1, 1):
        parts.append(box((x / 2 - 0.05, side * (y / 2 - 0.05), 0.05), (0.08, 0.08, 0.1), shade(wood, 0.7)))
    return parts


def _double_bed(size: Size, color: Color) -> list[Part]:
    return _bed(size, color, 2)


def _single_bed(size: Size, color: Color) -> list[Part]:
    return _bed(size, color, 1)


def _wardrobe(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    parts = cabinet(size, color, doors=max(2, round(y / 0.5)))
    parts.append(box((0, 0, z - 0.06), (x + 0.01, y + 0.01, 0.08), shade(color, 0.7), "wood"))
    return parts


def _dresser(size: Size, color: Color) -> list[Part]:
    return drawers(size, color, 4, 2)


def _nightstand(size: Size, color: Color) -> list[Part]:
    return drawers(size, color, 2, 1)


def _desk(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    parts = table(size, color, leg=0.05)
    parts.append(box((-0.05, 0.3 * y, z - 0.24), (x - 0.16, 0.28 * y, 0.36), shade(color, 0.9), "wood"))
    for i in range(2):
        at = (x / 2 - 0.125, 0.3 * y, z - 0.15 - 0.17 * i)
        parts.append(box(at, (0.012, 0.25 * y, 0.14), color, "wood"))
        parts.append(box((at[0] + 0.012, at[1], at[2]), (0.014, 0.10, 0.014), COLORS["silver"], "metal"))
    return parts


def _vanity(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    parts = table(size, color, leg=0.05)
    parts += [
        box((-x / 2 + 0.03, 0, z + 0.34), (0.04, 0.62 * y, 0.66), shade(color, 0.8), "wood", collides=True),
        box((-x / 2 + 0.052, 0, z + 0.34), (0.006, 0.54 * y, 0.58), (0.72, 0.82, 0.88), "gloss"),
        box((0, 0.26 * y, z - 0.09), (x - 0.06, 0.3 * y, 0.10), shade(color, 0.9), "wood"),
        box((0, -0.26 * y, z - 0.09), (x - 0.06, 0.3 * y, 0.10), shade(color, 0.9), "wood"),
    ]
    return parts


def _low_bookcase(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    parts = [
        box((0, 0, z / 2), size, color, collides=True, visible=False),
        box((-x / 2 + 0.01, 0, z / 2), (0.02, y, z), shade(color, 0.6), "wood"),
        box((0, 0, z - 0.015), (x, y, 0.03), color, "wood"),
        box((0, 0, 0.04), (x, y, 0.06), color, "wood"),
        box((0, 0, z / 2), (x, y - 0.04, 0.025), color, "wood"),
    ]
    for at in (-y / 2 + 0.015, 0.0, y / 2 - 0.015):
        parts.append(box((0, at, z / 2), (x, 0.03, z), color, "wood"))
    turned = (0.7071067811865476, 0.0, 0.0, 0.7071067811865476)
    for i, (across, level) in enumerate(((-0.25, 0.26), (0.25, 0.26), (-0.25, 0.72))):
        half = ((0.2, 0.14, 0.18)[i] * y, 0.36 * x, 0.16 * z)
        parts.append(Part("box", half, (-0.02, across * y, level * z), (1.0, 1.0, 1.0), "books", quat=turned))
    return parts


def _shoe_rack(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    parts = [box((0, 0, z - 0.02), (x, y, 0.04), color, "wood", collides=True)]
    parts += legs(x, y, z - 0.04, 0.02, 0.04, shade(color, 0.8))
    tones = ("red", "black", "white", "brown", "blue", "charcoal")
    for row, level in enumerate((0.14, 0.52)):
        parts.append(box((0, 0, level * z), (x - 0.02, y - 0.06, 0.02), color, "wood"))
        for i in range(3):
            tone = COLORS[tones[(3 * row + i) % 6]]
            for side in (-1, 1):
                at = (0.02, (-0.3 + 0.3 * i) * y + side * 0.05, level * z + 0.05)
                parts.append(ellipsoid(at, (0.26, 0.085, 0.09), tone))
    return parts


def _clothes_rack(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    parts = [
        box((0, 0, 0.03), (x, y, 0.06), COLORS["charcoal"], "metal", collides=True, visible=False),
        box((0, 0, 0.62 * z), (0.6 * x, 0.8 * y, 0.76 * z), color, collides=True, visible=False),
        rod((0, -y / 2 + 0.03, z - 0.03), (0, y / 2 - 0.03, z - 0.03), 0.016, COLORS["silver"], "metal"),
    ]
    for side in (-1, 1):
        at = side * (y / 2 - 0.03)
        parts.append(rod((0, at, 0.03), (0, at, z - 0.03), 0.016, COLORS["silver"], "metal"))
        parts.append(rod((-x / 2, at, 0.03), (x / 2, at, 0.03), 0.018, COLORS["silver"], "metal"))
    tones = ("navy", "red", "beige", "teal", "pink", "charcoal")
    for i, tone in enumerate(tones):
        long = (0.55, 0.42, 0.6, 0.45, 0.5, 0.4)[i] * z
        middle = (0.0, (-0.36 + 0.144 * i) * y, z - 0.08 - long / 2)
        parts.append(box(middle, (0.5 * x, 0.08 * y, long), COLORS[tone], "fabric"))
    return parts


def _standing_mirror(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    return [
        box((0, 0, z / 2), (0.06, y, z), color, collides=True, visible=False),
        box((0, 0, 0.03), (x, y, 0.06), shade(color, 0.8), "wood", collides=True),
        box((0, 0, z / 2), (0.04, y, z), color, "wood"),
        box((0.022, 0, z / 2), (0.006, 0.86 * y, 0.92 * z), (0.74, 0.84, 0.90), "gloss"),
        box((0.026, 0.1 * y, 0.6 * z), (0.004, 0.1 * y, 0.5 * z), (0.84, 0.91, 0.95), "gloss"),
    ]


BEDROOM: dict[str, FurnitureKind] = {
    "double_bed": FurnitureKind(_double_bed, (2.05, 1.60, 1.00), "navy", has_front=False,
                                noun="double bed", other_nouns=("bed",),
                                rooms=("bedroom",), colors=("navy", "teal", "beige", "gray")),
    "single_bed": FurnitureKind(_single_bed, (2.00, 0.95, 0.90), "orange", has_front=False,
                                noun="single bed", other_nouns=("bed",),
                                rooms=("bedroom",), colors=("orange", "green", "purple", "blue")),
    "wardrobe": FurnitureKind(_wardrobe, (0.60, 1.40, 2.00), "white", noun="wardrobe", other_nouns=("closet",),
                              rooms=("bedroom",), colors=("white", "oak", "walnut")),
    "dresser": FurnitureKind(_dresser, (0.48, 1.10, 0.82), "oak", holds_objects=True, noun="dresser",
                             other_nouns=("chest of drawers",), rooms=("bedroom",), colors=("oak", "white", "teal")),
    "nightstand": FurnitureKind(_nightstand, (0.42, 0.46, 0.54), "oak", holds_objects=True, noun="nightstand",
                                other_nouns=("bedside cabinet",), rooms=("bedroom",),
                                colors=("oak", "white", "walnut")),
    "desk": FurnitureKind(_desk, (0.62, 1.25, 0.74), "walnut", holds_objects=True, noun="desk",
                          other_nouns=("writing desk", "study table"), rooms=("bedroom", "living_room"),
                          colors=("walnut", "oak", "white")),
    "vanity": FurnitureKind(_vanity, (0.46, 1.00, 0.76), "white", holds_objects=True, top=(-0.3, 0.5, -0.5, 0.5),
                            noun="vanity", other_nouns=("dressing table",), rooms=("bedroom",),
                            colors=("white", "pink", "oak")),
    "low_bookcase": FurnitureKind(_low_bookcase, (0.36, 1.10, 0.72), "white", holds_objects=True, noun="low bookcase",
                                  other_nouns=("low shelf",), rooms=("bedroom", "living_room"),
                                  colors=("white", "oak", "walnut")),
    "shoe_rack": FurnitureKind(_shoe_rack, (0.34, 0.90, 0.46), "oak", holds_objects=True, noun="shoe rack",
                               other_nouns=("shoe bench",), rooms=("bedroom",), colors=("oak", "white")),
    "clothes_rack": FurnitureKind(_clothes_rack, (0.46, 1.20, 1.55), "silver", has_front=False, noun="clothes rack",
                                  other_nouns=("garment rack",), rooms=("bedroom",), colors=("silver",)),
    "standing_mirror": FurnitureKind(_standing_mirror, (0.36, 0.60, 1.65), "oak", noun="mirror",
                                     other_nouns=("standing mirror",), rooms=("bedroom",), colors=("oak", "white")),
}  # fmt: skip
