"""Gathered results: names, order, the leaderboard's figures against the files', damaged files."""

import json
import re

import pytest

from hv_sim.suites import load_suite
from hv_teachers.episodes import tasks_fingerprint
from hv_teachers.evaluation import EvaluationError
from hv_teachers.published_results import PUBLISHED_TABLES
from hv_teachers.results import (
    EARLIER_NOTE,
    README_MARKS,
    find_results,
    leaderboard,
    read_result,
    readme_table,
    with_results,
)


def metrics(success=0.5, suite="seen", policy="planner", count=2):
    each = {f"success_{i + 1}": success for i in range(count)}
    return {
        "at_0.4": {**each, "success_all": success},
        "at_0.2": {**each, "success_all": success / 2},
        "interval_0.4": {"success_all": [0.4, 0.6]},
        "fall_rate": 0.1,
        "n_episodes": 12,
        **{f"dist_{i + 1}": 0.25 for i in range(count)},
        "plan": {"policy": policy, "suite": suite},
    }


def write(folder, data, name=None):
    folder.mkdir(parents=True)
    (folder / "metrics.json").write_text(json.dumps(data))
    if name:
        (folder / "experiment.json").write_text(json.dumps({"name": name}))


def test_results_are_found_named_and_ordered(tmp_path):
    write(tmp_path / "a", metrics(0.2, policy="outputs/train/mine"))
    write(tmp_path / "b" / "seen", metrics(0.7, policy="x") | {"trained_samples": 3_000_000}, "wo_stage2")
    write(tmp_path / "c", {**metrics(0.9, "unseen"), "experiment": "teacher"})
    write(tmp_path / "d", metrics(0.4, "chain3", count=3))
    found = find_results([tmp_path])
    assert [(r.system, r.suite) for r in found] == [
        ("wo_stage2", "seen"), ("mine", "seen"), ("teacher", "unseen"), ("planner", "chain3"),
    ]  # fmt: skip
    text = leaderboard(found)
    row = "| 70.0 % | 70.0 % | **70.0 %** [40.0, 60.0] | 35.0 % | 0.25 / 0.25 | 10.0 % | 12 |"
    assert f"| wo_stage2 (3.0 M samples) {row}" in text
    assert text.index("## seen") < text.index("## unseen") < text.index("## chain3")
    assert "| object 1 | object 2 | object 3 |" in text
    # Table 1 of the paper: 72.381 % of both objects, for the teachers, on the 350 tasks
    assert "*HumanoidVerse-T, published (Table 1)* | 88.8 % | 72.9 % | 72.4 %" in text


def test_an_evaluation_in_two_places_is_one(tmp_path):
    for place in ("results", "outputs"):
        write(tmp_path / place / "planner-seen", {**metrics(0.7), "experiment": "planner"})
    (tmp_path / "outputs" / "planner-seen" / "episodes.jsonl").write_text("")
    write(tmp_path / "other", {**metrics(0.6), "experiment": "planner"})
    found = find_results([tmp_path / "results", tmp_path / "outputs", tmp_path / "other"])
    assert [r.folder.relative_to(tmp_path).parts[0] for r in found] == ["outputs", "other"]


def test_the_papers_shares_are_whole_numbers_of_episodes():
    for table in PUBLISHED_TABLES:
        episodes = {"seen": 1050, "unseen": 198}[table.suite]
        for row in table.rows:
            for share in (row.success_1, row.success_2, row.success_all):
                count = share * episodes
                assert abs(count - round(count)) < 0.02 * episodes / 100, f"{row.system}: {share}"


def test_damaged_files_are_named(tmp_path):
    with pytest.raises(EvaluationError, match="no such folder"):
        find_results([tmp_path / "none"])
    write(tmp_path / "a", {"at_0.4": {}})
    with pytest.raises(EvaluationError, match=r"metrics.json: at_0.2 is missing"):
        find_results([tmp_path])
    (tmp_path / "a" / "metrics.json").write_text("{")
    with pytest.raises(EvaluationError, match="not a readable"):
        read_result(tmp_path / "a" / "metrics.json")


def test_the_readmes_table_is_written_between_its_marks(tmp_path):
    write(tmp_path / "a", metrics(0.25))
    write(tmp_path / "b", metrics(0.5, "unseen"))
    begin, end = README_MARKS
    once = with_results(f"before\n{begin}\nold\n{end}\nafter", find_results([tmp_path]))
    assert once.startswith(f"before\n{begin}\n| success")
    assert once.endswith(f"|\n{end}\nafter")
    assert "| planner | 25.0 % | 50.0 % |" in once
    assert "| *HumanoidVerse-T, published, on their tasks* | 72.4 % | 64.6 % |" in once
    assert "old" not in once
    assert with_results(once, find_results([tmp_path])) == once
    assert with_results("no marks", []) == "no marks"


def test_what_was_measured_on_other_tasks_is_marked(tmp_path):
    unseen = load_suite("unseen")
    now, before, part = (metrics(0.5, "unseen", policy) for policy in ("now", "before", "part"))
    now["plan"] |= {"n_tasks": len(unseen), "tasks": tasks_fingerprint(unseen)}
    before["plan"] |= {"n_tasks": len(unseen), "tasks": "0123456789abcdef"}
    part["plan"] |= {"n_tasks": 5, "tasks": "0123456789abcdef"}
    for name, data in (("a", now), ("b", before), ("c", part)):
        write(tmp_path / name, data)
    found = find_results([tmp_path])
    for text in (leaderboard(found), readme_table(found)):
        assert "| now | 50.0 %" in text
        assert re.search(r"\| part \(5 tasks\) \| 50.0 %|\| part \| 50.0 % \(5 tasks\)", text)
        assert text.rstrip().endswith(EARLIER_NOTE)
    assert "| before † | 50.0 %" in leaderboard(found)
    assert "| before | 50.0 %† |" in readme_table(found)
    assert EARLIER_NOTE not in leaderboard([r for r in found if r.system != "before"])
