"""Things that do not exist, to practise on: whoever has seen a thousand shapes knows a thing when it sees one.

Each is a body or two to hold and bump into, and layers, bands, lids, knobs, handles, legs and panels to look at, drawn
from its number. Its name is a word for something that is not among the kinds of the package, so that neither the word
tells the shape nor the shape the word (randomised shapes, as in Tobin et al. 2018, "Domain randomization and generative
models for robotic grasping").
"""

from __future__ import annotations

from functools import cache
from itertools import pairwise

import numpy as np

from hv_sim.object_kinds.kind import ObjectKind, Size
from hv_sim.parts import COLORS, Color, Part, box, cylinder, ellipsoid, rod, shade

PREFIX, COUNT = "made_up_", 2000
"""Kinds `made_up_0000` to `made_up_1999`."""
NOUNS = (
    "typewriter", "samovar", "crucible", "accordion", "sewing machine", "hourglass", "metronome", "gramophone",
    "dollhouse", "terrarium", "aquarium", "humidifier", "heater", "projector", "router", "turntable", "tureen",
    "hatbox", "birdhouse", "bird cage", "beehive", "telescope", "microscope", "trophy", "helmet", "bust", "statue",
    "figurine", "sculpture", "jukebox", "cash register", "safe", "anvil", "vice", "generator", "compressor", "battery",
    "transformer", "pump", "motor", "gearbox", "winch", "pulley", "beacon", "siren", "buoy", "sled", "saddle", "easel",
    "abacus", "chessboard", "puzzle", "rocking horse", "spinning top", "toy castle", "toy truck", "robot", "drone",
    "doll", "candelabra", "incense burner", "fountain", "spinning wheel", "churn", "mortar", "grater", "juicer",
    "waffle iron", "fondue set", "cake stand", "cheese dome", "scale", "weighing scale", "water filter", "soda siphon",
    "vaporizer", "sterilizer", "centrifuge", "oscilloscope", "voltmeter", "modem", "console", "joystick", "camera",
    "tripod", "megaphone", "trumpet", "tuba", "xylophone", "harp", "banjo", "bongo", "gong", "bell", "clarinet",
    "periscope", "compass", "sextant", "barometer", "sundial", "weather vane", "gnome", "scarecrow", "wheelbarrow",
    "sprinkler", "trellis", "hay bale", "anchor", "life buoy", "oar", "lobster trap", "fish trap", "net float",
    "surf board",
)  # fmt: skip
_MATERIALS = ("matte", "matte", "gloss", "metal", "wood", "fabric")
_MOST_SEEN = 18
"""Parts of an object that are only looked at; a scene has room for so many."""
_DARK: Color = (0.08, 0.08, 0.09)


@cache
def made_up_kind(number: int) -> ObjectKind:
    """Made-up kind number `number`, always the same."""
    rng = np.random.default_rng([number, 17])
    is_round = bool(rng.random() < 0.45)
    across = rng.uniform(0.16, 0.4, 2).round(3)
    height = round(float(rng.uniform(0.16, 0.58)), 3)
    size = (float(across[0]), float(across[0] if is_round else across[1]), height)
    colors = [str(name) for name in rng.permutation(list(COLORS))[:5]]
    volume = size[0] * size[1] * size[2]
    return ObjectKind(
        lambda full, color: _build(number, is_round, full, color),
        size,
        round(float(np.clip(volume * rng.uniform(60, 160), 0.5, 4.0)), 2),
        colors[0],
        round=is_round,
        category="made up",
        noun=NOUNS[number % len(NOUNS)],
        colors=tuple(colors),
        support=str(rng.choice(["both", "both", "floor", "surface"])),
    )


def _build(number: int, is_round: bool, size: Size, color: Color) -> list[Part]:
    rng = np.random.default_rng([number, 18])
    material = str(rng.choice(_MATERIALS))
    z = size[2]
    form = str(rng.choice(["whole", "whole", "narrow_top", "narrow_foot"]))
    cut, narrow = float(rng.uniform(0.4, 0.7)), float(rng.uniform(0.3, 0.75))
    if form == "whole":
        bodies = [(-z / 2, z / 2, 1.0)]
    elif form == "narrow_top":
        bodies = [(-z / 2, -z / 2 + cut * z, 1.0), (-z / 2 + cut * z, z / 2, narrow)]
    else:
        bodies = [(-z / 2, z / 2 - cut * z, narrow), (z / 2 - cut * z, z / 2, 1.0)]
    solid = [_solid(is_round, *body, size, color) for body in bodies]
    seen = [part for body in bodies for part in _looks_of(rng, is_round, body, size, color, material)]
    return solid + (seen + _trimmings(rng, is_round, bodies, size, color))[:_MOST_SEEN]


def _solid(is_round: bool, low: float, high: float, share: float, size: Size, color: Color) -> Part:
    """What collides between two heights, a `share` of the width across."""
    middle, mass = (0.0, 0.0, (low + high) / 2), share**2
    if is_round:
        radius = share * size[0] / 2
        return cylinder(middle, radius, high - low, color, collides=True, visible=False, mass_share=mass)
    full = (share * size[0], share * size[1], high - low)
    return box(middle, full, color, collides=True, visible=False, mass_share=mass)


def _looks_of(
    rng: np.random.Generator, is_round: bool, body: tuple[float, float, float], size: Size, color: Color, material: str
) -> list[Part]:
    """One to four layers that fill a body, or legs and a top."""
    low, high, share = body
    x, y = share * size[0], share * size[1]
    if high - low > 0.15 and rng.random() < 0.15:
        return _legs(rng, (x, y), low, high, color, material)
    parts = []
    edges = np.sort(np.concatenate([[0.0, 1.0], rng.uniform(0.15, 0.85, int(rng.integers(0, 4)))]))
    widths = np.minimum(rng.uniform(0.72, 1.1, len(edges) - 1), 1.0)
    widths[int(rng.integers(len(widths)))] = 1.0
    other = list(COLORS.values())[int(rng.integers(len(COLORS)))]
    accent = int(rng.integers(len(widths))) if len(widths) > 2 and rng.random() < 0.4 else -1
    shape = str(rng.choice(["straight", "straight", "straight", "bulging"]))
    inner = 0.85 if shape == "bulging" else 1.0
    for i, (a, b) in enumerate(pairwise(edges)):
        bottom, top = low + a * (high - low), low + b * (high - low)
        tint = shade(other if i == accent else color, float(rng.uniform(0.7, 1.1)))
        middle, across = (0.0, 0.0, (bottom + top) / 2), (widths[i] * x, widths[i] * y)
        if shape == "bulging":
            parts.append(ellipsoid(middle, (*across, 1.25 * (top - bottom)), tint, material))
        if is_round:
            parts.append(cylinder(middle, inner * across[0] / 2, top - bottom, tint, material))
        else:
            parts.append(box(middle, (inner * across[0], inner * across[1], top - bottom), tint, material))
    return parts


def _legs(
    rng: np.random.Generator, across: tuple[float, float], low: float, high: float, color: Color, material: str
) -> list[Part]:
    """A top on three or four legs."""
    x, y = across
    top = float(rng.uniform(0.3, 0.6)) * (high - low)
    parts = [box((0, 0, high - top / 2), (x, y, top), color, material)]
    for i in range(4):
        at = ((0.42 if i % 2 else -0.42) * x, (0.42 if i < 2 else -0.42) * y)
        parts.append(rod((*at, low + 0.01), (0.9 * at[0], 0.9 * at[1], high - top), 0.014, shade(color, 0.6)))
    return parts


def _trimmings(
    rng: np.random.Generator, is_round: bool, bodies: list[tuple[float, float, float]], size: Size, color: Color
) -> list[Part]:
    """A few of: a knob, a bar or ears on top, handles, bands, a panel with buttons, an opening, spikes."""
    x, y, z = size
    top_share = bodies[-1][2]
    dark = _DARK if rng.random() < 0.6 else shade(color, 0.5)
    tint = list(COLORS.values())[int(rng.integers(len(COLORS)))] if rng.random() < 0.4 else shade(color, 0.6)
    tx, ty = top_share * x, top_share * y
    parts: list[Part] = []
    crown = int(rng.integers(7))
    if crown == 0:
        parts.append(ellipsoid((0, 0, z / 2), (0.35 * tx, 0.35 * ty, 0.08), tint, "gloss"))
    elif crown == 1:
        parts.append(rod((-0.25 * tx, 0, z / 2 + 0.03), (0.25 * tx, 0, z / 2 + 0.03), 0.012, tint, "metal"))
        parts += [rod((s * 0.25 * tx, 0, z / 2 - 0.01), (s * 0.25 * tx, 0, z / 2 + 0.03), 0.01, tint) for s in (-1, 1)]
    elif crown == 2:
        parts += [ellipsoid((0, s * 0.3 * ty, z / 2), (0.25 * tx, 0.25 * ty, 0.11), tint) for s in (-1, 1)]
    elif crown == 3:
        parts.append(box((0, 0, z / 2), (0.85 * tx, 0.85 * ty, 0.006), _DARK))
    elif crown == 4:
        parts.append(ellipsoid((0, 0, z / 2 - 0.02), (0.9 * tx, 0.9 * ty, 0.18), tint, "fabric"))
    elif crown == 5:
        for k in range(6):
            out = (0.3 * tx * np.cos(k * np.pi / 3), 0.3 * ty * np.sin(k * np.pi / 3))
            parts.append(rod((*out, z / 2 - 0.02), (1.5 * out[0], 1.5 * out[1], z / 2 + 0.08), 0.012, tint))
    for _ in range(int(rng.integers(0, 3))):  # bands
        low, high, share = bodies[int(rng.integers(len(bodies)))]
        at, wide = float(rng.uniform(low + 0.02, high - 0.02)), share * 1.005
        height = float(rng.uniform(0.01, 0.05))
        if is_round:
            parts.append(cylinder((0, 0, at), wide * x / 2, height, dark, "metal"))
        else:
            parts.append(box((0, 0, at), (wide * x, wide * y, height), dark, "metal"))
    low, high, share = bodies[0] if bodies[0][2] == 1.0 else bodies[-1]
    middle, tall = (low + high) / 2, high - low
    front = 0.5 * x * share
    if rng.random() < 0.4:  # a panel, with buttons or not
        panel = (0.012, float(rng.uniform(0.3, 0.7)) * y, float(rng.uniform(0.3, 0.7)) * tall)
        parts.append(box((front, 0, middle), panel, dark, "gloss"))
        for k in range(int(rng.integers(0, 4))):
            button = (front + 0.006, (0.12 * k - 0.18) * y, middle - 0.25 * panel[2])
            parts.append(ellipsoid(button, (0.012, 0.025, 0.025), tint))
    if rng.random() < 0.3:  # handles before and behind
        for s in (-1, 1):
            grip = (s * (front + 0.03), 0.0, middle + 0.2 * tall)
            parts.append(rod((s * front, 0.0, middle - 0.1 * tall), grip, 0.01, tint, "metal"))
            parts.append(rod(grip, (s * front, 0.0, middle + 0.3 * tall), 0.01, tint, "metal"))
    if rng.random() < 0.25:  # spots
        for _ in range(5):
            angle, level = rng.uniform(0, 2 * np.pi), float(rng.uniform(low + 0.1 * tall, high - 0.1 * tall))
            place = (0.48 * x * np.cos(angle), 0.48 * y * np.sin(angle), level)
            parts.append(ellipsoid(place, (0.05, 0.05, 0.05), tint))
    return parts
