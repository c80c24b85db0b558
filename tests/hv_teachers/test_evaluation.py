"""Evaluations: the same figures whatever the processes and the order, resumed where they were cut off."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
import torch

from hv_sim.metrics import EpisodeRecord
from hv_sim.suites import load_suite
from hv_sim.world import pick_phrasing
from hv_teachers.engines import Slice
from hv_teachers.episodes import Episode, EpisodeOutcome, SubTaskOutcome, film_episode, run_episodes
from hv_teachers.evaluated_policies import load_evaluated_policy
from hv_teachers.evaluation import (
    EvaluationConfig,
    EvaluationError,
    episode_seed,
    evaluate,
    metrics_of,
    read_outcomes,
    typical_outcomes,
    wilson_interval,
)

SHORT = EvaluationConfig("planner", "unseen", seed=5, max_episode_steps=40)


@pytest.fixture(scope="module")
def once(tmp_path_factory):
    folder = tmp_path_factory.mktemp("eval") / "once"
    return folder, evaluate(SHORT, load_suite("unseen")[:3], folder, workers=1)


def test_workers_do_not_change_a_bit(once, tmp_path):
    evaluate(SHORT, load_suite("unseen")[:3], tmp_path / "two", workers=2)
    assert (tmp_path / "two" / "metrics.json").read_bytes() == (once[0] / "metrics.json").read_bytes()
    lines = [sorted((f / "episodes.jsonl").read_text().splitlines()) for f in (once[0], tmp_path / "two")]
    assert lines[0] == lines[1]


def test_an_episode_alone_is_the_same_as_in_an_evaluation(once):
    torch.set_num_threads(1)
    task = load_suite("unseen")[2]
    episode = Episode(task, 0, episode_seed(5, task.name, 0))
    planner = load_evaluated_policy("planner")
    found = read_outcomes(once[0])
    assert run_episodes([episode], planner, 40)[0] in found
    assert film_episode(episode, planner, 40) in found


def test_what_was_interrupted_goes_on(once, tmp_path):
    folder = tmp_path / "cut"
    folder.mkdir()
    (folder / "evaluation.json").write_bytes((once[0] / "evaluation.json").read_bytes())
    lines = (once[0] / "episodes.jsonl").read_text().splitlines()
    (folder / "episodes.jsonl").write_text(lines[0] + "\n" + lines[1][:50])
    seen = []
    evaluate(SHORT, load_suite("unseen")[:3], folder, workers=1, on_episode=lambda o, n, m: seen.append((n, m)))
    assert seen == [(2, 3), (3, 3)]
    assert (folder / "metrics.json").read_bytes() == (once[0] / "metrics.json").read_bytes()
    timing = json.loads((folder / "timing.json").read_text())
    assert timing["episodes"] == 2
    with pytest.raises(EvaluationError, match="physics='cpu', not 'warp'"):
        evaluate(replace(SHORT, physics="warp"), load_suite("unseen")[:3], folder, workers=1)
    plan = json.loads((folder / "evaluation.json").read_text())
    del plan["physics"]  # as it was before there was a choice
    (folder / "evaluation.json").write_text(json.dumps(plan))
    assert evaluate(SHORT, load_suite("unseen")[:3], folder, workers=1)["plan"]["physics"] == "cpu"
    for name, value in (("code_hash", "0"), ("packages", {"mujoco": "2"})):
        (folder / "evaluation.json").write_text(json.dumps({**plan, name: value}))
        with pytest.raises(EvaluationError, match=f"holds an evaluation with {name}="):
            evaluate(SHORT, load_suite("unseen")[:3], folder, workers=1)
    (folder / "evaluation.json").write_text(json.dumps(plan))
    with pytest.raises(EvaluationError, match="seed=5, not 6"):
        evaluate(EvaluationConfig("planner", "unseen", seed=6, max_episode_steps=40), load_suite("unseen")[:3], folder)


def test_more_repeats_only_add_episodes(once, tmp_path):
    folder, task = tmp_path / "more", load_suite("unseen")[:1]
    first = evaluate(SHORT, task, folder, workers=1)
    seen = []
    more = evaluate(replace(SHORT, repeats=3), task, folder, workers=1, on_episode=lambda o, n, m: seen.append(n))
    assert seen == [2, 3]
    assert more["n_episodes"] == 3
    assert evaluate(SHORT, task, folder, workers=1) == first, "fewer again: nothing is played, nothing lost"
    assert len(read_outcomes(folder)) == 3
    assert json.loads((folder / "timing.json").read_text())["episodes"] == 3


def test_slices_add_up_to_the_whole(once, tmp_path):
    tasks, folder = load_suite("unseen")[:3], tmp_path / "slices"
    for index in (1, 0):
        assert evaluate(SHORT, tasks, folder, workers=1, only=Slice(index, 2)) == {}
    assert len(list(folder.glob("episodes.*-of-2.jsonl"))) == 2
    seen = []
    evaluate(SHORT, tasks, folder, workers=1, on_episode=lambda o, n, m: seen.append(n))
    assert seen == [], "nothing was left to play"
    assert (folder / "metrics.json").read_bytes() == (once[0] / "metrics.json").read_bytes()
    assert not list(folder.glob("episodes.*-of-2.jsonl"))


def test_names_must_tell_tasks_apart(tmp_path):
    task = load_suite("unseen")[0]
    with pytest.raises(ValueError, match=f"'{task.name}' twice"):
        evaluate(SHORT, [task, task], tmp_path / "twice", workers=1)
    with pytest.raises(ValueError, match="videos: 'other' is not among the tasks"):
        evaluate(SHORT, [task], tmp_path / "film", workers=1, videos=["other"])
    assert not (tmp_path / "film").exists()


def test_what_is_not_a_number_is_the_worst():
    lost = outcome((0.1, float("nan")), failures=("", "fell"))
    best, worst = outcome((0.1, 0.1)), outcome((0.5, 2.0), failures=("dropped", "dropped"))
    assert typical_outcomes([worst, lost, best])[:2] == [best, lost]


def test_metrics_have_what_others_read(once):
    metrics = json.loads((once[0] / "metrics.json").read_text())
    for key in ("at_0.4", "at_0.2"):
        assert {"success_1", "success_2", "success_all"} == set(metrics[key])
    assert metrics["n_episodes"] == 3
    assert metrics["fall_rate"] == 0.0
    assert metrics["dist_1"] > 0
    assert sum(metrics["failures"].values()) == 6, "nobody is done after 40 steps"
    assert metrics["plan"]["policy_hash"].startswith("planner-")
    assert metrics["physics_hz"] == 120
    assert len(metrics["physics_hash"]) == len(metrics["plan"]["code_hash"]) == 16


def outcome(distances, fallen=False, failures=("", ""), repeat=0):
    record = EpisodeRecord("t", 0, distances, fallen, 2, 100)
    subtasks = tuple(
        SubTaskOutcome("box", 1.0, 2.0, 0.0, 0.5, d, 10.0 * (i + 1), True, f)
        for i, (d, f) in enumerate(zip(distances, failures, strict=True))
    )
    return EpisodeOutcome(record, repeat, "kitchen", subtasks)


def test_metrics_by_hand():
    found = metrics_of([outcome((0.1, 0.3)), outcome((0.5, 2.0), True, ("dropped", "fell"))])
    assert found["at_0.4"] == {"success_1": 0.5, "success_2": 0.5, "success_all": 0.5}
    assert found["at_0.2"] == {"success_1": 0.5, "success_2": 0.0, "success_all": 0.0}
    assert {k: v for k, v in found["failures"].items() if v} == {"fell": 1, "dropped": 1}
    assert found["rooms"] == {"kitchen": {"success": 0.5, "n": 2}}
    assert found["kinds"] == {"box": {"success": 0.5, "n": 4}}
    assert (found["seconds_1"], found["seconds_2"]) == (10.0, 20.0)
    # Wilson's interval of 1 in 2, from the textbook
    assert found["interval_0.4"]["success_all"] == pytest.approx([0.0945, 0.9055], abs=1e-3)
    assert wilson_interval(0, 0) is None
    assert wilson_interval(0, 10)[0] == 0.0


def test_outcomes_survive_being_written():
    once = outcome((0.25, 1 / 3))
    assert EpisodeOutcome.from_json(once.to_json()) == once


def test_unknown_physics_is_refused():
    with pytest.raises(ValueError, match="physics: 'horse' is not valid; valid: cpu, warp"):
        replace(SHORT, physics="horse")


def test_warp_plays_what_the_cpu_plays():
    """A few steps, blind and seeing; how far the engines are apart is tested where they are."""
    pytest.importorskip("mujoco_warp", reason="Warp is not installed here: pip install 'lerobot_policy_hv[gpu]'")
    task = load_suite("unseen")[2]
    episode = Episode(task, 0, episode_seed(5, task.name, 0))
    planner = load_evaluated_policy("planner")
    [expected] = run_episodes([episode], planner, 3)
    [found] = run_episodes([episode], planner, 3, physics="warp")
    assert found.record.num_steps == 3
    assert found.record.distances_m == pytest.approx(expected.record.distances_m, abs=1e-3)
    assert film_episode(episode, planner, 3, physics="warp").record.num_steps == 3


def test_unknown_policies_are_refused(tmp_path: Path):
    with pytest.raises(ValueError, match="valid: planner, teacher"):
        load_evaluated_policy(str(tmp_path))


def test_the_seed_picks_among_the_phrasings():
    phrasings = load_suite("seen")[0].subtasks[0].phrasings
    picked = [pick_phrasing(phrasings, seed, 0) for seed in range(40)]
    assert picked == [pick_phrasing(phrasings, seed, 0) for seed in range(40)]
    assert set(picked) == set(phrasings)
    assert pick_phrasing(("one",), 7, 0) == "one"
