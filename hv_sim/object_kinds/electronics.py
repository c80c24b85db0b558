"""Screens, speakers, printers."""

from __future__ import annotations

import numpy as np

from hv_sim.object_kinds.kind import ObjectKind, Size
from hv_sim.parts import COLORS, Color, Part, box, cylinder, ellipsoid, rod, shade, tilt

_DARK = (0.10, 0.09, 0.09)


def _speaker(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    woofer, tweeter = 0.38 * y, 0.20 * y
    face = tilt(0, np.pi / 2)
    return [
        box((0, 0, 0), size, color, "wood", collides=True, mass_share=1),
        box((x / 2, 0, 0), (0.006, 0.94 * y, 0.97 * z), _DARK),
        cylinder((x / 2 + 0.004, 0, -0.18 * z), woofer, 0.010, COLORS["silver"], "metal", quat=face),
        cylinder((x / 2 + 0.006, 0, -0.18 * z), 0.88 * woofer, 0.010, COLORS["charcoal"], quat=face),
        ellipsoid((x / 2 + 0.008, 0, -0.18 * z), (0.03, 0.6 * woofer, 0.6 * woofer), COLORS["gray"], "gloss"),
        cylinder((x / 2 + 0.004, 0, 0.26 * z), tweeter, 0.010, COLORS["silver"], "metal", quat=face),
        cylinder((x / 2 + 0.006, 0, 0.26 * z), 0.82 * tweeter, 0.010, COLORS["charcoal"], quat=face),
        ellipsoid((x / 2 + 0.008, 0, 0.26 * z), (0.02, 0.6 * tweeter, 0.6 * tweeter), COLORS["gray"], "gloss"),
    ]


def _monitor(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    screen = 0.72 * z
    thick = 0.07
    return [
        box((0, 0, z / 2 - screen / 2), (thick, y, screen), color, collides=True, visible=False, mass_share=0.5),
        box((0, 0, z / 2 - screen / 2), (0.04, y, screen), color, "gloss"),
        box((0.022, 0, z / 2 - 0.48 * screen), (0.006, 0.93 * y, 0.84 * screen), (0.16, 0.32, 0.52), "glow"),
        box((0.026, -0.12 * y, z / 2 - 0.40 * screen), (0.004, 0.5 * y, 0.36 * screen), (0.85, 0.88, 0.92), "glow"),
        box((0.026, 0.28 * y, z / 2 - 0.62 * screen), (0.004, 0.26 * y, 0.3 * screen), (0.95, 0.70, 0.30), "glow"),
        box((-0.01, 0, -z / 2 + 0.15 * z), (0.04, 0.08, 0.28 * z), shade(color, 0.8), collides=True),
        box((0, 0, -z / 2 + 0.015), (x, 0.6 * y, 0.03), shade(color, 0.8), collides=True, mass_share=0.4),
    ]


def _laptop(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    stand = 0.42 * z
    lid = z - stand - 0.03
    return [
        box((0, 0, -z / 2 + stand / 2), (x, y, stand), COLORS["oak"], collides=True, visible=False, mass_share=0.9),
        box((0, 0, z / 2 - lid / 2), (0.1 * x, y, lid), color, collides=True, visible=False, mass_share=0.1),
        box((0, 0, -z / 2 + 0.1 * stand), (x, y, 0.2 * stand), COLORS["oak"], "wood"),
        box((0, 0.46 * y, -z / 2 + stand / 2), (0.96 * x, 0.08 * y, stand), COLORS["oak"], "wood"),
        box((0, -0.46 * y, -z / 2 + stand / 2), (0.96 * x, 0.08 * y, stand), COLORS["oak"], "wood"),
        box((0, 0, -z / 2 + 0.93 * stand), (x, y, 0.14 * stand), COLORS["oak"], "wood"),
        box((0.02, 0, -z / 2 + stand + 0.012), (0.86 * x, 0.92 * y, 0.024), color, "metal"),
        box((0.05 * x, 0, -z / 2 + stand + 0.025), (0.5 * x, 0.8 * y, 0.004), _DARK),
        box((-0.40 * x, 0, z / 2 - lid / 2), (0.014, 0.92 * y, lid), color, "metal", quat=tilt(0, -0.16)),
        box(
            (-0.385 * x, 0, z / 2 - lid / 2),
            (0.006, 0.84 * y, 0.86 * lid),
            (0.20, 0.45, 0.75),
            "glow",
            quat=tilt(0, -0.16),
        ),
        box(
            (-0.375 * x, 0.1 * y, z / 2 - 0.45 * lid),
            (0.006, 0.4 * y, 0.4 * lid),
            (0.92, 0.94, 0.96),
            "glow",
            quat=tilt(0, -0.16),
        ),
    ]


def _printer(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    return [
        box((0, 0, 0), size, color, collides=True, visible=False, mass_share=1),
        box((0, 0, -0.08 * z), (x, y, 0.84 * z), color, "gloss"),
        box((-0.1 * x, 0, 0.40 * z), (0.8 * x, 0.94 * y, 0.2 * z), shade(color, 0.8), "gloss"),
        box((0.49 * x, 0, -0.14 * z), (0.03, 0.7 * y, 0.20 * z), _DARK),
        box((0.5 * x + 0.03, 0, -0.20 * z), (0.09, 0.5 * y, 0.01), COLORS["white"], "glow"),
        box((0.42 * x, -0.3 * y, 0.36 * z), (0.14 * x, 0.24 * y, 0.03), _DARK),
        box((0.42 * x, -0.3 * y, 0.38 * z), (0.1 * x, 0.16 * y, 0.02), (0.35, 0.75, 0.95), "glow"),
        box((-0.46 * x, 0, 0.52 * z), (0.01, 0.6 * y, 0.18 * z), COLORS["white"], quat=tilt(0, -0.3)),
        box((0.5 * x, 0, -0.40 * z), (0.012, 0.8 * y, 0.12 * z), shade(color, 0.85)),
    ]


def _computer(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    parts = [
        box((0, 0, 0), size, color, "gloss", collides=True, mass_share=1),
        box((x / 2, 0, 0), (0.008, 0.92 * y, 0.97 * z), shade(color, 0.6)),
        box((x / 2 + 0.003, 0, 0.36 * z), (0.008, 0.76 * y, 0.06 * z), COLORS["silver"], "metal"),
        cylinder((x / 2 + 0.002, 0.25 * y, 0.24 * z), 0.014, 0.02, (0.3, 0.8, 1.0), "glow", quat=tilt(0, 1.5708)),
        box((x / 2 + 0.003, -0.1 * y, 0.24 * z), (0.008, 0.3 * y, 0.03), _DARK),
    ]
    for i in range(5):
        at = (x / 2 + 0.003, 0, (-0.05 - 0.08 * i) * z)
        parts.append(box(at, (0.008, 0.7 * y, 0.03 * z), _DARK))
    for i in range(4):
        parts.append(box((0.1 * x, y / 2, (0.2 - 0.1 * i) * z), (0.5 * x, 0.006, 0.03 * z), shade(color, 0.5)))
    return parts


def _radio(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    face = tilt(0, np.pi / 2)
    return [
        box((0, 0, 0), size, color, "wood", collides=True, mass_share=1),
        box((x / 2, 0, 0), (0.006, 0.92 * y, 0.86 * z), COLORS["cream"]),
        cylinder((x / 2 + 0.004, 0.22 * y, 0.02 * z), 0.32 * z, 0.012, COLORS["brown"], "fabric", quat=face),
        cylinder((x / 2 + 0.006, -0.24 * y, 0.12 * z), 0.17 * z, 0.014, COLORS["silver"], "metal", quat=face),
        box((x / 2 + 0.006, -0.24 * y, 0.12 * z), (0.02, 0.008, 0.26 * z), COLORS["red"]),
        cylinder((x / 2 + 0.01, -0.36 * y, -0.28 * z), 0.018, 0.03, _DARK, quat=face),
        cylinder((x / 2 + 0.01, -0.14 * y, -0.28 * z), 0.018, 0.03, _DARK, quat=face),
        rod((0, -0.4 * y, z / 2), (0, -0.1 * y, z / 2 + 0.24), 0.004, COLORS["silver"], "metal"),
        rod((0, -0.36 * y, z / 2 + 0.03), (0, 0.36 * y, z / 2 + 0.03), 0.012, _DARK),
    ]


def _fan(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    r, face = y / 2, tilt(0, np.pi / 2)
    centre = z / 2 - r
    base = 0.04
    parts = [
        box((0, 0, centre), (0.12, y, 1.2 * r), color, collides=True, visible=False, mass_share=0.35),
        box((0, 0, centre + 0.8 * r), (0.10, 1.1 * r, 0.4 * r), color, collides=True, visible=False, mass_share=0.0),
        cylinder(
            (0, 0, (centre - r + base - z / 2) / 2),
            0.02,
            max(0.02, centre - 0.6 * r + z / 2 - base),
            COLORS["silver"],
            "metal",
            collides=True,
            mass_share=0.15,
        ),
        box((0, 0, -z / 2 + base / 2), (x, 0.8 * y, base), color, "gloss", collides=True, mass_share=0.5),
        cylinder((0, 0, centre), r, 0.02, COLORS["silver"], "metal", quat=face),
        cylinder((0.012, 0, centre), 0.95 * r, 0.02, (0.83, 0.88, 0.92), quat=face),
        ellipsoid((0.05, 0, centre), (0.05, 0.24 * r, 0.24 * r), _DARK, "gloss"),
        ellipsoid((-0.05, 0, centre), (0.12, 0.5 * r, 0.5 * r), color, "gloss"),
    ]
    for i in range(3):
        a = i * 2 * np.pi / 3 + 0.5
        at = (0.035, 0.48 * r * np.cos(a), centre + 0.48 * r * np.sin(a))
        parts.append(ellipsoid(at, (0.02, 0.8 * r, 0.42 * r), color, "gloss", quat=tilt(a, 0)))
    return parts


ELECTRONICS: dict[str, ObjectKind] = {
    "speaker": ObjectKind(_speaker, (0.24, 0.22, 0.36), 3.0, "walnut", category="speaker", noun="speaker",
                          other_nouns=("loudspeaker",), colors=("walnut", "black", "white")),
    "monitor": ObjectKind(_monitor, (0.20, 0.44, 0.42), 3.2, "charcoal", category="monitor",
                          noun="computer monitor", other_nouns=("monitor", "computer screen"),
                          colors=("charcoal", "silver", "white"), support="surface", blocked=(1, 3)),
    "laptop": ObjectKind(_laptop, (0.27, 0.34, 0.34), 2.4, "silver", category="laptop",
                         noun="laptop", other_nouns=("laptop computer", "notebook computer"),
                         colors=("silver", "charcoal"), support="surface", blocked=(1, 3)),
    "printer": ObjectKind(_printer, (0.36, 0.42, 0.26), 5.0, "white", category="printer",
                          noun="printer", other_nouns=("inkjet printer",), colors=("white", "gray", "black"),
                          support="surface"),
    "computer": ObjectKind(_computer, (0.40, 0.20, 0.42), 6.0, "black", category="computer", noun="desktop computer",
                           other_nouns=("computer tower", "PC"), colors=("black", "silver", "white"),
                           support="floor", held_out=True),
    "radio": ObjectKind(_radio, (0.18, 0.32, 0.22), 1.6, "walnut", category="radio", noun="radio",
                        other_nouns=("table radio",), colors=("walnut", "red", "teal"), support="surface"),
    "fan": ObjectKind(_fan, (0.24, 0.32, 0.48), 2.0, "white", category="fan", noun="desk fan",
                      other_nouns=("electric fan", "table fan"), colors=("white", "black", "teal"), blocked=(1, 3)),
}  # fmt: skip
