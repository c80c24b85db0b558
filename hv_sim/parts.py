"""Parts: the coloured primitives that objects, furniture and rooms are built from, and the room that they take up."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

COLORS: dict[str, tuple[float, float, float]] = {
    "red": (0.76, 0.16, 0.14),
    "orange": (0.90, 0.49, 0.13),
    "yellow": (0.93, 0.77, 0.20),
    "green": (0.22, 0.52, 0.25),
    "teal": (0.13, 0.52, 0.53),
    "blue": (0.16, 0.34, 0.70),
    "navy": (0.14, 0.19, 0.38),
    "purple": (0.45, 0.24, 0.58),
    "pink": (0.90, 0.55, 0.62),
    "brown": (0.45, 0.29, 0.17),
    "tan": (0.76, 0.58, 0.38),
    "beige": (0.86, 0.79, 0.66),
    "cream": (0.94, 0.90, 0.80),
    "white": (0.93, 0.93, 0.92),
    "silver": (0.74, 0.76, 0.78),
    "gray": (0.50, 0.51, 0.53),
    "charcoal": (0.24, 0.25, 0.27),
    "black": (0.09, 0.09, 0.10),
    "terracotta": (0.72, 0.38, 0.25),
    "oak": (0.80, 0.62, 0.42),
    "walnut": (0.47, 0.31, 0.20),
}
"""Names that a task file may use for a colour -> red, green, blue in [0, 1]."""

COLLISION_SHAPES = ("box", "cylinder")
VISUAL_SHAPES = (*COLLISION_SHAPES, "ellipsoid", "capsule", "plane", "mesh")

Color = tuple[float, float, float]
Vector = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class MeshShape:
    """Triangles to look at: vertices (V, 3) float32 in m, faces (F, 3) int32."""

    vertices_m: np.ndarray
    faces: np.ndarray

    def stretched(self, factors: np.ndarray) -> MeshShape:
        """The same with its coordinates multiplied by (3,) factors."""
        return MeshShape((self.vertices_m * factors).astype(np.float32), self.faces)


@dataclass(frozen=True)
class Part:
    """One primitive, or a mesh that is only looked at.

    Attributes:
        shape: one of `VISUAL_SHAPES`; a part that collides is a `COLLISION_SHAPES` one and stands upright.
        size_m: MuJoCo's sizes (half-extents; radius and half-height).
        pos_m: centre in the frame of the thing it belongs to.
        color: red, green, blue in [0, 1]; multiplies the material's texture.
        material: a name in `hv_sim.materials.MATERIALS`.
        quat: orientation, wxyz.
        collides: takes part in contacts, in the occupancy grid and in the object's geometry.
        visible: False for a collision shape that finer visual parts stand in for.
        mass_share: of the object's mass (relative to the other parts; unused for furniture).
        mesh: the triangles of a part whose shape is "mesh".
    """

    shape: str
    size_m: Vector
    pos_m: Vector
    color: Color
    material: str = "matte"
    quat: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    collides: bool = False
    visible: bool = True
    mass_share: float = 0.0
    mesh: MeshShape | None = None

    def __post_init__(self) -> None:
        if self.shape not in VISUAL_SHAPES:
            raise ValueError(f"shape: {self.shape!r} is not a part's shape; valid: {', '.join(VISUAL_SHAPES)}")
        if self.collides and (self.shape not in COLLISION_SHAPES or self.quat[1] or self.quat[2]):
            raise ValueError(f"shape: a part that collides is an upright {' or '.join(COLLISION_SHAPES)}")


@dataclass(frozen=True)
class Prism:
    """The upright prism that a part fills: a convex polygon (M, 2), counter-clockwise, between two heights."""

    polygon_m: np.ndarray
    z_low_m: float
    z_high_m: float


def box(pos: Vector, size: Vector, color: Color, material: str = "matte", **options) -> Part:
    """A box by its centre and its full extents in metres."""
    return Part("box", (size[0] / 2, size[1] / 2, size[2] / 2), pos, color, material, **options)


def cylinder(pos: Vector, radius: float, height: float, color: Color, material: str = "matte", **options) -> Part:
    """An upright cylinder by its centre, radius and full height in metres."""
    return Part("cylinder", (radius, height / 2, 0.0), pos, color, material, **options)


def ellipsoid(pos: Vector, size: Vector, color: Color, material: str = "matte", **options) -> Part:
    """An ellipsoid by its centre and its full extents in metres; only to look at."""
    return Part("ellipsoid", (size[0] / 2, size[1] / 2, size[2] / 2), pos, color, material, **options)


def rod(start: Vector, end: Vector, radius: float, color: Color, material: str = "matte") -> Part:
    """A capsule between two points; only to look at."""
    a, b = np.asarray(start, float), np.asarray(end, float)
    length = float(np.linalg.norm(b - a))
    pos = _vector((a + b) / 2)
    return Part("capsule", (radius, length / 2, 0.0), pos, color, material, quat=_quat_from_z((b - a) / length))


def shade(color: Color, factor: float) -> Color:
    """The colour made darker (`factor` < 1) or lighter (> 1)."""
    r, g, b = (min(1.0, c * factor) for c in color)
    return (r, g, b)


def tilt(roll_rad: float, pitch_rad: float, yaw_rad: float = 0.0) -> tuple[float, float, float, float]:
    """Quaternion wxyz: roll about x, then pitch about y, then yaw about z (fixed axes)."""
    q = np.array([1.0, 0.0, 0.0, 0.0])
    for axis, angle in ((0, roll_rad), (1, pitch_rad), (2, yaw_rad)):
        r = np.zeros(4)
        r[0], r[1 + axis] = np.cos(angle / 2), np.sin(angle / 2)
        q = _quat_multiply(r, q)
    return (float(q[0]), float(q[1]), float(q[2]), float(q[3]))


def moved(parts: Iterable[Part], position_m: Sequence[float], yaw_rad: float) -> list[Part]:
    """The parts turned about z and then shifted, for instance from the frame of a chair into the world's."""
    c, s = np.cos(yaw_rad), np.sin(yaw_rad)
    turn = np.array([np.cos(yaw_rad / 2), 0.0, 0.0, np.sin(yaw_rad / 2)])
    result = []
    for part in parts:
        x, y, z = part.pos_m
        pos = (
            float(position_m[0] + c * x - s * y),
            float(position_m[1] + s * x + c * y),
            float(z + (position_m[2] if len(position_m) > 2 else 0.0)),
        )
        q = _quat_multiply(turn, np.asarray(part.quat))
        result.append(replace(part, pos_m=pos, quat=(float(q[0]), float(q[1]), float(q[2]), float(q[3]))))
    return result


def prism(part: Part) -> Prism:
    """The space that a colliding part fills (a cylinder as a 16-gon around it)."""
    yaw = 2.0 * np.arctan2(part.quat[3], part.quat[0])
    if part.shape == "box":
        hx, hy = part.size_m[0], part.size_m[1]
        corners = np.array([[hx, hy], [-hx, hy], [-hx, -hy], [hx, -hy]])
        half_height = part.size_m[2]
    else:
        angle = np.arange(16) * (2 * np.pi / 16)
        corners = part.size_m[0] / np.cos(np.pi / 16) * np.stack([np.cos(angle), np.sin(angle)], -1)
        half_height = part.size_m[1]
    c, s = np.cos(yaw), np.sin(yaw)
    polygon = corners @ np.array([[c, s], [-s, c]]) + np.asarray(part.pos_m[:2])
    return Prism(polygon, part.pos_m[2] - half_height, part.pos_m[2] + half_height)


def prisms(parts: Iterable[Part]) -> list[Prism]:
    """The space that the colliding ones among `parts` fill."""
    return [prism(part) for part in parts if part.collides]


def overlap_m(first: Prism, second: Prism) -> float:
    """How deep two prisms are in each other, in metres: the shortest shift that parts them.

    Zero or less means apart.
    """
    depth = min(first.z_high_m, second.z_high_m) - max(first.z_low_m, second.z_low_m)
    if depth <= 0:
        return float(depth)
    for polygon in (first.polygon_m, second.polygon_m):
        edges = np.roll(polygon, -1, axis=0) - polygon
        normals = np.stack([edges[:, 1], -edges[:, 0]], -1) / np.linalg.norm(edges, axis=1, keepdims=True)
        a, b = first.polygon_m @ normals.T, second.polygon_m @ normals.T
        depth = min(depth, float((np.minimum(a.max(0), b.max(0)) - np.maximum(a.min(0), b.min(0))).min()))
    return float(depth)


def deepest_overlap_m(first: Iterable[Prism], second: Sequence[Prism]) -> float:
    """The largest `overlap_m` between two groups of prisms, -inf when one is empty."""
    return max((overlap_m(a, b) for a in first for b in second), default=-np.inf)


def inside_polygon(points_m: np.ndarray, polygon_m: np.ndarray, margin_m: float = 0.0) -> np.ndarray:
    """(...,) bool: which of the (..., 2) points lie in the convex polygon grown by `margin_m`."""
    edges = np.roll(polygon_m, -1, axis=0) - polygon_m
    normals = np.stack([edges[:, 1], -edges[:, 0]], -1) / np.linalg.norm(edges, axis=1, keepdims=True)
    offsets = (normals * polygon_m).sum(-1)
    return (points_m @ normals.T <= offsets + margin_m).all(-1)


def support_height_m(xy_m: Sequence[float], below_m: float, solids: Iterable[Prism]) -> float:
    """Height of the highest top face under a point, at most `below_m`; 0 for the floor."""
    point = np.asarray(xy_m, dtype=float)[:2]
    tops = [s.z_high_m for s in solids if s.z_high_m <= below_m and inside_polygon(point, s.polygon_m)]
    return max(tops, default=0.0)


def bounding_half_extents_m(parts: Iterable[Part]) -> np.ndarray:
    """(3,) largest |coordinate| that the colliding parts reach along each axis of their frame."""
    reach = np.zeros(3)
    for part in parts:
        if not part.collides:
            continue
        if part.shape == "cylinder":
            extent = np.array([part.size_m[0], part.size_m[0], part.size_m[1]])
        else:
            yaw = 2.0 * np.arctan2(part.quat[3], part.quat[0])
            c, s = abs(np.cos(yaw)), abs(np.sin(yaw))
            hx, hy, hz = part.size_m
            extent = np.array([c * hx + s * hy, s * hx + c * hy, hz])
        reach = np.maximum(reach, np.abs(part.pos_m) + extent)
    return reach


def _vector(v: np.ndarray) -> Vector:
    return (float(v[0]), float(v[1]), float(v[2]))


def _quat_multiply(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.array(
        [
            a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
            a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
            a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
            a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
        ]
    )


def _quat_from_z(direction: np.ndarray) -> tuple[float, float, float, float]:
    """The shortest rotation that takes z to a unit vector."""
    x, y, z = direction
    if z < -1 + 1e-9:
        return (0.0, 1.0, 0.0, 0.0)
    q = np.array([1.0 + z, -y, x, 0.0])
    q /= np.linalg.norm(q)
    return (float(q[0]), float(q[1]), float(q[2]), float(q[3]))
