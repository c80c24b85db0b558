"""Things that do not exist can be held, named and shown like any other."""

import numpy as np
import pytest

from hv_policy.text_encoder import split_words
from hv_sim.furniture import FURNITURE_KINDS
from hv_sim.grounding import ground
from hv_sim.lexicon import furniture_nouns, means, object_nouns
from hv_sim.object_kinds.made_up import COUNT, NOUNS, made_up_name, made_up_number
from hv_sim.objects import OBJECT_KINDS, build_object
from hv_sim.places import layout_at
from hv_sim.scene import OBJECT_COLLIDERS, OBJECT_GEOMS, compile_scene
from hv_sim.suites import load_suite, read_tasks, write_tasks
from hv_sim.task import TaskError
from hv_sim.task_generator import draw_task


def test_each_can_be_held_and_fits_into_a_scene():
    shapes = set()
    for number in range(0, COUNT, 3):
        kind = OBJECT_KINDS[made_up_name(number)]
        built = build_object(made_up_name(number))
        np.testing.assert_allclose(2 * built.half_extents_m, kind.size_m, atol=1e-9)
        assert built.grasp_ok.any()
        solid = [part for part in built.parts if part.collides]
        assert len(solid) <= OBJECT_COLLIDERS
        assert len(built.parts) - len(solid) <= OBJECT_GEOMS - OBJECT_COLLIDERS
        shapes.add(tuple((part.shape, part.size_m) for part in built.parts))
    assert len(shapes) == len(range(0, COUNT, 3))


def test_they_are_found_by_name_and_not_listed():
    assert made_up_number("made_up_0042") == 42
    assert "made_up_0042" in OBJECT_KINDS
    assert not any(name.startswith("made_up") for name in OBJECT_KINDS)
    for wrong in ("made_up_2000", "made_up_42", "made_up_", "lamp"):
        assert made_up_number(wrong) is None
    with pytest.raises(KeyError):
        OBJECT_KINDS["made_up_9999"]


def test_their_names_are_no_other_thing_s_and_none_that_is_kept_for_unseen_tasks():
    nouns = [n for k in OBJECT_KINDS for n in object_nouns(k)]
    nouns += [n for k in FURNITURE_KINDS for n in furniture_nouns(k)]
    assert not [(a, b) for a in NOUNS for b in nouns if means(a, [b]) or means(b, [a])]
    said = {name: words_of(name) for name in ("seen", "unseen")}
    kept = {word for word in said["unseen"] - said["seen"] if len(word) > 3}
    assert not kept & {word for noun in NOUNS for word in split_words(noun)}


def words_of(suite: str) -> set[str]:
    return {w for task in load_suite(suite) for s in task.subtasks for p in s.phrasings for w in split_words(p)}


def test_practice_asks_for_some_and_means_them(tmp_path):
    tasks = [draw_task("practice", i) for i in range(16)]
    asked = 0
    for task in tasks:
        compile_scene(task)
        for i, subtask in enumerate(task.subtasks):
            kind = next(o.kind for o in task.objects if o.name == subtask.object)
            if made_up_number(kind) is None:
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
    (tmp_path / "tasks.jsonl").write_text(text.replace('"kind":"made_up_', '"kind":"made_up_9'))
    with pytest.raises(TaskError, match=r"made_up_9.* is not a known kind of object"):
        read_tasks(tmp_path / "tasks.jsonl")
