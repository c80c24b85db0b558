"""Experiments: what they say in advance, what they reuse, and every row of the paper's tables that has one."""

import json

import pytest

from hv_teachers.experiments import Places, known_experiments, plan_of, read_experiment, run_experiment
from hv_teachers.published_results import PUBLISHED_TABLES
from hv_teachers.teacher_recipe import read_recipe


def test_every_teacher_of_the_papers_tables_has_an_experiment():
    known = known_experiments()
    rows = {row.experiment for table in PUBLISHED_TABLES for row in table.rows}
    assert rows - set(known) == {"humanvla_student"}, "the only row without an experiment"
    for name in known:
        experiment = read_experiment(name)
        if experiment.train:
            recipe = read_recipe(experiment.train)
            assert set(experiment.reuse) <= set(recipe.stages)
            assert set(experiment.reuse.values()) <= set(known)


def test_says_what_is_to_be_done_and_how_long_it_takes(tmp_path):
    places = Places(tmp_path)
    said = plan_of(read_experiment("planner"), places)
    assert said.startswith("planner: 1050 episodes of seen, 198 episodes of unseen")
    said = plan_of(read_experiment("wo_stage2"), places)
    assert said.startswith("wo_stage2: train 3.0 M control steps, 1050 episodes of seen; about ")
    assert said.endswith(" min")


def test_runs_and_is_reused(tmp_path, monkeypatch):
    """A suite of two tasks, cut off after a moment; what is asked twice is played once."""
    from hv_sim.suites import load_suite
    from hv_teachers import evaluation, experiments

    monkeypatch.setattr(experiments, "load_suite", lambda name: load_suite(name)[:2])
    monkeypatch.setitem(experiments.SUITE_SIZES, "unseen", 2)
    real = evaluation.EvaluationConfig
    monkeypatch.setattr(
        experiments, "EvaluationConfig", lambda p, s, r, seed, _, i, **more: real(p, s, r, seed, 30, i, **more)
    )
    places, experiment = Places(tmp_path), read_experiment("planner").narrowed(["unseen"], 1)
    written = run_experiment(experiment, places, workers=1)
    assert [p.name for p in written] == ["metrics.json", "RESULTS.md"]
    metrics = json.loads(written[0].read_text())
    assert (metrics["experiment"], metrics["n_episodes"]) == ("planner", 2)
    assert "| planner (2 tasks) |" in places.leaderboard.read_text()
    assert plan_of(experiment, places) == "planner: done"
    before = (places.evaluation("planner", "unseen") / "timing.json").read_bytes()
    run_experiment(experiment, places, workers=1)
    assert (places.evaluation("planner", "unseen") / "timing.json").read_bytes() == before, "nothing was played again"

    first = (places.evaluation("planner", "unseen") / "episodes.jsonl").read_bytes()
    with monkeypatch.context() as changed:
        changed.setattr("hv_teachers.evaluated_policies._Planner.fingerprint", lambda _: "another")
        assert plan_of(experiment, places).startswith("planner: 2 episodes of unseen")
        for _ in range(2):  # what is put aside twice, of one policy, is there once
            run_experiment(experiment, places, workers=1)
        assert plan_of(experiment, places) == "planner: done"
        earlier = places.evaluation("planner", "unseen").parent / ".earlier"
        (aside,) = earlier.glob("unseen.*")
        assert (aside / "episodes.jsonl").read_bytes() == first
    run_experiment(experiment, places, workers=1)
    assert (places.evaluation("planner", "unseen") / "timing.json").read_bytes() == before, "it came back"
    (other,) = earlier.glob("unseen.*")
    assert other != aside
    more = read_experiment("planner").narrowed(["unseen"], 2)
    assert plan_of(more, places).startswith("planner: 2 episodes of unseen")
    assert plan_of(experiment, places, n_tasks=1).startswith("planner: 1 episodes of unseen")
    run_experiment(experiment, places, workers=1, n_tasks=1)
    assert json.loads(written[0].read_text())["n_episodes"] == 1


def test_what_is_reused_is_not_trained_again(tmp_path):
    places = Places(tmp_path)
    said = plan_of(read_experiment("wo_speed"), places)
    assert said.startswith("wo_speed: first hv-experiment humanoidverse_teacher, train 0.9 M control steps, ")
    for stage in ("stage1", "stage2"):
        (places.training("humanoidverse_teacher") / stage).mkdir(parents=True)
    assert plan_of(read_experiment("wo_speed"), places).startswith("wo_speed: train 0.9 M control steps, ")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("policy: planner\ntrain: wo_speed\nsuites: {seen: 1}", "policy, train"),
        ("policy: planner\nsuites: {other: 1}", "suites"),
        ("train: wo_speed\nscale: 0\nsuites: {seen: 1}", "scale: 0 is not valid; valid: a number > 0"),
        ("policy: planner\nsuites: {seen: 0}", "repeats"),
        ("policy: planner\nsuites: {seen: 1}\ncolour: red", "colour: unknown"),
        ("policy: student\nsuites: {seen: 1}\nwithout: [smell]", "without: 'smell' is not valid"),
    ],
)
def test_bad_files_are_refused(tmp_path, text, message):
    path = tmp_path / "mine.yaml"
    path.write_text(text)
    with pytest.raises(ValueError, match=message):
        read_experiment(str(path))
    with pytest.raises(ValueError, match=r"valid: .*planner"):
        read_experiment("nonsense")
    with pytest.raises(ValueError, match="--suites: 'chain9'"):
        read_experiment("planner").narrowed(["chain9"], None)
