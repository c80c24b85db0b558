"""Vectors and rotations of one robot as tuples, for what runs compiled (numba): three numbers, three columns of three.

A batched tensor of so few numbers takes microseconds for each operation, a compiled one nanoseconds. Compiled code is
kept between runs, and not made anew for a change in this file alone: delete `__pycache__` then.
"""

from __future__ import annotations

import math

import numba
import numpy as np

Vector = tuple[float, float, float]
Columns = tuple[Vector, Vector, Vector]


@numba.njit(cache=True)
def clip(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)


@numba.njit(cache=True)
def turned_xy(angle: float, x: float, y: float) -> tuple[float, float]:
    """A level vector turned by an angle."""
    c, s = math.cos(angle), math.sin(angle)
    return c * x - s * y, s * x + c * y


@numba.njit(cache=True)
def add(a: Vector, b: Vector) -> Vector:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@numba.njit(cache=True)
def sub(a: Vector, b: Vector) -> Vector:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@numba.njit(cache=True)
def scaled(a: Vector, factor: float) -> Vector:
    return a[0] * factor, a[1] * factor, a[2] * factor


@numba.njit(cache=True)
def dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@numba.njit(cache=True)
def cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@numba.njit(cache=True)
def norm(a: Vector) -> float:
    return math.sqrt(dot(a, a))


@numba.njit(cache=True)
def unit(a: Vector, least: float) -> Vector:
    """The vector divided by its length, or by `least` where it is shorter."""
    return scaled(a, 1.0 / max(norm(a), least))


@numba.njit(cache=True)
def vector_at(rows, i: int, k: int) -> Vector:  # type: ignore[no-untyped-def]
    """Row (i, k) of an array (N, K, 3)."""
    return np.float64(rows[i, k, 0]), np.float64(rows[i, k, 1]), np.float64(rows[i, k, 2])


@numba.njit(cache=True)
def column_at(rotations, i: int, k: int, column: int) -> Vector:  # type: ignore[no-untyped-def]
    """One column of matrix (i, k) of an array (N, K, 3, 3)."""
    x, y, z = rotations[i, k, 0, column], rotations[i, k, 1, column], rotations[i, k, 2, column]
    return np.float64(x), np.float64(y), np.float64(z)


@numba.njit(cache=True)
def columns_at(rotations, i: int, k: int) -> Columns:  # type: ignore[no-untyped-def]
    """Matrix (i, k) of an array (N, K, 3, 3)."""
    return column_at(rotations, i, k, 0), column_at(rotations, i, k, 1), column_at(rotations, i, k, 2)


@numba.njit(cache=True)
def times(m: Columns, v: Vector) -> Vector:
    """m @ v."""
    return add(add(scaled(m[0], v[0]), scaled(m[1], v[1])), scaled(m[2], v[2]))


@numba.njit(cache=True)
def transposed_times(m: Columns, v: Vector) -> Vector:
    """m.T @ v."""
    return dot(m[0], v), dot(m[1], v), dot(m[2], v)


@numba.njit(cache=True)
def product(a: Columns, b: Columns) -> Columns:
    """a @ b."""
    return times(a, b[0]), times(a, b[1]), times(a, b[2])


@numba.njit(cache=True)
def transposed_product(a: Columns, b: Columns) -> Columns:
    """a.T @ b."""
    return transposed_times(a, b[0]), transposed_times(a, b[1]), transposed_times(a, b[2])


@numba.njit(cache=True)
def about_y(angle: float) -> Columns:
    c, s = math.cos(angle), math.sin(angle)
    return (c, 0.0, -s), (0.0, 1.0, 0.0), (s, 0.0, c)


@numba.njit(cache=True)
def about_z(angle: float) -> Columns:
    c, s = math.cos(angle), math.sin(angle)
    return (c, s, 0.0), (-s, c, 0.0), (0.0, 0.0, 1.0)


@numba.njit(cache=True)
def hinges_xyz(x: float, y: float, z: float) -> Columns:
    """Rotation of three serial hinges x, y, z: Rx(x) Ry(y) Rz(z)."""
    sx, sy, sz, cx, cy, cz = math.sin(x), math.sin(y), math.sin(z), math.cos(x), math.cos(y), math.cos(z)
    return (
        (cy * cz, cx * sz + sx * sy * cz, sx * sz - cx * sy * cz),
        (-cy * sz, cx * cz - sx * sy * sz, sx * cz + cx * sy * sz),
        (sy, -sx * cy, cx * cy),
    )


@numba.njit(cache=True)
def hinge_angles(m: Columns) -> Vector:
    """Serial hinge angles x, y, z of a rotation, |y| <= 90 degrees."""
    return math.atan2(-m[2][1], m[2][2]), math.asin(clip(m[2][0], -1.0, 1.0)), math.atan2(-m[1][0], m[0][0])
