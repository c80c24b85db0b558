"""Practice in getting up: robots lie, rewards rise as they should, nobody who is not pulled is pulled."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from hv_policy.motor.get_up import STANDING, is_up, stands
from hv_policy.motor.prior import SHIPPED_MOTOR_PRIOR, load_motor_prior, load_shipped_motor_prior, motor_prior_notes
from hv_policy.motor.proprioception import read_proprioception
from hv_sim.humanoid import standing_qpos
from hv_sim.observations import Heading, proprioception
from hv_teachers.get_up_practice import (
    GetUpConfig,
    GetUpPractice,
    GetUpRewards,
    get_up_rewards,
    lying_poses,
)
from hv_teachers.motor_training import MotorTrainingConfig, getting_up, train_motor

SMALL = GetUpConfig(num_envs=8, lying=12, num_threads=1, counted=4)


@pytest.fixture(scope="module")
def practice() -> GetUpPractice:
    return GetUpPractice(SMALL, seed=0)


def rewards_at(practice: GetUpPractice, height: float, turn: list[float]) -> dict[str, float]:
    pose = standing_qpos((0.0, 0.0), 0.3)
    pose[2], pose[3:7] = height, turn
    practice.physics.reset(np.arange(8), [pose] * 8)
    state = practice.physics.state()
    seen = read_proprioception(proprioception(state, Heading.of(state)))
    terms = get_up_rewards(seen, state.joint_pos, state.joint_vel, torch.zeros(8, 28), GetUpRewards())
    return {name: float(value[0]) for name, value in terms.items()}


def test_robots_lie_in_many_ways():
    poses, speeds = lying_poses(np.random.default_rng(0), 24, 1)
    assert len(poses) == len(speeds) > 12
    assert (poses[:, 2] < 0.6).all()
    assert np.abs(poses[:, 7:] - STANDING.numpy()).max(1).min() > 0.2
    up = 1 - 2 * (poses[:, 4] ** 2 + poses[:, 5] ** 2)  # z of the pelvis' own up axis
    assert up.min() < -0.2
    assert up.max() < 0.9


def test_who_is_higher_and_more_upright_is_better_off(practice):
    upright, flat = [1.0, 0.0, 0.0, 0.0], [np.sqrt(0.5), 0.0, np.sqrt(0.5), 0.0]
    stood, lay = rewards_at(practice, 0.865, upright), rewards_at(practice, 0.15, flat)
    for name in ("head", "pelvis", "upright", "feet", "stand"):
        assert stood[name] > lay[name] + 0.05, name
    assert sum(stood.values()) == pytest.approx(0.6 + 0.6 + 0.3 + 0.65 + 1.5, abs=0.15)
    assert lay["stand"] == 0.0


def test_a_quarter_is_never_pulled_and_the_others_are(practice):
    practice._reset(torch.arange(8))
    assert practice.free.tolist() == [True, False, False, False] * 2
    assert (practice.pull_n[practice.free] == 0).all()
    weight = 48.891 * 9.81
    assert (practice.pull_n[~practice.free] > 0).all()
    assert practice.pull_n.max() <= SMALL.pull_share * weight


def test_the_pull_is_felt():
    heights = []
    for share in (0.0, 1.5):
        one = GetUpPractice(SMALL, seed=1, pull_share=share)
        one.pull_n[:] = share * 48.891 * 9.81
        for _ in range(15):
            one.step(torch.zeros(8, 28))
        heights.append(one.physics.state().link_pos_w[:, 1, 2])
    assert (heights[1] > heights[0] + 0.1).all()


def test_the_pull_becomes_less_as_enough_stand_up(practice):
    before = practice.pull_share
    practice.ended = {"free": [0, 0], "pulled": [0, 0]}
    ended, up = torch.ones(8, dtype=torch.bool), torch.zeros(8, dtype=torch.bool)
    practice._count(ended, up)
    assert practice.pull_share == before
    practice._count(ended, ~up)
    assert practice.pull_share == pytest.approx(before * SMALL.pull_decay - 0.005)


def test_who_is_up_need_not_be_at_rest(practice):
    pose = standing_qpos((0.0, 0.0), 0.0)
    pose[2] += 0.01
    practice.physics.reset(np.arange(8), [pose] * 8, [np.full(34, 0.5)] * 8)
    state = practice.physics.state()
    seen = read_proprioception(proprioception(state, Heading.of(state)))
    assert is_up(seen).all()
    assert not stands(seen).any()


def test_trained_it_goes_on_where_it_was_and_follows_as_before(tmp_path):
    base = MotorTrainingConfig(samples=8 * 3, get_up=SMALL)
    config = getting_up(base)
    config = replace(config, steps_per_iteration=3)
    train_motor(config, tmp_path)
    weights = train_motor(replace(config, samples=8 * 6), tmp_path)
    state = torch.load(tmp_path / "resume.pt", weights_only=True)
    assert (state["iteration"], state["samples"]) == (2, 48)
    assert 0 < state["pull_share"] <= SMALL.pull_share
    prior, shipped = load_motor_prior(weights), load_shipped_motor_prior()
    for name, value in shipped.residual.state_dict().items():
        assert torch.equal(value, prior.residual.state_dict()[name]), name
    notes = motor_prior_notes(SHIPPED_MOTOR_PRIOR)
    assert motor_prior_notes(weights) == notes | {"get_up_samples": "48", "get_up_seed": "0"}
    assert float(prior.get_up.layers[-1].weight.detach().abs().max()) > 0
    assert "free_up" in (tmp_path / "curve.csv").read_text().splitlines()[0]
