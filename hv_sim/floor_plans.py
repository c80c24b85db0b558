"""Floor plans: furnished rooms of four kinds, drawn by rules from a number.

Beds stand with their heads to a wall and a nightstand beside them, kitchens run along a wall round an island, sofas
face the television, racks leave aisles. Every top that things may be put on has room to stand before it, and all of
that room is connected.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy import ndimage

from hv_sim.furniture import FURNITURE_KINDS
from hv_sim.parts import prisms
from hv_sim.paths import ROBOT_RADIUS_M, OccupancyGrid, occupancy_grid
from hv_sim.rooms import ROOM_KINDS
from hv_sim.surfaces import Surface, surfaces_of
from hv_sim.task import FurniturePlacement, Room, furniture_parts, room_parts

HELD_OUT = range(100, 200)
"""Plans of these numbers occur only among the unseen tasks."""
STAND_M = 0.45
"""How far from the edge of a piece a robot stands to use its top."""

_MADE_UP_SHARE = 0.3
"""Of the pieces along the walls of plans that come after those that are held out."""
_FRONT_ZONE_M = 0.95
_GAP_M = 0.06
_ATTEMPTS = 400

_Rect = tuple[float, float, float, float]  # x low, x high, y low, y high

_LOOKS: dict[str, tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...], tuple[str, ...]]] = {
    # floors and wall colours of the seen plans, then those of the held-out ones
    "bedroom": (("oak", "carpet", "walnut"), ("cream", "beige", "white"), ("blue_carpet", "ash"), ("pink", "silver")),
    "kitchen": (("tiles", "oak", "ash"), ("white", "cream", "beige"), ("slate",), ("yellow", "silver")),
    "living_room": (("oak", "walnut", "carpet"), ("cream", "white", "beige"), ("ash", "slate"), ("silver", "tan")),
    "warehouse": (("concrete", "slate"), ("silver", "gray", "white"), ("epoxy",), ("beige", "silver")),
}
_SIZES: dict[str, tuple[tuple[float, float], tuple[float, float]]] = {
    "bedroom": ((4.8, 6.0), (4.6, 5.6)),
    "kitchen": ((5.6, 7.0), (5.6, 6.8)),
    "living_room": ((5.6, 7.0), (5.2, 6.4)),
    "warehouse": ((7.2, 9.0), (7.0, 9.0)),
}
_HELD_OUT_PIECES = {"piano", "display_cabinet", "vanity", "washing_machine", "conveyor", "locker", "record_cabinet"}
"""Furniture that no seen plan has."""


@dataclass(frozen=True)
class FloorPlan:
    """A furnished room without movable objects."""

    title: str
    room: Room
    furniture: tuple[FurniturePlacement, ...]

    @property
    def surfaces(self) -> list[Surface]:
        """Tops that things can be put on."""
        return surfaces_of(self.furniture)


def floor_plan(kind: str, index: int) -> FloorPlan:
    """Plan number `index` of a kind in `ROOM_KINDS`, always the same; those of `HELD_OUT` are the unseen ones.

    Raises:
        ValueError: there is no such kind, or the number is negative.
    """
    if kind not in ROOM_KINDS:
        raise ValueError(f"kind: {kind!r} is not a room; valid: {', '.join(ROOM_KINDS)}")
    if index < 0:
        raise ValueError(f"index: {index} is not valid; valid: an integer >= 0")
    for attempt in range(_ATTEMPTS):
        rng = np.random.default_rng([ROOM_KINDS.index(kind), index, attempt])
        plan = _draw(kind, index, rng)
        if plan is not None:
            return plan
    raise RuntimeError(f"index: plan {index} of a {kind} could not be drawn")


def standing_room(plan: FloorPlan) -> OccupancyGrid:
    """The largest connected part of the floor where a robot can stand (free cells are False)."""
    solids = prisms([*room_parts(plan.room), *(p for f in plan.furniture for p in furniture_parts(f))])
    taken = occupancy_grid(solids, plan.room.size_m).inflated(ROBOT_RADIUS_M)
    labels, count = ndimage.label(~taken.cells)
    if not count:
        return taken
    largest = 1 + int(np.argmax(ndimage.sum_labels(~taken.cells, labels, np.arange(1, count + 1))))
    return OccupancyGrid(taken.origin_m, taken.cell_m, labels != largest)


def can_stand_before(surface: Surface, room: OccupancyGrid) -> tuple[tuple[float, float, float, float], ...]:
    """The sides of a top (`Surface.sides`) before whose middle a robot finds room to stand."""
    found = []
    for side in surface.sides():
        yaw, edge, _, _ = side
        reach = edge + STAND_M
        at = np.asarray(surface.position_m) + reach * np.array([np.cos(yaw), np.sin(yaw)])
        cell = room.cell_of((float(at[0]), float(at[1])))
        inside = all(0 <= c < n for c, n in zip(cell, room.cells.shape, strict=True))
        if inside and not room.cells[cell]:
            found.append(side)
    return tuple(found)


@dataclass
class _Draft:
    """What has been placed so far."""

    kind: str
    index: int
    size: tuple[float, float]
    rng: np.random.Generator
    pieces: list[FurniturePlacement] = field(default_factory=list)
    bodies: list[_Rect] = field(default_factory=list)
    zones: list[_Rect] = field(default_factory=list)

    @property
    def held_out(self) -> bool:
        """The plan is one of those that only unseen tasks have."""
        return self.index in HELD_OUT

    def choose(self, *kinds: str) -> str:
        """One of these kinds that this plan may have."""
        allowed = [k for k in kinds if self.held_out or k not in _HELD_OUT_PIECES]
        rare = [k for k in kinds if k in _HELD_OUT_PIECES]
        if self.held_out and rare and self.rng.random() < 0.7:  # in turn, so that each of them stands somewhere
            return rare[self.index % len(rare)]
        return str(self.rng.choice(allowed))

    def against_wall(self, kind: str, walls: Sequence[str] = ("north", "east", "south", "west")) -> bool:
        """Puts a piece, in rooms to practise in now and then a made-up one, somewhere along a wall, its front to the
        room."""
        if self.index >= HELD_OUT.stop and self.rng.random() < _MADE_UP_SHARE:
            kind = FURNITURE_KINDS.draw_made_up(self.rng)
        depth, width, _ = FURNITURE_KINDS[kind].size_m
        x, y = self.size[0] / 2, self.size[1] / 2
        for _ in range(30):
            wall = str(self.rng.choice(list(walls)))
            along = (x if wall in ("north", "south") else y) - width / 2 - 0.08
            if along <= 0:
                continue
            at = float(self.rng.uniform(-along, along))
            off = depth / 2 + 0.06
            place = {
                "north": (at, y - off, -np.pi / 2),
                "south": (at, -y + off, np.pi / 2),
                "east": (x - off, at, np.pi),
                "west": (-x + off, at, 0.0),
            }[wall]
            if self.put(kind, *place):
                return True
        return False

    def in_the_open(self, kind: str, share: float = 0.28) -> bool:
        """Puts a piece somewhere in the middle of the room."""
        for _ in range(30):
            x, y = self.rng.uniform(-share, share, 2) * np.array(self.size)
            if self.put(kind, float(x), float(y), float(self.rng.choice([0.0, np.pi / 2, np.pi, -np.pi / 2]))):
                return True
        return False

    def put(
        self, kind: str, x: float, y: float, yaw: float, zone_m: float = _FRONT_ZONE_M, joined: bool = False
    ) -> bool:
        """Puts a piece where told, unless something is in the way; `joined` pieces may touch others."""
        spec = FURNITURE_KINDS[kind]
        depth, width, _ = spec.size_m
        c, s = round(np.cos(yaw)), round(np.sin(yaw))
        half = np.array([depth / 2 * abs(c) + width / 2 * abs(s), depth / 2 * abs(s) + width / 2 * abs(c)])
        gap = 0.004 if joined else _GAP_M
        body = (x - half[0] - gap, x + half[0] + gap, y - half[1] - gap, y + half[1] + gap)
        limit_x, limit_y = self.size[0] / 2 - 0.052, self.size[1] / 2 - 0.052
        if max(abs(x) + half[0] - limit_x, abs(y) + half[1] - limit_y) > 1e-6:
            return False
        middle = (x + c * (half[0] + zone_m / 2), y + s * (half[1] + zone_m / 2))
        deep, wide = zone_m / 2, width / 2
        across = (deep, wide) if c else (wide, deep)
        zone = (middle[0] - across[0], middle[0] + across[0], middle[1] - across[1], middle[1] + across[1])
        if spec.solid:
            if any(_overlap(body, b) for b in (*self.bodies, *self.zones)):
                return False
            if zone_m > 0 and any(_overlap(zone, b) for b in self.bodies):
                return False
            if zone_m > 0 and (abs(middle[0]) > limit_x or abs(middle[1]) > limit_y):
                return False
            self.bodies.append((x - half[0], x + half[0], y - half[1], y + half[1]))
            if zone_m > 0:
                self.zones.append(zone)
        number = sum(p.kind == kind for p in self.pieces) + 1
        colors = spec.colors or (spec.color,)
        color = colors[-1] if self.held_out and len(colors) > 1 else str(self.rng.choice(colors))
        name = kind if number == 1 else f"{kind}_{number}"
        self.pieces.append(
            FurniturePlacement(name, kind, (round(x, 3), round(y, 3)), round(float(yaw), 6), color=color)
        )
        return True


def _overlap(a: _Rect, b: _Rect) -> bool:
    return a[0] < b[1] and b[0] < a[1] and a[2] < b[3] and b[2] < a[3]


def _draw(kind: str, index: int, rng: np.random.Generator) -> FloorPlan | None:
    held_out = index in HELD_OUT
    (x_low, x_high), (y_low, y_high) = _SIZES[kind]
    size = (round(float(rng.uniform(x_low, x_high)), 1), round(float(rng.uniform(y_low, y_high)), 1))
    floors, walls, other_floors, other_walls = _LOOKS[kind]
    room = Room(
        kind,
        size,
        str(rng.choice(other_floors if held_out else floors)),
        str(rng.choice(other_walls if held_out else walls)),
    )
    draft = _Draft(kind, index, size, rng)
    door = {"living_room": -0.33, "bedroom": 0.33, "kitchen": -0.33, "warehouse": 0.0}[kind] * size[0]
    wide = 1.3 if kind == "warehouse" else 0.65
    draft.zones.append((door - wide, door + wide, -size[1] / 2, -size[1] / 2 + 1.0))
    if not {"bedroom": _bedroom, "kitchen": _kitchen, "living_room": _living_room, "warehouse": _warehouse}[kind](
        draft
    ):
        return None
    plan = FloorPlan(f"{kind} {index}", room, tuple(draft.pieces))
    room_to_stand = standing_room(plan)
    usable = [s for s in plan.surfaces if can_stand_before(s, room_to_stand)]
    free_m2 = float((~room_to_stand.cells).sum()) * room_to_stand.cell_m**2
    if len(usable) < len(plan.surfaces) or len(usable) < 3 or free_m2 < 0.22 * size[0] * size[1]:
        return None
    return plan


def _bedroom(draft: _Draft) -> bool:
    bed = draft.choose("double_bed", "single_bed")
    depth, width, _ = FURNITURE_KINDS[bed].size_m
    x, y = draft.size[0] / 2, draft.size[1] / 2
    wall = str(draft.rng.choice(["west", "north", "east"]))
    span = (x if wall == "north" else y) - width / 2 - 0.65
    at = float(draft.rng.uniform(-span, span))
    off = depth / 2 + 0.06
    place = {"north": (at, y - off, -np.pi / 2), "east": (x - off, at, np.pi), "west": (-x + off, at, 0.0)}[wall]
    if not draft.put(bed, *place, zone_m=0.7):
        return False
    near = width / 2 + 0.06 + 0.24
    deep = depth / 2 - 0.24  # of the nightstand before the wall, seen from the middle of the bed
    beside = 0
    for side in (-1, 1):
        dx, dy = {
            "north": (side * near, deep),
            "east": (deep, side * near),
            "west": (-deep, side * near),
        }[wall]
        if side < 0 or draft.rng.random() < 0.5:
            beside += draft.put("nightstand", place[0] + dx, place[1] + dy, place[2], joined=True)
    if not beside:
        return False
    ok = draft.against_wall("wardrobe") and draft.against_wall("dresser")
    ok = ok and draft.against_wall(draft.choose("desk", "vanity", "desk"))
    for kinds in (("low_bookcase", "shoe_rack", "console_table"), ("bench", "cabinet", "low_bookcase")):
        draft.against_wall(draft.choose(*kinds))
    for kind in ("standing_mirror", "floor_lamp", "clothes_rack", "armchair"):
        if draft.rng.random() < 0.4:
            draft.against_wall(kind)
    draft.put("rug", float(draft.rng.uniform(-0.4, 0.4)), float(draft.rng.uniform(-0.4, 0.4)), 0.0)
    return ok


def _kitchen(draft: _Draft) -> bool:
    line = ["stove", "sink_counter", "kitchen_counter", "dishwasher"]
    if draft.rng.random() < 0.5:
        line.append("kitchen_counter")
    order = [line[i] for i in draft.rng.permutation(len(line))]
    order = ["fridge", *order] if draft.rng.random() < 0.5 else [*order, "fridge"]
    total = sum(FURNITURE_KINDS[k].size_m[1] + 0.01 for k in order)
    if total > draft.size[0] - 0.2:
        return False
    slack = (draft.size[0] - 0.2 - total) / 2
    at = -total / 2 + float(draft.rng.uniform(-slack, slack))
    for kind in order:  # along the north wall, where the tiles are
        depth, width, _ = FURNITURE_KINDS[kind].size_m
        middle, off = at + width / 2 + 0.005, depth / 2 + 0.06
        if not draft.put(kind, middle, draft.size[1] / 2 - off, -np.pi / 2, joined=True):
            return False
        at += width + 0.01
    distance = float(draft.rng.uniform(2.1, 2.35))
    aside = float(draft.rng.uniform(-0.6, 0.6))
    if not draft.put("kitchen_island", aside, draft.size[1] / 2 - distance, -np.pi / 2):
        return False
    table = draft.choose("breakfast_table", "dining_table")
    if not draft.in_the_open(table, 0.34):
        return False
    if table == "dining_table":
        draft.against_wall("dining_chair")
    for kinds in (
        ("sideboard", "cabinet"),
        ("kitchen_trolley", "washing_machine"),
        ("tall_cupboard", "cabinet"),
        ("potted_tree",),
    ):
        if draft.rng.random() < 0.75:
            draft.against_wall(draft.choose(*kinds))
    return True


def _living_room(draft: _Draft) -> bool:
    x, y = draft.size[0] / 2, draft.size[1] / 2
    wall = str(draft.rng.choice(["west", "east", "north"]))
    span = (x if wall == "north" else y) - 1.2
    at = float(draft.rng.uniform(-span, span)) * 0.6
    place, ahead = {
        "north": ((at, y - 0.52, -np.pi / 2), (0.0, -1.0)),
        "east": ((x - 0.52, at, np.pi), (-1.0, 0.0)),
        "west": ((-x + 0.52, at, 0.0), (1.0, 0.0)),
    }[wall]
    if not draft.put("sofa", *place, zone_m=0.0):
        return False
    table = draft.choose("coffee_table", "round_coffee_table")
    depth = FURNITURE_KINDS[table].size_m[0]
    far = 0.45 + 0.42 + depth / 2
    if not draft.put(table, place[0] + ahead[0] * far, place[1] + ahead[1] * far, place[2], zone_m=0.9):
        return False
    draft.put("rug", place[0] + ahead[0] * far, place[1] + ahead[1] * far, place[2])
    opposite = {"north": ("south", "east", "west"), "east": ("west",), "west": ("east",)}[wall]
    ok = draft.against_wall("tv_stand", opposite)
    ok = ok and draft.against_wall(draft.choose("console_table", "sideboard", "record_cabinet"))
    for kinds in (
        ("bookshelf", "fireplace", "piano", "display_cabinet"),
        ("cabinet", "low_bookcase", "desk"),
        ("armchair", "armchair", "bench"),
        ("side_table",),
    ):
        draft.against_wall(draft.choose(*kinds))
    for kind in ("floor_lamp", "potted_tree"):
        if draft.rng.random() < 0.7:
            draft.against_wall(kind)
    return ok


def _warehouse(draft: _Draft) -> bool:
    ok = draft.against_wall("pallet_rack", ("north", "east", "west"))
    ok = ok and draft.against_wall("pallet_rack", ("north", "east", "west"))
    ok = ok and draft.against_wall("workbench")
    if draft.rng.random() < 0.6:
        draft.in_the_open("pallet_rack", 0.2)
    ok = ok and draft.in_the_open(draft.choose("packing_table", "conveyor", "packing_table"))
    ok = ok and draft.in_the_open("pallet_stack", 0.34)
    for kind in ("tool_cabinet", "shelving_unit", draft.choose("shelving_unit", "locker")):
        draft.against_wall(kind)
    for kinds in (("pallet",), ("platform_trolley",), ("forklift", "crate_stack"), ("barrel_group", "crate_stack")):
        draft.in_the_open(draft.choose(*kinds), 0.36)
    for kind in ("ladder", "traffic_cone", "barrel_group"):
        if draft.rng.random() < 0.5:
            draft.against_wall(kind)
    return ok
