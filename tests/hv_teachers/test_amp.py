"""AMP: the style reward by hand, the penalty by finite differences, and a discriminator that learns and saves."""

from contextlib import redirect_stdout
from copy import deepcopy
from io import StringIO
from types import SimpleNamespace

import numpy as np
import pytest
import torch
from rsl_rl.algorithms import PPO
from tensordict import TensorDict

from hv_teachers.amp import (
    WINDOW_DIM,
    AmpPPO,
    Discriminator,
    StyleConfig,
    WindowReplay,
    discriminator_loss,
    style_reward,
)
from hv_teachers.style import FRAME_DIM, MotionSet

N, STEPS = 6, 5


def make(style: StyleConfig | None = None) -> AmpPPO:
    torch.manual_seed(0)
    observations = TensorDict({"policy": torch.zeros(N, 4)}, batch_size=[N])
    network = {"class_name": "rsl_rl.models:MLPModel", "hidden_dims": [8], "activation": "elu"}
    noise = {"class_name": "rsl_rl.modules.distribution:GaussianDistribution", "init_std": 0.05, "learn_std": False}
    cfg = {
        "algorithm": {
            "class_name": "hv_teachers.amp:AmpPPO",
            "motion_set": MotionSet.of([torch.randn(40, FRAME_DIM) + 2.0]),
            "reward_scale": 0.5,
            "style": style or StyleConfig(hidden=(16,), batch_size=16, replay_keep=10, replay_size=25),
        },
        "actor": {**network, "distribution_cfg": noise},
        "critic": dict(network),
        "obs_groups": {"actor": ["policy"], "critic": ["policy"]},
        "num_steps_per_env": STEPS,
        "multi_gpu": None,
        "torch_compile_mode": None,
    }
    with redirect_stdout(StringIO()):
        return PPO.construct_algorithm(observations, SimpleNamespace(num_actions=2, num_envs=N), cfg, "cpu")


def rollout(ppo: AmpPPO, seed: int, valid: torch.Tensor | None = None) -> None:
    generator = torch.Generator().manual_seed(seed)
    for _ in range(STEPS):
        observations = TensorDict({"policy": torch.randn(N, 4, generator=generator)}, batch_size=[N])
        ppo.act(observations)
        extras = {"style_windows": torch.randn(N, WINDOW_DIM, generator=generator) - 2.0}
        if valid is not None:
            extras["valid"] = valid
        ppo.process_env_step(observations, torch.full((N,), 0.5), torch.zeros(N, dtype=torch.long), extras)
    ppo.compute_returns(observations)


def test_style_reward_by_hand():
    logits = torch.tensor([-3.0, 0.0, 0.5, 9.0, 9.0])
    task = torch.tensor([0.9, 0.9, 0.1, 0.1, 0.9])
    wanted = []
    for logit, r in zip(logits.tolist(), task.tolist(), strict=True):
        d = 1 / (1 + np.exp(-logit))
        wanted.append(min(-np.log(max(1 - d, 0.01)), max(r, 0.4)))
    torch.testing.assert_close(style_reward(logits, task, 0.4), torch.tensor(wanted, dtype=torch.float32))


def test_gradient_penalty_is_the_slope():
    torch.manual_seed(0)
    model = Discriminator((8,)).double()
    good, agent = torch.randn(3, WINDOW_DIM).double(), torch.randn(4, WINDOW_DIM).double()
    plain = StyleConfig(gradient_penalty=0.0, logit_regularization=0.0)
    base = discriminator_loss(model, good, agent, plain)[0]
    d = torch.sigmoid(model(torch.cat([good, agent])))
    by_hand = 0.5 * (-d[:3].log().mean() - (1 - d[3:]).log().mean())
    torch.testing.assert_close(base, by_hand)
    slopes = []
    for window in torch.cat([good, agent]):
        x = model.normalizer(window[None])
        step = 1e-5 * torch.eye(WINDOW_DIM, dtype=torch.float64)
        slopes.append((((model.score(x + step) - model.score(x - step)) / 2e-5) ** 2).sum())
    penalty = 5.0 * 0.5 * (torch.stack(slopes[:3]).mean() + torch.stack(slopes[3:]).mean())
    whole = discriminator_loss(model, good, agent, StyleConfig())[0]
    torch.testing.assert_close(whole - base, penalty + 0.01 * model.last.weight.square().sum(), rtol=1e-4, atol=1e-6)


def test_replay_is_a_ring():
    replay = WindowReplay(5)
    for k in range(8):
        replay.add(torch.full((1, WINDOW_DIM), float(k)))
    assert sorted(replay.windows[:, 0].tolist()) == [3, 4, 5, 6, 7]
    assert replay.sample(20).shape == (20, WINDOW_DIM)


def test_style_is_added_before_the_update_and_learned():
    ppo = make()
    assert isinstance(ppo, AmpPPO)
    rollout(ppo, 0)
    stored = ppo.storage.rewards[-1, :, 0]
    torch.testing.assert_close(stored, 0.5 * (0.5 + ppo.last_style_reward))
    assert (ppo.last_style_reward <= 0.5).all()
    for seed in range(40):
        ppo.update()
        rollout(ppo, seed + 1)
    shown = ppo.update()
    assert shown["style_good"] > 0.6 > 0.4 > shown["style_agent"]
    assert len(ppo.replay.windows) == 25


def test_others_transitions_do_not_count():
    valid = torch.tensor([True, False, True, False, False, False])
    ppo = make()
    rollout(ppo, 0, valid)
    rows = [batch.observations["policy"] for batch in ppo.storage.mini_batch_generator(2, 1)]
    found = torch.cat(rows)
    wanted = ppo.storage.observations["policy"][:, valid].flatten(0, 1)
    assert {tuple(r) for r in found.tolist()} == {tuple(r) for r in wanted.tolist()}
    chosen = ppo.storage.advantages[:, valid]
    assert abs(float(chosen.mean())) < 1e-5
    assert abs(float(chosen.std()) - 1) < 1e-3
    ppo.update()
    before = [p.clone() for p in ppo.actor.parameters()]
    rollout(ppo, 1, torch.zeros(N, dtype=torch.bool))
    ppo.update()
    assert all(torch.equal(a, b) for a, b in zip(before, ppo.actor.parameters(), strict=True))


def test_goes_on_as_it_was_saved():
    ppo = make()
    for seed in range(3):
        rollout(ppo, seed)
        ppo.update()
    saved = deepcopy(ppo.save())
    other = make()
    other.load(saved, None, strict=True)
    results = []
    for each in (ppo, other):
        torch.manual_seed(7)
        rollout(each, 9)
        results.append(each.update())
    assert results[0] == pytest.approx(results[1])
