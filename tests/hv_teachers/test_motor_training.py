"""A few iterations of PPO: resumable, and what is exported is what was trained."""

import csv
from dataclasses import replace

import pytest
import torch

from hv_policy.motor.prior import MotorPrior, MotorPriorConfig, load_motor_prior
from hv_teachers.curves import plot_curve
from hv_teachers.motor_env import MotorEnv, MotorEnvConfig
from hv_teachers.motor_training import (
    MotorTraining,
    MotorTrainingConfig,
    _observations,
    build_ppo,
    export_actor,
    fine_tuning,
    train_motor,
)


@pytest.fixture(scope="module")
def config():
    return MotorTrainingConfig(
        samples=2 * 8 * 6,
        steps_per_iteration=6,
        prior=MotorPriorConfig(hidden=(16,)),
        env=MotorEnvConfig(num_envs=8, num_threads=1),
    )


def rows(folder):
    with (folder / "curve.csv").open() as file:
        return list(csv.DictReader(file))


def test_training_goes_on_where_it_was(tmp_path, config):
    weights = train_motor(config, tmp_path)
    assert [int(r["samples"]) for r in rows(tmp_path)] == [48, 96]
    first = load_motor_prior(weights).residual.layers[0].weight.clone()
    state = torch.load(tmp_path / "resume.pt", weights_only=True)
    train_motor(config, tmp_path)  # nothing is left to do: what was loaded is what had been saved
    again = torch.load(tmp_path / "resume.pt", weights_only=True)
    assert again["iteration"] == state["iteration"] == 2
    for part in ("actor_state_dict", "critic_state_dict"):
        for name, value in state["ppo"][part].items():
            assert torch.equal(value, again["ppo"][part][name]), name
    with (tmp_path / "curve.csv").open("a") as file:  # killed after a row and before its state
        file.write((tmp_path / "curve.csv").read_text().splitlines()[-1].replace(",96,", ",144,") + "\n")
    train_motor(replace(config, samples=192), tmp_path)
    assert [int(r["samples"]) for r in rows(tmp_path)] == [48, 96, 144, 192]
    assert not torch.equal(first, load_motor_prior(weights).residual.layers[0].weight)
    assert (tmp_path / "curve.png").stat().st_size > 1000
    assert not list(tmp_path.glob("*.tmp*"))


def test_fine_tuning_begins_with_what_there_was_and_the_critic_learns_first(tmp_path, config):
    train_motor(config, tmp_path / "before")
    start = tmp_path / "before" / "resume.pt"
    before = torch.load(start, weights_only=True)["ppo"]
    short = replace(config, samples=96, init=str(start))
    small = replace(fine_tuning(short), steps_per_iteration=6, critic_warmup=1)
    states = {}
    for iterations in (1, 2):
        train_motor(replace(small, samples=48 * iterations), tmp_path / "after")
        states[iterations] = torch.load(tmp_path / "after" / "resume.pt", weights_only=True)["ppo"]

    def same(a, b, part, layer="mlp.0.weight"):
        return torch.equal(a[f"{part}_state_dict"][layer], b[f"{part}_state_dict"][layer])

    assert same(before, states[1], "actor")
    assert not same(before, states[1], "critic")
    assert not same(states[1], states[2], "actor")
    assert [float(r["noise"]) for r in rows(tmp_path / "after")] == [small.noise] * 2


def test_worlds_are_drawn_anew(config):
    training = MotorTraining(replace(config, worlds_every=2), 2)
    boxes = []
    for _ in range(4):
        training.iterate()
        boxes.append(training.env.mass.tolist())
    assert boxes[0] == boxes[1], "iterations 2 and 3"
    assert boxes[2] == boxes[3] != boxes[1], "iterations 4 and 5"
    assert MotorTraining(replace(config, worlds_every=2), 4).env.mass.tolist() == boxes[2]


def test_what_cannot_be_read_is_refused(tmp_path, config):
    (tmp_path / "junk").write_bytes(b"junk")
    with pytest.raises(ValueError, match="junk: cannot be read"):
        train_motor(replace(config, init=str(tmp_path / "junk")), tmp_path / "out")


def test_a_folder_of_another_training_is_refused(tmp_path, config):
    train_motor(replace(config, samples=48), tmp_path)
    for other in (fine_tuning(config), replace(config, prior=MotorPriorConfig(hidden=(8,)))):
        with pytest.raises(ValueError, match=r"resume\.pt: is of another training"):
            train_motor(other, tmp_path)
    small = replace(config, prior=MotorPriorConfig(hidden=(8,)), init=str(tmp_path / "resume.pt"))
    with pytest.raises(ValueError, match=r"resume\.pt: is of another training"):
        train_motor(small, tmp_path / "other")


def test_the_export_is_the_actors_mean(config):
    prior = MotorPrior(config.prior)
    env = MotorEnv(prior, config.env, 0)
    ppo = build_ppo(_observations(env), 8, config)
    observations = _observations(env)
    ppo.actor.update_normalization(observations)
    torch.nn.init.normal_(ppo.actor.mlp[-1].weight)
    export_actor(ppo, prior.residual)
    ppo.actor.eval()
    torch.testing.assert_close(prior.residual(env.features), ppo.actor(observations), atol=1e-4, rtol=1e-4)


def test_curves_name_an_unknown_column(tmp_path):
    (tmp_path / "c.csv").write_text("samples,reward\n1,2\n2,3\n")
    plot_curve(tmp_path / "c.csv", tmp_path / "c.png", ["reward"])
    assert (tmp_path / "c.png").exists()
    with pytest.raises(ValueError, match=r"columns: \['speed'\] are not in .*; valid: \['samples', 'reward'\]"):
        plot_curve(tmp_path / "c.csv", tmp_path / "d.png", ["speed"])
    assert not (tmp_path / "d.png").exists()
