"""Places that an instruction can name: on a top or a part of it, beside, before or behind a piece of furniture.

Left and right are those of somebody who stands before the front of the furniture and looks at it.
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
WITHOUT_LANDMARK = ("floor", "room_middle", "your_left", "your_right")
RELATIONS = (*ON, *BESIDE, *WITHOUT_LANDMARK)

NEAR_M = 0.95
"""Farther than this from a piece's edge nothing is beside, before or behind it."""
PARTED_M = 1.0
"""Tops from this width on have a left side, a middle and a right side."""
NEIGHBOUR_M = (0.12, 0.8)
"""Distances, along a top, between two objects that stand side by side."""
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
    def half_height_m(self) -> dict[str, float]:
        """Object name -> half of its height."""
        return {o.name: float(built_object(o).half_extents_m[2]) for o in self.task.objects}

    def furniture(self, name: str) -> FurniturePlacement | None:
        """The piece of that name, if there is one."""
        return next((f for f in self.task.furniture if f.name == name), None)

    def contains(self, place: Place, name: str, position_m: tuple[float, float, float]) -> bool:
        """Whether the object `name`, its centre at a position, would be at the place."""
        bottom = position_m[2] - self.half_height_m[name]
        on_floor = abs(bottom) < _ON_FLOOR_M
        if place.relation == "floor":
            return on_floor
        if place.relation == "room_middle":
            x, y = self.task.room.size_m
            return on_floor and abs(position_m[0]) < 0.2 * x and abs(position_m[1]) < 0.2 * y
        if place.relation in ("your_left", "your_right"):
            return self.fresh and self._robot_side(position_m) == place.relation
        if place.relation in ON:
            surface = self.surfaces.get(place.landmark)
            return surface is not None and _on(surface, place.relation, position_m, bottom)
        piece = self.furniture(place.landmark)
        if piece is not None:
            return on_floor and _beside_furniture(piece, place.relation, position_m)
        return place.landmark != name and self._beside_object(place, position_m, bottom)

    def places(self, name: str, position_m: tuple[float, float, float]) -> list[Place]:
        """All places that an object's position fits, the most telling ones first."""
        found = [Place(r, s) for s in self.surfaces for r in reversed(ON)]
        found += [Place(r, f.name) for f in self.task.furniture for r in BESIDE if FURNITURE_KINDS[f.kind].solid]
        found += [Place(r, o) for o in self.poses for r in ("left_of", "right_of") if o != name]
        found += [Place(r) for r in reversed(WITHOUT_LANDMARK)]
        return [p for p in found if self.contains(p, name, position_m)]

    def _robot_side(self, position_m: tuple[float, float, float]) -> str:
        robot = self.task.robot
        bearing = np.arctan2(position_m[1] - robot.position_m[1], position_m[0] - robot.position_m[0]) - robot.yaw_rad
        bearing = np.arctan2(np.sin(bearing), np.cos(bearing))
        if not _ASIDE_RAD < abs(bearing) < np.pi - _ASIDE_RAD:
            return ""
        return "your_left" if bearing > 0 else "your_right"

    def _beside_object(self, place: Place, position_m: tuple[float, float, float], bottom_m: float) -> bool:
        other = self.poses.get(place.landmark)
        if other is None or place.relation not in ("left_of", "right_of"):
            return False
        other_bottom = other[0][2] - self.half_height_m[place.landmark]
        for surface in self.surfaces.values():
            if not (_on(surface, "on", position_m, bottom_m) and _on(surface, "on", other[0], other_bottom)):
                continue
            ahead, left = _local(surface.position_m, surface.yaw_rad, position_m)
            other_ahead, other_left = _local(surface.position_m, surface.yaw_rad, other[0])
            apart = other_left - left if place.relation == "left_of" else left - other_left
            return NEIGHBOUR_M[0] < apart < NEIGHBOUR_M[1] and abs(ahead - other_ahead) < 0.35
        return False


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
    return share > 1 / 6 if relation == "on_left" else share < -1 / 6


def _beside_furniture(piece: FurniturePlacement, relation: str, position_m: tuple[float, ...]) -> bool:
    ahead, left = _local(piece.position_m, piece.yaw_rad, position_m)
    depth, width, _ = FURNITURE_KINDS[piece.kind].size_m if piece.size_m is None else piece.size_m
    if relation in ("left_of", "right_of"):
        beyond = (-left if relation == "left_of" else left) - width / 2
        return 0 < beyond < NEAR_M and abs(ahead) < depth / 2 + 0.2
    beyond = (ahead if relation == "in_front_of" else -ahead) - depth / 2
    return 0 < beyond < NEAR_M and abs(left) < width / 2
