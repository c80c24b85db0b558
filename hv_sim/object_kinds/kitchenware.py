"""What stands about in a kitchen."""

from __future__ import annotations

from hv_sim.object_kinds.kind import ObjectKind, Size
from hv_sim.parts import COLORS, Color, Part, box, cylinder, ellipsoid, rod, shade, tilt

_DARK = (0.10, 0.09, 0.09)


def _toaster(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    edge = 0.16 * z
    return [
        box((0, 0, 0), size, color, collides=True, visible=False, mass_share=1),
        box((0, 0, -0.5 * edge + 0.01), (x, y, z - edge - 0.02), color, "gloss"),
        box((0, 0, 0), (x - 2 * edge, y, z), color, "gloss"),
        rod(
            (x / 2 - edge, -y / 2 + edge, z / 2 - edge),
            (x / 2 - edge, y / 2 - edge, z / 2 - edge),
            edge,
            color,
            "gloss",
        ),
        rod(
            (-x / 2 + edge, -y / 2 + edge, z / 2 - edge),
            (-x / 2 + edge, y / 2 - edge, z / 2 - edge),
            edge,
            color,
            "gloss",
        ),
        box((0, 0, -z / 2 + 0.012), (x * 0.98, y * 0.98, 0.024), _DARK),
        box((0.17 * x, 0, z / 2), (0.17 * x, 0.74 * y, 0.004), (0.03, 0.03, 0.03)),
        box((-0.17 * x, 0, z / 2), (0.17 * x, 0.74 * y, 0.004), (0.03, 0.03, 0.03)),
        box((0, y / 2, 0.02 * z), (0.02, 0.003, 0.6 * z), (0.03, 0.03, 0.03)),
        box((0, y / 2 + 0.012, 0.22 * z), (0.07, 0.024, 0.03), _DARK, "gloss"),
        ellipsoid((0.28 * x, y / 2, -0.22 * z), (0.05, 0.03, 0.05), COLORS["silver"], "metal"),
        box((x / 2, 0, -0.05 * z), (0.003, 0.55 * y, 0.10 * z), COLORS["silver"], "metal"),
    ]


def _cooking_pot(size: Size, color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    body = 0.74 * z
    top = -z / 2 + body
    return [
        cylinder((0, 0, -z / 2 + body / 2), r, body, color, "metal", collides=True, mass_share=0.9),
        cylinder((0, 0, (top + z / 2) / 2), 0.3 * r, z / 2 - top, _DARK, collides=True, visible=False, mass_share=0.1),
        cylinder((0, 0, top - 0.010), 1.01 * r, 0.022, shade(color, 0.75), "metal"),
        ellipsoid((0, 0, top), (1.92 * r, 1.92 * r, 0.30 * z), COLORS["silver"], "metal"),
        cylinder((0, 0, z / 2 - 0.045), 0.012, 0.04, _DARK),
        ellipsoid((0, 0, z / 2 - 0.018), (0.055, 0.055, 0.036), _DARK, "gloss"),
        rod((r, -0.30 * r, top - 0.05), (r + 0.035, 0, top - 0.05), 0.011, _DARK),
        rod((r, 0.30 * r, top - 0.05), (r + 0.035, 0, top - 0.05), 0.011, _DARK),
        rod((-r, -0.30 * r, top - 0.05), (-r - 0.035, 0, top - 0.05), 0.011, _DARK),
        rod((-r, 0.30 * r, top - 0.05), (-r - 0.035, 0, top - 0.05), 0.011, _DARK),
    ]


def _microwave(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    front = x / 2
    return [
        box((0, 0, 0), size, color, "gloss", collides=True, mass_share=1),
        box((front, 0.14 * y, 0), (0.006, 0.64 * y, 0.84 * z), COLORS["charcoal"], "gloss"),
        box((front + 0.003, 0.16 * y, 0), (0.004, 0.48 * y, 0.56 * z), (0.03, 0.05, 0.07), "gloss"),
        box((front + 0.020, -0.15 * y, 0), (0.016, 0.02, 0.66 * z), COLORS["silver"], "metal"),
        box((front, -0.34 * y, 0), (0.006, 0.24 * y, 0.84 * z), COLORS["charcoal"]),
        box((front + 0.003, -0.34 * y, 0.27 * z), (0.005, 0.18 * y, 0.14 * z), (0.20, 0.85, 0.60), "glow"),
        box((front + 0.003, -0.34 * y, 0.02 * z), (0.005, 0.16 * y, 0.08 * z), COLORS["silver"]),
        box((front + 0.003, -0.34 * y, -0.12 * z), (0.005, 0.16 * y, 0.08 * z), COLORS["silver"]),
        box((front + 0.003, -0.34 * y, -0.28 * z), (0.005, 0.16 * y, 0.12 * z), COLORS["red"]),
    ]


def _coffee_maker(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    return [
        box((0, 0, 0), size, color, collides=True, visible=False, mass_share=1),
        box((0, 0, -z / 2 + 0.06 * z), (x, y, 0.12 * z), color, "gloss"),
        box((-0.32 * x, 0, 0), (0.36 * x, y, z), color, "gloss"),
        box((0, 0, z / 2 - 0.14 * z), (x, y, 0.28 * z), color, "gloss"),
        cylinder((0.17 * x, 0, -0.15 * z), 0.27 * x, 0.40 * z, (0.20, 0.13, 0.09), "gloss"),
        cylinder((0.17 * x, 0, 0.07 * z), 0.22 * x, 0.06 * z, _DARK),
        rod((0.17 * x, 0.27 * x, 0.0), (0.17 * x, 0.27 * x + 0.04, -0.12 * z), 0.012, _DARK),
        box((x / 2, 0, z / 2 - 0.14 * z), (0.006, 0.6 * y, 0.14 * z), COLORS["silver"], "metal"),
        cylinder((x / 2 - 0.01, -0.3 * y, z / 2 - 0.14 * z), 0.02, 0.03, COLORS["red"], "glow"),
        cylinder((0.17 * x, 0, 0.2 * z), 0.12 * x, 0.06 * z, _DARK),
    ]


def _kettle(size: Size, color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    parts = [cylinder((0, 0, 0), r, z, color, collides=True, visible=False, mass_share=1)]
    for i in range(4):
        level, wide = -0.38 + 0.22 * i, 1.0 - 0.09 * i
        parts.append(cylinder((0, 0, level * z), wide * r, 0.23 * z, color, "metal"))
    parts += [
        cylinder((0, 0, 0.40 * z), 0.68 * r, 0.04 * z, _DARK),
        ellipsoid((0, 0, 0.45 * z), (0.2 * r, 0.2 * r, 0.1 * z), _DARK, "gloss"),
        rod((0.7 * r, 0, 0.1 * z), (1.15 * r, 0, 0.36 * z), 0.02, color, "metal"),
        rod((-0.6 * r, 0, 0.38 * z), (-1.2 * r, 0, 0.28 * z), 0.016, _DARK),
        rod((-1.2 * r, 0, 0.28 * z), (-0.95 * r, 0, -0.2 * z), 0.016, _DARK),
        cylinder((0, 0, -z / 2 + 0.03 * z), 1.0 * r, 0.06 * z, _DARK),
    ]
    return parts


def _blender(size: Size, color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    base = 0.48 * z
    glass = (0.72, 0.84, 0.88)
    return [
        cylinder((0, 0, -z / 2 + base / 2), r, base, color, collides=True, visible=False, mass_share=0.85),
        cylinder((0, 0, base / 2), 0.7 * r, z - base, glass, collides=True, visible=False, mass_share=0.15),
        cylinder((0, 0, -z / 2 + 0.35 * base), r, 0.7 * base, color, "gloss"),
        cylinder((0, 0, -z / 2 + 0.82 * base), 0.8 * r, 0.36 * base, shade(color, 0.85), "gloss"),
        cylinder((0, 0, 0.5 * base - 0.12 * z), 0.56 * r, 0.30 * z, glass, "gloss"),
        cylinder((0, 0, 0.5 * base + 0.12 * z), 0.68 * r, 0.32 * z, glass, "gloss"),
        cylinder((0, 0, 0.5 * base - 0.08 * z), 0.6 * r, 0.24 * z, (0.86, 0.40, 0.36)),
        cylinder((0, 0, z / 2 - 0.03 * z), 0.7 * r, 0.06 * z, _DARK),
        rod((0, 0.66 * r, 0.36 * z), (0, 0.98 * r, 0.28 * z), 0.012, _DARK),
        rod((0, 0.98 * r, 0.28 * z), (0, 0.62 * r, 0.0), 0.012, _DARK),
        cylinder((0.96 * r, 0, -z / 2 + 0.35 * base), 0.03, 0.04, COLORS["silver"], "metal"),
    ]


def _rice_cooker(size: Size, color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    return [
        cylinder((0, 0, 0), r, z, color, collides=True, visible=False, mass_share=1),
        cylinder((0, 0, -0.12 * z), r, 0.76 * z, color, "gloss"),
        ellipsoid((0, 0, 0.22 * z), (2 * r, 2 * r, 0.56 * z), COLORS["silver"], "gloss"),
        cylinder((0, 0, 0.22 * z), 1.004 * r, 0.03 * z, _DARK),
        ellipsoid((0, 0, z / 2 - 0.01), (0.07, 0.16, 0.03), _DARK),
        box((0.96 * r, 0, -0.15 * z), (0.03, 0.55 * r, 0.36 * z), _DARK),
        box((0.96 * r + 0.012, 0, -0.06 * z), (0.01, 0.3 * r, 0.1 * z), (0.95, 0.55, 0.20), "glow"),
    ]


def _bread_bin(size: Size, color: Color) -> list[Part]:
    x, y, z = size
    return [
        box((0, 0, 0), size, color, collides=True, visible=False, mass_share=1),
        box((-0.04 * x, 0, -0.06 * z), (0.92 * x, y, 0.88 * z), color, "wood"),
        box((-0.2 * x, 0, 0.1 * z), (0.6 * x, y, 0.8 * z), color, "wood"),
        box((0.24 * x, 0, 0.06 * z), (0.44 * x, 0.96 * y, 0.36 * z), shade(color, 1.1), "wood", quat=tilt(0, 0.7)),
        box((0.47 * x, 0, -0.12 * z), (0.02, 0.24 * y, 0.06 * z), COLORS["silver"], "metal"),
        box((0.425 * x, 0, -0.3 * z), (0.01, 0.9 * y, 0.02), shade(color, 0.6)),
    ]


def _fruit_bowl(size: Size, color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    bowl = 0.74 * z
    return [
        cylinder((0, 0, -z / 2 + bowl / 2), r, bowl, color, collides=True, visible=False, mass_share=0.9),
        cylinder((0, 0, bowl / 2), 0.8 * r, z - bowl, color, collides=True, visible=False, mass_share=0.1),
        cylinder((0, 0, -z / 2 + 0.12 * bowl), 0.55 * r, 0.24 * bowl, shade(color, 0.8), "gloss"),
        cylinder((0, 0, -z / 2 + 0.38 * bowl), 0.78 * r, 0.34 * bowl, color, "gloss"),
        cylinder((0, 0, -z / 2 + 0.76 * bowl), r, 0.48 * bowl, color, "gloss"),
        ellipsoid((0.3 * r, 0.3 * r, 0.16 * z), (0.75 * r, 0.75 * r, 0.55 * z), COLORS["red"], "gloss"),
        ellipsoid((-0.35 * r, 0.3 * r, 0.16 * z), (0.75 * r, 0.75 * r, 0.55 * z), COLORS["orange"], "gloss"),
        ellipsoid((0.05 * r, -0.42 * r, 0.16 * z), (0.75 * r, 0.75 * r, 0.55 * z), (0.50, 0.70, 0.25), "gloss"),
        ellipsoid((-0.02 * r, 0.0, 0.3 * z), (0.7 * r, 0.7 * r, 0.5 * z), COLORS["yellow"], "gloss"),
    ]


KITCHENWARE: dict[str, ObjectKind] = {
    "toaster": ObjectKind(_toaster, (0.22, 0.32, 0.22), 1.8, "red", max_height_m=0.4, category="toaster",
                          noun="toaster", other_nouns=("bread toaster",), colors=("red", "silver", "cream", "teal"),
                          support="surface"),
    "cooking_pot": ObjectKind(_cooking_pot, (0.28, 0.28, 0.24), 2.0, "silver", round=True,
                              max_height_m=0.4, category="pot", noun="cooking pot",
                              other_nouns=("pot", "stockpot", "saucepan"), colors=("silver", "red", "navy"),
                              support="surface"),
    "microwave": ObjectKind(_microwave, (0.32, 0.44, 0.26), 4.5, "white", max_height_m=0.4, category="microwave",
                            noun="microwave", other_nouns=("microwave oven",), colors=("white", "silver", "red"),
                            support="surface"),
    "coffee_maker": ObjectKind(_coffee_maker, (0.26, 0.24, 0.36), 2.5, "black",
                               category="coffee maker", noun="coffee maker",
                               other_nouns=("coffee machine", "coffee brewer"), colors=("black", "red", "silver"),
                               support="surface"),
    "kettle": ObjectKind(_kettle, (0.20, 0.20, 0.26), 1.4, "silver", round=True, category="kettle",
                         noun="kettle", other_nouns=("electric kettle", "tea kettle"),
                         colors=("silver", "red", "teal"), support="surface"),
    "blender": ObjectKind(_blender, (0.20, 0.20, 0.40), 2.4, "red", round=True, category="blender",
                          noun="blender", other_nouns=("smoothie maker",), colors=("red", "black", "white"),
                          support="surface", held_out=True),
    "rice_cooker": ObjectKind(_rice_cooker, (0.28, 0.28, 0.26), 2.8, "white", round=True,
                              category="pot", noun="rice cooker", other_nouns=("electric cooker",),
                              colors=("white", "pink", "teal"), support="surface"),
    "bread_bin": ObjectKind(_bread_bin, (0.26, 0.40, 0.22), 2.0, "oak", category="box",
                            noun="bread bin", other_nouns=("bread box",), colors=("oak", "white", "walnut"),
                            support="surface"),
    "fruit_bowl": ObjectKind(_fruit_bowl, (0.32, 0.32, 0.20), 1.8, "blue", round=True,
                             category="bowl", noun="fruit bowl", other_nouns=("bowl of fruit",),
                             colors=("blue", "white", "oak"), support="surface"),
}  # fmt: skip
