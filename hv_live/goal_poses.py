"""Where exactly a thing shall stand when somebody only says "on the table": a free pose at a place, within reach."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np

from hv_sim.furniture import FURNITURE_KINDS
from hv_sim.navigation import sides_with_room
from hv_sim.places import BESIDE, NEAR_M, ON, Layout, Place, Pose
from hv_sim.scene import Scene
from hv_sim.surfaces import Surface

_MARGIN_M = 0.04
"""Between a thing and the edge of the top that it stands on."""
_GAP_M = 0.06
"""Between two things."""
_FLOOR_GAP_M = 0.10
_SHARES = (0.0, -0.5, 0.5, -1.0, 1.0, -0.25, 0.25, -0.75, 0.75)
"""Along an edge: of what is free on either side of its middle."""
_CANDIDATES = 60


def goal_pose(scene: Scene, layout: Layout, name: str, place: Place) -> Pose | None:
    """A pose of the object `name` at a place: nothing is in the way there and the robot has room to stand before it.

    A goal of the task's own is taken where it fits the place; it is known to be reachable.

    Args:
        scene: the compiled room.
        layout: where everything is now.
        name: the object.
        place: where it shall go.

    Returns:
        Position of its centre in m and yaw in rad, world frame; None where there is no free pose.
    """
    k = scene.object_names.index(name)
    half, grasp_ok = scene.half_extents_m[k], scene.grasp_ok[k]
    own = [(s.goal_position_m, s.goal_yaw_rad) for s in scene.task.subtasks if s.object == name]
    others = [i for i in range(scene.num_objects) if i != k]
    radii = [float(np.hypot(*scene.half_extents_m[i, :2])) for i in others]
    positions = [layout.poses[scene.object_names[i]][0] for i in others]
    grid = scene.occupancy.with_discs(positions, radii)
    wall = scene.occupancy.clearance_m()

    def is_free(pose: Pose) -> bool:
        at = pose[0]
        if not layout.contains(place, name, at):
            return False
        for i, position, radius in zip(others, positions, radii, strict=True):
            apart = float(np.hypot(at[0] - position[0], at[1] - position[1]))
            levels = abs(at[2] - position[2]) < half[2] + scene.half_extents_m[i, 2] + _GAP_M
            if levels and apart < radius + float(np.hypot(*half[:2])) + _GAP_M:
                return False
        on_floor = at[2] - half[2] < _FLOOR_GAP_M
        return not on_floor or wall[scene.occupancy.cell_of(at)] > float(np.hypot(*half[:2])) + _FLOOR_GAP_M

    known = next((pose for pose in own if is_free(pose)), None)
    if known is not None:
        return known
    free = itertools.islice(filter(is_free, _candidates(scene, layout, name, place)), _CANDIDATES)
    return next((pose for pose in free if sides_with_room(grid, pose[0], pose[1], half, grasp_ok)), None)


def _candidates(scene: Scene, layout: Layout, name: str, place: Place) -> Iterator[Pose]:
    """Poses about the place, the most natural ones first."""
    half = scene.half_extents_m[scene.object_names.index(name)]
    if place.relation in ON:
        if place.landmark in layout.surfaces:  # not a bed, nor what is too high or too low
            yield from _on_top(scene, layout.surfaces[place.landmark], name)
    elif place.landmark in layout.poses:  # beside another thing: on the top on which that stands
        at = layout.poses[place.landmark][0]
        for surface in layout.surfaces.values():
            if layout.contains(Place("on", surface.furniture), place.landmark, at):
                poses = list(_on_top(scene, surface, name, shares=tuple(np.linspace(-1, 1, 21))))
                yield from sorted(poses, key=lambda p: float(np.hypot(p[0][0] - at[0], p[0][1] - at[1])))
    elif place.relation in BESIDE:
        piece = next(f for f in scene.task.furniture if f.name == place.landmark)
        depth, width, _ = piece.size_m or FURNITURE_KINDS[piece.kind].size_m
        c, s = np.cos(piece.yaw_rad), np.sin(piece.yaw_rad)
        for beyond in np.arange(float(max(half[:2])) + 0.12, NEAR_M - 0.05, 0.08).tolist():
            for share in _SHARES[:5]:
                if place.relation in ("left_of", "right_of"):
                    left = (width / 2 + beyond) * (-1 if place.relation == "left_of" else 1)
                    ahead = share * depth / 2
                else:
                    ahead = (depth / 2 + beyond) * (-1 if place.relation == "behind" else 1)
                    left = 0.8 * share * width / 2
                x, y = piece.position_m
                yield _standing(x + c * ahead - s * left, y + s * ahead + c * left, 0.0, piece.yaw_rad, half)
    else:  # on the floor: near the middle of the room, or near the robot
        near = np.zeros(2) if place.relation == "room_middle" else np.asarray(layout.task.robot.position_m)
        cells = scene.occupancy.centers_m()[::3, ::3].reshape(-1, 2)
        for x, y in cells[np.argsort(np.linalg.norm(cells - near, axis=1))]:
            if place.relation == "room_middle" or np.hypot(x - near[0], y - near[1]) > 1.0:
                yield _standing(x, y, 0.0, 0.0, half)


def _on_top(scene: Scene, surface: Surface, name: str, shares: tuple[float, ...] = _SHARES) -> Iterator[Pose]:
    """Poses along the edges of a top, turned so that the robot takes the thing from before the edge."""
    k = scene.object_names.index(name)
    half = scene.half_extents_m[k]
    for share in shares:
        for outward, edge, deep, wide in surface.sides():
            for grasp in np.flatnonzero(scene.grasp_ok[k]).tolist():
                depth, width = (half[0], half[1]) if grasp % 2 == 0 else (half[1], half[0])
                out, free = min(edge - _MARGIN_M - depth, deep - depth), wide - width - 0.02
                if out < -deep + depth or free < 0:
                    continue
                c, s = np.cos(outward), np.sin(outward)
                x = surface.position_m[0] + c * out - s * share * free
                y = surface.position_m[1] + s * out + c * share * free
                yield _standing(x, y, surface.height_m, outward + np.pi - grasp * np.pi / 2, half)


def _standing(x: float, y: float, support_m: float, yaw_rad: float, half: np.ndarray) -> Pose:
    yaw = float(np.arctan2(np.sin(yaw_rad), np.cos(yaw_rad)))
    return (float(x), float(y), float(support_m + half[2])), yaw
