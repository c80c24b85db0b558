"""Movable objects: what the robot can lift by squeezing them between its two hands.

Every object is a few upright boxes and cylinders for contact and finer primitives to look at. Its frame sits at the
centre of its bounding box, z up, its front along +x. Hands press two opposing, vertical side faces; there is one such
pair for each of the four directions from which the robot may face the object.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hv_sim.kinds import Kinds
from hv_sim.lying_grasps import first_hit_m
from hv_sim.object_kinds.containers import CONTAINERS
from hv_sim.object_kinds.decor import DECOR
from hv_sim.object_kinds.electronics import ELECTRONICS
from hv_sim.object_kinds.kind import ObjectKind
from hv_sim.object_kinds.kitchenware import KITCHENWARE
from hv_sim.object_kinds.luggage import LUGGAGE
from hv_sim.object_kinds.made_up import COUNT, PREFIX, made_up_kind
from hv_sim.object_kinds.seats import SEATS
from hv_sim.object_kinds.small_tables import SMALL_TABLES
from hv_sim.object_kinds.soft import SOFT
from hv_sim.object_kinds.tools import TOOLS
from hv_sim.parts import COLORS, Part, Prism, bounding_half_extents_m, prisms
from hv_sim.user_objects import user_kinds

BELOW_TOP_M, PATCH_M, FLUSH_M = 0.05, 0.02, 0.012
"""How far below the upper edge of a face a hand presses, half of the patch that it needs, and how far inside the
bounding box that may lie."""
AHEAD_M, EDGE_M = (0.055, 0.045, 0.035, 0.025, 0.015), 0.035
"""How far beyond the middle of a face, seen from the robot, hands press, the most first, and how much face they need
farther on. They roll back by 3 cm until an object is put down; what hangs from behind its centre of mass tips over."""
GRASP_WIDTH_M = (0.15, 0.45)
"""Narrowest and widest distance between the hands."""
MASS_KG = (0.3, 15.0)
"""Lightest and heaviest object that a task may ask for."""


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
        grasp_ok: (4,) bool: nothing of the object is in the way of the hands or of the robot there.
    """

    parts: tuple[Part, ...]
    half_extents_m: np.ndarray
    mass_kg: float
    com_m: np.ndarray
    inertia: np.ndarray
    grasps_o: np.ndarray
    grasp_ok: np.ndarray

    @property
    def rolls(self) -> bool:
        """All of it that collides is round about the z axis of its frame."""
        solid = [part for part in self.parts if part.collides]
        return all(part.shape == "cylinder" and not np.any(part.pos_m[:2]) for part in solid)


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
    return BuiltObject(
        parts,
        bounding_half_extents_m(parts),
        mass,
        com,
        inertia,
        *propose_grasps(parts, spec.blocked),
    )


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


def propose_grasps(parts: Sequence[Part], blocked: Sequence[int] = ()) -> tuple[np.ndarray, np.ndarray]:
    """Where two hands press the opposite sides of an object for each direction that a robot may face, and whether.

    As high as may be, because what is held near its middle tips over between hands that roll a little while the
    forearms turn; but `BELOW_TOP_M` below the upper edge of the faces that are pressed.

    Args:
        parts: in the object's frame.
        blocked: directions in which a part of it is in the way.

    Returns:
        (4, 2, 3) as `BuiltObject.grasps_o`, and (4,) bool as `BuiltObject.grasp_ok`.
    """
    half = bounding_half_extents_m(parts)
    solid = prisms(parts)
    grasps, ok = np.zeros((4, 2, 3)), np.zeros(4, dtype=bool)
    heights = [_pressed_height_m(solid, half, axis) for axis in (0, 1)]
    for i in range(4):
        angle = i * np.pi / 2
        left = np.array([-np.sin(angle), np.cos(angle)]).round(12)
        pressed = 1 - i % 2
        grasps[i, 0, :2], grasps[i, 1, :2] = half[pressed] * left, -half[pressed] * left
        height = heights[pressed]
        grasps[i, :, 2] = 0.0 if height is None else height
        ok[i] = height is not None and i not in blocked
        if ok[i]:
            grasps[i] = _further_ahead(parts, grasps[i], np.array([np.cos(angle), np.sin(angle), 0.0]).round(12))
    return grasps, ok


def _further_ahead(parts: Sequence[Part], grasp: np.ndarray, ahead: np.ndarray) -> np.ndarray:
    """(2, 3) contact points as far in a direction as the faces at (2, 3) go on, at most by the first of `AHEAD_M`."""
    outward = (grasp[0] - grasp[1]) / np.linalg.norm(grasp[0] - grasp[1])
    by = np.asarray(AHEAD_M)
    reached, there = np.ones(len(by), dtype=bool), []
    for point, out in zip(grasp, (outward, -outward), strict=True):
        start = point + 3 * FLUSH_M * out
        reached &= first_hit_m(parts, start + (by + EDGE_M)[:, None] * ahead, -out) < 4 * FLUSH_M
        inward = first_hit_m(parts, start + by[:, None] * ahead, -out).clip(max=1.0)  # finite where it counts
        there.append(start + by[:, None] * ahead - inward[:, None] * out)
    if not reached.any():
        return grasp
    return np.stack(there, 1)[int(reached.argmax())]


def _pressed_height_m(solid: Sequence[Prism], half: np.ndarray, axis: int) -> float | None:
    """The height at which both sides along an axis offer a hand a face at the bounding box, or None."""
    faces: list[list[tuple[float, float]]] = [[], []]
    for one in solid:
        low, high = one.polygon_m.min(0), one.polygon_m.max(0)
        other = 1 - axis
        if low[other] > -PATCH_M or high[other] < PATCH_M or one.z_high_m - one.z_low_m < 2 * PATCH_M:
            continue
        for side, reached in enumerate((-low[axis], high[axis])):
            if reached > half[axis] - FLUSH_M:
                faces[side].append((one.z_low_m, one.z_high_m))
    best = None
    for low_a, high_a in faces[0]:
        for low_b, high_b in faces[1]:
            low, high = max(low_a, low_b), min(high_a, high_b)
            if high - low < 2 * PATCH_M:
                continue
            height = max(high - BELOW_TOP_M, (low + high) / 2)
            best = height if best is None else max(best, height)
    return best


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


PACKAGED_KINDS: dict[str, ObjectKind] = {
    **CONTAINERS, **SEATS, **SMALL_TABLES, **DECOR, **KITCHENWARE, **ELECTRONICS, **LUGGAGE, **TOOLS, **SOFT,
}  # fmt: skip
"""Kinds that come with the package."""

OBJECT_KINDS = Kinds({**user_kinds(), **PACKAGED_KINDS}, PREFIX, COUNT, made_up_kind)
"""Kinds that a task file may name: those of the package, the user's own (`hv_sim.user_objects`), and made-up
ones (`hv_sim.object_kinds.made_up`)."""
