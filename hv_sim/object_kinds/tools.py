"""What a workshop or a warehouse has lying about."""

from __future__ import annotations

from hv_sim.object_kinds.kind import ObjectKind, Size
from hv_sim.parts import COLORS, Color, Part, box, cylinder, ellipsoid, rod, shade, tilt

_DARK = (0.10, 0.09, 0.09)


def _toolbox(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    steel = COLORS["silver"]
    return [
        box((0, 0, -0.08 * z), (x, y, 0.84 * z), color, collides=True, visible=False, mass_share=1),
        box((0, 0, -0.16 * z), (x, y, 0.68 * z), color, "gloss"),
        box((0, 0, 0.26 * z), (0.94 * x, 0.98 * y, 0.16 * z), shade(color, 0.75), "gloss"),
        box((0, 0, 0.37 * z), (0.5 * x, 0.94 * y, 0.08 * z), shade(color, 0.7), "gloss"),
        box((0, 0, 0.46 * z), (0.1 * x, 0.5 * y, 0.08 * z), _DARK),
        box((x / 2, -0.28 * y, 0.15 * z), (0.016, 0.08 * y, 0.2 * z), steel, "metal"),
        box((x / 2, 0.28 * y, 0.15 * z), (0.016, 0.08 * y, 0.2 * z), steel, "metal"),
        box((x / 2, 0, -0.2 * z), (0.008, 0.4 * y, 0.14 * z), COLORS["yellow"]),
    ]


def _jerry_can(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    return [
        box((0, 0, -0.06 * z), (x, y, 0.88 * z), color, collides=True, visible=False, mass_share=1),
        box((0, 0, -0.06 * z), (0.96 * x, y, 0.88 * z), color, "gloss"),
        box((0, 0, -0.06 * z), (x, 0.96 * y, 0.84 * z), shade(color, 0.9), "gloss"),
        box((x / 2, 0, -0.08 * z), (0.008, 0.62 * y, 0.05 * z), shade(color, 0.6), quat=tilt(0.7, 0)),
        box((x / 2, 0, -0.08 * z), (0.008, 0.62 * y, 0.05 * z), shade(color, 0.6), quat=tilt(-0.7, 0)),
        rod((0, -0.26 * y, z / 2 - 0.02), (0, 0.16 * y, z / 2 - 0.02), 0.016, shade(color, 0.7)),
        rod((0, -0.26 * y, z / 2 - 0.08 * z - 0.02), (0, -0.26 * y, z / 2 - 0.02), 0.014, shade(color, 0.7)),
        cylinder((0, 0.34 * y, z / 2 - 0.03), 0.032, 0.06, COLORS["yellow"], "gloss"),
    ]


def _fire_extinguisher(size: Size, color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    body = 0.76 * z
    return [
        cylinder((0, 0, -z / 2 + body / 2), r, body, color, collides=True, visible=False, mass_share=0.95),
        cylinder((0, 0, body / 2), 0.4 * r, z - body, _DARK, collides=True, visible=False, mass_share=0.05),
        cylinder((0, 0, -z / 2 + 0.46 * body), r, 0.88 * body, color, "gloss"),
        ellipsoid((0, 0, -z / 2 + 0.88 * body), (2 * r, 2 * r, 0.26 * body), color, "gloss"),
        cylinder((0, 0, -z / 2 + 0.03), 1.0 * r, 0.05, _DARK),
        cylinder((0, 0, 0.31 * z), 0.3 * r, 0.12 * z, COLORS["silver"], "metal"),
        rod((-0.2 * r, 0, 0.42 * z), (1.1 * r, 0, 0.47 * z), 0.012, _DARK),
        rod((-0.2 * r, 0, 0.38 * z), (1.0 * r, 0, 0.38 * z), 0.010, _DARK),
        rod((0.0, -0.3 * r, 0.34 * z), (0.0, -1.1 * r, 0.24 * z), 0.012, _DARK),
        rod((0.0, -1.1 * r, 0.24 * z), (0.0, -1.12 * r, -0.1 * z), 0.014, _DARK),
        box((0.93 * r, 0, -0.1 * z), (0.03, 0.9 * r, 0.22 * z), COLORS["white"]),
    ]


def _paint_can(size: Size, color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    steel = COLORS["silver"]
    return [
        cylinder((0, 0, 0), r, z, color, collides=True, visible=False, mass_share=1),
        cylinder((0, 0, 0), 0.98 * r, 0.96 * z, steel, "metal"),
        cylinder((0, 0, -0.02 * z), 0.99 * r, 0.62 * z, COLORS["white"]),
        cylinder((0, 0, -0.08 * z), 1.0 * r, 0.34 * z, color, "gloss"),
        cylinder((0, 0, z / 2 - 0.03 * z), r, 0.06 * z, steel, "metal"),
        cylinder((0, 0, -z / 2 + 0.03 * z), r, 0.06 * z, steel, "metal"),
        cylinder((0, 0, z / 2), 0.84 * r, 0.004, color, "gloss"),
        ellipsoid((0.9 * r, 0.25 * r, 0.36 * z), (0.16 * r, 0.3 * r, 0.34 * z), color, "gloss"),
        rod((0, r, 0.30 * z), (0, 0.7 * r, z / 2 + 0.5 * r), 0.005, steel, "metal"),
        rod((0, -r, 0.30 * z), (0, -0.7 * r, z / 2 + 0.5 * r), 0.005, steel, "metal"),
        rod((0, 0.7 * r, z / 2 + 0.5 * r), (0, -0.7 * r, z / 2 + 0.5 * r), 0.005, steel, "metal"),
    ]


def _cable_reel(size: Size, color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    plate = 0.22 * z
    parts = [
        cylinder((0, 0, z / 2 - plate / 2), r, plate, color, "wood", collides=True, mass_share=0.35),
        cylinder((0, 0, 0), 0.78 * r, z - 2 * plate, COLORS["charcoal"], collides=True, visible=False, mass_share=0.3),
        cylinder((0, 0, -z / 2 + plate / 2), r, plate, color, "wood", collides=True, mass_share=0.35),
        cylinder((0, 0, z / 2), 0.18 * r, 0.006, _DARK),
    ]
    for i in range(5):
        level = (-0.4 + 0.2 * i) * (z - 2 * plate)
        parts.append(cylinder((0, 0, level), 0.78 * r, 0.16 * (z - 2 * plate), COLORS["orange"], "gloss"))
        parts.append(cylinder((0, 0, level + 0.1 * (z - 2 * plate)), 0.72 * r, 0.1 * (z - 2 * plate), _DARK))
    return parts


TOOLS: dict[str, ObjectKind] = {
    "toolbox": ObjectKind(_toolbox, (0.26, 0.42, 0.28), 4.5, "red", category="toolbox",
                          noun="toolbox", other_nouns=("tool chest", "tool case"), colors=("red", "blue", "green")),
    "jerry_can": ObjectKind(_jerry_can, (0.18, 0.34, 0.44), 4.0, "green", category="canister",
                            noun="jerry can", other_nouns=("fuel can", "canister"), colors=("green", "red", "blue"),
                            support="floor"),
    "fire_extinguisher": ObjectKind(_fire_extinguisher, (0.18, 0.18, 0.52), 4.5, "red", round=True,
                                    category="extinguisher", noun="fire extinguisher", other_nouns=("extinguisher",),
                                    colors=("red",), support="floor", held_out=True),
    "paint_can": ObjectKind(_paint_can, (0.22, 0.22, 0.26), 3.0, "blue", round=True,
                            category="can", noun="paint can", other_nouns=("can of paint", "paint tin"),
                            colors=("blue", "red", "green", "yellow")),
    "cable_reel": ObjectKind(_cable_reel, (0.38, 0.38, 0.32), 4.0, "oak", round=True,
                             category="reel", noun="cable reel", other_nouns=("cable drum",), colors=("oak", "walnut"),
                             support="floor"),
}  # fmt: skip
