"""Movable objects: what the robot can lift by squeezing them between its two hands.

Every object is a few upright boxes and cylinders for contact and finer primitives to look at. Its frame sits at the
centre of its bounding box, z up, its front along +x. Hands press two opposing, vertical side faces; there is one such
pair for each of the four directions from which the robot may face the object.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hv_sim.parts import COLORS, Color, Part, bounding_half_extents_m, box, cylinder, ellipsoid, rod, shade, tilt

GRASP_WIDTH_M = (0.15, 0.45)
"""Narrowest and widest distance between the hands."""
MASS_KG = (0.3, 6.0)
"""Lightest and heaviest object that a task may ask for."""

_DARK = (0.10, 0.09, 0.09)


@dataclass(frozen=True)
class ObjectKind:
    """A kind of movable object.

    Attributes:
        build: (full size (x, y, z) in metres, colour) -> parts in the object's frame.
        size_m: usual full size.
        mass_kg: usual mass.
        color: usual colour, a name in `COLORS`.
        grasp_height: where the hands press, above the centre, as a share of the full height.
        round: stands on a round foot, so its sizes along x and y are the same.
        max_height_m: tallest that still looks and balances right.
    """

    build: Callable[[tuple[float, float, float], Color], list[Part]]
    size_m: tuple[float, float, float]
    mass_kg: float
    color: str
    grasp_height: float = 0.2
    round: bool = False
    max_height_m: float = 0.6


@dataclass(frozen=True)
class BuiltObject:
    """An object made to size.

    Attributes:
        parts: in the object's frame.
        half_extents_m: (3,) of its bounding box, which is what collides.
        mass_kg: total.
        com_m: (3,) centre of mass in the object's frame; x and y are zero.
        inertia: (3,) principal moments about the centre of mass, along the object's axes, kg m^2.
        grasps_o: (4, 2, 3) contact points of the (left, right) hand in the object's frame for a robot that faces along
            the object's +x, +y, -x, -y axis, metres.
    """

    parts: tuple[Part, ...]
    half_extents_m: np.ndarray
    mass_kg: float
    com_m: np.ndarray
    inertia: np.ndarray
    grasps_o: np.ndarray


def build_object(
    kind: str,
    size_m: tuple[float, float, float] | None = None,
    mass_kg: float | None = None,
    color: str | None = None,
) -> BuiltObject:
    """Makes an object of a kind in `OBJECT_KINDS`; what is left out takes the kind's usual value.

    Raises:
        ValueError: `size_m: ...` when the object would be too narrow, too wide or too tall to be carried, or a round
            one is not as wide as deep; `mass_kg: ...` outside `MASS_KG`.
        KeyError: an unknown kind or colour.
    """
    spec = OBJECT_KINDS[kind]
    size = spec.size_m if size_m is None else (float(size_m[0]), float(size_m[1]), float(size_m[2]))
    mass = spec.mass_kg if mass_kg is None else float(mass_kg)
    _check_size(kind, spec, size)
    if not MASS_KG[0] <= mass <= MASS_KG[1]:
        raise ValueError(f"mass_kg: {mass:g} cannot be carried; valid: {MASS_KG[0]:g} to {MASS_KG[1]:g}")
    parts = tuple(spec.build(size, COLORS[spec.color if color is None else color]))
    com, inertia = _mass_properties(parts, mass)
    return BuiltObject(parts, bounding_half_extents_m(parts), mass, com, inertia, _grasps(size, spec.grasp_height))


def _check_size(kind: str, spec: ObjectKind, size: tuple[float, float, float]) -> None:
    low, high = GRASP_WIDTH_M
    if not all(low <= s <= high for s in size[:2]):
        raise ValueError(
            f"size_m: {list(size)} cannot be held by a {kind}'s sides; valid: {low:g} to {high:g} along x and y"
        )
    if not 0.1 <= size[2] <= spec.max_height_m:
        raise ValueError(f"size_m: {list(size)} is not a {kind}'s height; valid: 0.1 to {spec.max_height_m:g} along z")
    if spec.round and abs(size[0] - size[1]) > 1e-9:
        raise ValueError(f"size_m: {list(size)} is not round as a {kind} is; valid: the same size along x and y")


def _grasps(size: tuple[float, float, float], grasp_height: float) -> np.ndarray:
    grasps = np.zeros((4, 2, 3))
    for i in range(4):
        angle = i * np.pi / 2
        left = np.array([-np.sin(angle), np.cos(angle)]).round(12)
        half_width = abs(left @ np.asarray(size[:2])) / 2
        grasps[i, 0, :2], grasps[i, 1, :2] = half_width * left, -half_width * left
        grasps[i, :, 2] = grasp_height * size[2]
    return grasps


def _mass_properties(parts: tuple[Part, ...], mass_kg: float) -> tuple[np.ndarray, np.ndarray]:
    """Centre of mass (3,) and principal moments (3,) of solid parts, whose arrangement must be symmetric in x and y."""
    solid = [p for p in parts if p.mass_share > 0]
    share = np.array([p.mass_share for p in solid])
    masses = mass_kg * share / share.sum()
    positions = np.array([p.pos_m for p in solid])
    com = masses @ positions / mass_kg
    # MuJoCo lays its arrays out differently when a centre of mass is exactly the body's origin; scenes that run in one
    # batch must not differ in that, so no object's centre of mass lies less than a millimetre from its centre.
    com = np.array([0.0, 0.0, com[2] if abs(com[2]) >= 1e-3 else -1e-3])
    inertia = np.zeros(3)
    for part, mass, position in zip(solid, masses, positions, strict=True):
        if part.shape == "box":
            x2, y2, z2 = np.square(part.size_m)
            local = mass / 3 * np.array([y2 + z2, x2 + z2, x2 + y2])
        else:
            radius, half_height = part.size_m[:2]
            side = mass * (radius**2 / 4 + half_height**2 / 3)
            local = np.array([side, side, mass * radius**2 / 2])
        d = position - com
        inertia += local + mass * (d @ d - d**2)
    return com, inertia


def _box(size: tuple[float, float, float], color: Color) -> list[Part]:
    x, y, z = size
    tape, ink = shade(color, 1.25), shade(color, 0.45)
    return [
        box((0, 0, 0), size, color, "cardboard", collides=True, mass_share=1),
        box((0, 0, z / 2), (0.055, y * 0.99, 0.003), tape, "gloss"),
        box((0, y / 2 - 0.0005, z / 2 - 0.03), (0.055, 0.003, 0.06), tape, "gloss"),
        box((0, -y / 2 + 0.0005, z / 2 - 0.03), (0.055, 0.003, 0.06), tape, "gloss"),
        box((0.0, 0, z / 2 + 0.0005), (0.004, y, 0.003), ink),
        box((x / 2, -0.18 * y, 0.12 * z), (0.003, 0.36 * y, 0.30 * z), COLORS["white"]),
        box((x / 2 + 0.0015, -0.18 * y, 0.16 * z), (0.002, 0.26 * y, 0.04 * z), _DARK),
        box((x / 2 + 0.0015, -0.18 * y, 0.07 * z), (0.002, 0.26 * y, 0.04 * z), _DARK),
        box((-x / 2, 0, 0), (0.003, 0.12 * y, 0.22 * z), ink),
        box((-x / 2, 0, 0.13 * z), (0.003, 0.22 * y, 0.05 * z), ink),
    ]


def _crate(size: tuple[float, float, float], color: Color) -> list[Part]:
    x, y, z = size
    parts = [
        box((0, 0, 0), size, color, collides=True, visible=False, mass_share=1),
        box((0, 0, -0.02 * z), (x - 0.03, y - 0.03, 0.95 * z), shade(color, 0.28)),
    ]
    for level in (-0.36, 0.0, 0.36):
        parts.append(box((0, 0, level * z), (x - 0.008, y - 0.008, 0.25 * z), color, "wood"))
    parts.append(box((0, 0, z / 2 - 0.008), (x - 0.05, y - 0.05, 0.016), shade(color, 0.22)))
    post = 0.035
    for sx in (-1, 1):
        for sy in (-1, 1):
            at = (sx * (x - post) / 2, sy * (y - post) / 2, 0.0)
            parts.append(box(at, (post, post, z), shade(color, 0.82), "wood"))
    return parts


def _basket(size: tuple[float, float, float], color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    rim = 0.12 * z
    parts = [
        cylinder((0, 0, 0), r, z, color, collides=True, visible=False, mass_share=1),
        cylinder((0, 0, -0.30 * z), 0.90 * r, 0.40 * z, color, "wicker"),
        cylinder((0, 0, 0.05 * z), 0.95 * r, 0.70 * z, color, "wicker"),
        cylinder((0, 0, z / 2 - rim / 2), r, rim, shade(color, 0.72), "wicker"),
        cylinder((0, 0, z / 2), 0.86 * r, 0.003, shade(color, 0.25)),
        ellipsoid((0.25 * r, 0.15 * r, z / 2 - 0.01), (1.0 * r, 0.9 * r, 0.10), COLORS["white"], "fabric"),
        ellipsoid((-0.3 * r, -0.25 * r, z / 2 - 0.01), (0.9 * r, 0.8 * r, 0.08), COLORS["teal"], "fabric"),
    ]
    for side in (-1, 1):
        for arm in (-1, 1):
            parts.append(
                rod(
                    (side * r, arm * 0.3 * r, z / 2 - 0.02),
                    (side * 1.02 * r, 0, z / 2 + 0.045),
                    0.012,
                    shade(color, 0.6),
                )
            )
    return parts


def _trash_bin(size: tuple[float, float, float], color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    return [
        cylinder((0, 0, 0), r, z, color, collides=True, visible=False, mass_share=1),
        cylinder((0, 0, -0.40 * z), 0.80 * r, 0.20 * z, color, "metal"),
        cylinder((0, 0, -0.20 * z), 0.86 * r, 0.25 * z, color, "metal"),
        cylinder((0, 0, 0.03 * z), 0.92 * r, 0.25 * z, color, "metal"),
        cylinder((0, 0, 0.28 * z), 0.97 * r, 0.30 * z, color, "metal"),
        cylinder((0, 0, 0.46 * z), r, 0.08 * z, shade(color, 0.6), "metal"),
        cylinder((0, 0, z / 2), 0.90 * r, 0.003, (0.04, 0.04, 0.04)),
        ellipsoid((0.2 * r, 0.1 * r, z / 2 - 0.01), (0.8 * r, 0.7 * r, 0.05), COLORS["white"], "fabric"),
    ]


def _stool(size: tuple[float, float, float], color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    seat = min(0.14, 0.4 * z)
    leg = z - seat
    foot = 0.72 * r
    wood = COLORS["walnut"]
    parts = [
        cylinder((0, 0, z / 2 - seat / 2), r, seat, color, "fabric", collides=True, visible=False, mass_share=0.6),
        cylinder((0, 0, z / 2 - seat / 2), 0.985 * r, seat * 0.96, color, "fabric"),
        cylinder((0, 0, z / 2 - 0.02), r, 0.012, shade(color, 0.7), "fabric"),
        cylinder((0, 0, z / 2 - seat + 0.02), r, 0.012, shade(color, 0.7), "fabric"),
        ellipsoid((0, 0, z / 2), (0.04, 0.04, 0.02), shade(color, 0.6)),
    ]
    for sx in (-1, 1):
        for sy in (-1, 1):
            at = (sx * foot * 0.7071, sy * foot * 0.7071, -z / 2 + leg / 2)
            parts.append(cylinder(at, 0.02, leg, wood, "wood", collides=True, mass_share=0.1))
    rail, reach = -z / 2 + 0.35 * leg, foot * 0.7071
    for side in (-1, 1):
        parts.append(rod((-reach, side * reach, rail), (reach, side * reach, rail), 0.009, wood, "wood"))
    return parts


def _plant(size: tuple[float, float, float], color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    pot = min(0.24, 0.48 * z)
    top = -z / 2 + pot
    leaf = (0.20, 0.50, 0.20)
    parts = [
        cylinder((0, 0, -z / 2 + pot / 2), r, pot, color, collides=True, visible=False, mass_share=0.9),
        cylinder((0, 0, -z / 2 + 0.40 * pot), 0.90 * r, 0.80 * pot, color),
        cylinder((0, 0, top - 0.12 * pot), r, 0.24 * pot, shade(color, 1.12)),
        cylinder((0, 0, top), 0.88 * r, 0.004, (0.16, 0.10, 0.07)),
        cylinder((0, 0, (z / 2 + top) / 2), 0.6 * r, z / 2 - top, leaf, collides=True, visible=False, mass_share=0.1),
    ]
    crown = z / 2 - top
    for i in range(6):  # a ring of leaning leaves around an upright one
        angle, lean = i * 2 * np.pi / 6, 0.55 if i % 2 else 0.85
        out = 0.55 * r
        at = (out * np.cos(angle), out * np.sin(angle), top + crown * (0.52 if i % 2 else 0.36))
        length = crown * (0.92 if i % 2 else 0.75)
        parts.append(
            ellipsoid(
                at, (0.035, 0.55 * r, length), shade(leaf, 0.8 + 0.12 * (i % 3)), "matte", quat=tilt(0, lean, angle)
            )
        )
    parts.append(ellipsoid((0, 0, top + 0.5 * crown), (0.5 * r, 0.5 * r, crown), shade(leaf, 1.15)))
    return parts


def _lamp(size: tuple[float, float, float], color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    hood = 0.48 * z
    base = 0.18 * z
    warm = (1.0, 0.92, 0.72)
    stem = z - hood - base
    return [
        cylinder((0, 0, z / 2 - hood / 2), r, hood, warm, "glow", collides=True, visible=False, mass_share=0.25),
        cylinder((0, 0, z / 2 - 0.30 * hood), 0.90 * r, 0.58 * hood, warm, "glow"),
        cylinder((0, 0, z / 2 - 0.70 * hood), 0.98 * r, 0.58 * hood, warm, "glow"),
        cylinder((0, 0, z / 2 - hood + 0.008), r, 0.016, shade(color, 0.9)),
        cylinder((0, 0, z / 2 - 0.005), 0.92 * r, 0.012, shade(color, 0.9)),
        cylinder((0, 0, z / 2), 0.5 * r, 0.003, (1.0, 1.0, 0.9), "glow"),
        cylinder((0, 0, -z / 2 + base + stem / 2), 0.025, stem, color, "gloss", collides=True, mass_share=0.1),
        cylinder(
            (0, 0, -z / 2 + base / 2), 0.70 * r, base, color, "gloss", collides=True, visible=False, mass_share=0.65
        ),
        cylinder((0, 0, -z / 2 + 0.2 * base), 0.70 * r, 0.4 * base, color, "gloss"),
        ellipsoid((0, 0, -z / 2 + 0.4 * base), (1.3 * r, 1.3 * r, 1.3 * base), color, "gloss"),
    ]


def _vase(size: tuple[float, float, float], color: Color) -> list[Part]:
    r, z = size[0] / 2, size[2]
    belly = 0.70 * z
    middle = -z / 2 + belly / 2
    neck = z - belly
    return [
        cylinder((0, 0, middle), r, belly, color, collides=True, visible=False, mass_share=0.9),
        cylinder((0, 0, z / 2 - neck / 2), 0.5 * r, neck, color, collides=True, visible=False, mass_share=0.1),
        cylinder((0, 0, -z / 2 + 0.03 * z), 0.62 * r, 0.06 * z, shade(color, 0.8), "gloss"),
        ellipsoid((0, 0, middle - 0.04 * z), (2 * r, 2 * r, 0.92 * belly), color, "gloss"),
        cylinder((0, 0, middle), 0.995 * r, 0.34 * belly, color, "gloss"),
        ellipsoid((0, 0, middle + 0.06 * z), (1.98 * r, 1.98 * r, 0.92 * belly), color, "gloss"),
        cylinder((0, 0, z / 2 - 0.5 * neck), 0.40 * r, neck, color, "gloss"),
        cylinder((0, 0, z / 2 - 0.02), 0.55 * r, 0.04, shade(color, 1.1), "gloss"),
        cylinder((0, 0, z / 2), 0.40 * r, 0.003, _DARK),
        cylinder((0, 0, middle + 0.09 * z), r, 0.012, COLORS["yellow"], "gloss"),
        cylinder((0, 0, middle - 0.09 * z), r, 0.012, COLORS["yellow"], "gloss"),
    ]


def _toaster(size: tuple[float, float, float], color: Color) -> list[Part]:
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


def _cooking_pot(size: tuple[float, float, float], color: Color) -> list[Part]:
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


def _suitcase(size: tuple[float, float, float], color: Color) -> list[Part]:
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


def _speaker(size: tuple[float, float, float], color: Color) -> list[Part]:
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


def _microwave(size: tuple[float, float, float], color: Color) -> list[Part]:
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


OBJECT_KINDS: dict[str, ObjectKind] = {
    "box": ObjectKind(_box, (0.30, 0.30, 0.28), 2.0, "tan"),
    "crate": ObjectKind(_crate, (0.34, 0.38, 0.30), 3.0, "oak"),
    "basket": ObjectKind(_basket, (0.34, 0.34, 0.28), 1.2, "tan", round=True),
    "trash_bin": ObjectKind(_trash_bin, (0.28, 0.28, 0.36), 1.0, "charcoal", grasp_height=0.24, round=True),
    "stool": ObjectKind(_stool, (0.34, 0.34, 0.42), 2.5, "teal", grasp_height=0.333, round=True),
    "plant": ObjectKind(_plant, (0.26, 0.26, 0.50), 2.5, "terracotta", grasp_height=-0.14, round=True),
    "lamp": ObjectKind(_lamp, (0.28, 0.28, 0.44), 1.5, "blue", grasp_height=0.24, round=True),
    "vase": ObjectKind(_vase, (0.24, 0.24, 0.36), 1.5, "navy", grasp_height=0.0, round=True),
    "toaster": ObjectKind(_toaster, (0.22, 0.32, 0.22), 1.8, "red", max_height_m=0.4),
    "cooking_pot": ObjectKind(_cooking_pot, (0.28, 0.28, 0.24), 2.0, "silver", grasp_height=-0.05, round=True,
                              max_height_m=0.4),
    "suitcase": ObjectKind(_suitcase, (0.22, 0.36, 0.48), 3.0, "orange"),
    "speaker": ObjectKind(_speaker, (0.24, 0.22, 0.36), 3.0, "walnut"),
    "microwave": ObjectKind(_microwave, (0.32, 0.44, 0.26), 4.5, "white", max_height_m=0.4),
}  # fmt: skip
"""Kinds that a task file may name."""
