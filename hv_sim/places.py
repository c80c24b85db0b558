"""Places that an instruction can name: on a top or a part of it, beside, before or behind a piece of furniture.

Left and right are those of somebody who stands before the front of the furniture and looks at it; only furniture with
a front that anybody sees has a left, a right, a front and a back.

Where a thing *is* may be said of all that a place holds (`Layout.contains`). Where it *shall go* is one spot: the
middle of the place, close to what it is named by (`Layout.spot_m`), and only places small enough for that spot to be
what anybody would aim at have one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hv_sim.furniture import FURNITURE_KINDS
from hv_sim.surfaces import Surface, surfaces_of
from hv_sim.task import FurniturePlacement, Task, built_object

ON = ("on", "on_left", "on_middle", "on_right")
BESIDE = ("left_of", "right_of", "in_front_of", "behind")
BY_THE_MIDDLE = ("front_middle", "back_middle")
"""Before and behind the middle of a long piece."""
WITHOUT_LANDMARK = ("floor", "room_middle", "your_left", "your_right")
RELATIONS = (*ON, *BESIDE, *BY_THE_MIDDLE, *WITHOUT_LANDMARK)

NEAR_M = 0.8
"""Farther than this from a piece's edge nothing is beside, before or behind it."""
PARTED_M = 1.0
"""Tops from this width on have a left side, a middle and a right side, and are too wide for a goal just "on" them."""
LONG_M = 1.06
"""Sides from this length on are too long for a goal just before or beside them."""
NEIGHBOUR_M = (0.12, 0.8)
"""Distances, along a top, between two objects that stand side by side."""
GAP_M = 0.22
"""Between an object and the furniture beside which, or the object next to which, it shall be put."""
SPOT_M = 0.25
"""How far from its place's spot a goal may lie."""
MIDDLE_M = 0.35
"""How far from the middle of a side or of a room something may be said to be in the middle."""
_ON_FLOOR_M = 0.06
_ASIDE_RAD = 0.35

Pose = tuple[tuple[float, float, float], float]


@dataclass(frozen=True)
class Place:
    """A relation (one of `RELATIONS`) and the furniture or object that it refers to, by its name in the task."""

    relation: str
    landmark: str = ""


@dataclass(frozen=True)
class Layout:
    """Where everything is when a sub-task begins."""

    task: Task
    poses: Mapping[str, Pose]
    """Object name -> position of its centre in m, yaw in rad; world frame."""
    fresh: bool
    """The robot still stands at its start."""

    @cached_property
    def surfaces(self) -> dict[str, Surface]:
        """Furniture name -> its top."""
        return {s.furniture: s for s in surfaces_of(self.task.furniture)}

    @cached_property
    def half_extents_m(self) -> dict[str, np.ndarray]:
        """Object name -> (3,) half extents of its bounding box."""
        return {o.name: built_object(o).half_extents_m for o in self.task.objects}

    def furniture(self, name: str) -> FurniturePlacement | None:
        """The piece of that name, if there is one."""
        return next((f for f in self.task.furniture if f.name == name), None)

    def contains(self, place: Place, name: str, position_m: tuple[float, float, float]) -> bool:
        """Whether the object `name`, its centre at a position, would be at the place."""
        bottom = self._bottom_m(name, position_m)
        on_floor = abs(bottom) < _ON_FLOOR_M
        if place.relation == "floor":
            return on_floor
        if place.relation == "room_middle":
            return on_floor and bool(np.hypot(*position_m[:2]) < MIDDLE_M)
        if place.relation in ("your_left", "your_right"):
            return self.fresh and self._robot_side(position_m) == place.relation
        if place.relation in ON:
            surface = self.surfaces.get(place.landmark)
            return surface is not None and _on(surface, place.relation, position_m, bottom)
        piece = self.furniture(place.landmark)
        if piece is not None:
            return on_floor and _beside_furniture(piece, place.relation, position_m)
        return place.landmark != name and self._beside_object(place, position_m, bottom)

    def spot_m(self, place: Place, name: str) -> tuple[float, float] | None:
        """World (x, y) where the object `name` shall be put if it is to go to the place.

        None where the words leave too much open: a long top without a part of it, a long side without its middle, the
        left of something round.
        """
        if place.relation == "room_middle":
            return 0.0, 0.0
        if place.relation in ON:
            surface = self.surfaces.get(place.landmark)
            return None if surface is None else _spot_on(surface, place.relation)
        half = float(max(self.half_extents_m[name][:2]))
        piece = self.furniture(place.landmark)
        if piece is not None:
            return _spot_beside(piece, place.relation, half)
        if place.landmark not in self.poses or place.relation not in ("left_of", "right_of"):
            return None
        surface = self.top_under(place.landmark)
        if surface is None or not FURNITURE_KINDS[surface.kind].has_front:
            return None
        ahead, left = _local(surface.position_m, surface.yaw_rad, self.poses[place.landmark][0])
        apart = half + float(max(self.half_extents_m[place.landmark][:2])) + GAP_M
        return surface.point_m(ahead, left + (-apart if place.relation == "left_of" else apart))

    def is_goal(self, place: Place, name: str, position_m: tuple[float, float, float]) -> bool:
        """Whether the object `name`, its centre at a position, would be where the place's words send it."""
        spot = self.spot_m(place, name)
        if spot is None or not self.contains(place, name, position_m):
            return False
        return bool(np.hypot(position_m[0] - spot[0], position_m[1] - spot[1]) < SPOT_M)

    def places(self, name: str, position_m: tuple[float, float, float]) -> list[Place]:
        """All places that an object's position fits, the most telling ones first."""
        found = [Place(r, s) for s in self.surfaces for r in reversed(ON)]
        solid = [f for f in self.task.furniture if FURNITURE_KINDS[f.kind].solid]
        found += [Place(r, f.name) for f in solid for r in (*BESIDE, *BY_THE_MIDDLE)]
        found += [Place(r, o) for o in self.poses for r in ("left_of", "right_of") if o != name]
        found += [Place(r) for r in reversed(WITHOUT_LANDMARK)]
        return [p for p in found if self.contains(p, name, position_m)]

    def top_under(self, name: str) -> Surface | None:
        """The top on which an object stands."""
        at = self.poses[name][0]
        bottom = self._bottom_m(name, at)
        return next((s for s in self.surfaces.values() if _on(s, "on", at, bottom)), None)

    def _bottom_m(self, name: str, position_m: tuple[float, float, float]) -> float:
        return float(position_m[2] - self.half_extents_m[name][2])

    def _robot_side(self, position_m: tuple[float, float, float]) -> str:
        robot = self.task.robot
        bearing = np.arctan2(position_m[1] - robot.position_m[1], position_m[0] - robot.position_m[0]) - robot.yaw_rad
        bearing = np.arctan2(np.sin(bearing), np.cos(bearing))
        if not _ASIDE_RAD < abs(bearing) < np.pi - _ASIDE_RAD:
            return ""
        return "your_left" if bearing > 0 else "your_right"

    def _beside_object(self, place: Place, position_m: tuple[float, float, float], bottom_m: float) -> bool:
        if place.landmark not in self.poses or place.relation not in ("left_of", "right_of"):
            return False
        surface = self.top_under(place.landmark)
        if surface is None or not FURNITURE_KINDS[surface.kind].has_front:
            return False
        if not _on(surface, "on", position_m, bottom_m):
            return False
        ahead, left = _local(surface.position_m, surface.yaw_rad, position_m)
        other_ahead, other_left = _local(surface.position_m, surface.yaw_rad, self.poses[place.landmark][0])
        apart = other_left - left if place.relation == "left_of" else left - other_left
        return NEIGHBOUR_M[0] < apart < NEIGHBOUR_M[1] and abs(ahead - other_ahead) < 0.35


def layout_at(task: Task, subtask: int) -> Layout:
    """The layout when sub-task number `subtask` begins, those before it done as they should be."""
    poses: dict[str, Pose] = {o.name: (o.position_m, o.yaw_rad) for o in task.objects}
    for done in task.subtasks[:subtask]:
        poses[done.object] = (done.goal_position_m, done.goal_yaw_rad)
    return Layout(task, poses, fresh=subtask == 0)


def _local(origin_m: tuple[float, float], yaw_rad: float, point_m: tuple[float, ...]) -> tuple[float, float]:
    """A world point as (ahead, left) of something's own front."""
    dx, dy = point_m[0] - origin_m[0], point_m[1] - origin_m[1]
    c, s = np.cos(yaw_rad), np.sin(yaw_rad)
    return float(c * dx + s * dy), float(c * dy - s * dx)


def _on(surface: Surface, relation: str, position_m: tuple[float, ...], bottom_m: float) -> bool:
    ahead, left = _local(surface.position_m, surface.yaw_rad, position_m)
    if abs(bottom_m - surface.height_m) > _ON_FLOOR_M:
        return False
    if abs(ahead) > surface.depth_m / 2 or abs(left) > surface.width_m / 2:
        return False
    if relation == "on":
        return True
    if surface.width_m < PARTED_M:
        return False
    # a viewer before the front has the piece's own right hand at the left
    share = -left / surface.width_m
    if relation == "on_middle":
        return abs(share) < 1 / 6
    if not FURNITURE_KINDS[surface.kind].has_front:
        return False
    return share > 1 / 6 if relation == "on_left" else share < -1 / 6


def _spot_on(surface: Surface, relation: str) -> tuple[float, float] | None:
    if (relation == "on") == (surface.width_m >= PARTED_M):
        return None
    if relation in ("on", "on_middle"):
        return surface.position_m
    if not FURNITURE_KINDS[surface.kind].has_front:
        return None
    return surface.point_m(0.0, surface.width_m * (-0.27 if relation == "on_left" else 0.27))


def _footprint(piece: FurniturePlacement) -> tuple[float, float]:
    """Depth and width in m."""
    depth, width, _ = FURNITURE_KINDS[piece.kind].size_m if piece.size_m is None else piece.size_m
    return depth, width


def _beside_furniture(piece: FurniturePlacement, relation: str, position_m: tuple[float, ...]) -> bool:
    if not FURNITURE_KINDS[piece.kind].has_front:
        return False
    ahead, left = _local(piece.position_m, piece.yaw_rad, position_m)
    depth, width = _footprint(piece)
    if relation in ("left_of", "right_of"):
        beyond = (-left if relation == "left_of" else left) - width / 2
        return 0 < beyond < NEAR_M and abs(ahead) < depth / 2 + 0.2
    beyond = (ahead if relation in ("in_front_of", "front_middle") else -ahead) - depth / 2
    along = MIDDLE_M if relation in BY_THE_MIDDLE else width / 2
    return 0 < beyond < NEAR_M and abs(left) < along and (relation not in BY_THE_MIDDLE or width >= LONG_M)


def _spot_beside(piece: FurniturePlacement, relation: str, half_m: float) -> tuple[float, float] | None:
    """Beside the middle of a side, for an object of half that width."""
    if not FURNITURE_KINDS[piece.kind].has_front:
        return None
    depth, width = _footprint(piece)
    side = depth if relation in ("left_of", "right_of") else width
    if (side >= LONG_M) != (relation in BY_THE_MIDDLE):
        return None
    beyond = half_m + GAP_M
    ahead, left = {
        "left_of": (0.0, -width / 2 - beyond),
        "right_of": (0.0, width / 2 + beyond),
        "in_front_of": (depth / 2 + beyond, 0.0),
        "front_middle": (depth / 2 + beyond, 0.0),
        "behind": (-depth / 2 - beyond, 0.0),
        "back_middle": (-depth / 2 - beyond, 0.0),
    }[relation]
    c, s = np.cos(piece.yaw_rad), np.sin(piece.yaw_rad)
    x, y = piece.position_m
    return float(x + c * ahead - s * left), float(y + s * ahead + c * left)
