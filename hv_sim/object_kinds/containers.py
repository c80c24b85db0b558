"""Boxes, baskets, bins, barrels: what holds other things."""

from __future__ import annotations

from hv_sim.object_kinds.kind import ObjectKind, Size
from hv_sim.parts import COLORS, Color, Part, box, cylinder, ellipsoid, rod, shade, tilt

_DARK = (0.10, 0.09, 0.09)


def _box(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    tape, ink = shade(color, 1.25), shade(color, 0.45)
    return [
        box((0, 0, 0), size, color, "cardboard", collides=True, mass_share=1),
        box((0, 0, z / 2), (0.055, y * 0.99, 0.003), tape, "gloss"),
        box((0, y / 2 - 0.0005, z / 2 - 0.03), (0.055, 0.003, 0.06), tape, "gloss"),
        box((0, -y / 2 + 0.0005, z / 2 - 0.03), (0.055, 0.003, 0.06), tape, "gloss"),
        box((0.0, 0, z / 2 + 0.0005), (0.004, y, 0.003), ink),
        box((x / 2, -0.18 * y, 0.12 * z), (0.003, 0.36 * y, 0.30 * z), COLORS["white"]),
        box((x / 2 + 0.0015, -0.18 * y, 0.16 * z), (0.002, 0.26 * y, 0.04 * z), _DARK),
        box((x / 2 + 0.0015, -0.18 * y, 0.07 * z), (0.002, 0.26 * y, 0.04 * z), _DARK),
        box((-x / 2, 0, 0), (0.003, 0.12 * y, 0.22 * z), ink),
        box((-x / 2, 0, 0.13 * z), (0.003, 0.22 * y, 0.05 * z), ink),
    ]


def _crate(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    parts = [
        box((0, 0, 0), size, color, collides=True, visible=False, mass_share=1),
        box((0, 0, -0.02 * z), (x - 0.03, y - 0.03, 0.95 * z), shade(color, 0.28)),
    ]
    for level in (-0.36, 0.0, 0.36):
        parts.append(box((0, 0, level * z), (x - 0.008, y - 0.008, 0.25 * z), color, "wood"))
    parts.append(box((0, 0, z / 2 - 0.008), (x - 0.05, y - 0.05, 0.016), shade(color, 0.22)))
    post = 0.035
    for sx in (-1, 1):
        for sy in (-1, 1):
            at = (sx * (x - post) / 2, sy * (y - post) / 2, 0.0)
            parts.append(box(at, (post, post, z), shade(color, 0.82), "wood"))
    return parts


def _basket(size: Size, color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    rim = 0.12 * z
    parts = [
        cylinder((0, 0, 0), r, z, color, collides=True, visible=False, mass_share=1),
        cylinder((0, 0, -0.30 * z), 0.90 * r, 0.40 * z, color, "wicker"),
        cylinder((0, 0, 0.05 * z), 0.95 * r, 0.70 * z, color, "wicker"),
        cylinder((0, 0, z / 2 - rim / 2), r, rim, shade(color, 0.72), "wicker"),
        cylinder((0, 0, z / 2), 0.86 * r, 0.003, shade(color, 0.25)),
        ellipsoid((0.25 * r, 0.15 * r, z / 2 - 0.01), (1.0 * r, 0.9 * r, 0.10), COLORS["white"], "fabric"),
        ellipsoid((-0.3 * r, -0.25 * r, z / 2 - 0.01), (0.9 * r, 0.8 * r, 0.08), COLORS["teal"], "fabric"),
    ]
    for side in (-1, 1):
        for arm in (-1, 1):
            parts.append(
                rod(
                    (side * r, arm * 0.3 * r, z / 2 - 0.02),
                    (side * 1.02 * r, 0, z / 2 + 0.045),
                    0.012,
                    shade(color, 0.6),
                )
            )
    return parts


def _trash_bin(size: Size, color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    return [
        cylinder((0, 0, 0), r, z, color, collides=True, visible=False, mass_share=1),
        cylinder((0, 0, -0.40 * z), 0.80 * r, 0.20 * z, color, "metal"),
        cylinder((0, 0, -0.20 * z), 0.86 * r, 0.25 * z, color, "metal"),
        cylinder((0, 0, 0.03 * z), 0.92 * r, 0.25 * z, color, "metal"),
        cylinder((0, 0, 0.28 * z), 0.97 * r, 0.30 * z, color, "metal"),
        cylinder((0, 0, 0.46 * z), r, 0.08 * z, shade(color, 0.6), "metal"),
        cylinder((0, 0, z / 2), 0.90 * r, 0.003, (0.04, 0.04, 0.04)),
        ellipsoid((0.2 * r, 0.1 * r, z / 2 - 0.01), (0.8 * r, 0.7 * r, 0.05), COLORS["white"], "fabric"),
    ]


def _tote(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    lid = 0.10 * z
    parts = [
        box((0, 0, 0), size, color, collides=True, visible=False, mass_share=1),
        box((0, 0, -0.06 * z), (0.90 * x, 0.90 * y, 0.88 * z), color, "gloss"),
        box((0, 0, z / 2 - lid / 2), (x, y, lid), shade(color, 0.55), "gloss"),
        box((0, 0, z / 2), (0.78 * x, 0.78 * y, 0.006), shade(color, 0.75), "gloss"),
        box((0.455 * x, 0, -0.05 * z), (0.01, 0.30 * y, 0.22 * z), COLORS["white"]),
    ]
    for side in (-1, 1):
        parts.append(box((0, side * 0.47 * y, 0.30 * z), (0.22 * x, 0.05 * y, 0.22 * z), COLORS["charcoal"]))
        parts.append(box((0.3 * x, side * 0.455 * y, -0.1 * z), (0.03, 0.012, 0.7 * z), shade(color, 0.85)))
        parts.append(box((-0.3 * x, side * 0.455 * y, -0.1 * z), (0.03, 0.012, 0.7 * z), shade(color, 0.85)))
    return parts


def _laundry_basket(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    parts = [
        box((0, 0, 0), size, color, collides=True, visible=False, mass_share=1),
        box((0, 0, -0.02 * z), (0.92 * x, 0.92 * y, 0.94 * z), shade(color, 0.55)),
        box((0, 0, z / 2 - 0.05 * z), (x, y, 0.10 * z), color, "gloss"),
        box((0, 0, -z / 2 + 0.04 * z), (0.96 * x, 0.96 * y, 0.08 * z), color, "gloss"),
        box((0, 0, 0.0), (0.97 * x, 0.97 * y, 0.05 * z), color, "gloss"),
        ellipsoid((0.15 * x, 0.1 * y, z / 2), (0.55 * x, 0.55 * y, 0.22), COLORS["white"], "fabric"),
        ellipsoid((-0.18 * x, -0.15 * y, z / 2), (0.5 * x, 0.5 * y, 0.18), COLORS["blue"], "fabric"),
        ellipsoid((-0.1 * x, 0.24 * y, z / 2), (0.4 * x, 0.35 * y, 0.15), COLORS["pink"], "fabric"),
    ]
    for i in range(4):
        at = (-0.36 + 0.24 * i) * y
        parts.append(box((0, at, 0), (0.975 * x, 0.07 * y, 0.9 * z), color, "gloss"))
    for i in range(4):
        at = (-0.36 + 0.24 * i) * x
        parts.append(box((at, 0, 0), (0.07 * x, 0.975 * y, 0.9 * z), color, "gloss"))
    return parts


def _barrel(size: Size, color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    iron = COLORS["charcoal"]
    parts = [
        cylinder((0, 0, 0), r, z, color, collides=True, visible=False, mass_share=1),
        cylinder((0, 0, 0), r, 0.40 * z, color, "wood"),
        cylinder((0, 0, 0), 0.95 * r, 0.66 * z, shade(color, 0.97), "wood"),
        cylinder((0, 0, 0), 0.88 * r, 0.86 * z, shade(color, 0.94), "wood"),
        cylinder((0, 0, 0), 0.82 * r, 0.998 * z, shade(color, 0.9), "wood"),
        cylinder((0, 0, z / 2), 0.72 * r, 0.006, shade(color, 0.6), "wood"),
    ]
    for level, width in ((-0.38, 0.91), (-0.22, 1.0), (0.22, 1.0), (0.38, 0.91)):
        parts.append(cylinder((0, 0, level * z), width * r, 0.06 * z, iron, "metal"))
    return parts


def _drum(size: Size, color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    parts = [
        cylinder((0, 0, 0), r, z, color, collides=True, visible=False, mass_share=1),
        cylinder((0, 0, 0), 0.96 * r, 0.98 * z, color, "gloss"),
        cylinder((0, 0, z / 2), 0.88 * r, 0.006, shade(color, 0.7), "gloss"),
        cylinder((0.45 * r, 0, z / 2 + 0.001), 0.14 * r, 0.012, COLORS["silver"], "metal"),
        box((0.955 * r, 0, 0.0), (0.012, 0.5 * r, 0.22 * z), COLORS["yellow"]),
    ]
    for level in (-0.485, -0.17, 0.17, 0.485):
        parts.append(cylinder((0, 0, level * z), r, 0.03 * z, shade(color, 0.8), "gloss"))
    return parts


def _bucket(size: Size, color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    parts = [cylinder((0, 0, 0), r, z, color, collides=True, visible=False, mass_share=1)]
    for i in range(5):
        parts.append(cylinder((0, 0, (-0.4 + 0.2 * i) * z), (0.76 + 0.05 * i) * r, 0.201 * z, color, "gloss"))
    parts += [
        cylinder((0, 0, z / 2 - 0.03 * z), r, 0.06 * z, shade(color, 0.8), "gloss"),
        cylinder((0, 0, z / 2), 0.90 * r, 0.003, (0.45, 0.62, 0.72), "gloss"),
    ]
    steel = COLORS["silver"]
    top = (0.0, 0.0, z / 2 + 0.55 * r)
    for side in (-1, 1):
        parts.append(rod((0, side * r, z / 2 - 0.02), (0, side * 0.62 * r, z / 2 + 0.42 * r), 0.006, steel, "metal"))
        parts.append(rod((0, side * 0.62 * r, z / 2 + 0.42 * r), top, 0.006, steel, "metal"))
    return parts


def _gift_box(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    ribbon = COLORS["yellow"] if color != COLORS["yellow"] else COLORS["red"]
    parts = [
        box((0, 0, 0), size, color, collides=True, visible=False, mass_share=1),
        box((0, 0, -0.08 * z), (0.96 * x, 0.96 * y, 0.84 * z), color),
        box((0, 0, 0.39 * z), (x, y, 0.22 * z), shade(color, 0.85)),
        box((0, 0, 0.002), (0.16 * x, y * 1.004, z), ribbon, "gloss"),
        box((0, 0, 0.002), (x * 1.004, 0.16 * y, z), ribbon, "gloss"),
        ellipsoid((0, 0, z / 2 + 0.02), (0.06, 0.06, 0.05), ribbon, "gloss"),
    ]
    for side in (-1, 1):
        parts.append(
            ellipsoid((0, side * 0.075, z / 2 + 0.035), (0.06, 0.13, 0.07), ribbon, "gloss", quat=tilt(side * 0.5, 0))
        )
    return parts


def _cooler(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    return [
        box((0, 0, 0), size, color, collides=True, visible=False, mass_share=1),
        box((0, 0, -0.13 * z), (0.96 * x, 0.96 * y, 0.74 * z), color, "gloss"),
        box((0, 0, 0.37 * z), (x, y, 0.26 * z), COLORS["white"], "gloss"),
        box((0, 0, 0.245 * z), (0.985 * x, 0.985 * y, 0.02), COLORS["charcoal"]),
        box((x / 2, 0, 0.22 * z), (0.02, 0.12 * y, 0.18 * z), COLORS["charcoal"]),
        rod((0, -0.36 * y, z / 2 + 0.03), (0, 0.36 * y, z / 2 + 0.03), 0.013, COLORS["charcoal"]),
        rod((0, -0.36 * y, z / 2 - 0.02), (0, -0.36 * y, z / 2 + 0.03), 0.012, COLORS["charcoal"]),
        rod((0, 0.36 * y, z / 2 - 0.02), (0, 0.36 * y, z / 2 + 0.03), 0.012, COLORS["charcoal"]),
        box((0.482 * x, 0, -0.14 * z), (0.006, 0.5 * y, 0.2 * z), COLORS["white"]),
    ]


def _chest(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    brass = COLORS["yellow"]
    parts = [
        box((0, 0, 0), size, color, collides=True, visible=False, mass_share=1),
        box((0, 0, -0.12 * z), (x, y, 0.76 * z), color, "wood"),
        box((0, 0, 0.33 * z), (0.985 * x, 0.985 * y, 0.12 * z), shade(color, 0.8), "wood"),
        box((0, 0, 0.44 * z), (0.80 * x, 0.985 * y, 0.12 * z), shade(color, 0.9), "wood"),
        box((x / 2, 0, 0.2 * z), (0.02, 0.12 * y, 0.2 * z), brass, "metal"),
        box((0, 0, 0.26 * z), (1.004 * x, 1.004 * y, 0.03 * z), brass, "metal"),
        box((0, 0, -z / 2 + 0.03 * z), (1.004 * x, 1.004 * y, 0.05 * z), brass, "metal"),
    ]
    for side in (-1, 1):
        parts.append(box((0, side * 0.36 * y, 0), (1.004 * x, 0.06 * y, 0.99 * z), shade(color, 0.45), "wood"))
    return parts


CONTAINERS: dict[str, ObjectKind] = {
    "box": ObjectKind(_box, (0.30, 0.30, 0.28), 2.0, "tan", category="box", noun="cardboard box",
                      other_nouns=("box", "carton", "parcel"), colors=("tan", "brown", "white")),
    "crate": ObjectKind(_crate, (0.34, 0.38, 0.30), 3.0, "oak", category="crate", noun="wooden crate",
                        other_nouns=("crate", "slatted crate"), colors=("oak", "walnut", "green")),
    "basket": ObjectKind(_basket, (0.34, 0.34, 0.28), 1.2, "tan", round=True, category="basket",
                         noun="wicker basket", other_nouns=("basket", "woven basket"),
                          colors=("tan", "brown", "cream")),
    "trash_bin": ObjectKind(_trash_bin, (0.28, 0.28, 0.36), 1.0, "charcoal", round=True,
                            category="bin", noun="trash bin", other_nouns=("waste bin", "trash can", "garbage can"),
                            colors=("charcoal", "silver", "teal", "white"), support="floor"),
    "tote": ObjectKind(_tote, (0.32, 0.40, 0.26), 2.5, "blue", category="crate", noun="storage tote",
                       other_nouns=("plastic tote", "storage box"), colors=("blue", "green", "gray", "red")),
    "laundry_basket": ObjectKind(_laundry_basket, (0.34, 0.42, 0.30), 1.6, "white", category="basket",
                                 noun="laundry basket", other_nouns=("washing basket", "hamper"),
                                 colors=("white", "teal", "pink", "beige"), support="floor"),
    "barrel": ObjectKind(_barrel, (0.34, 0.34, 0.44), 5.0, "oak", round=True, category="barrel",
                         noun="wooden barrel", other_nouns=("keg", "cask"), colors=("oak", "walnut"),
                         support="floor"),
    "drum": ObjectKind(_drum, (0.34, 0.34, 0.46), 6.0, "blue", round=True, category="barrel", noun="metal drum",
                       other_nouns=("oil drum", "steel drum"), colors=("blue", "red", "green"), support="floor",
                       held_out=True),
    "bucket": ObjectKind(_bucket, (0.28, 0.28, 0.27), 2.2, "red", round=True, category="bucket",
                         noun="bucket", other_nouns=("pail", "mop bucket"), colors=("red", "blue", "yellow", "gray"),
                         support="floor"),
    "gift_box": ObjectKind(_gift_box, (0.26, 0.28, 0.24), 1.2, "purple", category="box",
                           noun="gift box", other_nouns=("present", "wrapped gift"),
                           colors=("purple", "red", "green", "pink")),
    "cooler": ObjectKind(_cooler, (0.28, 0.40, 0.30), 3.0, "red", category="cooler",
                         noun="cool box", other_nouns=("cooler", "picnic cooler"), colors=("red", "blue", "teal"),
                         held_out=True),
    "chest": ObjectKind(_chest, (0.30, 0.42, 0.30), 4.5, "walnut", category="chest",
                        noun="wooden chest", other_nouns=("treasure chest", "keepsake chest"),
                        colors=("walnut", "oak"), support="floor"),
}  # fmt: skip
