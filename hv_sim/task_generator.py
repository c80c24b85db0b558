"""Draws the benchmark's tasks: a floor plan, things in it, what goes where, and how to say so. All from a seed.

What is drawn fits, is unambiguous and can be walked; whatever else makes a task solvable is checked by whoever draws
(`accept`), and candidates that fail are thrown away.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from hv_sim.floor_plans import HELD_OUT, STAND_M, FloorPlan, can_stand_before, floor_plan, standing_room
from hv_sim.furniture import FURNITURE_KINDS
from hv_sim.instructions import write_instructions
from hv_sim.lexicon import alike_in_color, called, furniture_nouns, usable
from hv_sim.navigation import sides_with_room
from hv_sim.objects import GRASP_WIDTH_M, MASS_KG, OBJECT_KINDS, BuiltObject
from hv_sim.parts import prisms
from hv_sim.paths import OccupancyGrid, occupancy_grid
from hv_sim.places import BESIDE, BY_THE_MIDDLE, ON, Layout, Place, Pose, layout_at
from hv_sim.rooms import ROOM_KINDS
from hv_sim.single_object import single_object_tasks
from hv_sim.suites import SUITE_SIZES
from hv_sim.surfaces import Surface
from hv_sim.task import (
    ObjectPlacement,
    RobotStart,
    SubTask,
    Task,
    TaskError,
    built_object,
    check_task,
    furniture_parts,
    room_parts,
)

SEED = 2026
"""Of the suites in the package."""
SEEN_PLANS, UNSEEN_PLANS = range(12), HELD_OUT[:5]
PRACTICE_PLANS = (*range(12, HELD_OUT.start), *range(HELD_OUT.stop, 5000))
"""Floor plans of each kind of room."""
SUBTASKS = {"seen": 2, "unseen": 2, "chain3": 3, "chain5": 5, "practice": 2}
"""Of a suite's tasks. There is no end to `practice`: rooms to learn in, which no other suite has."""
PHRASINGS = 6

HEAVIEST_KG = 8.0
FARTHEST_M, NEAREST_M = 9.0, 0.9
"""Between where an object is and where it shall go."""
_MARGIN_M = (0.02, 0.06)
"""Between an object that is to be moved and the edge of the top on which it stands."""
_GOAL_MARGIN_M = 0.12
"""The same where it shall go: as near the middle of the top as the robot reaches over it."""
_JITTER_M = 0.04
"""How far along a top or on the floor a goal is drawn from the spot that the words mean."""
_REACH_M = 0.15
"""Farthest near side of an object behind the edge over which it is handled."""
_SIZES, _UNSEEN_SIZES = (0.90, 1.0, 1.08), (0.94, 1.04)
_MASSES = (0.7, 1.0, 1.4, 1.9)
_OBJECT_GAP_M = 0.06
_FLOOR_GAP_M = 0.10
_ATTEMPTS, _POSES = 400, 60
_MADE_UP_SHARE = 0.4
"""Of the things in rooms to practise in."""

OBJECTS_IN: dict[str, tuple[str, ...]] = {
    "bedroom": (
        "lamp", "suitcase", "backpack", "cushion", "blanket_stack", "book_stack", "laundry_basket", "trash_bin",
        "stool", "pouf", "plant", "vase", "laptop", "radio", "gift_box", "mantel_clock", "globe", "duffel_bag", "fan",
        "box", "chest", "basket", "dining_chair", "speaker", "side_table", "teddy_bear", "briefcase", "kids_chair",
    ),
    "kitchen": (
        "toaster", "cooking_pot", "microwave", "coffee_maker", "kettle", "rice_cooker", "bread_bin", "fruit_bowl",
        "bucket", "trash_bin", "dining_chair", "stool", "bar_stool", "step_stool", "crate", "basket", "plant", "vase",
        "radio", "box", "tote", "blender", "cooler",
    ),
    "living_room": (
        "lamp", "floor_lamp", "vase", "plant", "lantern", "globe", "mantel_clock", "speaker", "radio", "cushion",
        "book_stack", "blanket_stack", "basket", "box", "gift_box", "pouf", "stool", "dining_chair", "bedside_table",
        "side_table", "suitcase", "backpack", "laptop", "trash_bin", "chest", "crate", "cactus", "teddy_bear",
        "kids_chair",
    ),
    "warehouse": (
        "box", "crate", "tote", "toolbox", "paint_can", "jerry_can", "bucket", "barrel", "cable_reel", "printer",
        "monitor", "laptop", "step_stool", "trash_bin", "lantern", "fan", "speaker", "chest", "stool", "basket",
        "drum", "computer", "fire_extinguisher", "cooler",
    ),
}  # fmt: skip
"""What is found in each kind of room; kinds that are held out come last and only in unseen tasks."""


def draw_suite(
    name: str, accept: Callable[[Task], bool] = lambda task: True, count: int | None = None
) -> Iterator[Task]:
    """The tasks of a suite (`hv_sim.suites.SUITES` but `single`), in order, the same ones each time.

    Args:
        name: of the suite.
        accept: whether a candidate is good enough; it must always say the same of the same task.
        count: stops after so many; by default the suite is complete (`practice` never is).
    """
    for index in range(SUITE_SIZES[name] if count is None else count):
        yield draw_task(name, index, accept)


def draw_task(suite: str, index: int, accept: Callable[[Task], bool] = lambda task: True, seed: int = SEED) -> Task:
    """Task number `index` of a suite.

    Raises:
        ValueError: there is no such suite.
        RuntimeError: none of many candidates was good enough.
    """
    if suite not in SUBTASKS:
        raise ValueError(f"suite: {suite!r} is not drawn; valid: {', '.join(SUBTASKS)}")
    for attempt in range(_ATTEMPTS):
        rng = np.random.default_rng([seed, list(SUBTASKS).index(suite), index, attempt])
        task = _candidate(suite, index, rng)
        if task is not None and accept(task):
            return task
    raise RuntimeError(f"index: task {index} of {suite} could not be drawn")


def single_tasks(seen: Iterable[Task]) -> Iterator[Task]:
    """The suite `single`: each sub-task of the tasks of `seen` on its own."""
    for task in seen:
        for i, single in enumerate(single_object_tasks(task), 1):
            yield replace(single, name=f"{task.name.replace('seen', 'single')}_{i}")


@functools.cache
def _plan(kind: str, number: int) -> tuple[FloorPlan, OccupancyGrid]:
    plan = floor_plan(kind, number)
    return plan, standing_room(plan)


@dataclass
class _Draft:
    """A task in the making."""

    plan: FloorPlan
    room: OccupancyGrid
    rng: np.random.Generator
    unseen: bool
    invents: bool
    """Some of its things are made up (`hv_sim.object_kinds.made_up`)."""
    objects: list[ObjectPlacement]
    built: list[BuiltObject]
    poses: list[Pose]

    def without(self, i: int) -> OccupancyGrid:
        """The floor with all objects but one on it."""
        others = [j for j in range(len(self.poses)) if j != i]
        radii = [float(np.hypot(*self.built[j].half_extents_m[:2])) for j in others]
        return _solids(self.plan).with_discs([self.poses[j][0] for j in others], radii)

    def taken(self, xy: tuple[float, float], radius_m: float, bottom_m: float, but: int) -> bool:
        """Whether another object is in the way there."""
        for j, (position, _) in enumerate(self.poses):
            if j == but:
                continue
            half = self.built[j].half_extents_m
            low, high = position[2] - half[2], position[2] + half[2]
            beside = np.hypot(xy[0] - position[0], xy[1] - position[1])
            if low - 0.6 < bottom_m < high + 0.6 and beside < radius_m + np.hypot(half[0], half[1]) + _OBJECT_GAP_M:
                return True
        return False


def _candidate(suite: str, index: int, rng: np.random.Generator) -> Task | None:
    unseen = suite == "unseen"
    kind = ROOM_KINDS[index % len(ROOM_KINDS)]
    plans = {"unseen": UNSEEN_PLANS, "practice": PRACTICE_PLANS}.get(suite, SEEN_PLANS)
    plan, room = _plan(kind, int(plans[int(rng.integers(len(plans)))]))
    draft = _Draft(plan, room, rng, unseen, suite == "practice", [], [], [])
    targets = SUBTASKS[suite]
    extras = int(rng.integers(1, 4)) if targets < 5 else 1
    for number, (name, spec) in enumerate(_things(draft, kind, targets, extras)):
        if not _put_somewhere(draft, name, spec, needs_room=number < targets):
            return None
    start = _robot_start(draft)
    if start is None:
        return None
    task = Task(f"{suite}_{index:03d}", plan.room, start, plan.furniture, tuple(draft.objects), ())
    for i in range(targets):
        done = _subtask(draft, task, i)
        if done is None:
            return None
        task = replace(task, subtasks=(*task.subtasks, done))
    try:
        check_task(task)
    except TaskError:
        return None
    return task


def _things(draft: _Draft, room: str, targets: int, extras: int) -> list[tuple[str, ObjectPlacement]]:
    """The objects of a task, those to be moved first; now and then one that looks like one of them."""
    rng = draft.rng
    kinds = [k for k in OBJECTS_IN[room] if draft.unseen or not OBJECT_KINDS[k].held_out]
    if draft.unseen:  # half of what is to be moved is of a kind never seen
        held_out = [k for k in kinds if OBJECT_KINDS[k].held_out]
        first = str(rng.choice(held_out))
        kinds = [first, *(k for k in rng.permutation([k for k in kinds if k != first]).tolist())]
        order = [kinds[i] for i in ([0, 1] if rng.random() < 0.5 else [1, 0])] + kinds[2:]
    else:
        order = rng.permutation(kinds).tolist()
    if draft.invents:
        order = [OBJECT_KINDS.draw_made_up(rng) if rng.random() < _MADE_UP_SHARE else kind for kind in order]
    chosen = order[: targets + extras]
    if rng.random() < 0.6:
        chosen[-1] = chosen[int(rng.integers(targets))]
    things: list[tuple[str, ObjectPlacement]] = []
    taken = {piece.name for piece in draft.plan.furniture}
    for kind in chosen:
        twin = next((o for _, o in things if o.kind == kind), None)
        name = next(n for n in (kind, *(f"{kind}_{i}" for i in range(2, 9))) if n not in taken)
        taken.add(name)
        things.append((name, _instance(draft, name, kind, twin)))
    return things


def _instance(draft: _Draft, name: str, kind: str, twin: ObjectPlacement | None) -> ObjectPlacement:
    """An object of a kind with its own size, mass and colour; seen and unseen tasks have none of them in common."""
    spec, rng = OBJECT_KINDS[kind], draft.rng
    colors = list(spec.colors or (spec.color,))
    if len(colors) > 1:
        colors = colors[-1:] if draft.unseen else colors[:-1]
    color = str(rng.choice(colors))
    scale = float(rng.choice(_UNSEEN_SIZES if draft.unseen else _SIZES))
    if twin is not None:
        others = [c for c in colors if not alike_in_color(c, str(twin.color))]
        if others:
            color = str(rng.choice(others))
        else:
            scale = 0.8 if twin.size_m is not None and twin.size_m[2] >= 0.98 * spec.size_m[2] else 1.2
            scale += 0.01 * draft.unseen
    low, high = GRASP_WIDTH_M
    across = [round(float(np.clip(s * scale, low, high)), 3) for s in spec.size_m[:2]]
    tall = round(float(np.clip(spec.size_m[2] * scale, 0.1, spec.max_height_m)), 3)
    mass = spec.mass_kg * scale**2 * float(rng.choice(_MASSES))
    mass = round(float(np.clip(mass, MASS_KG[0], HEAVIEST_KG)), 2)
    return ObjectPlacement(name, kind, (0.0, 0.0, 0.0), 0.0, (across[0], across[1], tall), mass, color)


def _put_somewhere(draft: _Draft, name: str, spec: ObjectPlacement, needs_room: bool) -> bool:
    """Gives an object a place to begin."""
    rng, support = draft.rng, OBJECT_KINDS[spec.kind].support
    built = built_object(spec)
    high = support == "surface" or (support == "both" and rng.random() < 0.5)
    for _ in range(_POSES):
        pose = _pose_on_top(draft, built, needs_room) if high else _pose_on_floor(draft, built)
        if pose is not None:
            position, yaw = pose
            draft.objects.append(replace(spec, position_m=position, yaw_rad=yaw))
            draft.built.append(built)
            draft.poses.append(pose)
            return True
    return False


def _pose_on_top(draft: _Draft, built: BuiltObject, needs_room: bool) -> Pose | None:
    """A pose on some top near an edge before which the robot can stand."""
    rng = draft.rng
    tops = draft.plan.surfaces
    if not tops:
        return None
    surface = tops[int(rng.integers(len(tops)))]
    edges = can_stand_before(surface, draft.room)
    if not edges:
        return None
    outward, edge, deep, wide = edges[int(rng.integers(len(edges)))]
    grasp = int(rng.choice(np.flatnonzero(built.grasp_ok)))
    depth, width = _turned(built, grasp)
    out = min(edge - float(rng.uniform(*_MARGIN_M)) - depth, deep - depth)
    free = wide - width - 0.02
    if out < -deep + depth or free < 0 or (needs_room and edge - out > depth + _REACH_M):
        return None
    return _at_edge(draft, built, surface, (outward, edge, out, float(rng.uniform(-free, free))), grasp, -1)


def _goal_on_top(
    draft: _Draft, built: BuiltObject, surface: Surface, spot_m: tuple[float, float], but: int, sides: list[int]
) -> Pose | None:
    """A pose on a top as near a spot as the robot reaches from one of its edges."""
    rng = draft.rng
    edges = can_stand_before(surface, draft.room)
    if not edges:
        return None
    outward, edge, deep, wide = edges[int(rng.integers(len(edges)))]
    grasp = int(rng.choice(sides))
    depth, width = _turned(built, grasp)
    toward = np.subtract(spot_m, surface.position_m)
    c, s = np.cos(outward), np.sin(outward)
    wanted = float(c * toward[0] + s * toward[1])
    out = min(max(wanted, edge - _GOAL_MARGIN_M - depth), edge - _MARGIN_M[0] - depth, deep - depth)
    aside = float(c * toward[1] - s * toward[0]) + float(rng.uniform(-_JITTER_M, _JITTER_M))
    if out < -deep + depth or edge - out > depth + _REACH_M or abs(aside) > wide - width:
        return None
    return _at_edge(draft, built, surface, (outward, edge, out, aside), grasp, but)


def _turned(built: BuiltObject, grasp: int) -> tuple[float, float]:
    """Half extents of an object along and across the view of a robot that takes it from a side."""
    x, y = (float(v) for v in built.half_extents_m[:2])
    return (x, y) if grasp % 2 == 0 else (y, x)


def _at_edge(
    draft: _Draft,
    built: BuiltObject,
    surface: Surface,
    where: tuple[float, float, float, float],
    grasp: int,
    but: int,
) -> Pose | None:
    """The pose at `where` (the outward yaw of an edge, its distance, how far out and how far aside), if there is room
    for it and for a robot before that edge."""
    outward, edge, out, aside = where
    c, s = np.cos(outward), np.sin(outward)
    at = (surface.position_m[0] + c * out - s * aside, surface.position_m[1] + s * out + c * aside)
    # the robot faces the other way than the side looks, and the object's axis number `grasp` along its view
    yaw = _wrapped(outward + np.pi - grasp * np.pi / 2)
    reach = edge - out + STAND_M
    if draft.room.cells[draft.room.cell_of((at[0] + c * reach, at[1] + s * reach))]:
        return None
    return _settled(draft, at, surface.height_m, yaw, built, but)


def _pose_on_floor(
    draft: _Draft, built: BuiltObject, spot_m: tuple[float, float] | None = None, but: int = -1
) -> Pose | None:
    """A pose on the floor, at a spot or anywhere, clear of everything."""
    rng, size = draft.rng, draft.plan.room.size_m
    if spot_m is None:
        at = (float(rng.uniform(-0.48, 0.48) * size[0]), float(rng.uniform(-0.48, 0.48) * size[1]))
    else:
        at = (
            spot_m[0] + float(rng.uniform(-_JITTER_M, _JITTER_M)),
            spot_m[1] + float(rng.uniform(-_JITTER_M, _JITTER_M)),
        )
    yaw = _wrapped(float(rng.choice([0.0, 0.5, 1.0, -0.5])) * np.pi + float(rng.uniform(-0.25, 0.25)))
    half = np.hypot(*built.half_extents_m[:2])
    index = _solids(draft.plan).cell_of(at)
    clearance = _clearance(draft.plan)
    if not all(0 <= i < n for i, n in zip(index, clearance.shape, strict=True)):
        return None
    if clearance[tuple(index)] < half + _FLOOR_GAP_M:
        return None
    return _settled(draft, at, 0.0, yaw, built, but)


@functools.cache
def _solids(plan: FloorPlan) -> OccupancyGrid:
    solids = prisms([*room_parts(plan.room), *(p for f in plan.furniture for p in furniture_parts(f))])
    return occupancy_grid(solids, plan.room.size_m)


@functools.cache
def _clearance(plan: FloorPlan) -> np.ndarray:
    return _solids(plan).clearance_m()


def _settled(
    draft: _Draft, at: tuple[float, float], support_m: float, yaw: float, built: BuiltObject, but: int
) -> Pose | None:
    """The pose at rest on a support, unless another object is in the way."""
    half = built.half_extents_m
    if draft.taken(at, float(np.hypot(half[0], half[1])), support_m, but):
        return None
    position = (round(float(at[0]), 3), round(float(at[1]), 3), round(float(support_m + half[2]), 4))
    return position, round(yaw, 4)


def _robot_start(draft: _Draft) -> RobotStart | None:
    rng, room = draft.rng, draft.room
    free = np.argwhere(~room.cells)
    for _ in range(_POSES):
        cell = free[int(rng.integers(len(free)))]
        x, y = (room.origin_m + (cell + 0.5) * room.cell_m).tolist()
        gaps = [np.hypot(x - p[0][0], y - p[0][1]) for p in draft.poses if p[0][2] < 1.0]
        if min(gaps, default=9.0) > 0.75:
            yaw = float(rng.uniform(-np.pi, np.pi))
            return RobotStart((round(x, 3), round(y, 3)), round(yaw, 4))
    return None


def _subtask(draft: _Draft, task: Task, i: int) -> SubTask | None:
    """What shall happen to object number `i`."""
    rng, placed, built = draft.rng, task.objects[i], draft.built[i]
    layout = layout_at(task, i)
    kind = OBJECT_KINDS[placed.kind]
    grid = draft.without(i)
    sides = sides_with_room(grid, placed.position_m, placed.yaw_rad, built.half_extents_m, built.grasp_ok)
    if not sides:
        return None
    places = _goals(draft, layout, placed.name, kind.support)
    for number in rng.permutation(len(places)).tolist()[:25]:
        place = places[number]
        if place.landmark and not _is_named_alone(layout, place, draft.unseen):
            continue
        if layout.contains(place, placed.name, placed.position_m):
            continue
        spot = layout.spot_m(place, placed.name)
        assert spot is not None, "`_goals` leaves others out"
        top = _top_of(layout, place)
        for _ in range(8):
            if top is None:
                pose = _pose_on_floor(draft, built, spot, i)
            else:
                pose = _goal_on_top(draft, built, top, spot, i, sides)
            if pose is None or not layout.is_goal(place, placed.name, pose[0]):
                continue
            there = sides_with_room(grid, *pose, built.half_extents_m, built.grasp_ok)
            if not set(sides) & set(there):
                continue
            if not NEAREST_M < np.hypot(*np.subtract(pose[0], placed.position_m)[:2]) < FARTHEST_M:
                continue
            said = write_instructions(
                layout, placed.name, pose[0], place, rng, unseen=draft.unseen, count=PHRASINGS, later=i > 0
            )
            if len(said) < PHRASINGS:
                break
            draft.poses[i] = pose
            return SubTask(placed.name, pose[0], pose[1], said[0], tuple(said[1:]))
    return None


def _goals(draft: _Draft, layout: Layout, name: str, support: str) -> list[Place]:
    """Places where such a thing may be brought."""
    found: list[Place] = []
    if support in ("surface", "both"):
        for surface in draft.plan.surfaces:
            found += [Place(r, surface.furniture) for r in ON]
            here = [n for n, (at, _) in layout.poses.items() if layout.contains(Place("on", surface.furniture), n, at)]
            found += [Place(r, n) for n in here for r in ("left_of", "right_of")]
    if support in ("floor", "both"):
        solid = [f for f in draft.plan.furniture if FURNITURE_KINDS[f.kind].solid]
        found += [Place(r, f.name) for f in solid for r in (*BESIDE, *BY_THE_MIDDLE)]
        found.append(Place("room_middle"))
    return [p for p in found if layout.spot_m(p, name) is not None]


def _top_of(layout: Layout, place: Place) -> Surface | None:
    """The top on which a place lies, None on the floor."""
    if place.relation in ON:
        return layout.surfaces[place.landmark]
    return layout.top_under(place.landmark) if place.landmark in layout.poses else None


def _is_named_alone(layout: Layout, place: Place, unseen: bool) -> bool:
    piece = layout.furniture(place.landmark)
    if piece is None:
        return True
    return any(called(layout, noun) == ([], [piece.name]) for noun in usable(furniture_nouns(piece.kind), unseen))


def _wrapped(angle: float) -> float:
    return float(np.arctan2(np.sin(angle), np.cos(angle)))
