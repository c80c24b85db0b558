"""Basis point sets: a shape as the vectors from fixed points to its surface.

From Prokudin et al., "Efficient Learning on Point Clouds with Basis Point Sets" (ICCV 2019); HumanVLA and HumanoidVerse
describe objects so, with 200 points in the unit ball.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from hv_sim.parts import Part

NUM_BASIS_POINTS = 200


def _basis_points() -> np.ndarray:
    """(200, 3): an even spiral over the unit ball, the same everywhere because no generator is involved."""
    i = np.arange(NUM_BASIS_POINTS) + 0.5
    radius = np.cbrt(i / NUM_BASIS_POINTS)
    shuffled = (i * (np.sqrt(2.0) - 1.0)) % 1.0  # so that height does not follow the radius
    z = 1.0 - 2.0 * shuffled
    angle = np.pi * (1.0 + np.sqrt(5.0)) * i
    ring = np.sqrt(1.0 - z**2)
    points = radius[:, None] * np.stack([ring * np.cos(angle), ring * np.sin(angle), z], -1)
    points.setflags(write=False)
    return points


BASIS_POINTS = _basis_points()
"""(200, 3) the fixed points, in the unit ball."""

_SURFACE_STEP_M = 0.01


def basis_point_set(parts: Iterable[Part]) -> np.ndarray:
    """(200, 3) float32 vectors from `BASIS_POINTS` to the nearest points of an object's surface.

    The object, the union of its colliding parts, is scaled about its frame's origin until its farthest point lies on
    the unit sphere; sizes are therefore lost, and policies are given the half-extents beside it. Points outside the
    object get the exact nearest point, and so do points inside an object of one part; where parts join, points inside
    get the nearest one of a 1 cm grid on the surface.
    """
    solid = [part for part in parts if part.collides]
    if not solid:
        raise ValueError("parts: none of them collides, so there is no surface")
    scale = max(_reach(part) for part in solid)
    targets = nearest_surface_points(BASIS_POINTS * scale, solid)
    return (targets / scale - BASIS_POINTS).astype(np.float32)


def nearest_surface_points(points_m: np.ndarray, parts: Iterable[Part]) -> np.ndarray:
    """(P, 3) the points of the surface of a union of boxes and cylinders that are nearest to (P, 3) points."""
    solid = list(parts)
    projected = np.stack([_project(part, points_m) for part in solid])  # (parts, P, 3)
    distance = np.linalg.norm(projected - points_m, axis=-1)
    best = projected[distance.argmin(0), np.arange(len(points_m))]
    if len(solid) == 1:
        return best
    within = np.stack([_inside(part, points_m, 0.0) for part in solid]).any(0)
    if within.any():
        surface = np.concatenate([_surface_grid(part) for part in solid])
        hidden = np.stack([_inside(part, surface, -1e-6) for part in solid]).any(0)
        # where two parts touch, both of their faces are inside the object
        seam = np.stack([_inside(part, surface, 1e-6) for part in solid]).sum(0) > 1
        surface = surface[~hidden & ~seam]
        for row in np.flatnonzero(within):
            best[row] = surface[np.square(surface - points_m[row]).sum(-1).argmin()]
    return best


def _yaw(part: Part) -> float:
    return 2.0 * np.arctan2(part.quat[3], part.quat[0])


def _to_part(part: Part, points: np.ndarray) -> np.ndarray:
    c, s = np.cos(_yaw(part)), np.sin(_yaw(part))
    return (points - np.asarray(part.pos_m)) @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])


def _from_part(part: Part, local: np.ndarray) -> np.ndarray:
    c, s = np.cos(_yaw(part)), np.sin(_yaw(part))
    return local @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]]) + np.asarray(part.pos_m)


def _reach(part: Part) -> float:
    """Distance from the object's origin to the farthest point of a part."""
    if part.shape == "box":
        signs = np.array(np.meshgrid(*[(-1, 1)] * 3)).reshape(3, -1).T
        return float(np.linalg.norm(_from_part(part, signs * np.asarray(part.size_m)), axis=-1).max())
    across = np.hypot(part.pos_m[0], part.pos_m[1]) + part.size_m[0]
    return float(np.hypot(across, abs(part.pos_m[2]) + part.size_m[1]))


def _inside(part: Part, points: np.ndarray, margin: float) -> np.ndarray:
    """(P,) bool: in the part grown by `margin`."""
    local = _to_part(part, points)
    if part.shape == "box":
        return (np.abs(local) <= np.asarray(part.size_m) + margin).all(-1)
    return (np.hypot(local[:, 0], local[:, 1]) <= part.size_m[0] + margin) & (
        np.abs(local[:, 2]) <= part.size_m[1] + margin
    )


def _project(part: Part, points: np.ndarray) -> np.ndarray:
    """(P, 3) nearest points on one part's surface, from outside or inside."""
    local = _to_part(part, points)
    if part.shape == "box":
        return _from_part(part, _project_box(local, np.asarray(part.size_m)))
    # a cylinder is a rectangle in (radius, height); the axis, where every direction is as good, takes +x
    radius = np.hypot(local[:, 0], local[:, 1])
    direction = np.where(radius[:, None] > 0, local[:, :2] / np.maximum(radius, 1e-12)[:, None], [1.0, 0.0])
    flat = np.stack([radius, local[:, 2]], -1)
    target = np.clip(flat, [0.0, -part.size_m[1]], [part.size_m[0], part.size_m[1]])
    gaps = np.stack([part.size_m[0] - flat[:, 0], part.size_m[1] - flat[:, 1], part.size_m[1] + flat[:, 1]], -1)
    inner = (gaps > 0).all(-1)
    nearest = gaps.argmin(-1)
    target[inner & (nearest == 0), 0] = part.size_m[0]
    target[inner & (nearest == 1), 1] = part.size_m[1]
    target[inner & (nearest == 2), 1] = -part.size_m[1]
    return _from_part(part, np.concatenate([direction * target[:, :1], target[:, 1:]], -1))


def _project_box(local: np.ndarray, half: np.ndarray) -> np.ndarray:
    target = np.clip(local, -half, half)
    gaps = half - np.abs(local)
    inner = np.flatnonzero((gaps > 0).all(-1))
    axis = gaps[inner].argmin(-1)
    target[inner, axis] = np.where(local[inner, axis] >= 0, half[axis], -half[axis])
    return target


def _surface_grid(part: Part) -> np.ndarray:
    """(S, 3) points about 1 cm apart on one part's surface, edges included."""
    if part.shape == "box":
        half = np.asarray(part.size_m)
        lines = [np.linspace(-h, h, max(2, int(np.ceil(2 * h / _SURFACE_STEP_M)) + 1)) for h in half]
        faces = []
        for axis in range(3):
            u, v = (i for i in range(3) if i != axis)
            grid = np.stack(np.meshgrid(lines[u], lines[v], indexing="ij"), -1).reshape(-1, 2)
            for side in (-1, 1):
                face = np.empty((len(grid), 3))
                face[:, u], face[:, v], face[:, axis] = grid[:, 0], grid[:, 1], side * half[axis]
                faces.append(face)
        return _from_part(part, np.concatenate(faces))
    radius, half_height = part.size_m[:2]
    angle = np.linspace(0, 2 * np.pi, max(12, int(np.ceil(2 * np.pi * radius / _SURFACE_STEP_M))), endpoint=False)
    circle = np.stack([np.cos(angle), np.sin(angle)], -1)
    heights = np.linspace(-half_height, half_height, max(2, int(np.ceil(2 * half_height / _SURFACE_STEP_M)) + 1))
    radii = np.linspace(0, radius, max(2, int(np.ceil(radius / _SURFACE_STEP_M)) + 1))
    side = np.concatenate([np.c_[radius * circle, np.full(len(circle), h)] for h in heights])
    caps = np.concatenate([np.c_[r * circle, np.full(len(circle), s * half_height)] for r in radii for s in (-1, 1)])
    return _from_part(part, np.concatenate([side, caps]))
