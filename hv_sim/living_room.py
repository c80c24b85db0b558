"""The living room: floor, walls with windows, a door and pictures, and the light in it.

The room's centre is the world's origin, the floor is z = 0; the first size runs along x, the second along y.
"""

from __future__ import annotations

import numpy as np

from hv_sim.parts import COLORS, Color, Part, box, cylinder, moved, rod, shade, tilt

WALL_HEIGHT_M = 2.5
WALL_THICKNESS_M = 0.2

FLOORS: dict[str, tuple[str, Color]] = {
    "oak": ("planks", (0.80, 0.62, 0.43)),
    "walnut": ("planks", (0.52, 0.36, 0.25)),
    "tiles": ("tiles", (0.86, 0.84, 0.80)),
    "carpet": ("plush", (0.66, 0.62, 0.58)),
}
"""Floor names that a task file may use -> material and colour."""

ROOM_SIZE_M = ((4.0, 10.0), (4.0, 10.0))
"""Smallest and largest size along x and y."""

_SKIRTING = (0.92, 0.91, 0.88)


def build_living_room(size_m: tuple[float, float], floor: str = "oak", wall_color: str = "cream") -> list[Part]:
    """Parts of an empty room, in the world frame.

    Walls are one-sided planes to look at, which leaves the view from outside free, backed by invisible boxes that
    collide. The floor's plane is not among the parts: the scene adds it, because it is the one shape without end.

    Raises:
        KeyError: a floor that is not in `FLOORS` or a colour that is not in `COLORS`.
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
    details = {
        "north": _window(0.24 * x) + _window(-0.24 * x),
        "south": _door(-0.33 * x) + _picture(0.2 * x, 0.9, 0.6, "landscape"),
        "east": _picture(0.0, 0.6, 0.8, "painting"),
        "west": _picture(0.15 * y, 0.8, 0.55, "landscape") + _clock(-0.25 * y),
    }
    parts: list[Part] = []
    for name, (foot, yaw, length) in walls.items():
        parts += moved(
            _wall(length, shade(color, 0.96 if name in ("east", "west") else 1.0)) + details[name], foot, yaw
        )
    return parts


def _wall(length: float, color: Color) -> list[Part]:
    upright = tilt(0, np.pi / 2)  # turns the plane's normal from up to +x
    thickness = WALL_THICKNESS_M
    middle = (-thickness / 2, 0, WALL_HEIGHT_M / 2)
    return [
        Part("plane", (WALL_HEIGHT_M / 2, length / 2, 1.0), (0.0, 0.0, WALL_HEIGHT_M / 2), color, quat=upright),
        box(middle, (thickness, length + 2 * thickness, WALL_HEIGHT_M), color, collides=True, visible=False),
        box((0.0, 0, 0.05), (0.05, length, 0.10), _SKIRTING),
    ]


def _window(at: float) -> list[Part]:
    wide, tall, middle, frame = 1.2, 1.15, 1.45, COLORS["white"]
    parts = [
        box((0.005, at, middle), (0.01, wide, tall), (1, 1, 1), "sky"),
        box((0.02, at, middle), (0.03, 0.035, tall), frame),
        box((0.02, at, middle + 0.1), (0.03, wide, 0.03), frame),
        box((0.05, at, middle - tall / 2 - 0.02), (0.14, wide + 0.2, 0.035), frame),
        rod(
            (0.07, at - 0.95, middle + tall / 2 + 0.12),
            (0.07, at + 0.95, middle + tall / 2 + 0.12),
            0.015,
            COLORS["charcoal"],
        ),
    ]
    for side in (-1, 1):
        parts.append(box((0.02, at + side * wide / 2, middle), (0.04, 0.05, tall + 0.05), frame))
        parts.append(box((0.02, at, middle + side * tall / 2), (0.04, wide + 0.05, 0.05), frame))
        for fold in range(2):  # curtain
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
