"""Random practice grounds for the motor prior: an empty floor, or a box to carry from one support to another."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from hv_sim.humanoid import (
    ALL_CONAFFINITY,
    BODY_NAMES,
    ENVIRONMENT_CONTYPE,
    JOINT_NAMES,
    KD,
    KP,
    add_humanoid,
    configure_physics,
)
from hv_sim.navigation import stand_distance_m

TABLE_HALF_M = (0.3, 0.5)
"""Half depth and half width of a support."""
EDGE_M = (0.02, 0.12)
"""Room between a box on a support and the support's edge."""
EDGE_STAND_M = 0.22
"""Between the edge and the middle of the robot that stands before it: its toes and knees need as much."""
GRASP_BELOW_TOP_M = 0.045
"""Hands roll some centimetres on what they hold as the forearms turn: a box hangs upright only if gripped well above
its centre."""
MOST_DRAWS = 1000
FEET, HANDS = ("right_foot", "left_foot"), ("right_hand", "left_hand")
BEHIND_M = 0.5
PASSING_M = 0.55
"""Clearance of a robot's middle that carries a box past a table."""
RETREAT_M, RETREAT_CLEARANCE_M = 1.1, 0.35
"""How far behind the place where it put the box down the robot must find room, and how much."""


@dataclass(frozen=True)
class LoadRange:
    """Boxes, supports and ways that are drawn; m, kg, rad."""

    width_m: tuple[float, float] = (0.15, 0.5)
    depth_m: tuple[float, float] = (0.15, 0.5)
    height_m: tuple[float, float] = (0.15, 0.5)
    mass_kg: tuple[float, float] = (0.5, 8.0)
    support_m: tuple[float, float] = (0.05, 0.9)
    floor_share: float = 0.4
    walk_m: tuple[float, float] = (0.8, 2.5)
    turn_rad: float = 2.1
    friction: tuple[float, float] = (0.8, 1.3)


@dataclass(frozen=True)
class CarryTask:
    """One box, where it is, where it belongs and where to stand for both; world frame."""

    half_extents_m: np.ndarray  # (3,) depth, width, height
    mass_kg: float
    grasp_height_m: float  # of the hands above the box's centre
    start_pos: np.ndarray  # (3,)
    goal_pos: np.ndarray  # (3,)
    pick_stand: np.ndarray  # (3,) x, y, yaw
    place_stand: np.ndarray  # (3,)
    support_m: tuple[float, float]
    table_ahead_m: tuple[float, float]  # of the middle of each support beyond the box's place, seen from the stand


def draw_carry_task(rng: np.random.Generator, load: LoadRange) -> CarryTask:
    """Draws a box, two supports and the way between them.

    Raises:
        ValueError: no way within the range is free of the supports.
    """
    width, depth, height = (rng.uniform(*r) for r in (load.width_m, load.depth_m, load.height_m))
    # a small box is a light one
    heaviest = min(load.mass_kg[1], 900.0 * width * depth * height + 1.0)
    mass = rng.uniform(load.mass_kg[0], heaviest)
    supports = tuple(0.0 if rng.random() < load.floor_share else rng.uniform(*load.support_m) for _ in range(2))
    edges = [depth / 2 + rng.uniform(*EDGE_M) for _ in supports]
    ahead = [TABLE_HALF_M[0] - e for e in edges]
    stands = [
        max(stand_distance_m(depth, s), e + EDGE_STAND_M if s > 0 else 0.0)
        for s, e in zip(supports, edges, strict=True)
    ]
    pick = np.array([-stands[0], 0.0, 0.0])
    for _ in range(MOST_DRAWS):
        bearing = rng.uniform(0.35 * np.pi, 1.65 * np.pi)
        far = rng.uniform(*load.walk_m)
        place = np.array([pick[0] + far * np.cos(bearing), far * np.sin(bearing), rng.uniform(-1, 1) * load.turn_rad])
        goal = place[:2] + stands[1] * np.array([np.cos(place[2]), np.sin(place[2])])
        tables = [(0.0, 0.0, 0.0, ahead[0])] if supports[0] > 0 else []
        tables += [(*goal, place[2], ahead[1])] if supports[1] > 0 else []
        # from behind one stand to behind the other, and back from the goal when all is done
        way = np.linspace(behind(pick), behind(place), 40)
        back = np.linspace(behind(place), behind(place, RETREAT_M), 8)
        clear = table_clearance_m(way, tables) > PASSING_M and table_clearance_m(back, tables) > RETREAT_CLEARANCE_M
        if np.linalg.norm(goal) > 1.0 and np.linalg.norm(goal - pick[:2]) > 0.9 and clear:
            break
    else:
        raise ValueError(f"walk_m: {load.walk_m} is not valid; valid: a way that leads around the supports")
    return CarryTask(
        half_extents_m=np.array([depth, width, height]) / 2,
        mass_kg=float(mass),
        grasp_height_m=float(height / 2 - GRASP_BELOW_TOP_M),
        start_pos=np.array([0.0, 0.0, supports[0] + height / 2]),
        goal_pos=np.array([goal[0], goal[1], supports[1] + height / 2]),
        pick_stand=pick,
        place_stand=place,
        support_m=(float(supports[0]), float(supports[1])),
        table_ahead_m=(float(ahead[0]), float(ahead[1])),
    )


def behind(stand: np.ndarray, distance_m: float = BEHIND_M) -> np.ndarray:
    """(2,) where the robot comes from, and goes back to, before it faces a stand (x, y, yaw)."""
    return stand[:2] - distance_m * np.array([np.cos(stand[2]), np.sin(stand[2])])


def tables_of(task: CarryTask) -> list[tuple[float, float, float, float]]:
    """(x, y, yaw of what stands on it, how far its middle lies beyond that) of each support that is a table."""
    places = ((task.start_pos, 0.0), (task.goal_pos, float(task.place_stand[2])))
    return [
        (float(pos[0]), float(pos[1]), yaw, ahead)
        for (pos, yaw), height, ahead in zip(places, task.support_m, task.table_ahead_m, strict=True)
        if height > 0
    ]


def table_clearance_m(points: np.ndarray, tables: list[tuple[float, float, float, float]]) -> float:
    """How near the points (P, 2) come to a table (`tables_of`); infinite where there is none."""
    nearest = np.inf
    for x, y, yaw, ahead in tables:
        c, s = np.cos(yaw), np.sin(yaw)
        local = (points - [x, y]) @ np.array([[c, -s], [s, c]]) - [ahead, 0.0]
        outside = np.maximum(np.abs(local) - TABLE_HALF_M, 0.0)
        nearest = min(nearest, float(np.sqrt((outside**2).sum(1).min())))
    return nearest


def compile_ground(
    rng: np.random.Generator,
    task: CarryTask | None,
    *,
    randomize: bool = True,
    friction: tuple[float, float] = (0.8, 1.3),
    physics_hz: int = 120,
) -> mujoco.MjModel:
    """A floor, and for a task its box and supports. With `randomize`, masses and servo gains vary by 10 %, and so does
    friction, the hands' apart from that of everything else (soles, floor, supports, box), within `friction`."""
    spec = mujoco.MjSpec()
    add_humanoid(spec)
    grip = rng.uniform(*friction) if randomize else 1.0
    if randomize:
        # of two geoms the greater friction counts, and with hands only theirs
        _rub(spec, FEET, grip)
        _rub(spec, HANDS, rng.uniform(*friction))
    floor = spec.worldbody.add_geom(
        name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[30, 30, 1], rgba=[0.6, 0.6, 0.6, 1]
    )
    floor.contype, floor.conaffinity, floor.friction = ENVIRONMENT_CONTYPE, ALL_CONAFFINITY, [grip, 0.05, 0.005]
    spec.worldbody.add_light(pos=[0, 0, 5], dir=[0, 0, -1])
    if task is not None:
        _add_load(spec, task, grip)
    if randomize:
        for name in BODY_NAMES:
            scale = rng.uniform(0.9, 1.1)
            for geom in spec.body(name).geoms:
                geom.mass *= scale
        for name, kp, kd in zip(JOINT_NAMES, KP, KD, strict=True):
            scale = rng.uniform(0.9, 1.1)
            spec.actuator(name).set_to_position(kp=float(kp * scale), kv=float(kd * scale))
    configure_physics(spec, physics_hz)
    return spec.compile()


def _rub(spec: mujoco.MjSpec, bodies: tuple[str, str], sliding: float) -> None:
    for name in bodies:
        for geom in spec.body(name).geoms:
            geom.friction = [sliding, *geom.friction[1:]]


def _add_load(spec: mujoco.MjSpec, task: CarryTask, grip: float) -> None:
    places = ((task.start_pos, 0.0), (task.goal_pos, task.place_stand[2]))
    for i, ((pos, yaw), support, further) in enumerate(zip(places, task.support_m, task.table_ahead_m, strict=True)):
        if support <= 0:
            continue
        ahead = np.array([np.cos(yaw), np.sin(yaw)]) * further
        table = spec.worldbody.add_geom(
            name=f"support_{i}", type=mujoco.mjtGeom.mjGEOM_BOX, size=[*TABLE_HALF_M, support / 2]
        )
        table.pos = [pos[0] + ahead[0], pos[1] + ahead[1], support / 2]
        table.quat = [np.cos(yaw / 2), 0, 0, np.sin(yaw / 2)]
        table.contype, table.conaffinity, table.rgba = ENVIRONMENT_CONTYPE, ALL_CONAFFINITY, [0.6, 0.45, 0.3, 1]
        table.friction = [grip, 0.05, 0.005]
    box = spec.worldbody.add_body(name="box", pos=list(task.start_pos))
    box.add_freejoint()
    geom = box.add_geom(name="box", type=mujoco.mjtGeom.mjGEOM_BOX, size=list(task.half_extents_m))
    geom.mass, geom.contype, geom.conaffinity, geom.condim = task.mass_kg, ENVIRONMENT_CONTYPE, ALL_CONAFFINITY, 4
    geom.friction, geom.rgba = [grip, 0.02, 0.001], [0.75, 0.5, 0.2, 1]
