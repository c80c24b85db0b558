"""The motor prior without learning: it must stand, walk, crouch; and its file must be the whole truth."""

import pytest
import torch
from plain_ground import play
from safetensors.torch import save_file

from hv_policy.motor.intent import neutral_intent
from hv_policy.motor.prior import (
    MotorPrior,
    MotorPriorConfig,
    load_motor_prior,
    load_shipped_motor_prior,
    save_motor_prior,
)
from hv_sim.observations import proprioception


def crouch(step):
    intent = neutral_intent(4)
    if step > 15:
        intent[:, 3], intent[:, 4] = 0.45, 1.3
        intent[:, 5:11] = torch.tensor([0.5, 0.22, 0.2, 0.5, -0.22, 0.2])
    return intent


def walk(step):
    intent = neutral_intent(4)
    intent[:, 0] = torch.tensor([0.3, 0.6, -0.3, 0.0])
    intent[3, 2] = 0.8
    return intent


def test_stands():
    physics, lowest = play(MotorPrior(), lambda _: neutral_intent(4), 4, 150)
    assert lowest.min() > 0.8
    assert physics.state().link_pos_w[:, 0, :2].norm(dim=-1).max() < 0.1


def test_walks_and_turns():
    physics, lowest = play(MotorPrior(), walk, 4, 150)
    assert lowest.min() > 0.7
    speed = physics.state().link_pos_w[:3, 0, :2].norm(dim=-1) / 5.0
    torch.testing.assert_close(speed, torch.tensor([0.3, 0.6, 0.3]), atol=0.12, rtol=0)


def test_crouches_and_brings_the_hands_to_the_floor():
    prior = MotorPrior()
    physics, lowest = play(prior, crouch, 4, 150)
    assert lowest.min() > 0.38
    state = physics.state()
    assert (state.link_pos_w[:, 0, 2] - 0.45).abs().max() < 0.05
    assert (state.link_pos_w[:, [5, 8], 2] - 0.2).abs().max() < 0.1


def test_reset_touches_only_its_rows():
    prior, kept = MotorPrior(), MotorPrior()
    physics, _ = play(prior, walk, 4, 40)
    observed = proprioception(physics.state())
    kept.memory = prior.memory.select(torch.arange(4))
    kept._last_residual, kept._fresh = prior._last_residual.clone(), prior._fresh.clone()
    prior.reset(torch.tensor([1, 3]))
    prior.advance(observed, walk(0))
    kept.advance(observed, walk(0))
    for name in ("phase", "anchor", "foot_pos", "joints", "velocity"):
        now, otherwise = getattr(prior.memory, name), getattr(kept.memory, name)
        assert torch.equal(now[[0, 2]], otherwise[[0, 2]]), name
    assert (prior.memory.velocity[1, 0] - 0.6).abs() > 0.4, "a new start begins from rest"
    assert (kept.memory.velocity[1, 0] - 0.6).abs() < 1e-5


def test_saved_and_loaded_gives_the_same_targets(tmp_path):
    prior = MotorPrior(MotorPriorConfig(hidden=(32, 16), leg_residual_rad=0.2))
    torch.nn.init.normal_(prior.residual.layers[-1].weight, std=0.1)
    save_motor_prior(prior, tmp_path / "p.safetensors", {"seed": "3"})
    loaded = load_motor_prior(tmp_path / "p.safetensors")
    assert loaded.config == prior.config
    prior.eval()
    physics, _ = play(prior, walk, 4, 5)
    observed = proprioception(physics.state())
    prior.reset()
    for _ in range(5):
        assert torch.equal(loaded(observed, walk(0)), prior(observed, walk(0)))


def test_other_files_are_refused_in_one_line(tmp_path):
    path = tmp_path / "p.safetensors"
    save_file({"x": torch.zeros(2)}, path)
    with pytest.raises(ValueError, match=r"format is None; valid: 'hv_motor_prior/1'"):
        load_motor_prior(path)
    prior = MotorPrior(MotorPriorConfig(hidden=(8,)))
    prior.residual.layers[0] = torch.nn.Linear(prior.residual.mean.shape[0], 9)
    save_motor_prior(prior, path)
    with pytest.raises(ValueError, match="do not fit the configuration") as error:
        load_motor_prior(path)
    assert "\n" not in str(error.value)


def test_the_shipped_one_loads():
    assert load_shipped_motor_prior().config == MotorPriorConfig()
