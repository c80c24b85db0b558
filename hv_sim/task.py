"""Tasks: what a room holds, where the robot starts and what it is to put where; and their files (docs/task_format.md).

Positions are metres in the world frame, whose origin is the middle of the room's floor; yaws are radians about z.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hv_sim.furniture import FURNITURE_KINDS, build_furniture
from hv_sim.humanoid import BODY_NAMES
from hv_sim.objects import MASS_KG, OBJECT_KINDS, BuiltObject, build_object
from hv_sim.parts import COLORS, Part, Prism, deepest_overlap_m, moved, prisms, support_height_m
from hv_sim.rooms import FLOORS, ROOM_KINDS, ROOM_SIZE_M, build_room
from hv_sim.task_fields import (
    Reader,
    TaskError,
    list_of,
    name,
    number,
    one_of,
    read_fields,
    sentence,
    unique_keys,
    vector,
)

SCHEMA = "hv_sim.task/1"
ROBOT_RADIUS_M = 0.30
"""Room that the robot needs around its start."""
OVERLAP_TOLERANCE_M = 0.01
SUPPORT_TOLERANCE_M = 0.01
"""How far above its support a thing may start or be wanted, and how far it may move while it comes to rest."""

_PACKAGED = Path(__file__).parent / "tasks"
_MAX_FILE_BYTES = 1_000_000


@dataclass(frozen=True)
class Room:
    """The empty room: a kind in `ROOM_KINDS`, its size along x and y, the floor and the colour of the walls by name."""

    kind: str = "living_room"
    size_m: tuple[float, float] = (6.0, 5.0)
    floor: str = "oak"
    wall_color: str = "cream"


@dataclass(frozen=True)
class RobotStart:
    """Where the robot stands at first, and where it looks."""

    position_m: tuple[float, float] = (0.0, 0.0)
    yaw_rad: float = 0.0


@dataclass(frozen=True)
class FurniturePlacement:
    """A piece of furniture: the middle of its footprint, and where its front faces (+x at yaw 0).

    The size is depth, width, height.
    """

    name: str
    kind: str
    position_m: tuple[float, float]
    yaw_rad: float = 0.0
    size_m: tuple[float, float, float] | None = None
    color: str | None = None


@dataclass(frozen=True)
class ObjectPlacement:
    """A movable object: the centre of its bounding box; size, mass and colour default to the kind's."""

    name: str
    kind: str
    position_m: tuple[float, float, float]
    yaw_rad: float = 0.0
    size_m: tuple[float, float, float] | None = None
    mass_kg: float | None = None
    color: str | None = None


@dataclass(frozen=True)
class SubTask:
    """One thing to do: bring the named object's centre to a pose, as the instruction says.

    `paraphrases` are further ways to say the instruction; an episode's seed picks among all of them.
    """

    object: str
    goal_position_m: tuple[float, float, float]
    goal_yaw_rad: float
    instruction: str
    paraphrases: tuple[str, ...] = ()

    @property
    def phrasings(self) -> tuple[str, ...]:
        """The instruction and its paraphrases."""
        return (self.instruction, *self.paraphrases)


@dataclass(frozen=True)
class Task:
    """A room, what is in it, and any number of sub-tasks to be done in turn."""

    name: str
    room: Room
    robot: RobotStart
    furniture: tuple[FurniturePlacement, ...]
    objects: tuple[ObjectPlacement, ...]
    subtasks: tuple[SubTask, ...]

    @staticmethod
    def from_dict(data: Any) -> Task:
        """The task that a decoded JSON document describes, checked.

        Raises:
            TaskError: a field is missing, unknown or not valid, or things do not fit into the room together.
        """
        task = parse_task(data)
        check_task(task)
        return task

    def to_dict(self) -> dict[str, Any]:
        """The JSON document of the task; fields left to their kind's usual value stay out of it."""

        def plain(value: Any) -> Any:
            if isinstance(value, dict):
                return {k: plain(v) for k, v in value.items() if v is not None and not (k == "paraphrases" and not v)}
            return [plain(v) for v in value] if isinstance(value, (list, tuple)) else value

        return {"schema": SCHEMA, **plain(asdict(self))}


def load_task(name_or_path: str | os.PathLike[str]) -> Task:
    """Reads one task: one of `available_tasks()` by name, one of a suite (`unseen:3` or its name), or a JSON file.

    Raises:
        TaskError: there is no such task or file, it is not JSON, or it is not a valid task.
    """
    text = os.fspath(name_or_path)
    if text in available_tasks():
        return _read(_PACKAGED / f"{text}.json")
    from hv_sim.suites import SUITES, select_tasks

    selected = select_tasks(text)
    if selected is not None and len(selected) == 1:
        return selected[0]
    path = Path(text)
    if not path.is_file():
        known = f"tasks: {', '.join(available_tasks())}; suites: {', '.join(SUITES)}"
        raise TaskError(f"task: {text!r} is neither a task nor a file; {known}")
    return _read(path)


def save_task(task: Task, path: str | os.PathLike[str]) -> None:
    """Writes a task file, or replaces it, in one move."""
    target = Path(path)
    draft = target.with_name(f".{target.name}.{os.getpid()}.tmp")
    try:
        draft.write_text(_pretty(task.to_dict()), encoding="utf-8")
        draft.replace(target)
    finally:
        draft.unlink(missing_ok=True)


def available_tasks() -> list[str]:
    """Names of the tasks that come with the package, in order."""
    names = [path.stem for path in _PACKAGED.glob("*.json")]
    return sorted(names, key=lambda name: [int(t) if t.isdigit() else t for t in re.split(r"(\d+)", name)])


def resolve_tasks(name: str | os.PathLike[str]) -> list[Task]:
    """The tasks that a name stands for.

    A suite (`unseen`), one or several of its tasks by number (`unseen:3`, `unseen:0-15`) or by name, a hand-made task,
    the beginning of several (`living_room`), a task file, a file with one task a line (`.jsonl`, `.jsonl.gz`), or a
    folder of task files.

    Raises:
        TaskError: it stands for nothing, or one of the tasks is not valid.
    """
    from hv_sim.suites import read_tasks, select_tasks

    text = os.fspath(name)
    names = available_tasks()
    if text in names:
        return [load_task(text)]
    if (selected := select_tasks(text)) is not None:
        return selected
    if text.endswith((".jsonl", ".jsonl.gz")):
        return read_tasks(text)
    if text and (family := [n for n in names if n.startswith(text.rstrip("_") + "_")]):
        return [load_task(n) for n in family]
    if Path(text).is_dir():
        files = sorted(Path(text).glob("*.json"))
        if not files:
            raise TaskError(f"task: the folder {text!r} holds no .json file")
        return [_read(file) for file in files]
    return [load_task(text)]


def furniture_parts(placement: FurniturePlacement) -> list[Part]:
    """Parts of a placed piece of furniture, in the world frame."""
    return moved(
        build_furniture(placement.kind, placement.size_m, placement.color), placement.position_m, placement.yaw_rad
    )


def built_object(placement: ObjectPlacement) -> BuiltObject:
    """The object that a placement asks for, in its own frame."""
    return build_object(placement.kind, placement.size_m, placement.mass_kg, placement.color)


def room_parts(room: Room) -> list[Part]:
    """Parts of the empty room, in the world frame."""
    return build_room(room.kind, room.size_m, room.floor, room.wall_color)


def check_task(task: Task) -> None:
    """Checks that names are used once, that what is asked for exists, and that everything fits.

    Raises:
        TaskError: the first thing that does not hold.
    """
    _check_names(task)
    furniture = {f.name: prisms(_built(furniture_parts, f, f"furniture[{i}]")) for i, f in enumerate(task.furniture)}
    built = [_built(built_object, o, f"objects[{i}]") for i, o in enumerate(task.objects)]
    walls = prisms(room_parts(task.room))
    solids = [*walls, *(solid for group in furniture.values() for solid in group)]

    for i, piece in enumerate(task.furniture):
        where = f"furniture[{i}].position_m: {list(piece.position_m)}"
        _check_in_room(piece.position_m, task.room, where)
        if deepest_overlap_m(furniture[piece.name], walls) > OVERLAP_TOLERANCE_M:
            raise TaskError(f"{where} puts {piece.name!r} into a wall")
        for earlier in task.furniture[:i]:
            if deepest_overlap_m(furniture[piece.name], furniture[earlier.name]) > OVERLAP_TOLERANCE_M:
                raise TaskError(f"{where} puts {piece.name!r} into {earlier.name!r}")

    present: list[list[Prism]] = []
    for i, (placed, made) in enumerate(zip(task.objects, built, strict=True)):
        here = _placed(made, placed.position_m, placed.yaw_rad)
        field = f"objects[{i}].position_m: {list(placed.position_m)}"
        beneath = [*solids, *(solid for group in present for solid in group)]
        _check_pose(field, placed.name, placed.position_m, made, here, task, furniture, beneath)
        for j in range(i):
            if deepest_overlap_m(here, present[j]) > OVERLAP_TOLERANCE_M:
                raise TaskError(f"{field} puts {placed.name!r} into {task.objects[j].name!r}")
        present.append(here)

    _check_robot(task, furniture, walls, present)

    names = [o.name for o in task.objects]
    for i, subtask in enumerate(task.subtasks):
        k = names.index(subtask.object)
        there = _placed(built[k], subtask.goal_position_m, subtask.goal_yaw_rad)
        field = f"subtasks[{i}].goal_position_m: {list(subtask.goal_position_m)}"
        others = [(names[j], present[j]) for j in range(len(names)) if j != k]
        for other, solid in others:
            if deepest_overlap_m(there, solid) > OVERLAP_TOLERANCE_M:
                raise TaskError(f"{field} is inside {other!r}, which will be there by then")
        beneath = [*solids, *(solid for _, group in others for solid in group)]
        _check_pose(field, subtask.object, subtask.goal_position_m, built[k], there, task, furniture, beneath)
        present[k] = there


def _check_names(task: Task) -> None:
    names = [o.name for o in task.objects]
    for group, given in (("furniture", [f.name for f in task.furniture]), ("objects", names)):
        for i, given_name in enumerate(given):
            if given_name in given[:i] or (group == "objects" and given_name in BODY_NAMES):
                raise TaskError(f"{group}[{i}].name: {given_name!r} is used twice")
    for i, subtask in enumerate(task.subtasks):
        if subtask.object not in names:
            raise TaskError(
                f"subtasks[{i}].object: {subtask.object!r} does not exist; objects here: {', '.join(names)}"
            )


def _built(build: Callable[[Any], Any], placement: Any, path: str) -> Any:
    try:
        return build(placement)
    except ValueError as error:
        raise TaskError(f"{path}.{error}") from None


def _placed(made: BuiltObject, position_m: tuple[float, float, float], yaw_rad: float) -> list[Prism]:
    return prisms(moved(made.parts, position_m, yaw_rad))


def _check_in_room(position_m: tuple[float, ...], room: Room, where: str) -> None:
    if any(abs(p) > s / 2 for p, s in zip(position_m[:2], room.size_m, strict=True)):
        x, y = (s / 2 for s in room.size_m)
        raise TaskError(f"{where} is outside the room; valid: -{x:g} to {x:g} and -{y:g} to {y:g}")


def _check_pose(
    field: str,
    name: str,
    position_m: tuple[float, float, float],
    made: BuiltObject,
    here: list[Prism],
    task: Task,
    furniture: dict[str, list[Prism]],
    beneath: list[Prism],
) -> None:
    """An object's pose is in the room, clear of walls and furniture, and something carries it."""
    _check_in_room(position_m, task.room, field)
    if deepest_overlap_m(here, prisms(room_parts(task.room))) > OVERLAP_TOLERANCE_M:
        raise TaskError(f"{field} is outside the room: {name!r} would be in a wall")
    for other, solid in furniture.items():
        if deepest_overlap_m(here, solid) > OVERLAP_TOLERANCE_M:
            raise TaskError(f"{field} is inside furniture: {name!r} would be in {other!r}")
    bottom = position_m[2] - made.half_extents_m[2]
    support = support_height_m(position_m, bottom + OVERLAP_TOLERANCE_M, beneath)
    rest = support + made.half_extents_m[2]
    if bottom < -OVERLAP_TOLERANCE_M or bottom - support > SUPPORT_TOLERANCE_M:
        what = "below the floor" if bottom < -OVERLAP_TOLERANCE_M else "in the air"
        raise TaskError(f"{field} is {what}: {name!r} rests here at z = {rest:.3f}")


def _check_robot(task: Task, furniture: dict[str, list[Prism]], walls: list[Prism], objects: list[list[Prism]]) -> None:
    x, y = task.robot.position_m
    where = f"robot.position_m: {[x, y]}"
    _check_in_room((x, y), task.room, where)
    angle = np.arange(16) * (2 * np.pi / 16)
    body = [Prism(np.array([x, y]) + ROBOT_RADIUS_M * np.stack([np.cos(angle), np.sin(angle)], -1), 0.02, 1.7)]
    things = [("a wall", walls), *((repr(n), s) for n, s in furniture.items())]
    things += [(repr(o.name), s) for o, s in zip(task.objects, objects, strict=True)]
    for what, solid in things:
        if deepest_overlap_m(body, solid) > 0.0:
            raise TaskError(f"{where} is less than {ROBOT_RADIUS_M:g} m from {what}")


def _read(path: Path) -> Task:
    try:
        if path.stat().st_size > _MAX_FILE_BYTES:
            raise TaskError(f"larger than {_MAX_FILE_BYTES} bytes")
        data = json.loads(path.read_text(encoding="utf-8"), object_pairs_hook=unique_keys)
        return Task.from_dict(data)
    except TaskError as error:
        raise TaskError(f"{path}: {error}") from None
    except (OSError, ValueError, RecursionError) as error:
        raise TaskError(f"{path}: not a readable JSON file ({error})") from None


def _pretty(data: dict[str, Any]) -> str:
    """JSON with one line per thing, so that files can be read and compared."""
    lines = []
    for key, value in data.items():
        if isinstance(value, list):
            rows = ",\n".join(f"    {json.dumps(row)}" for row in value)
            lines.append(f"  {json.dumps(key)}: [\n{rows}\n  ]" if value else f"  {json.dumps(key)}: []")
        else:
            lines.append(f"  {json.dumps(key)}: {json.dumps(value)}")
    return "{\n" + ",\n".join(lines) + "\n}\n"


# the fields of the JSON document and what each may hold


def parse_task(data: Any) -> Task:
    """The task that a decoded JSON document describes, its fields checked one by one but not whether things fit.

    Raises:
        TaskError: a field is missing, unknown or not valid.
    """
    fields = read_fields(
        data,
        "",
        required={
            "schema": one_of((SCHEMA,), "schema"),
            "name": name,
            "room": lambda v, p: Room(**read_fields(v, p, {}, _ROOM)),
            "robot": lambda v, p: RobotStart(**read_fields(v, p, _ROBOT, {})),
            "furniture": list_of(lambda v, p: FurniturePlacement(**read_fields(v, p, *_FURNITURE)), 0, 60),
            "objects": list_of(lambda v, p: ObjectPlacement(**read_fields(v, p, *_OBJECT)), 1, 40),
            "subtasks": list_of(lambda v, p: SubTask(**read_fields(v, p, _SUBTASK, _PARAPHRASES)), 1, 100),
        },
        optional={},
    )
    del fields["schema"]
    return Task(**fields)


_FAR, _HEIGHT = (-20.0, 20.0), (-1.0, 3.0)
_YAW = number(-6.2832, 6.2832)
_SIZE = vector((0.001, 10.0), (0.001, 10.0), (0.001, 10.0))
_COLOR = one_of(tuple(COLORS), "colour")
_ROOM: dict[str, Reader] = {
    "kind": one_of(ROOM_KINDS, "room"),
    "size_m": vector(*ROOM_SIZE_M),
    "floor": one_of(tuple(FLOORS), "floor"),
    "wall_color": _COLOR,
}
_ROBOT: dict[str, Reader] = {"position_m": vector(_FAR, _FAR), "yaw_rad": _YAW}
_FURNITURE: tuple[dict[str, Reader], dict[str, Reader]] = (
    {"name": name, "kind": one_of(FURNITURE_KINDS, "kind of furniture"), "position_m": vector(_FAR, _FAR)},
    {"yaw_rad": _YAW, "size_m": _SIZE, "color": _COLOR},
)
_OBJECT: tuple[dict[str, Reader], dict[str, Reader]] = (
    {"name": name, "kind": one_of(OBJECT_KINDS, "kind of object"), "position_m": vector(_FAR, _FAR, _HEIGHT)},
    {"yaw_rad": _YAW, "size_m": _SIZE, "mass_kg": number(*MASS_KG), "color": _COLOR},
)
_SUBTASK: dict[str, Reader] = {
    "object": name,
    "goal_position_m": vector(_FAR, _FAR, _HEIGHT),
    "goal_yaw_rad": _YAW,
    "instruction": sentence,
}
_PARAPHRASES: dict[str, Reader] = {"paraphrases": list_of(sentence, 0, 50)}
