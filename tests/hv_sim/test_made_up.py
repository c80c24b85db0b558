"""Things that do not exist can be held, named and shown like any other."""

import re

import numpy as np
import pytest

from hv_policy.text_encoder import split_words
from hv_sim.floor_plans import HELD_OUT, floor_plan
from hv_sim.furniture import FURNITURE_KINDS, build_furniture
from hv_sim.furniture_kinds.made_up import COUNT as PIECES
from hv_sim.furniture_kinds.made_up import NOUNS as PIECE_NOUNS
from hv_sim.grounding import ground
from hv_sim.lexicon import furniture_nouns, means, object_nouns
from hv_sim.object_kinds.made_up import COUNT, NOUNS
from hv_sim.objects import OBJECT_KINDS, build_object
from hv_sim.places import layout_at
from hv_sim.scene import OBJECT_COLLIDERS, OBJECT_GEOMS, compile_scene
from hv_sim.suites import load_suite, read_tasks, write_tasks
from hv_sim.surfaces import REACHABLE_M
from hv_sim.task import TaskError
from hv_sim.task_generator import draw_task


def test_each_can_be_held_and_fits_into_a_scene():
    shapes = set()
    for number in range(0, COUNT, 3):
        name = OBJECT_KINDS.made_up_name(number)
        kind, built = OBJECT_KINDS[name], build_object(name)
        np.testing.assert_allclose(2 * built.half_extents_m, kind.size_m, atol=1e-9)
        assert built.grasp_ok.any()
        solid = [part for part in built.parts if part.collides]
        assert len(solid) <= OBJECT_COLLIDERS
        assert len(built.parts) - len(solid) <= OBJECT_GEOMS - OBJECT_COLLIDERS
        shapes.add(tuple((part.shape, part.size_m) for part in built.parts))
    assert len(shapes) == len(range(0, COUNT, 3))


def test_they_are_found_by_name_and_not_listed():
    assert OBJECT_KINDS.made_up_number("made_up_0042") == 42
    assert OBJECT_KINDS.made_up_name(42) == "made_up_0042"
    assert "made_up_0042" in OBJECT_KINDS
    assert not any(name.startswith("made_up") for name in OBJECT_KINDS)
    for wrong in ("made_up_2000", "made_up_42", "made_up_", "lamp"):
        assert OBJECT_KINDS.made_up_number(wrong) is None
    with pytest.raises(KeyError):
        OBJECT_KINDS["made_up_9999"]


def test_each_piece_of_furniture_has_a_front_and_fills_its_box():
    for number in range(0, PIECES, 5):
        name = FURNITURE_KINDS.made_up_name(number)
        kind, parts = FURNITURE_KINDS[name], build_furniture(name)
        (body,) = [part for part in parts if part.collides]
        assert tuple(2 * s for s in body.size_m) == pytest.approx(kind.size_m)
        assert kind.has_front
        assert kind.holds_objects == (kind.size_m[2] < REACHABLE_M[1])
        at = np.array([part.pos_m for part in parts if part.visible])
        assert at[:, 0].max() > 0.9 * kind.size_m[0] / 2  # something is on the front,
        assert at[:, 0].min() > -0.9 * kind.size_m[0] / 2  # nothing on the back
    assert not any(name.startswith("made_up") for name in FURNITURE_KINDS)
    plans = [floor_plan("bedroom", HELD_OUT.stop + i) for i in range(4)]
    assert any(FURNITURE_KINDS.made_up_number(piece.kind) is not None for plan in plans for piece in plan.furniture)
    for index in (*range(0, HELD_OUT.stop, 25), HELD_OUT.stop - 1):
        assert not [f for f in floor_plan("bedroom", index).furniture if f.kind.startswith("made_up")]


def test_their_names_are_no_other_thing_s_and_none_that_is_kept_for_unseen_tasks():
    nouns = [n for k in OBJECT_KINDS for n in object_nouns(k)]
    nouns += [n for k in FURNITURE_KINDS for n in furniture_nouns(k)]
    for own, others in ((NOUNS, (*nouns, *PIECE_NOUNS)), (PIECE_NOUNS, (*nouns, *NOUNS))):
        assert not [(a, b) for a in own for b in others if means(a, [b]) or means(b, [a])]
    said = {name: words_of(name) for name in ("seen", "unseen")}
    kept = {word for word in said["unseen"] - said["seen"] if len(word) > 3}
    assert not kept & {word for noun in (*NOUNS, *PIECE_NOUNS) for word in split_words(noun)}


def words_of(suite: str) -> set[str]:
    return {w for task in load_suite(suite) for s in task.subtasks for p in s.phrasings for w in split_words(p)}


def test_practice_asks_for_some_and_means_them(tmp_path):
    tasks = [draw_task("practice", i) for i in range(16)]
    asked = 0
    for task in tasks:
        compile_scene(task)
        for i, subtask in enumerate(task.subtasks):
            kind = next(o.kind for o in task.objects if o.name == subtask.object)
            if OBJECT_KINDS.made_up_number(kind) is None:
                continue
            asked += 1
            layout = layout_at(task, i)
            assert all(ground(text, layout).objects == {subtask.object} for text in subtask.phrasings)
    assert 6 <= asked <= 20
    write_tasks(tmp_path / "tasks.jsonl", tasks)
    assert read_tasks(tmp_path / "tasks.jsonl") == tasks


def test_a_task_with_a_number_too_high_is_refused(tmp_path):
    task = next(t for t in (draw_task("practice", i) for i in range(16)) if any("made_up" in o.kind for o in t.objects))
    write_tasks(tmp_path / "tasks.jsonl", [task])
    text = (tmp_path / "tasks.jsonl").read_text()
    (tmp_path / "tasks.jsonl").write_text(re.sub(r'"made_up_\d{4}"', '"made_up_9999"', text))
    with pytest.raises(TaskError, match=r"made_up_9999. is not a known kind of object"):
        read_tasks(tmp_path / "tasks.jsonl")
