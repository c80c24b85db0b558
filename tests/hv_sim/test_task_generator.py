"""Tasks drawn from a seed: always the same ones, and those in the package."""

import pytest

from hv_policy.text_encoder import split_words
from hv_scripts.task_jobs import generate_suite, is_solvable
from hv_sim.floor_plans import HELD_OUT, floor_plan
from hv_sim.furniture import FURNITURE_KINDS
from hv_sim.furniture_kinds.made_up import NOUNS as PIECE_NOUNS
from hv_sim.lexicon import furniture_nouns, usable
from hv_sim.object_kinds.made_up import NOUNS
from hv_sim.objects import OBJECT_KINDS
from hv_sim.rooms import ROOM_KINDS
from hv_sim.suites import SUITES, load_suite, suite_path, write_tasks
from hv_sim.task import check_task
from hv_sim.task_generator import OBJECTS_IN, PRACTICE_PLANS, SEEN_PLANS, SUBTASKS, UNSEEN_PLANS, draw_suite, draw_task


@pytest.mark.parametrize(
    ("suite", "index"), [("seen", 1), ("seen", 347), ("unseen", 64), ("chain3", 2), ("chain5", 58)]
)
def test_the_package_holds_what_the_generator_draws(suite, index):
    assert draw_task(suite, index, is_solvable) == load_suite(suite)[index]


def test_the_same_seed_gives_the_same_task_in_any_order():
    forward = [draw_task("seen", i) for i in (4, 5)]
    assert [draw_task("seen", i) for i in (5, 4)] == forward[::-1]
    assert draw_task("seen", 4, seed=1) != forward[0]
    assert list(draw_suite("seen", count=2)) == [draw_task("seen", 0), draw_task("seen", 1)]


def test_candidates_that_are_not_accepted_are_thrown_away():
    first = draw_task("chain3", 0)
    other = draw_task("chain3", 0, accept=lambda task: task != first)
    assert other != first
    check_task(other)
    with pytest.raises(ValueError, match="valid: seen, unseen"):
        draw_task("single", 0)


def test_every_room_has_enough_things():
    for kinds in OBJECTS_IN.values():
        assert len(set(kinds)) == len(kinds) > max(SUBTASKS.values()) + 4


def test_every_kind_of_furniture_stands_in_some_room():
    plans = [floor_plan(kind, i) for kind in ROOM_KINDS for i in (*SEEN_PLANS, *UNSEEN_PLANS)]
    assert {f.kind for plan in plans for f in plan.furniture} == set(FURNITURE_KINDS)


@pytest.mark.slow
def test_whole_suites_are_drawn_again_byte_for_byte(tmp_path):
    seen = None
    for name in SUITES:
        tasks = generate_suite(name, seen=seen)
        seen = tasks if name == "seen" else seen
        path = tmp_path / suite_path(name).name
        write_tasks(path, tasks)
        assert path.read_bytes() == suite_path(name).read_bytes(), name


def test_practice_has_plans_that_no_suite_has_and_words_of_the_seen_tasks():
    assert not set(PRACTICE_PLANS) & {*SEEN_PLANS, *UNSEEN_PLANS}
    assert not set(PRACTICE_PLANS) & set(HELD_OUT)
    drawn = [draw_task("practice", i) for i in range(8)]
    assert drawn[5] == draw_task("practice", 5)
    known = {word for task in load_suite("seen") for s in task.subtasks for p in s.phrasings for word in split_words(p)}
    words = {word for task in drawn for s in task.subtasks for p in s.phrasings for word in split_words(p)}
    usual = [noun for kind in FURNITURE_KINDS for noun in usable(furniture_nouns(kind), unseen=False)]
    nouns = [*NOUNS, *PIECE_NOUNS, *usual]
    assert words <= known | {word for noun in nouns for word in split_words(noun)}
    assert not any(OBJECT_KINDS[o.kind].held_out for task in drawn for o in task.objects)
    plans = {floor_plan(kind, i).furniture for kind in ROOM_KINDS for i in (*SEEN_PLANS, *UNSEEN_PLANS)}
    assert not {task.furniture for task in drawn} & plans
