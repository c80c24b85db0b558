"""Tables that one person carries."""

from __future__ import annotations

from hv_sim.object_kinds.kind import ObjectKind, Size
from hv_sim.parts import COLORS, Color, Part, box, cylinder, shade


def _bedside_table(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    knob = COLORS["silver"]
    parts = [
        box((0, 0, 0.06 * z), (x, y, 0.88 * z), color, "wood", collides=True, visible=False, mass_share=0.9),
        box((0, 0, 0.06 * z), (0.97 * x, 0.98 * y, 0.87 * z), color, "wood"),
        box((0, 0, z / 2 - 0.015), (x, y, 0.03), shade(color, 0.8), "wood"),
    ]
    for level in (0.27, -0.10):
        parts.append(box((0.485 * x, 0, level * z), (0.012, 0.86 * y, 0.32 * z), shade(color, 1.12), "wood"))
        parts.append(box((0.5 * x - 0.004, 0, level * z), (0.016, 0.05, 0.025), knob, "metal"))
    for sx in (-1, 1):
        for sy in (-1, 1):
            at = (sx * (x / 2 - 0.03), sy * (y / 2 - 0.03), -z / 2 + 0.06 * z)
            parts.append(box(at, (0.035, 0.035, 0.12 * z), shade(color, 0.6), "wood", collides=True, mass_share=0.025))
    return parts


def _side_table(size: Size, color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    top, foot = 0.10, 0.03
    return [
        cylinder((0, 0, z / 2 - top / 2), r, top, color, "wood", collides=True, visible=False, mass_share=0.45),
        cylinder((0, 0, z / 2 - 0.02), r, 0.04, color, "wood"),
        cylinder((0, 0, z / 2 - 0.06), 0.97 * r, 0.05, shade(color, 0.8), "wood"),
        cylinder((0, 0, 0), 0.03, z - top - foot, shade(color, 0.6), "wood", collides=True, mass_share=0.1),
        cylinder((0, 0, -z / 2 + foot / 2), 0.85 * r, foot, shade(color, 0.6), "wood", collides=True, mass_share=0.45),
    ]


SMALL_TABLES: dict[str, ObjectKind] = {
    "bedside_table": ObjectKind(_bedside_table, (0.36, 0.40, 0.46), 4.5, "oak", category="table",
                                noun="bedside table", other_nouns=("nightstand", "night table"),
                                colors=("oak", "walnut", "white"), support="floor"),
    "side_table": ObjectKind(_side_table, (0.40, 0.40, 0.48), 3.0, "walnut", round=True,
                             category="table", noun="side table", other_nouns=("end table", "occasional table"),
                             colors=("walnut", "oak", "white", "black"), support="floor"),
}  # fmt: skip
