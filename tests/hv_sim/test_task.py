"""Task files: what is read is what was written, and what is wrong is refused in one line that names the field."""

import copy
import json
from pathlib import Path

import pytest

from hv_sim.furniture import FURNITURE_KINDS
from hv_sim.objects import OBJECT_KINDS
from hv_sim.parts import COLORS
from hv_sim.rooms import FLOORS
from hv_sim.task import ROOM_KINDS, Task, TaskError, available_tasks, load_task, resolve_tasks, save_task


@pytest.fixture
def document():
    return {
        "schema": "hv_sim.task/1",
        "name": "test",
        "room": {"kind": "living_room", "size_m": [6.0, 5.0]},
        "robot": {"position_m": [0.0, 0.0], "yaw_rad": 0.0},
        "furniture": [{"name": "table", "kind": "dining_table", "position_m": [1.5, 0.0]}],
        "objects": [
            {"name": "box", "kind": "box", "position_m": [-1.0, 0.0, 0.14]},
            {"name": "vase", "kind": "vase", "position_m": [1.3, 0.4, 0.93], "color": "red"},
        ],
        "subtasks": [
            {
                "object": "box",
                "goal_position_m": [1.3, -0.4, 0.89],
                "goal_yaw_rad": 0.5,
                "instruction": "Put the box on the table.",
            },
            {"object": "vase", "goal_position_m": [-1.0, 0.0, 0.18], "goal_yaw_rad": 0, "instruction": "Now the vase."},
        ],
    }


def test_valid_document_round_trips(document, tmp_path):
    task = Task.from_dict(document)
    assert task.subtasks[0].goal_position_m == (1.3, -0.4, 0.89)
    assert task.objects[1].color == "red"
    assert task.objects[0].color is None
    save_task(task, tmp_path / "task.json")
    assert load_task(tmp_path / "task.json") == task
    assert Task.from_dict(json.loads(json.dumps(task.to_dict()))) == task
    assert [p.name for p in tmp_path.iterdir()] == ["task.json"]


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (("schema",), "hv_sim.task/9", "schema: .*hv_sim.task/9.*valid: hv_sim.task/1"),
        (("robot",), None, "robot: null is not an object"),
        (("robot", "yaw"), 1.0, "robot.yaw: unknown field; valid: position_m, yaw_rad"),
        (("objects", 0, "kind"), "bicycle", r"objects\[0\].kind: .*bicycle.*valid: box, crate"),
        (("objects", 0, "mass_kg"), 50, r"objects\[0\].mass_kg: 50 is not valid"),
        (("objects", 0, "mass_kg"), True, r"objects\[0\].mass_kg: true"),
        (("objects", 0, "size_m"), [0.9, 0.3, 0.3], r"objects\[0\].size_m: .*0.15 to 0.45"),
        (("objects", 1, "size_m"), [0.2, 0.3, 0.3], r"objects\[1\].size_m: .*not round"),
        (("objects", 0, "position_m"), [-1.0, float("nan"), 0.14], r"objects\[0\].position_m\[1\]: NaN"),
        (("objects", 0, "position_m"), [-1.0, 0.14], r"objects\[0\].position_m: .*list of 3 numbers"),
        (("objects", 0, "position_m"), [-1.0, 0.0, 0.5], r"objects\[0\].position_m: .*in the air.*z = 0.140"),
        (("objects", 0, "position_m"), [-1.0, 0.0, 0.05], r"objects\[0\].position_m: .*below the floor"),
        (("objects", 0, "position_m"), [1.3, 0.35, 0.89], r"objects\[1\].position_m: .*'vase' into 'box'"),
        (("objects", 1, "name"), "box", r"objects\[1\].name: 'box' is used twice"),
        (("objects", 0, "name"), "a b", r"objects\[0\].name: .*not a name"),
        (("objects", 0, "color"), "sparkling", r"objects\[0\].color: .*valid: red"),
        (("objects",), [], "objects: .*1 to 40"),
        (("furniture", 0, "kind"), "throne", r"furniture\[0\].kind: .*valid: sofa"),
        (("furniture", 0, "size_m"), [9.0, 1.0, 1.0], r"furniture\[0\].size_m: .*depth, width, height"),
        (("furniture", 0, "position_m"), [2.9, 0.0], r"furniture\[0\].position_m: .*into a wall"),
        (("robot", "position_m"), [1.5, 0.9], "robot.position_m: .*less than 0.3 m from 'table'"),
        (("subtasks", 0, "object"), "chair", r"subtasks\[0\].object: 'chair' does not exist; objects here: box, vase"),
        (("subtasks", 0, "goal_position_m"), [1.3, -0.4, 0.70], r"subtasks\[0\].goal_position_m: .*inside furniture"),
        (("subtasks", 0, "goal_position_m"), [8.0, 0.0, 0.14], r"subtasks\[0\].goal_position_m: .*outside the room"),
        (("subtasks", 0, "goal_position_m"), [2.95, 0.9, 0.14], r"subtasks\[0\].goal_position_m: .*outside the room"),
        (("subtasks", 0, "goal_position_m"), [1.3, 0.35, 0.89], r"subtasks\[0\].goal_position_m: .*inside 'vase'"),
        (("subtasks", 0, "instruction"), "", r"subtasks\[0\].instruction"),
        (("subtasks", 0, "instruction"), "x" * 201, r"subtasks\[0\].instruction: .*1 to 200 characters"),
    ],
)
def test_what_is_wrong_is_named(document, path, value, message):
    where = document
    for key in path[:-1]:
        where = where[key]
    where[path[-1]] = value
    with pytest.raises(TaskError, match=message) as error:
        Task.from_dict(document)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("field", ["schema", "name", "room", "robot", "furniture", "objects", "subtasks"])
def test_missing_field_is_named(document, field):
    del document[field]
    with pytest.raises(TaskError, match=f"^{field}: missing; required fields here: schema"):
        Task.from_dict(document)


def test_goal_may_be_where_an_object_has_left(document):
    """The vase's goal is the box's start: fine in this order, an error in the other."""
    Task.from_dict(copy.deepcopy(document))
    document["subtasks"].reverse()
    with pytest.raises(TaskError, match=r"subtasks\[0\].goal_position_m: .*inside 'box'"):
        Task.from_dict(document)


def test_objects_may_be_stacked(document):
    document["subtasks"][1]["goal_position_m"] = [1.3, -0.4, 0.75 + 0.28 + 0.18]
    Task.from_dict(document)


def test_unreadable_files_are_refused_in_one_line(tmp_path):
    for name, text in (
        ("broken", "{"),
        ("twice", '{"name": "a", "name": "b"}'),
        ("bytes", "\xff"),
        ("digits", '{"name": ' + "9" * 5000 + "}"),
        ("deep", "[" * 100000),
        ("list", "[]"),
    ):
        file = tmp_path / f"{name}.json"
        file.write_text(text, encoding="latin-1")
        with pytest.raises(TaskError, match=name) as error:
            load_task(file)
        assert "\n" not in str(error.value)
    with pytest.raises(TaskError, match="living_room_1"):
        load_task("no_such_task")


def test_names_resolve_to_tasks(document, tmp_path):
    names = available_tasks()
    assert names[:8] == [f"living_room_{i}" for i in range(1, 9)]
    assert [t.name for t in resolve_tasks("living_room")] == names
    assert [t.name for t in resolve_tasks("living_room_1")] == ["living_room_1"]
    save_task(Task.from_dict(document), tmp_path / "mine.json")
    assert [t.name for t in resolve_tasks(tmp_path)] == ["test"]
    assert [t.name for t in resolve_tasks(tmp_path / "mine.json")] == ["test"]
    for missing in ("kitchen_7", "liv", ""):
        with pytest.raises(TaskError):
            resolve_tasks(missing)


@pytest.mark.parametrize("name", available_tasks())
def test_packaged_tasks_suit_two_hands(name):
    task = load_task(name)
    assert task.name == name
    assert len(task.subtasks) == 2
    assert len({s.object for s in task.subtasks}) == 2
    assert all(s.instruction.endswith(".") for s in task.subtasks)


def test_documentation_lists_what_there_is():
    """docs/task_format.md names every kind and colour, and its example is a valid task."""
    text = (Path(__file__).parents[2] / "docs" / "task_format.md").read_text(encoding="utf-8")
    for name in (*OBJECT_KINDS, *FURNITURE_KINDS, *COLORS, *FLOORS, *ROOM_KINDS):
        assert f"`{name}`" in text, name
    example = text.split("```json\n")[1].split("```")[0]
    assert Task.from_dict(json.loads(example)).name == "tidy_up"
