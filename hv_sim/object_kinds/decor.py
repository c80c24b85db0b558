"""Plants, lamps, vases, clocks: what decorates a room."""

from __future__ import annotations

import numpy as np

from hv_sim.object_kinds.kind import ObjectKind, Size
from hv_sim.parts import COLORS, Color, Part, box, cylinder, ellipsoid, rod, shade, tilt

_DARK = (0.10, 0.09, 0.09)


def _plant(size: Size, color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    pot = min(0.24, 0.48 * z)
    top = -z / 2 + pot
    leaf = (0.20, 0.50, 0.20)
    parts = [
        cylinder((0, 0, -z / 2 + pot / 2), r, pot, color, collides=True, visible=False, mass_share=0.9),
        cylinder((0, 0, -z / 2 + 0.40 * pot), 0.90 * r, 0.80 * pot, color),
        cylinder((0, 0, top - 0.12 * pot), r, 0.24 * pot, shade(color, 1.12)),
        cylinder((0, 0, top), 0.88 * r, 0.004, (0.16, 0.10, 0.07)),
        cylinder((0, 0, (z / 2 + top) / 2), 0.6 * r, z / 2 - top, leaf, collides=True, visible=False, mass_share=0.1),
    ]
    crown = z / 2 - top
    for i in range(6):  # a ring of leaning leaves around an upright one
        angle, lean = i * 2 * np.pi / 6, 0.55 if i % 2 else 0.85
        out = 0.55 * r
        at = (out * np.cos(angle), out * np.sin(angle), top + crown * (0.52 if i % 2 else 0.36))
        length = crown * (0.92 if i % 2 else 0.75)
        parts.append(
            ellipsoid(
                at, (0.035, 0.55 * r, length), shade(leaf, 0.8 + 0.12 * (i % 3)), "matte", quat=tilt(0, lean, angle)
            )
        )
    parts.append(ellipsoid((0, 0, top + 0.5 * crown), (0.5 * r, 0.5 * r, crown), shade(leaf, 1.15)))
    return parts


def _lamp(size: Size, color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    hood = 0.48 * z
    base = 0.18 * z
    warm = (1.0, 0.92, 0.72)
    stem = z - hood - base
    return [
        cylinder((0, 0, z / 2 - hood / 2), r, hood, warm, "glow", collides=True, visible=False, mass_share=0.25),
        cylinder((0, 0, z / 2 - 0.30 * hood), 0.90 * r, 0.58 * hood, warm, "glow"),
        cylinder((0, 0, z / 2 - 0.70 * hood), 0.98 * r, 0.58 * hood, warm, "glow"),
        cylinder((0, 0, z / 2 - hood + 0.008), r, 0.016, shade(color, 0.9)),
        cylinder((0, 0, z / 2 - 0.005), 0.92 * r, 0.012, shade(color, 0.9)),
        cylinder((0, 0, z / 2), 0.5 * r, 0.003, (1.0, 1.0, 0.9), "glow"),
        cylinder((0, 0, -z / 2 + base + stem / 2), 0.025, stem, color, "gloss", collides=True, mass_share=0.1),
        cylinder(
            (0, 0, -z / 2 + base / 2), 0.70 * r, base, color, "gloss", collides=True, visible=False, mass_share=0.65
        ),
        cylinder((0, 0, -z / 2 + 0.2 * base), 0.70 * r, 0.4 * base, color, "gloss"),
        ellipsoid((0, 0, -z / 2 + 0.4 * base), (1.3 * r, 1.3 * r, 1.3 * base), color, "gloss"),
    ]


def _vase(size: Size, color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    belly = 0.70 * z
    middle = -z / 2 + belly / 2
    neck = z - belly
    return [
        cylinder((0, 0, middle), r, belly, color, collides=True, visible=False, mass_share=0.9),
        cylinder((0, 0, z / 2 - neck / 2), 0.5 * r, neck, color, collides=True, visible=False, mass_share=0.1),
        cylinder((0, 0, -z / 2 + 0.03 * z), 0.62 * r, 0.06 * z, shade(color, 0.8), "gloss"),
        ellipsoid((0, 0, middle - 0.04 * z), (2 * r, 2 * r, 0.92 * belly), color, "gloss"),
        cylinder((0, 0, middle), 0.995 * r, 0.34 * belly, color, "gloss"),
        ellipsoid((0, 0, middle + 0.06 * z), (1.98 * r, 1.98 * r, 0.92 * belly), color, "gloss"),
        cylinder((0, 0, z / 2 - 0.5 * neck), 0.40 * r, neck, color, "gloss"),
        cylinder((0, 0, z / 2 - 0.02), 0.55 * r, 0.04, shade(color, 1.1), "gloss"),
        cylinder((0, 0, z / 2), 0.40 * r, 0.003, _DARK),
        cylinder((0, 0, middle + 0.09 * z), r, 0.012, COLORS["yellow"], "gloss"),
        cylinder((0, 0, middle - 0.09 * z), r, 0.012, COLORS["yellow"], "gloss"),
    ]


def _cactus(size: Size, color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    pot, green = 0.44 * z, (0.24, 0.48, 0.26)
    top = -z / 2 + pot
    stem = z - pot
    return [
        cylinder((0, 0, -z / 2 + pot / 2), r, pot, color, collides=True, visible=False, mass_share=0.9),
        cylinder((0, 0, -z / 2 + 0.42 * pot), 0.9 * r, 0.84 * pot, color),
        cylinder((0, 0, top - 0.12 * pot), r, 0.24 * pot, shade(color, 1.1)),
        cylinder((0, 0, top), 0.88 * r, 0.004, COLORS["tan"]),
        cylinder((0, 0, top + stem / 2), 0.36 * r, stem, green, collides=True, visible=False, mass_share=0.1),
        rod((0, 0, top), (0, 0, z / 2 - 0.06), 0.06, green),
        rod((0, 0.03, top + 0.30 * stem), (0, 0.75 * r, top + 0.36 * stem), 0.032, shade(green, 1.1)),
        rod((0, 0.75 * r, top + 0.36 * stem), (0, 0.75 * r, top + 0.70 * stem), 0.032, shade(green, 1.1)),
        rod((0, -0.03, top + 0.45 * stem), (0, -0.7 * r, top + 0.50 * stem), 0.03, shade(green, 1.1)),
        rod((0, -0.7 * r, top + 0.50 * stem), (0, -0.7 * r, top + 0.80 * stem), 0.03, shade(green, 1.1)),
        ellipsoid((0.03, 0, z / 2 - 0.015), (0.05, 0.05, 0.03), COLORS["pink"]),
    ]


def _floor_lamp(size: Size, color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    hood, base, warm = 0.24 * z, 0.035, (1.0, 0.92, 0.72)
    return [
        cylinder((0, 0, z / 2 - hood / 2), r, hood, warm, "glow", collides=True, visible=False, mass_share=0.15),
        cylinder((0, 0, z / 2 - 0.30 * hood), 0.88 * r, 0.6 * hood, warm, "glow"),
        cylinder((0, 0, z / 2 - 0.70 * hood), 0.98 * r, 0.6 * hood, warm, "glow"),
        cylinder((0, 0, z / 2 - hood + 0.01), r, 0.02, shade(color, 0.9)),
        cylinder((0, 0, (base - hood) / 2), 0.02, z - hood - base, color, "metal", collides=True, mass_share=0.15),
        cylinder((0, 0, -z / 2 + base / 2), 0.95 * r, base, color, "metal", collides=True, mass_share=0.7),
    ]


def _lantern(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    base, roof = 0.12 * z, 0.24 * z
    parts = [
        box((0, 0, 0), size, color, collides=True, visible=False, mass_share=1),
        box((0, 0, -z / 2 + base / 2), (x, y, base), color, "metal"),
        box((0, 0, z / 2 - roof + 0.02), (x, y, 0.04), color, "metal"),
        box((0, 0, z / 2 - 0.55 * roof), (0.66 * x, 0.66 * y, 0.5 * roof), color, "metal"),
        box((0, 0, z / 2 - 0.16 * roof), (0.34 * x, 0.34 * y, 0.34 * roof), color, "metal"),
        box((0, 0, -0.06 * z), (0.84 * x, 0.84 * y, 0.6 * z), (0.95, 0.88, 0.66), "glow"),
        cylinder((0, 0, -0.16 * z), 0.2 * x, 0.36 * z, COLORS["cream"], "glow"),
    ]
    for sx in (-1, 1):
        for sy in (-1, 1):
            parts.append(box((sx * 0.45 * x, sy * 0.45 * y, -0.06 * z), (0.08 * x, 0.08 * y, 0.66 * z), color, "metal"))
    return parts


def _globe(size: Size, color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    base, centre = 0.14 * z, z / 2 - r
    sea, land = (0.20, 0.45, 0.72), (0.36, 0.58, 0.30)
    return [
        cylinder((0, 0, centre), r, 0.9 * r, sea, collides=True, visible=False, mass_share=0.5),
        cylinder((0, 0, z / 2 - r / 2 + 0.0), 0.6 * r, r, sea, collides=True, visible=False, mass_share=0.0),
        cylinder((0, 0, -z / 2 + base / 2), 0.75 * r, base, color, "wood", collides=True, mass_share=0.5),
        cylinder((0, 0, (centre - r - z / 2 + base) / 2), 0.03, 2 * r * 0.3 + 0.02, color, "wood"),
        ellipsoid((0, 0, centre), (2 * r, 2 * r, 2 * r), sea, "gloss"),
        ellipsoid((0.55 * r, 0.2 * r, centre + 0.30 * r), (0.95 * r, 1.0 * r, 1.1 * r), land),
        ellipsoid((0.45 * r, -0.5 * r, centre - 0.25 * r), (0.9 * r, 0.9 * r, 1.2 * r), land),
        ellipsoid((-0.5 * r, 0.35 * r, centre + 0.15 * r), (0.95 * r, 1.1 * r, 1.2 * r), land),
        ellipsoid((-0.35 * r, -0.55 * r, centre + 0.35 * r), (0.8 * r, 0.8 * r, 0.9 * r), land),
        ellipsoid((0, 0, centre + 0.90 * r), (0.8 * r, 0.8 * r, 0.2 * r), COLORS["white"]),
    ]


def _mantel_clock(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    face = tilt(0, np.pi / 2)
    dial = 0.34 * y
    return [
        box((0, 0, 0), size, color, collides=True, visible=False, mass_share=1),
        box((0, 0, -z / 2 + 0.06 * z), (x, y, 0.12 * z), shade(color, 0.7), "wood"),
        box((0, 0, -0.05 * z), (0.86 * x, 0.88 * y, 0.8 * z), color, "wood"),
        box((0, 0, 0.38 * z), (0.93 * x, y, 0.08 * z), shade(color, 0.7), "wood"),
        box((0, 0, 0.45 * z), (0.7 * x, 0.7 * y, 0.1 * z), color, "wood"),
        cylinder((0.43 * x, 0, 0.0), dial, 0.02, COLORS["yellow"], "metal", quat=face),
        cylinder((0.43 * x + 0.004, 0, 0.0), 0.88 * dial, 0.02, COLORS["white"], quat=face),
        box((0.43 * x + 0.016, 0, 0.3 * dial), (0.004, 0.012, 0.6 * dial), _DARK),
        box((0.43 * x + 0.016, -0.22 * dial, 0.0), (0.004, 0.45 * dial, 0.012), _DARK),
    ]


DECOR: dict[str, ObjectKind] = {
    "plant": ObjectKind(_plant, (0.26, 0.26, 0.50), 2.5, "terracotta", round=True,
                        category="plant", noun="potted plant", other_nouns=("plant", "houseplant"),
                        colors=("terracotta", "white", "charcoal", "teal")),
    "cactus": ObjectKind(_cactus, (0.24, 0.24, 0.46), 2.2, "terracotta", round=True,
                         category="plant", noun="cactus", other_nouns=("potted cactus",),
                         colors=("terracotta", "white", "yellow"), held_out=True),
    "lamp": ObjectKind(_lamp, (0.28, 0.28, 0.44), 1.5, "blue", round=True, category="lamp",
                       noun="table lamp", other_nouns=("lamp", "reading lamp"),
                       colors=("blue", "red", "green", "black"), support="surface"),
    "floor_lamp": ObjectKind(_floor_lamp, (0.30, 0.30, 1.15), 3.0, "black", round=True,
                             max_height_m=1.2, category="lamp", noun="standing lamp", other_nouns=("pole lamp",),
                             colors=("black", "silver", "oak"), support="floor"),
    "vase": ObjectKind(_vase, (0.24, 0.24, 0.36), 1.5, "navy", round=True, category="vase",
                       noun="vase", other_nouns=("ceramic vase", "urn"),
                        colors=("navy", "white", "teal", "terracotta")),
    "lantern": ObjectKind(_lantern, (0.22, 0.22, 0.38), 1.4, "black", category="lantern", noun="lantern",
                          other_nouns=("candle lantern",), colors=("black", "silver", "white")),
    "globe": ObjectKind(_globe, (0.30, 0.30, 0.42), 1.8, "walnut", round=True, category="globe",
                        noun="globe", other_nouns=("world globe",), colors=("walnut", "oak")),
    "mantel_clock": ObjectKind(_mantel_clock, (0.18, 0.28, 0.28), 2.2, "walnut", category="clock",
                               noun="mantel clock", other_nouns=("clock", "table clock"),
                               colors=("walnut", "oak", "black"), support="surface"),
}  # fmt: skip
