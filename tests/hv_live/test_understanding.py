import pytest

from hv_live.understanding import NotUnderstoodError, clean_sentence, understand
from hv_sim.objects import OBJECT_KINDS
from hv_sim.places import Place, layout_at
from hv_sim.scene import compile_scene
from hv_sim.suites import load_suite
from hv_sim.task import load_task


@pytest.fixture(scope="module")
def room():
    task = load_task("living_room_1")
    return compile_scene(task), layout_at(task, 0)


def test_the_tasks_own_sentences_mean_its_own_sub_tasks(room):
    scene, layout = room
    for subtask in scene.task.subtasks:
        meant = understand(subtask.instruction, scene, layout)
        assert (meant.object, meant.goal_position_m) == (subtask.object, subtask.goal_position_m)


@pytest.mark.parametrize(
    ("sentence", "name", "place"),
    [
        ("Put the toaster on the console table.", "toaster", Place("on", "console_table")),
        ("could you move the cardboard box to the middle of the room?", "box", Place("room_middle")),
        ("Put the cardboard box to the left of the TV stand.", "box", Place("left_of", "tv_stand")),
        ("put the box on the floor", "box", Place("floor")),
        ("I'd love to see the toasting machine atop the entryway table.", "toaster", Place("on", "console_table")),
        ("can the package go to the left of the media console?", "box", Place("left_of", "tv_stand")),
    ],
)
def test_other_sentences_get_a_free_place_that_fits(room, sentence, name, place):
    scene, layout = room
    meant = understand(sentence, scene, layout)
    assert meant.object == name
    assert meant.instruction == sentence
    assert layout.contains(place, name, meant.goal_position_m)


@pytest.mark.parametrize(
    ("sentence", "words"),
    [
        ("dance", "the cardboard box and the toaster"),
        ("Put the toaster away.", "no place"),
        ("Put the elephant on the console table.", "no object"),
        ("Put the toaster on the sofa.", "no free spot"),
    ],
)
def test_what_cannot_be_meant_is_explained(room, sentence, words):
    with pytest.raises(NotUnderstoodError, match=words):
        understand(sentence, *room)


def test_which_one_is_asked():
    task = next(t for t in load_suite("seen") if len({o.kind for o in t.objects}) < len(t.objects))
    kinds = [o.kind for o in task.objects]
    twin = next(o for o in task.objects if kinds.count(o.kind) > 1)
    scene, layout = compile_scene(task), layout_at(task, 0)
    with pytest.raises(NotUnderstoodError, match=r"which one: .* or "):
        understand(f"Put the {OBJECT_KINDS[twin.kind].noun} on the floor.", scene, layout)


def test_clean_sentence():
    assert clean_sentence("  Put it\n there ") == "Put it there"
    for bad in ("", "   ", "x" * 201, "a\x00b", "a\u202eb"):
        with pytest.raises(NotUnderstoodError):
            clean_sentence(bad)
