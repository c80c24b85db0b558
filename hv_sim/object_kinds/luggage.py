"""Suitcases and bags."""

from __future__ import annotations

from hv_sim.object_kinds.kind import ObjectKind, Size
from hv_sim.parts import COLORS, Color, Part, box, ellipsoid, rod, shade

_DARK = (0.10, 0.09, 0.09)


def _suitcase(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    dark = shade(color, 0.55)
    parts = [
        box((0, 0, 0), size, color, collides=True, visible=False, mass_share=1),
        box((0, 0, 0.02), (x, y, z - 0.04), color, "gloss"),
        box((0, 0, 0.02), (0.014, y + 0.004, z - 0.036), _DARK),
        box((x / 2, -0.25 * y, 0.02), (0.008, 0.03, z * 0.86), dark, "gloss"),
        box((x / 2, 0.25 * y, 0.02), (0.008, 0.03, z * 0.86), dark, "gloss"),
        box((-x / 2, -0.25 * y, 0.02), (0.008, 0.03, z * 0.86), dark, "gloss"),
        box((-x / 2, 0.25 * y, 0.02), (0.008, 0.03, z * 0.86), dark, "gloss"),
        rod((0, -0.2 * y, z / 2 + 0.035), (0, 0.2 * y, z / 2 + 0.035), 0.012, _DARK),
        rod((0, -0.2 * y, z / 2 - 0.01), (0, -0.2 * y, z / 2 + 0.035), 0.010, _DARK),
        rod((0, 0.2 * y, z / 2 - 0.01), (0, 0.2 * y, z / 2 + 0.035), 0.010, _DARK),
        rod((-0.35 * x, -0.4 * y, -z / 2 + 0.02), (0.35 * x, -0.4 * y, -z / 2 + 0.02), 0.02, _DARK),
        rod((-0.35 * x, 0.4 * y, -z / 2 + 0.02), (0.35 * x, 0.4 * y, -z / 2 + 0.02), 0.02, _DARK),
    ]
    return parts


def _backpack(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    dark = shade(color, 0.6)
    return [
        box((0, 0, 0), size, color, collides=True, visible=False, mass_share=1),
        box((-0.08 * x, 0, -0.08 * z), (0.80 * x, y, 0.84 * z), color, "fabric"),
        ellipsoid((-0.08 * x, 0, 0.28 * z), (0.82 * x, y, 0.46 * z), color, "fabric"),
        box((0.40 * x, 0, -0.24 * z), (0.20 * x, 0.74 * y, 0.42 * z), dark, "fabric"),
        box((0.5 * x, 0, -0.08 * z), (0.012, 0.66 * y, 0.02), COLORS["yellow"], "metal"),
        box((0.325 * x, 0, 0.2 * z), (0.012, 0.76 * y, 0.016), COLORS["yellow"], "metal"),
        rod((-0.15 * x, -0.08, z / 2 - 0.01), (-0.15 * x, 0.08, z / 2 - 0.01), 0.013, dark),
        rod((-0.5 * x, 0.24 * y, 0.36 * z), (-0.58 * x, 0.26 * y, -0.30 * z), 0.02, dark),
        rod((-0.5 * x, -0.24 * y, 0.36 * z), (-0.58 * x, -0.26 * y, -0.30 * z), 0.02, dark),
        box((0.326 * x, 0, 0.34 * z), (0.02, 0.2 * y, 0.1 * z), COLORS["white"], "fabric"),
    ]


def _briefcase(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    brass = COLORS["yellow"]
    return [
        box((0, 0, 0), size, color, collides=True, visible=False, mass_share=1),
        box((0, 0, -0.02 * z), (0.92 * x, y, 0.95 * z), color, "gloss"),
        box((0, 0, -0.02 * z), (x, 0.985 * y, 0.90 * z), shade(color, 0.85), "gloss"),
        box((0, 0, 0.456 * z), (0.14 * x, 1.002 * y, 0.03), shade(color, 0.5)),
        rod((0, -0.16 * y, z / 2 + 0.03), (0, 0.16 * y, z / 2 + 0.03), 0.014, _DARK),
        rod((0, -0.16 * y, z / 2 - 0.02), (0, -0.16 * y, z / 2 + 0.03), 0.011, brass, "metal"),
        rod((0, 0.16 * y, z / 2 - 0.02), (0, 0.16 * y, z / 2 + 0.03), 0.011, brass, "metal"),
        box((x / 2, -0.3 * y, 0.30 * z), (0.014, 0.06, 0.05), brass, "metal"),
        box((x / 2, 0.3 * y, 0.30 * z), (0.014, 0.06, 0.05), brass, "metal"),
    ]


def _duffel_bag(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    dark = shade(color, 0.55)
    return [
        box((0, 0, 0), size, color, collides=True, visible=False, mass_share=1),
        box((0, 0, -0.12 * z), (0.96 * x, 0.98 * y, 0.74 * z), color, "fabric"),
        ellipsoid((0, 0, 0.16 * z), (0.98 * x, 1.0 * y, 0.68 * z), color, "fabric"),
        box((0, 0, 0.475 * z), (0.03, 0.62 * y, 0.02), COLORS["silver"], "metal"),
        box((0, 0.27 * y, -0.1 * z), (1.0 * x, 0.05 * y, 0.8 * z), dark, "fabric"),
        box((0, -0.27 * y, -0.1 * z), (1.0 * x, 0.05 * y, 0.8 * z), dark, "fabric"),
        rod((0.1 * x, -0.2 * y, z / 2 + 0.05), (0.1 * x, 0.2 * y, z / 2 + 0.05), 0.013, dark),
        rod((0.1 * x, -0.2 * y, z / 2 + 0.05), (0.4 * x, -0.27 * y, 0.25 * z), 0.012, dark),
        rod((0.1 * x, 0.2 * y, z / 2 + 0.05), (0.4 * x, 0.27 * y, 0.25 * z), 0.012, dark),
        box((0.49 * x, 0, -0.14 * z), (0.012, 0.3 * y, 0.36 * z), dark, "fabric"),
    ]


LUGGAGE: dict[str, ObjectKind] = {
    "suitcase": ObjectKind(_suitcase, (0.22, 0.36, 0.48), 3.0, "orange", category="suitcase", noun="suitcase",
                           other_nouns=("travel case", "hard-shell suitcase"),
                           colors=("orange", "navy", "silver", "pink"), support="floor"),
    "backpack": ObjectKind(_backpack, (0.24, 0.32, 0.44), 2.2, "green", category="bag",
                           noun="backpack", other_nouns=("rucksack", "school bag"),
                           colors=("green", "blue", "red", "black")),
    "briefcase": ObjectKind(_briefcase, (0.17, 0.42, 0.32), 2.5, "brown", category="bag", noun="briefcase",
                            other_nouns=("attache case",), colors=("brown", "black"), blocked=(1, 3), held_out=True),
    "duffel_bag": ObjectKind(_duffel_bag, (0.28, 0.44, 0.28), 2.8, "navy", category="bag",
                             noun="gym bag", other_nouns=("duffel bag", "sports bag"),
                             colors=("navy", "red", "charcoal"), support="floor"),
}  # fmt: skip
