"""Cushions, blankets, toys and books."""

from __future__ import annotations

from hv_sim.object_kinds.kind import ObjectKind, Size
from hv_sim.parts import COLORS, Color, Part, box, ellipsoid, shade, tilt


def _cushion(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    return [
        box((0, 0, 0), size, color, collides=True, visible=False, mass_share=1),
        box((0, 0, 0), (0.30 * x, y, z), color, "fabric"),
        box((0, 0, 0), (0.62 * x, 0.88 * y, 0.88 * z), color, "fabric"),
        ellipsoid((0, 0, 0), (x, 1.16 * y, 1.16 * z), color, "fabric"),
        box((0, 0, 0), (0.07 * x, 1.02 * y, 1.02 * z), shade(color, 0.6), "fabric"),
        ellipsoid((0.49 * x, 0, 0), (0.02, 0.04, 0.04), shade(color, 0.5)),
    ]


def _blanket_stack(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    tones = (color, COLORS["cream"], shade(color, 0.7), COLORS["gray"])
    parts = [box((0, 0, 0), size, color, collides=True, visible=False, mass_share=1)]
    for i, tone in enumerate(tones):
        level = (-0.375 + 0.25 * i) * z
        parts.append(box((0, 0, level), (0.94 * x, y, 0.22 * z), tone, "fabric"))
        parts.append(ellipsoid((0.46 * x, 0, level), (0.1 * x, y, 0.23 * z), tone, "fabric"))
    return parts


def _teddy_bear(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    dark, light = shade(color, 0.55), shade(color, 1.3)
    parts = [
        box((0, 0, -0.18 * z), (x, y, 0.64 * z), color, collides=True, visible=False, mass_share=0.8),
        box((0, 0, 0.32 * z), (0.6 * x, 0.6 * y, 0.36 * z), color, collides=True, visible=False, mass_share=0.2),
        ellipsoid((0, 0, -0.16 * z), (0.9 * x, 0.84 * y, 0.68 * z), color, "fabric"),
        ellipsoid((0.34 * x, 0, -0.16 * z), (0.3 * x, 0.5 * y, 0.44 * z), light, "fabric"),
        ellipsoid((0.02, 0, 0.30 * z), (0.66 * x, 0.68 * y, 0.40 * z), color, "fabric"),
        ellipsoid((0.30 * x, 0, 0.26 * z), (0.26 * x, 0.3 * y, 0.16 * z), light, "fabric"),
        ellipsoid((0.42 * x, 0, 0.29 * z), (0.06, 0.06, 0.04), (0.1, 0.08, 0.08), "gloss"),
    ]
    for side in (-1, 1):
        parts.append(ellipsoid((0, side * 0.24 * y, 0.45 * z), (0.2 * x, 0.2 * y, 0.12 * z), dark, "fabric"))
        parts.append(ellipsoid((0.31 * x, side * 0.12 * y, 0.36 * z), (0.03, 0.03, 0.03), (0.1, 0.08, 0.08), "gloss"))
        parts.append(ellipsoid((0.1 * x, side * 0.40 * y, -0.06 * z), (0.3 * x, 0.2 * y, 0.42 * z), color, "fabric"))
        parts.append(ellipsoid((0.3 * x, side * 0.27 * y, -0.40 * z), (0.42 * x, 0.3 * y, 0.2 * z), color, "fabric"))
        parts.append(
            ellipsoid(
                (0.5 * x, side * 0.27 * y, -0.38 * z), (0.04, 0.2 * y, 0.15 * z), light, "fabric", quat=tilt(0, 0)
            )
        )
    return parts


def _book_stack(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    covers = (color, COLORS["green"], COLORS["navy"], COLORS["cream"], COLORS["red"], COLORS["teal"])
    parts = [box((0, 0, 0), size, color, collides=True, visible=False, mass_share=1)]
    for i, cover in enumerate(covers):
        level = (-0.5 + (i + 0.5) / len(covers)) * z
        thick = z / len(covers)
        turn = (0.05, -0.08, 0.03, 0.1, -0.04, 0.06)[i]
        wide = 0.92 - 0.02 * (i % 3)
        parts.append(box((-0.005, 0, level), (wide * x, 0.94 * y, thick * 0.98), cover, quat=tilt(0, 0, turn)))
        parts.append(box((0.012, 0, level), (wide * x, 0.95 * y, thick * 0.7), COLORS["white"], quat=tilt(0, 0, turn)))
    return parts


SOFT: dict[str, ObjectKind] = {
    "cushion": ObjectKind(_cushion, (0.20, 0.40, 0.38), 0.7, "orange", category="cushion",
                          noun="cushion", other_nouns=("throw pillow", "pillow"),
                          colors=("orange", "teal", "pink", "navy", "yellow")),
    "blanket_stack": ObjectKind(_blanket_stack, (0.32, 0.40, 0.26), 2.0, "blue", category="blanket",
                                noun="stack of blankets", other_nouns=("pile of blankets", "bundle of blankets"),
                                colors=("blue", "red", "green")),
    "teddy_bear": ObjectKind(_teddy_bear, (0.28, 0.32, 0.42), 0.8, "brown", category="toy",
                             noun="teddy bear", other_nouns=("stuffed bear", "teddy"),
                             colors=("brown", "tan", "cream", "pink"), held_out=True),
    "book_stack": ObjectKind(_book_stack, (0.24, 0.32, 0.22), 3.5, "red", category="books",
                             noun="stack of books", other_nouns=("pile of books", "tower of books"),
                             colors=("red", "navy", "green")),
}  # fmt: skip
