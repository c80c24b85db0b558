"""Furniture that does not exist, to practise on, as `hv_sim.object_kinds.made_up` has things.

Each is a body with a front of doors, drawers, shelves, windows or dials, on a foot or on legs, low enough to put things
on or not, drawn from its number.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from hv_sim.furniture_kinds.kind import DARK, FurnitureKind, Size, cabinet_front, legs
from hv_sim.parts import COLORS, Color, Part, box, cylinder, ellipsoid, rod, shade

PREFIX, COUNT = "made_up_piece_", 1000
NOUNS = (
    "lectern", "pulpit", "altar", "kiosk", "furnace", "harmonium", "pinball machine", "photocopier", "lathe", "kiln",
    "manger", "crib", "cradle", "playpen", "settle", "pillory", "turnstile", "switchboard", "telephone booth",
    "ticket machine", "slot machine", "weaving loom", "wash stand", "umbrella stand", "card catalogue",
    "control panel", "radiator", "sarcophagus", "confessional", "treadmill",
)  # fmt: skip
_LOW_M, _HIGH_M = (0.42, 0.9), (1.1, 2.0)
_LOW_SHARE = 0.65
_MATERIALS = ("wood", "wood", "matte", "gloss", "metal")


@cache
def made_up_piece(number: int) -> FurnitureKind:
    """Made-up kind number `number`, always the same."""
    rng = np.random.default_rng([number, 27])
    is_low = bool(rng.random() < _LOW_SHARE)
    height = rng.uniform(*(_LOW_M if is_low else _HIGH_M))
    size = tuple(round(float(v), 2) for v in (rng.uniform(0.36, 0.75), rng.uniform(0.5, 1.6), height))
    colors = tuple(str(name) for name in rng.permutation(list(COLORS))[:4])
    return FurnitureKind(
        lambda full, color: _build(number, full, color),
        (size[0], size[1], size[2]),
        colors[0],
        holds_objects=is_low,
        noun=NOUNS[number % len(NOUNS)],
        colors=colors,
    )


def _build(number: int, size: Size, color: Color) -> list[Part]:
    rng = np.random.default_rng([number, 28])
    x, y, z = size
    material = str(rng.choice(_MATERIALS))
    other = list(COLORS.values())[int(rng.integers(len(COLORS)))] if rng.random() < 0.3 else shade(color, 0.75)
    foot = float(rng.uniform(0.06, 0.3)) * min(z, 1.0)
    parts = [box((0, 0, z / 2), size, color, collides=True, visible=False)]
    if rng.random() < 0.4:
        parts += [_unsolid(part) for part in legs(x, y, foot, 0.05, float(rng.uniform(0.03, 0.07)), other)]
    else:
        parts.append(box((-0.03, 0, foot / 2), (x - 0.1, y - 0.1, foot), DARK if rng.random() < 0.5 else other))
    top = float(rng.uniform(0.02, 0.08))
    parts.append(box((0, 0, z - top / 2), (x, y, top), other, material))
    parts.append(box((-0.01, 0, (foot + z - top) / 2), (x - 0.03, y - 0.02, z - top - foot), color, material))
    return parts + _front(rng, (x - 0.02, y, z), foot, z - top, color, other)


def _front(rng: np.random.Generator, size: Size, low: float, high: float, color: Color, other: Color) -> list[Part]:
    """What tells the front, one thing above the other or side by side."""
    x, y, _ = size
    tall, fronts = high - low, ("doors", "drawers", "shelves", "window", "dials", "slot")
    parts: list[Part] = []
    levels = np.linspace(low, high, int(rng.integers(1, 4)) + 1 if tall > 0.5 else 2)
    for bottom, upper in zip(levels[:-1].tolist(), levels[1:].tolist(), strict=True):
        middle, height = (bottom + upper) / 2, upper - bottom
        kind = str(rng.choice(fronts))
        if kind == "doors":
            parts += cabinet_front(x, y - 0.04, bottom, upper, int(rng.integers(1, 5)), shade(color, 0.9))
        elif kind == "drawers":
            columns = int(rng.integers(1, 4))
            for k in range(columns):
                aside, wide = ((k + 0.5) / columns - 0.5) * (y - 0.04), (y - 0.04) / columns - 0.03
                parts.append(box((x / 2, aside, middle), (0.018, wide, height - 0.03), other, "wood"))
                parts.append(box((x / 2 + 0.014, aside, middle), (0.016, 0.1, 0.014), COLORS["silver"], "metal"))
        elif kind == "shelves":
            parts.append(box((x / 2 - 0.005, 0, middle), (0.02, y - 0.06, height - 0.04), DARK))
            parts.append(box((x / 2, 0, middle), (0.02, y - 0.06, 0.02), other))
        elif kind == "window":
            glass = COLORS["silver"] if rng.random() < 0.5 else DARK
            wide = float(rng.uniform(0.4, 0.9)) * y
            parts.append(box((x / 2, 0, middle), (0.02, wide, 0.8 * height), other))
            parts.append(box((x / 2 + 0.006, 0, middle), (0.02, 0.85 * wide, 0.65 * height), glass, "gloss"))
        elif kind == "dials":
            for k in range(int(rng.integers(2, 6))):
                at = (x / 2, (0.14 * k - 0.28) * y, middle)
                parts.append(ellipsoid(at, (0.05, 0.09, 0.09), other if k % 2 else DARK, "gloss"))
        else:
            parts.append(box((x / 2, 0, middle), (0.02, 0.5 * y, min(0.06, 0.5 * height)), DARK))
    if rng.random() < 0.25:
        one, end = ((x / 2 + 0.03, side * 0.4 * y, high - 0.05) for side in (-1, 1))
        parts.append(rod(one, end, 0.014, other, "metal"))
    if rng.random() < 0.2:
        parts.append(cylinder((0.3 * x, 0.3 * y, (low + high) / 2), 0.05, tall, other))
    return parts


def _unsolid(part: Part) -> Part:
    """The same to look at only: the body stands in for it."""
    return Part(part.shape, part.size_m, part.pos_m, part.color, part.material)
