"""Where somebody who obeys an instruction's words might put a thing, drawn by geometry that knows nothing of goals.

The reading is a person's: a thing put on a top stands wholly on it, the left side of a top is the third at the left,
"just" and "a few inches" leave up to 40 cm, beside a piece means beside it and not round its corner, and the middle of
a side or of a room is within 25 cm of it.
"""

import numpy as np

from hv_sim.furniture import FURNITURE_KINDS
from hv_sim.places import Layout, Place

CLOSE_M = (0.05, 0.40)
MIDDLE_M = 0.25


def obeying_points(layout: Layout, place: Place, name: str, rng: np.random.Generator, count: int = 200) -> np.ndarray:
    """(count, 2) world positions in m of the thing's centre that do what the words of the place say."""
    half = float(max(layout.half_extents_m[name][:2]))
    if place.relation == "room_middle":
        angle, away = rng.uniform(0, 2 * np.pi, count), MIDDLE_M * np.sqrt(rng.uniform(0, 1, count))
        return np.stack([away * np.cos(angle), away * np.sin(angle)], -1)
    if place.relation.startswith("on"):
        top = layout.surfaces[place.landmark]
        deep, wide = max(top.depth_m / 2 - half, 0.0), max(top.width_m / 2 - half, 0.0)
        third = top.width_m / 6
        # a viewer before the front has the top's own right, where "left" is negative, at the left
        low, high = {"on": (-wide, wide), "on_middle": (-third, third), "on_left": (-wide, -third)}.get(
            place.relation, (third, wide)
        )
        if place.relation == "on_middle":
            deep = min(deep, MIDDLE_M)
        points = np.stack([rng.uniform(-deep, deep, count), rng.uniform(low, max(low, high), count)], -1)
        return _world(points, top.position_m, top.yaw_rad)
    piece = layout.furniture(place.landmark)
    away = rng.uniform(*CLOSE_M, count) + half
    if piece is None:
        top = layout.top_under(place.landmark)
        away += float(max(layout.half_extents_m[place.landmark][:2]))
        sign = -1 if place.relation == "left_of" else 1
        points = np.stack([rng.uniform(-0.1, 0.1, count), sign * away], -1)
        return _world(points, layout.poses[place.landmark][0][:2], top.yaw_rad)
    depth, width, _ = FURNITURE_KINDS[piece.kind].size_m if piece.size_m is None else piece.size_m
    if place.relation in ("left_of", "right_of"):
        along = max(depth / 2 - half, 0.0)
        sign = -1 if place.relation == "left_of" else 1
        points = np.stack([rng.uniform(-along, along, count), sign * (width / 2 + away)], -1)
    else:
        along = MIDDLE_M if place.relation.endswith("middle") else max(width / 2 - half, 0.0)
        sign = 1 if place.relation in ("in_front_of", "front_middle") else -1
        points = np.stack([sign * (depth / 2 + away), rng.uniform(-along, along, count)], -1)
    return _world(points, piece.position_m, piece.yaw_rad)


def _world(points: np.ndarray, origin_m, yaw: float) -> np.ndarray:
    c, s = np.cos(yaw), np.sin(yaw)
    return points @ np.array([[c, s], [-s, c]]) + np.asarray(origin_m)
