"""The motor prior's practice: episodes, rewards, ends."""

import numpy as np
import pytest
import torch

from hv_policy.decision.view import Phase
from hv_policy.motor import embodiment as body
from hv_policy.motor.intent import split_hands
from hv_policy.motor.prior import FEATURE_DIM, MotorPrior
from hv_sim.observations import Heading
from hv_teachers.motor_critic import CRITIC_EXTRA
from hv_teachers.motor_env import START_PHASES, MotorEnv, MotorEnvConfig, draw_intents
from hv_teachers.motor_scenes import LoadRange, draw_carry_task


def make(seed=0, num=6, **changes):
    return MotorEnv(MotorPrior(), MotorEnvConfig(num_envs=num, num_threads=1, **changes), seed)


def test_features_have_their_sizes_and_stay_finite():
    env = make()
    for _ in range(20):
        reward, failed, timed_out, terms = env.step(0.1 * torch.randn(6, 28))
        assert torch.isfinite(env.features).all()
        assert torch.isfinite(reward).all()
    assert env.features.shape == (6, FEATURE_DIM)
    assert env.critic_extra.shape == (6, len(CRITIC_EXTRA))
    assert not (failed & timed_out).any()
    assert set(terms) >= {"velocity", "hands", "load", "placed"}


def test_the_same_seed_gives_the_same_practice():
    first, second = make(3), make(3)
    for _ in range(15):
        a, b = first.step(torch.zeros(6, 28))[0], second.step(torch.zeros(6, 28))[0]
        assert torch.equal(a, b)
    assert torch.equal(first.features, second.features)


def test_standing_still_is_worth_more_than_shaking():
    still, shaken = make(1, load_share=0.0, push_n_s=0.0), make(1, load_share=0.0, push_n_s=0.0)
    calm = torch.stack([still.step(torch.zeros(6, 28))[0] for _ in range(20)]).mean()
    wild = torch.stack([shaken.step(2.0 * torch.sign(torch.randn(6, 28)))[0] for _ in range(20)]).mean()
    assert calm > wild + 0.1


def test_a_toppled_robot_ends_its_episode():
    env = make(2, load_share=0.0, bent_share=0.0)
    env.shove(np.arange(6), np.tile([300.0, 0.0, 0.0], (6, 1)))
    failed = torch.zeros(6, dtype=torch.bool)
    for _ in range(45):
        failed |= env.step(torch.zeros(6, 28))[1]
    assert failed.all()


@pytest.mark.parametrize("phase", [Phase.CARRY, Phase.ALIGN_PLACE])
def test_an_episode_may_begin_with_the_box_in_the_hands(phase):
    shares = tuple(float(p == phase) for p in START_PHASES)
    load = LoadRange(mass_kg=(1.0, 2.0), width_m=(0.3, 0.35), depth_m=(0.25, 0.3), height_m=(0.25, 0.3))
    env = make(4, load_share=1.0, start_shares=shares, push_n_s=0.0, auto_reset=False, load=load, randomize=False)
    assert (env.phase == phase).all()
    for _ in range(25):
        env.step(torch.zeros(6, 28))
    height = env.physics.state().object_pos_w[:, 0, 2]
    assert (height > env.start_pos[:, 2] + 0.05).float().mean() > 0.8, "most still hold it after .8 s"


def test_an_episode_may_begin_bent_over_the_box_that_was_just_put_down():
    shares = tuple(float(p == Phase.RELEASE) for p in START_PHASES)
    env = make(5, load_share=1.0, start_shares=shares, push_n_s=0.0, auto_reset=False, randomize=False)
    assert (env.object_goal_distance() < 0.01).all()
    for _ in range(30):
        env.step(torch.zeros(6, 28))
    state = env.physics.state()
    assert (env.phase >= Phase.RETREAT).all()
    assert (state.link_pos_w[:, 0, 2] > 0.35).float().mean() > 0.8
    assert (env.object_goal_distance() < 0.1).float().mean() > 0.6


@pytest.mark.parametrize("phase", [Phase.SQUEEZE, Phase.CARRY, Phase.ALIGN_PLACE, Phase.RELEASE])
def test_wherever_an_episode_begins_hands_are_sent_to_where_they_nearly_are(phase):
    shares = tuple(float(p == phase) for p in START_PHASES)
    env = make(6, load_share=1.0, start_shares=shares, push_n_s=0.0)
    for _ in range(2):  # the second time after other episodes
        heading = Heading.of(env.physics.state())
        origin = heading.origin_w[:, None] * torch.tensor([1.0, 1.0, 0.0])
        hands = heading.rotate(env.physics.state().link_pos_w[:, body.HANDS] - origin)
        assert ((split_hands(env.intent) - hands).norm(dim=-1) < 0.25).all()
        env._reset(np.arange(6))
        env._look()


def test_servos_of_some_robots_hear_a_step_later():
    env = make(7, num=8, late_share=0.5, push_n_s=0.0)
    heard = []
    physics_step = env.physics.step
    env.physics.step = lambda targets: (heard.append(targets.clone()), physics_step(targets))
    told = []
    apply = env.prior.apply_residual
    env.prior.apply_residual = lambda *a: (told.append(apply(*a)), told[-1])[1]
    for _ in range(3):
        env.step(torch.randn(8, 28))
    late = env._late[:, 0]
    assert 2 <= late.sum() <= 6
    assert torch.equal(heard[0], told[0]), "there was nothing before the first"
    for now, at_once, before in zip(heard[1:], told[1:], told, strict=False):
        assert torch.equal(now[~late], at_once[~late])
        assert torch.equal(now[late], before[late])
    assert not make(7, num=8, late_share=0.5, randomize=False)._late.any()


def test_draws_keep_to_their_ranges():
    rng = np.random.default_rng(0)
    intents = draw_intents(rng, 2000)
    assert intents[:, 0].min() >= -0.5
    assert intents[:, 0].max() <= 1.2
    assert intents[:, 1].abs().max() <= 0.4
    assert intents[:, 2].abs().max() <= 1.5
    assert intents[:, 3].min() >= 0.42 - 1e-6
    assert intents[:, 3].max() <= 0.86 + 1e-6
    assert intents[:, 4].min() >= 0
    assert intents[:, 4].max() <= 1.4
    assert (intents[intents[:, 4] > 0.7, 0].abs() <= 0.15).all(), "slow while bent"
    load = LoadRange()
    for _ in range(200):
        task = draw_carry_task(rng, load)
        assert load.mass_kg[0] <= task.mass_kg <= load.mass_kg[1]
        assert load.width_m[0] <= 2 * task.half_extents_m[1] <= load.width_m[1]
        assert all(s == 0 or load.support_m[0] <= s <= load.support_m[1] for s in task.support_m)
