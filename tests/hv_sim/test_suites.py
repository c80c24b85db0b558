"""The suites in the package: sizes, nothing that leaks from seen to unseen, and instructions that mean one thing."""

import gzip
import json
import re

import numpy as np
import pytest
from obeying_words import obeying_points

from hv_sim.floor_plans import HELD_OUT
from hv_sim.furniture import FURNITURE_KINDS
from hv_sim.grounding import fits, ground
from hv_sim.lexicon import COLOR_WORDS, MOTION_WORDS, PLACE_WORDS, SIZE_WORDS, furniture_nouns, object_nouns, usable
from hv_sim.metrics import SUCCESS_THRESHOLDS_M
from hv_sim.objects import OBJECT_KINDS, PACKAGED_KINDS
from hv_sim.places import layout_at
from hv_sim.suites import SUITE_SIZES, SUITES, load_suite, read_tasks, select_tasks, suite_path, write_tasks
from hv_sim.task import RobotStart, TaskError, check_task
from hv_sim.task_generator import UNSEEN_PLANS, _plan


@pytest.fixture(scope="module")
def suites():
    return {name: load_suite(name) for name in SUITES}


def phrasings(tasks):
    return {p for t in tasks for s in t.subtasks for p in s.phrasings}


def test_sizes(suites):
    assert {name: len(tasks) for name, tasks in suites.items()} == SUITE_SIZES
    assert SUITE_SIZES == {"seen": 350, "unseen": 66, "single": 700, "chain3": 100, "chain5": 60}
    subtasks = {"seen": 2, "unseen": 2, "single": 1, "chain3": 3, "chain5": 5}
    for name, tasks in suites.items():
        assert {len(t.subtasks) for t in tasks} == {subtasks[name]}
        assert len({t.name for t in tasks}) == len(tasks)
        assert len({t.room.kind for t in tasks}) == 4
    assert sum(suite_path(n).stat().st_size for n in SUITES) < 10_000_000


def test_every_instruction_has_five_paraphrases_and_fits_one_object_and_one_goal(suites):
    for name in ("seen", "unseen", "chain3", "chain5"):
        for task in suites[name]:
            for i, subtask in enumerate(task.subtasks):
                assert len(set(subtask.phrasings)) >= 6
                layout = layout_at(task, i)
                for sentence in subtask.phrasings:
                    assert fits(sentence, layout, subtask.object, subtask.goal_position_m), f"{task.name}: {sentence}"


def test_unseen_shares_no_plan_object_or_phrasing_with_seen(suites):
    seen, unseen = suites["seen"], suites["unseen"]
    assert not phrasings(seen) & phrasings(unseen)
    rooms = [{(t.room, t.furniture) for t in tasks} for tasks in (seen, unseen)]
    assert not rooms[0] & rooms[1]
    instances = [{(o.kind, o.size_m, o.mass_kg, o.color) for t in tasks for o in t.objects} for tasks in (seen, unseen)]
    assert not instances[0] & instances[1]
    held_out = {k for k, spec in OBJECT_KINDS.items() if spec.held_out}
    assert not held_out & {o.kind for t in seen for o in t.objects}
    assert held_out <= {o.kind for t in unseen for o in t.objects}
    assert set(UNSEEN_PLANS) <= set(HELD_OUT)
    # not even the verbs: the first words of half of the unseen sentences occur in no seen one
    first = {p.split()[0] for p in phrasings(seen)}
    assert sum(p.split()[0] not in first for p in phrasings(unseen)) > 0.5 * len(phrasings(unseen))


def test_words_that_are_held_out_for_unseen_occur_nowhere_in_seen(suites):
    seen = " ".join(f" {p.lower()} " for name in SUITES if name != "unseen" for p in phrasings(suites[name]))
    seen = re.sub(r"[^a-z'-]+", " ", seen)
    held_out = {phrase for words in (PLACE_WORDS, MOTION_WORDS) for _, unseen in words.values() for phrase in unseen}
    words = {phrase.replace("{}", "").strip() for phrase in held_out}
    words |= {said[-1] for said in (*COLOR_WORDS.values(), *SIZE_WORDS.values()) if len(said) > 1}
    moved = [object_nouns(k) for k in OBJECT_KINDS] + [furniture_nouns(k) for k in FURNITURE_KINDS]
    said_of_seen = {n for nouns in moved for n in usable(nouns, unseen=False)}
    words |= {nouns[-1] for nouns in moved if len(nouns) > 1 and nouns[-1] not in said_of_seen}
    words |= {"shift", "transfer", "relocate", "leave", "deposit", "fetch", "grab", "leaving", "make sure"}
    assert len(words) > 130
    # a colour's word may be part of a noun ("navy" is not), and a noun end as a longer one of another thing does
    assert not {w for w in words if f" {w.lower()} " in seen and not any(f" {w}" in f" {n}" for n in said_of_seen)}
    spoken = " ".join(f" {p.lower()} " for p in phrasings(suites["unseen"]))
    assert sum(f" {w.lower()}" in spoken for w in words) > 0.6 * len(words), "and they do occur in unseen"


def test_whoever_obeys_the_words_succeeds(suites):
    rng = np.random.default_rng(0)
    shares = []
    for task in suites["seen"] + suites["unseen"]:
        for i, subtask in enumerate(task.subtasks):
            layout = layout_at(task, i)
            for sentence in subtask.phrasings[:2]:
                [place] = ground(sentence, layout).goals
                there = obeying_points(layout, place, subtask.object, rng)
                near = np.linalg.norm(there - subtask.goal_position_m[:2], axis=1) < SUCCESS_THRESHOLDS_M[0]
                shares.append((float(near.mean()), task.name, sentence))
    assert np.mean([share for share, *_ in shares]) > 0.98
    assert np.mean([share > 0.9 for share, *_ in shares]) > 0.97
    assert min(shares)[0] > 0.6, min(shares)


def test_left_right_and_behind_are_said_of_what_has_a_front(suites):
    for task in suites["seen"] + suites["unseen"]:
        for i, subtask in enumerate(task.subtasks):
            layout = layout_at(task, i)
            [place] = ground(subtask.instruction, layout).goals
            piece = layout.furniture(place.landmark)
            if piece is not None and place.relation not in ("on", "on_middle"):
                assert FURNITURE_KINDS[piece.kind].has_front, f"{task.name}: {subtask.instruction}"


def test_every_kind_of_object_is_moved_in_some_task(suites):
    moved = {
        o.kind for t in suites["seen"] + suites["unseen"] for s in t.subtasks for o in t.objects if o.name == s.object
    }
    assert moved == set(PACKAGED_KINDS)


def test_sentences_vary(suites):
    said = phrasings(suites["seen"])
    assert len(said) > 4000
    assert len({" ".join(p.split()[:3]) for p in said}) > 300
    targets = {o.kind for t in suites["seen"] for s in t.subtasks for o in t.objects if o.name == s.object}
    assert len({OBJECT_KINDS[k].category for k in targets}) >= 18
    assert len({f.kind for t in suites["seen"] + suites["unseen"] for f in t.furniture}) >= 50
    assert len(FURNITURE_KINDS) >= 50


def test_tasks_fit_together(suites):
    for tasks in suites.values():
        for task in tasks[:: max(1, len(tasks) // 12)]:
            check_task(task)


def test_single_takes_seen_apart(suites):
    for i in (0, 123, 349):
        whole, parts = suites["seen"][i], suites["single"][2 * i : 2 * i + 2]
        assert [p.subtasks[0] for p in parts] == list(whole.subtasks)
        assert parts[0].objects == whole.objects
        placed = next(o for o in parts[1].objects if o.name == whole.subtasks[0].object)
        assert placed.position_m == whole.subtasks[0].goal_position_m


def test_selection(suites):
    assert select_tasks("unseen:3") == [suites["unseen"][3]]
    assert select_tasks("seen:0-15") == suites["seen"][:16]
    assert select_tasks("chain3_007") == [suites["chain3"][7]]
    assert select_tasks("nonsense") is None
    with pytest.raises(TaskError, match="unseen:0 to 65"):
        select_tasks("unseen:66")
    with pytest.raises(TaskError, match="valid: seen, unseen"):
        suite_path("other")


def test_files_are_read_and_written_byte_for_byte(tmp_path, suites):
    path = tmp_path / "unseen.jsonl.gz"
    write_tasks(path, suites["unseen"])
    assert path.read_bytes() == suite_path("unseen").read_bytes()
    assert read_tasks(path, check=False) == suites["unseen"]
    assert [p.name for p in tmp_path.iterdir()] == ["unseen.jsonl.gz"], "no draft is left behind"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "holds no task"),
        (b"{", "not a JSON document"),
        (b"\xff\xfe", "not a readable file"),
        (b'{"schema": "hv_sim.task/2"}', ":1: name: missing"),
    ],
)
def test_damaged_files_are_refused_in_one_line(tmp_path, content, message):
    file = tmp_path / "tasks.jsonl"
    file.write_bytes(content)
    with pytest.raises(TaskError, match=message) as caught:
        read_tasks(file)
    assert "\n" not in str(caught.value)
    zipped = tmp_path / "tasks.jsonl.gz"
    zipped.write_bytes(gzip.compress(content)[:-4] if content else b"no gzip")
    with pytest.raises(TaskError):
        read_tasks(zipped)


def test_an_unreachable_start_in_a_file_is_named(tmp_path, suites):
    data = suites["seen"][0].to_dict()
    data["robot"]["position_m"] = list(data["objects"][0]["position_m"][:2])
    file = tmp_path / "tasks.jsonl"
    file.write_text(json.dumps(data) + "\n")
    with pytest.raises(TaskError, match=r"tasks.jsonl:1: robot.position_m"):
        read_tasks(file)


def test_plans_are_drawn_once_and_rooms_are_connected():
    plan, room = _plan("kitchen", 0)
    assert _plan("kitchen", 0)[0] is plan
    assert (~room.cells).any()
    assert RobotStart().position_m == (0.0, 0.0)
