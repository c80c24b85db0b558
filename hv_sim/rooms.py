"""Empty rooms: floor, and walls with what hangs on them in a bedroom, a kitchen, a living room and a warehouse.

The room's centre is the world's origin, the floor is z = 0; the first size runs along x, the second along y.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hv_sim.parts import COLORS, Color, Part, box, cylinder, moved, rod, shade, tilt

WALL_HEIGHT_M = 2.5
WALL_THICKNESS_M = 0.2

ROOM_KINDS = ("bedroom", "kitchen", "living_room", "warehouse")

FLOORS: dict[str, tuple[str, Color]] = {
    "oak": ("planks", (0.80, 0.62, 0.43)),
    "walnut": ("planks", (0.52, 0.36, 0.25)),
    "ash": ("planks", (0.88, 0.80, 0.68)),
    "tiles": ("tiles", (0.86, 0.84, 0.80)),
    "slate": ("tiles", (0.50, 0.53, 0.56)),
    "carpet": ("plush", (0.66, 0.62, 0.58)),
    "blue_carpet": ("plush", (0.45, 0.52, 0.62)),
    "concrete": ("matte", (0.62, 0.62, 0.60)),
    "epoxy": ("gloss", (0.46, 0.53, 0.52)),
}
"""Floor names that a task file may use -> material and colour."""

ROOM_SIZE_M = ((4.0, 10.0), (4.0, 10.0))
"""Smallest and largest size along x and y."""

_SKIRTING = (0.92, 0.91, 0.88)


def build_room(kind: str, size_m: tuple[float, float], floor: str = "oak", wall_color: str = "cream") -> list[Part]:
    """Parts of an empty room, in the world frame.

    Walls are one-sided planes to look at, which leaves the view from outside free, backed by invisible boxes that
    collide. The floor's plane is not among the parts: the scene adds it, because it is the one shape without end.

    Raises:
        KeyError: a kind that is not in `ROOM_KINDS`, a floor that is not in `FLOORS` or a colour not in `COLORS`.
    """
    x, y = size_m
    color = COLORS[wall_color]
    # (centre of the wall's foot, yaw): in the wall's frame x points into the room and y runs along the wall
    walls = {
        "north": ((0.0, y / 2), -np.pi / 2, x),
        "south": ((0.0, -y / 2), np.pi / 2, x),
        "east": ((x / 2, 0.0), np.pi, y),
        "west": ((-x / 2, 0.0), 0.0, y),
    }
    details = _DETAILS[kind](x, y)
    parts: list[Part] = []
    for name, (foot, yaw, length) in walls.items():
        tone = shade(color, 0.96 if name in ("east", "west") else 1.0)
        parts += moved(_wall(length, tone, kind) + details[name], foot, yaw)
    return parts


def _living_room(x: float, y: float) -> dict[str, list[Part]]:
    return {
        "north": _window(0.24 * x) + _window(-0.24 * x),
        "south": _door(-0.33 * x) + _picture(0.2 * x, 0.9, 0.6, "landscape"),
        "east": _picture(0.0, 0.6, 0.8, "painting"),
        "west": _picture(0.15 * y, 0.8, 0.55, "landscape") + _clock(-0.25 * y),
    }


def _bedroom(x: float, y: float) -> dict[str, list[Part]]:
    return {
        "north": _window(0.0),
        "south": _door(0.33 * x) + _picture(-0.2 * x, 0.5, 0.7, "painting"),
        "east": _picture(-0.2 * y, 0.7, 0.5, "landscape") + _picture(0.2 * y, 0.7, 0.5, "painting"),
        "west": _picture(0.0, 1.1, 0.6, "landscape"),
    }


def _kitchen(x: float, y: float) -> dict[str, list[Part]]:
    return {
        "north": _backsplash(x) + _window(0.0, tall=0.8, middle=1.62, curtains=False),
        "south": _door(-0.33 * x) + _clock(0.2 * x),
        "east": _picture(0.0, 0.5, 0.5, "painting"),
        "west": _window(0.0, tall=0.9, middle=1.55, curtains=False),
    }


def _warehouse(x: float, y: float) -> dict[str, list[Part]]:
    return {
        "north": _high_window(0.25 * x) + _high_window(-0.25 * x) + _stripe(x),
        "south": _gate(0.0) + _sign(0.36 * x) + _stripe(x),
        "east": _high_window(0.0) + _stripe(y),
        "west": _sign(-0.3 * y) + _high_window(0.1 * y) + _stripe(y),
    }


_DETAILS: dict[str, Callable[[float, float], dict[str, list[Part]]]] = {
    "bedroom": _bedroom,
    "kitchen": _kitchen,
    "living_room": _living_room,
    "warehouse": _warehouse,
}


def _wall(length: float, color: Color, kind: str) -> list[Part]:
    upright = tilt(0, np.pi / 2)  # turns the plane's normal from up to +x
    thickness = WALL_THICKNESS_M
    middle = (-thickness / 2, 0, WALL_HEIGHT_M / 2)
    return [
        Part("plane", (WALL_HEIGHT_M / 2, length / 2, 1.0), (0.0, 0.0, WALL_HEIGHT_M / 2), color, quat=upright),
        box(middle, (thickness, length + 2 * thickness, WALL_HEIGHT_M), color, collides=True, visible=False),
        box((0.0, 0, 0.05), (0.05, length, 0.10), COLORS["charcoal"] if kind == "warehouse" else _SKIRTING),
    ]


def _window(at: float, tall: float = 1.15, middle: float = 1.45, curtains: bool = True) -> list[Part]:
    wide, frame = 1.2, COLORS["white"]
    parts = [
        box((0.005, at, middle), (0.01, wide, tall), (1, 1, 1), "sky"),
        box((0.02, at, middle), (0.03, 0.035, tall), frame),
        box((0.02, at, middle + 0.1), (0.03, wide, 0.03), frame),
        box((0.05, at, middle - tall / 2 - 0.02), (0.14, wide + 0.2, 0.035), frame),
    ]
    if curtains:
        high = middle + tall / 2 + 0.12
        parts.append(rod((0.07, at - 0.95, high), (0.07, at + 0.95, high), 0.015, COLORS["charcoal"]))
    for side in (-1, 1):
        parts.append(box((0.02, at + side * wide / 2, middle), (0.04, 0.05, tall + 0.05), frame))
        parts.append(box((0.02, at, middle + side * tall / 2), (0.04, wide + 0.05, 0.05), frame))
        for fold in range(2 if curtains else 0):
            along = at + side * (wide / 2 + 0.07 + 0.12 * fold)
            parts.append(
                Part(
                    "ellipsoid",
                    (0.045, 0.08, tall / 2 + 0.16),
                    (0.06, along, middle - 0.05),
                    shade(COLORS["beige"], 1.0 - 0.08 * fold),
                    "fabric",
                )
            )
    return parts


def _door(at: float) -> list[Part]:
    wood, frame = (0.60, 0.44, 0.30), COLORS["white"]
    return [
        box((0.008, at, 1.02), (0.016, 0.86, 2.04), wood, "wood"),
        box((0.018, at, 1.52), (0.010, 0.62, 0.80), shade(wood, 0.9), "wood"),
        box((0.018, at, 0.52), (0.010, 0.62, 0.66), shade(wood, 0.9), "wood"),
        box((0.015, at - 0.47, 1.05), (0.03, 0.08, 2.10), frame),
        box((0.015, at + 0.47, 1.05), (0.03, 0.08, 2.10), frame),
        box((0.015, at, 2.08), (0.03, 1.02, 0.08), frame),
        rod((0.05, at + 0.34, 1.02), (0.05, at + 0.24, 1.02), 0.012, COLORS["silver"], "metal"),
    ]


def _picture(at: float, wide: float, tall: float, motif: str) -> list[Part]:
    return [
        box((0.012, at, 1.6), (0.024, wide + 0.08, tall + 0.08), COLORS["charcoal"]),
        box((0.020, at, 1.6), (0.014, wide, tall), (1, 1, 1), motif),
    ]


def _clock(at: float) -> list[Part]:
    face = tilt(0, np.pi / 2)
    return [
        cylinder((0.015, at, 1.85), 0.17, 0.03, COLORS["charcoal"], quat=face),
        cylinder((0.022, at, 1.85), 0.15, 0.03, COLORS["white"], quat=face),
        box((0.040, at, 1.90), (0.004, 0.014, 0.10), COLORS["black"]),
        box((0.040, at - 0.04, 1.85), (0.004, 0.08, 0.014), COLORS["black"]),
    ]


def _backsplash(length: float) -> list[Part]:
    """White tiles above the worktop, and wall cupboards at both ends."""
    parts = [box((0.006, 0, 1.18), (0.012, length, 0.6), (0.86, 0.90, 0.92), "tiles")]
    for side in (-1, 1):
        at = side * (length / 2 - 0.75)
        parts.append(box((0.17, at, 1.85), (0.34, 1.3, 0.66), COLORS["white"], "wood"))
        for door in (-1, 1):
            parts.append(box((0.345, at + door * 0.325, 1.85), (0.012, 0.62, 0.62), (0.95, 0.95, 0.93), "wood"))
            parts.append(box((0.355, at + door * 0.06, 1.62), (0.014, 0.014, 0.10), COLORS["silver"], "metal"))
    return parts


def _high_window(at: float) -> list[Part]:
    parts = [box((0.005, at, 2.15), (0.01, 1.6, 0.4), (1, 1, 1), "sky")]
    for across in (-0.8, -0.4, 0.0, 0.4, 0.8):
        parts.append(box((0.02, at + across, 2.15), (0.03, 0.03, 0.42), COLORS["charcoal"]))
    return parts


def _stripe(length: float) -> list[Part]:
    """A yellow line on the floor along the wall, and the steel columns of a hall."""
    parts = [box((0.32, 0, 0.002), (0.08, length - 0.7, 0.004), COLORS["yellow"])]
    for share in (-0.36, 0.0, 0.36):
        parts.append(box((0.03, share * length, 1.25), (0.06, 0.14, 2.5), COLORS["blue"], "metal"))
    return parts


def _gate(at: float) -> list[Part]:
    """A roller shutter."""
    parts = [box((0.02, at, 1.1), (0.04, 2.4, 2.2), (0.72, 0.74, 0.76), "metal")]
    for i in range(11):
        parts.append(box((0.042, at, 0.1 + 0.2 * i), (0.012, 2.36, 0.02), (0.52, 0.54, 0.56), "metal"))
    for side in (-1, 1):
        parts.append(box((0.04, at + side * 1.25, 1.1), (0.08, 0.1, 2.2), COLORS["yellow"]))
        parts.append(box((0.045, at + side * 1.25, 0.5), (0.08, 0.102, 0.2), COLORS["black"]))
        parts.append(box((0.045, at + side * 1.25, 1.1), (0.08, 0.102, 0.2), COLORS["black"]))
    return parts


def _sign(at: float) -> list[Part]:
    return [
        box((0.01, at, 1.7), (0.02, 0.7, 0.45), COLORS["yellow"]),
        box((0.016, at, 1.78), (0.02, 0.5, 0.08), COLORS["black"]),
        box((0.016, at, 1.62), (0.02, 0.36, 0.06), COLORS["black"]),
    ]
