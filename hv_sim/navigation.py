"""Navigation: where to stand to pick an object up and to put it down, and the ways there that many robots follow."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from hv_sim.lying_grasps import press_points
from hv_sim.paths import (
    ROBOT_RADIUS_M,
    OccupancyGrid,
    Point,
    lookahead,
    nearest_free,
    path_length_m,
    plan_path,
    resampled,
)
from hv_sim.scene import Scene, rotation_about_z

STAND_CLEARANCE_M = 0.12
"""Clearance of a stand pose, where the robot may be close to a table's edge (pelvis and feet)."""
EASY_CLEARANCE_M, STEP_BACK_M = 0.22, 0.16
"""Where a table's edge is nearer than the first, the robot stands farther back, by at most the second."""
RETREAT_M, RETREAT_CLEARANCE_M = 0.7, 0.25
"""How far the robot steps back from a stand pose, and the clearance that it needs there."""
LOW_SUPPORT_M = 0.3
"""Below this height the robot squats, for which it stands `SQUAT_ROOM_M` farther back."""
SQUAT_ROOM_M, SQUAT_STAND_M = 0.07, 0.45
TOE_ROOM_M = 0.2
"""How far the way to an object keeps from it, so that the robot does not kick what it is to lift."""
OFF_M = 0.05
"""Who is nearer to an object than its way may be steps back from it first, until it is so much farther than that."""
_STEP_OFF_M, _BACK_OFF_M = 0.2, 1.0
_SAME_SIDE = 0.8
UPRIGHT = 0.8
"""Cosine of the tilt from which an object counts as lying on its side."""
TOP_ROOM_M = 0.045
"""How far below the top of what lies and offers no faces the hands press."""
WORSE_M = 0.05
"""Ways to hold what lies do not count if their points are so much farther from where they should be than the best."""
REACH_M = (0.45, 0.52)
"""How far ahead of its stand a robot reaches down to what lies; farther off its hands do not get there."""
OUT_OF_REACH = 3.0
"""What a metre out of reach counts beside a metre between where hands press and where they should."""
SPURNED_M = 5.0
"""So much longer a way is preferred to a side from which the object was tried in vain once."""
WINDOW = 10
"""Waypoints among which the nearest is looked for."""
FAR_M = 1.0


@dataclass(frozen=True)
class SubTaskRoute:
    """Where to walk for one sub-task, world frame.

    Attributes:
        pick_stand_xy_yaw: (3,) where to stand and look when picking the object up.
        place_stand_xy_yaw: (3,) the same for putting it down; the object is then turned as the goal wants.
        waypoints_to_object: (W1, 2), first off from what lies at the robot's feet, the last one the pick stand.
        waypoints_to_goal: (W2, 2), first straight back from the pick stand, the last one the place stand.
        steps_back: how many of `waypoints_to_goal` lead straight back.
        steps_off: how many of `waypoints_to_object` lead off from the object.
        ahead: (W1 + W2,) index of the waypoint to make for from each waypoint, over both legs.
        grasp_o: (2, 3) where the (left, right) hand touches the object, in its frame.
        depth_m: the object's extent along the robot's view.
        lacking_m: by how much the room at the two stands and behind them falls short; 0 where there is enough.
        missed_m: how far the ways end from where they should; 0 where they lead there.
    """

    pick_stand_xy_yaw: np.ndarray
    place_stand_xy_yaw: np.ndarray
    waypoints_to_object: np.ndarray
    waypoints_to_goal: np.ndarray
    grasp_o: np.ndarray
    depth_m: float
    steps_back: int
    ahead: np.ndarray
    lacking_m: float = 0.0
    missed_m: float = 0.0
    steps_off: int = 0


def plan_subtask(
    scene: Scene,
    subtask: int,
    robot_xy_m: Point,
    object_pos_w: np.ndarray,
    object_rot_w: np.ndarray | None = None,
    spurned_rad: np.ndarray | None = None,
) -> SubTaskRoute:
    """Chooses the side from which to take the sub-task's object, and the ways to it and with it to the goal.

    A side is a grasp (`Scene.grasps_o`); it fixes from where the robot faces the object and, as the object must end up
    turned as the goal wants, from where it faces the goal. Of the sides with room to stand and to step back at both
    ends the one with the least walking is taken; without such a side, the one with the most room. Other movable
    objects are obstacles.

    Args:
        scene: the scene.
        subtask: index of the sub-task.
        robot_xy_m: where the robot is.
        object_pos_w: (K, 3) where the objects are.
        object_rot_w: (K, 3, 3) how they are turned; by default as the task put them.
        spurned_rad: (M,) yaws in which a robot faced the object when it tried it in vain, once each; those that are not
            numbers are none. Other sides are preferred.
    """
    k = int(scene.subtask_object[subtask])
    positions = np.asarray(object_pos_w, dtype=float)[: scene.num_objects]
    if object_rot_w is None:
        rotation = rotation_about_z(scene.task.objects[k].yaw_rad)
    else:
        rotation = np.asarray(object_rot_w, dtype=float)[k]
    goal, goal_yaw = scene.goal_pos_w[subtask], _yaw_of(scene.goal_rot_w[subtask])
    others = [i for i in range(scene.num_objects) if i != k]
    radii = np.linalg.norm(scene.half_extents_m[others, :2], axis=-1)
    grid = scene.occupancy.with_discs(positions[others], radii)
    clearance = grid.clearance_m()
    free = OccupancyGrid(grid.origin_m, grid.cell_m, clearance < ROBOT_RADIUS_M)

    half = scene.half_extents_m[k]
    footprint_m = float(np.linalg.norm(np.delete(half, int(np.abs(rotation[2]).argmax()))))
    here = np.asarray(robot_xy_m, dtype=float)[:2]
    low = positions[k, 2] - float(np.abs(rotation[2]) @ half)
    sides = []
    for number, (grasp_o, depth, facing, places_facing, off) in enumerate(_ways_to_hold(scene, k, rotation, goal_yaw)):
        picks = _stand(grid, clearance, positions[k], facing, depth, low, off)
        for place_facing in places_facing:
            places = _stand(grid, clearance, goal, place_facing, depth, goal[2] - half[2], off)
            lacking = _lacking_room_m(grid, clearance, picks) + _lacking_room_m(grid, clearance, places)
            before, after = _back_off(free, picks), _back_off(free, places)
            straight = np.linalg.norm(before - here) + np.linalg.norm(after - before)
            extra = lacking * 100.0 + SPURNED_M * _times_spurned(facing, spurned_rad)
            at_least = extra + float(straight)
            sides.append((at_least, number, extra, lacking, picks, places, before, after, grasp_o, depth))
    sides.sort(key=lambda side: side[:2])

    best: tuple[float, tuple] | None = None
    for at_least, _, extra, lacking, picks, places, before, after, *hold in sides:
        if best is not None and at_least >= best[0]:
            break  # straight lines are no longer than ways
        stand_m = float(np.linalg.norm(picks[:2] - positions[k, :2]))
        around = min(footprint_m + TOE_ROOM_M, stand_m - 0.05)
        off = _steps_off(free, here, positions[k, :2], around)
        start = off[-1] if len(off) else here
        to_object = np.vstack([off, plan_path(free.with_discs([positions[k]], [around]), start, before, clearance)])
        to_goal = plan_path(free, before, after, clearance)
        there, onward = np.vstack([here, to_object]), np.vstack([before, to_goal])
        walk = path_length_m(there) + path_length_m(onward)
        missed = np.linalg.norm(to_object[-1] - before) + np.linalg.norm(to_goal[-1] - after)
        cost = float(extra + walk + 100.0 * (missed > 0.5))
        if best is None or cost < best[0]:
            best = cost, (picks, places, before, to_object, to_goal, hold, lacking, float(missed), len(off))
    assert best is not None
    picks, places, before, to_object, to_goal, (grasp_o, depth), lacking, missed, steps_off = best[1]
    back = resampled(np.vstack([picks[:2], before]))
    to_object = np.vstack([to_object, resampled(np.vstack([to_object[-1], picks[:2]]))[1:]])
    to_goal = np.vstack([back, to_goal, resampled(np.vstack([to_goal[-1], places[:2]]))[1:]])
    around_it = grid.with_discs([positions[k]], [footprint_m])
    ahead = np.concatenate(
        [
            np.full(max(0, steps_off - 1), steps_off - 1),
            [min(steps_off, len(to_object) - 1)] * min(1, steps_off),
            steps_off + lookahead(to_object[steps_off:], around_it.clearance_m(), around_it),
            # back first: whoever turns at once sweeps what is carried over what it stood on
            np.full(len(back) - 1, len(to_object) + len(back) - 1),
            [len(to_object) + min(len(back), len(to_goal) - 1)],
            len(to_object) + len(back) + lookahead(to_goal[len(back) :], clearance, grid),
        ]
    )
    return SubTaskRoute(picks, places, to_object, to_goal, grasp_o, depth, len(back), ahead, lacking, missed, steps_off)


def _steps_off(free: OccupancyGrid, here: np.ndarray, object_xy_m: np.ndarray, around_m: float) -> np.ndarray:
    """(W, 2) waypoints straight away from an object to which the robot is nearer than `around_m`; none if it is not, or
    there is no room."""
    away = here - object_xy_m
    distance = float(np.linalg.norm(away))
    none = np.zeros((0, 2))
    if distance >= around_m:
        return none
    there = object_xy_m + (around_m + OFF_M) * away / max(distance, 1e-6)
    return none if free.cells[free.cell_of(there)] else resampled(np.stack([here, there]))[1:]


def _times_spurned(facing_rad: float, spurned_rad: np.ndarray | None) -> int:
    return 0 if spurned_rad is None else int((np.cos(spurned_rad - facing_rad) > _SAME_SIDE).sum())


def _ways_to_hold(
    scene: Scene, k: int, rotation: np.ndarray, goal_yaw: float
) -> Iterator[tuple[np.ndarray, float, float, list[float], Point]]:
    """The ways to take object k: (2, 3) grasp in its frame, depth in m, where to face there, and where at the goal;
    and how far ahead of its middle, and to the left, the hands are, if that matters for where to stand."""
    half = scene.half_extents_m[k]
    if rotation[2, 2] > UPRIGHT:
        yaw = _yaw_of(rotation)
        for i in np.flatnonzero(scene.grasp_ok[k]).tolist():
            turn = i * np.pi / 2
            yield scene.grasps_o[k, i], 2 * float(half[i % 2]), yaw + turn, [goal_yaw + turn], (0.0, 0.0)
        return
    # it lies: press what faces the hands, along the axis that lies flattest or across that, and turn it at the goal as
    # there is room
    flattest = int(np.abs(rotation[2]).argmin())
    first = rotation[:2, flattest] / np.linalg.norm(rotation[:2, flattest])
    thing = scene.built[k]
    ways = []
    for ahead in (np.array([*first, 0.0]), np.array([-first[1], first[0], 0.0])):
        for ahead_w in (ahead, -ahead):
            ahead_o, up_o = rotation.T @ ahead_w, rotation[2]
            found = press_points(thing.parts, thing.com_m, ahead_o, up_o, half)
            if found is not None:
                ways.append((found[1], found[0], ahead_w, 2 * float(np.abs(ahead_o) @ half)))
    if not ways:
        ways = list(_by_extent(half, rotation, first))
    middles = [rotation @ grasp.mean(0) for _, grasp, _, _ in ways]
    offs = [
        (float(at @ ahead), float(at[1] * ahead[0] - at[0] * ahead[1]))
        for at, (_, _, ahead, _) in zip(middles, ways, strict=True)
    ]
    too_far = [
        max(0.0, stand_distance_m(depth, 0.0) + off[0] - REACH_M[1])
        for off, (_, _, _, depth) in zip(offs, ways, strict=True)
    ]
    costs = [way[0] + OUT_OF_REACH * far for way, far in zip(ways, too_far, strict=True)]
    for cost, off, (_, grasp, ahead_w, depth) in zip(costs, offs, ways, strict=True):
        if cost < min(costs) + WORSE_M:
            facing = float(np.arctan2(ahead_w[1], ahead_w[0]))
            yield grasp, depth, facing, [goal_yaw + i * np.pi / 2 for i in range(4)], off


def _by_extent(
    half: np.ndarray, rotation: np.ndarray, level: np.ndarray
) -> Iterator[tuple[float, np.ndarray, np.ndarray, float]]:
    """Ways to hold what offers no faces (nought, grasp, where to face, depth): by its bounding box, where it is
    narrowest."""
    directions = np.array([[*level, 0.0], [-level[1], level[0], 0.0]])
    extent = np.abs(directions @ rotation) @ half
    across = int(extent.argmin())
    upward = rotation[2]
    half_height = float(np.abs(upward) @ half)
    up = min(half_height / 2, max(0.0, half_height - TOP_ROOM_M)) * upward
    for sign in (1.0, -1.0):
        ahead = sign * directions[1 - across]
        left = extent[across] * (rotation.T @ np.array([-ahead[1], ahead[0], 0.0]))
        yield 0.0, np.stack([left, -left]) + up, ahead, 2 * float(extent[1 - across])


class Navigator:
    """Where many environments have got to on their routes, and the waypoint that each makes for.

    A route first leads to the object; its last waypoint stays current until the object has been moved `moved_m` from
    where it was when the route was planned, then the waypoints to the goal follow: straight back first, and on only
    from the end of that. Progress is the nearest of the next waypoints and never goes back.

    Args:
        scenes: one per environment (N).
        moved_m: displacement of the object from which it counts as picked up.
    """

    def __init__(self, scenes: Sequence[Scene], *, moved_m: float = 0.1) -> None:
        self.scenes = list(scenes)
        self.num_envs = len(self.scenes)
        self._moved_m = moved_m
        self.routes: list[SubTaskRoute | None] = [None] * self.num_envs
        """The route of each environment, None before the first `plan`."""
        self._waypoints = torch.zeros(self.num_envs, 1, 2)
        self._ahead = torch.zeros(self.num_envs, 1, dtype=torch.int64)
        self._last = torch.zeros(self.num_envs, dtype=torch.int64)
        self._last_to_object = torch.zeros(self.num_envs, dtype=torch.int64)
        self._last_back = torch.zeros(self.num_envs, dtype=torch.int64)
        self._last_off = torch.full((self.num_envs,), -1)
        self._object_start_w = torch.zeros(self.num_envs, 3)
        self._rows = torch.arange(self.num_envs)
        self._next = torch.arange(WINDOW)
        self._room = RoomToMove(self.scenes)
        self.progress = torch.zeros(self.num_envs, dtype=torch.int64)
        """(N,) number of the waypoint that is nearest, on the whole route."""
        self.picked_up = torch.zeros(self.num_envs, dtype=torch.bool)
        """(N,) the object has been moved since the route was planned."""

    def plan(
        self,
        ids: Sequence[int] | Tensor,
        subtask_index: Tensor,
        robot_pos_w: Tensor,
        object_pos_w: Tensor,
        object_rot_w: Tensor | None = None,
        spurned_rad: Tensor | None = None,
    ) -> list[SubTaskRoute]:
        """Plans the routes of environments `ids` anew and returns them.

        Args:
            ids: environments, (n,).
            subtask_index: (N,) the sub-task of every environment.
            robot_pos_w: (N, 2) or (N, 3) where the robots are.
            object_pos_w: (N, K, 3), absent objects' rows ignored.
            object_rot_w: (N, K, 3, 3); by default as the tasks put them.
            spurned_rad: (N, M) see `plan_subtask`.
        """
        planned = []
        for env in (int(i) for i in ids):
            scene, subtask = self.scenes[env], int(subtask_index[env])
            positions = object_pos_w[env].cpu().numpy()
            rotations = None if object_rot_w is None else object_rot_w[env].cpu().numpy()
            spurned = None if spurned_rad is None else spurned_rad[env].cpu().numpy()
            route = plan_subtask(scene, subtask, robot_pos_w[env, :2].cpu().numpy(), positions, rotations, spurned)
            self.take(env, route)
            self._object_start_w[env] = object_pos_w[env, int(scene.subtask_object[subtask])]
            self.progress[env] = 0
            self.picked_up[env] = False
            planned.append(route)
        return planned

    def take(self, env: int, route: SubTaskRoute) -> None:
        """Lets environment `env` follow a route; its progress is left as it is."""
        points = torch.as_tensor(np.vstack([route.waypoints_to_object, route.waypoints_to_goal]), dtype=torch.float32)
        if len(points) > self._waypoints.shape[1]:
            more = len(points) - self._waypoints.shape[1]
            self._waypoints = torch.cat([self._waypoints, torch.zeros(self.num_envs, more, 2)], 1)
            self._ahead = torch.cat([self._ahead, torch.zeros(self.num_envs, more, dtype=torch.int64)], 1)
        self._waypoints[env, : len(points)] = points
        self._ahead[env, : len(points)] = torch.as_tensor(route.ahead)
        self._last[env] = len(points) - 1
        self._last_to_object[env] = len(route.waypoints_to_object) - 1
        self._last_back[env] = len(route.waypoints_to_object) + route.steps_back - 1
        self._last_off[env] = route.steps_off - 1
        self.routes[env] = route

    def update(self, robot_pos_w: Tensor, object_pos_w: Tensor) -> None:
        """Goes on along the routes.

        Args:
            robot_pos_w: (N, 2) or (N, 3) where the robots are.
            object_pos_w: (N, 3) where the current sub-tasks' objects are.
        """
        displacement = (object_pos_w - self._object_start_w).norm(dim=-1)
        newly = (displacement > self._moved_m) & ~self.picked_up
        self.picked_up |= newly
        self.progress = torch.where(newly, torch.maximum(self.progress, self._last_to_object + 1), self.progress)
        limit = torch.where(self.progress < self._last_back, self._last_back, self._last)
        there = torch.where(self.progress < self._last_off, self._last_off, self._last_to_object)
        limit = torch.where(self.picked_up, limit, there)
        nearby = (self.progress[:, None] + self._next).minimum(limit[:, None])
        points = self._waypoints.gather(1, nearby[..., None].expand(-1, -1, 2))
        away = (points - robot_pos_w[:, None, :2]).square().sum(-1)
        self.progress = nearby.gather(1, away.argmin(-1, keepdim=True))[:, 0]

    @property
    def waypoint_index(self) -> Tensor:
        """(N,) number of the current waypoint on the whole route."""
        limit = torch.where(self.picked_up, self._last, self._last_to_object)
        return self._ahead[self._rows, self.progress].minimum(limit)

    @property
    def leg_is_done(self) -> Tensor:
        """(N,) bool: the current waypoint is the last one to the object, or to the goal once it was picked up."""
        return self.waypoint_index >= torch.where(self.picked_up, self._last, self._last_to_object)

    @property
    def current_waypoint(self) -> Tensor:
        """(N, 3) where to walk next, on the floor, world frame."""
        xy = self._waypoints[self._rows, self.waypoint_index]
        return torch.cat([xy, torch.zeros(self.num_envs, 1)], dim=-1)

    @property
    def stepping_back(self) -> Tensor:
        """(N,) bool: the way leads straight back from where the object was taken, or off from where it fell."""
        return self.progress < torch.where(self.picked_up, self._last_back, self._last_off)

    def room(self, robot_pos_w: Tensor) -> tuple[Tensor, Tensor]:
        """(N,) how far walls and furniture are, up to `FAR_M`, and (N, 2) the direction away from them, world."""
        return self._room(robot_pos_w)


class RoomToMove:
    """How far walls and furniture are from any place, looked up for many rooms at once.

    Args:
        scenes: one per environment (N).
    """

    def __init__(self, scenes: Sequence[Scene]) -> None:
        known: dict[int, Tensor] = {}
        for scene in scenes:
            if id(scene) not in known:
                known[id(scene)] = torch.as_tensor(scene.occupancy.clearance_m(), dtype=torch.float32).clamp(max=FAR_M)
        size = [max(field.shape[k] for field in known.values()) for k in range(2)]
        self._field = torch.zeros(len(known), *size, 3)
        """(R, X, Y, 3) distance, and how it grows along x and y."""
        number = {}
        for i, (key, field) in enumerate(known.items()):
            self._field[i, : field.shape[0], : field.shape[1], 0] = field
            number[key] = i
        distance = self._field[..., 0]
        for axis in (1, 2):
            low, high = ((torch.arange(size[axis - 1]) + step).clamp(0, size[axis - 1] - 1) for step in (-2, 2))
            self._field[..., axis] = distance.index_select(axis, high) - distance.index_select(axis, low)
        self._which = torch.tensor([number[id(scene)] for scene in scenes])
        self._origin = torch.tensor(np.stack([s.occupancy.origin_m for s in scenes]), dtype=torch.float32)
        self._cell_m, self._most = scenes[0].occupancy.cell_m, torch.tensor(size) - 1

    def __call__(self, xy_m: Tensor) -> tuple[Tensor, Tensor]:
        """See `Navigator.room`; `xy_m` is (N, 2) or (N, 3)."""
        cell = torch.floor((xy_m[:, :2] - self._origin) / self._cell_m).long()
        found = self._field[self._which, *cell.clamp(min=0).minimum(self._most).unbind(-1)]
        slope = found[:, 1:]
        return found[:, 0], slope / slope.norm(dim=-1, keepdim=True).clamp(min=1e-3)


def stand_distance_m(depth_m: float, support_height_m: float) -> float:
    """How far from an object's centre the robot stands to lift it or set it down.

    Args:
        depth_m: the object's extent along the robot's view.
        support_height_m: height of what it stands on.
    """
    if support_height_m < LOW_SUPPORT_M:
        return max(SQUAT_STAND_M, 0.2 + SQUAT_ROOM_M + depth_m / 2)
    return max(0.34, 0.2 + depth_m / 2)


def sides_with_room(
    grid: OccupancyGrid, position_w: Point, yaw_rad: float, half_extents_m: np.ndarray, grasp_ok: np.ndarray
) -> list[int]:
    """The sides of an object, as grasp indices, before which a robot finds room to stand and to step back.

    Args:
        grid: the floor with everything else on it, not inflated.
        position_w: (3,) of the object.
        yaw_rad: how it is turned.
        half_extents_m: (3,) of it.
        grasp_ok: (4,) bool: sides from which it can be taken at all.
    """
    clearance, at = grid.clearance_m(), np.asarray(position_w, dtype=float)
    found = []
    for i in np.flatnonzero(grasp_ok).tolist():
        support = at[2] - half_extents_m[2]
        stand = _stand(grid, clearance, at, yaw_rad + i * np.pi / 2, 2 * half_extents_m[i % 2], support)
        if _lacking_room_m(grid, clearance, stand) == 0.0:
            found.append(i)
    return found


def _stand(
    grid: OccupancyGrid,
    clearance_m: np.ndarray,
    position_w: np.ndarray,
    facing_rad: float,
    depth_m: float,
    support_height_m: float,
    off_m: Point = (0.0, 0.0),
) -> np.ndarray:
    """(3,) x, y and yaw of the robot that faces an object at a position, its knees and toes clear of a table; the
    hands `off_m` ahead of its middle and to the left."""
    nearest = stand_distance_m(depth_m, support_height_m)
    if off_m[0] < 0:
        nearest = max(nearest, REACH_M[0] - off_m[0])
    yaw = np.arctan2(np.sin(facing_rad), np.cos(facing_rad))
    ahead = np.array([np.cos(yaw), np.sin(yaw)])
    distances = nearest + np.arange(0.0, STEP_BACK_M + 1e-9, 0.02)
    middle = position_w[:2] + off_m[1] * np.array([-ahead[1], ahead[0]])
    places = middle - distances[:, None] * ahead
    at = grid.cells_of(places)
    enough = clearance_m[at[:, 0], at[:, 1]] >= EASY_CLEARANCE_M
    chosen = int(enough.argmax()) if enough.any() else 0
    return np.array([*places[chosen], yaw])


def _lacking_room_m(grid: OccupancyGrid, clearance_m: np.ndarray, stand: np.ndarray) -> float:
    """By how much clearance falls short at a stand pose (counted tenfold) and behind it; 0 where there is room."""
    behind = stand[:2] - RETREAT_M * np.array([np.cos(stand[2]), np.sin(stand[2])])
    here, there = clearance_m[grid.cell_of(stand)], clearance_m[grid.cell_of(behind)]
    return 10 * max(0.0, STAND_CLEARANCE_M - float(here)) + max(0.0, RETREAT_CLEARANCE_M - float(there))


def _back_off(free: OccupancyGrid, stand: np.ndarray) -> np.ndarray:
    """(2,) the first free place straight behind a stand pose, within a metre, else the nearest free place."""
    backward = -np.array([np.cos(stand[2]), np.sin(stand[2])])
    points = stand[:2] + np.arange(_STEP_OFF_M, _BACK_OFF_M + 1e-9, free.cell_m)[:, None] * backward
    at = free.cells_of(points)
    clear = ~free.cells[at[:, 0], at[:, 1]]
    if clear.any():
        return points[clear.argmax()]
    return free.origin_m + (np.array(nearest_free(free, stand[:2])) + 0.5) * free.cell_m


def _yaw_of(rotation: np.ndarray) -> float:
    """Yaw of a rotation matrix; of its most level axis when the object has toppled."""
    if np.hypot(rotation[0, 0], rotation[1, 0]) >= 0.5:
        return float(np.arctan2(rotation[1, 0], rotation[0, 0]))
    return float(np.arctan2(-rotation[0, 1], rotation[1, 1]))


