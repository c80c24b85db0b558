"""The teachers' practice on Warp: what they see, what they are paid and when they begin anew are those of the CPU."""

import pytest
import torch
from warp_scenes import DEVICE, living_room

import hv_sim.warp_physics
from hv_policy.motor.prior import load_shipped_motor_prior
from hv_teachers.teacher_config import training_config
from hv_teachers.teacher_env import TeacherEnv

STEPS = 30
SIGHTS, REWARD = 5e-4, 1.5e-3
"""Tolerances; 5e-5 and 2e-4 were measured. A reward is about .1 a step."""


def practice(physics: str):
    """What two environments see at the end of a second, its rewards (T, N), and the episodes begun."""
    config = training_config({"dagger.samples": 1, "env.num_envs": 2, "env.num_threads": 1, "env.physics": physics})
    tasks = [living_room().task] * 2
    env = TeacherEnv(tasks, config.env, config.teacher, load_shipped_motor_prior(), seed=3)
    if physics == "cpu":  # the models as Warp steps them
        for group in env.world.physics._groups:
            for model in {id(m): m for m in group.models}.values():
                model.opt.noslip_iterations = 0
            group.batch.set_models(group.models)
        env.begin(torch.arange(2))
    else:
        env.begin(torch.arange(2))
    rewards = []
    with torch.no_grad():
        for step in range(STEPS):
            if step == STEPS // 2:
                env.world.fallen[1] = True  # so that it begins anew
            seen = env.look()
            rewards.append(torch.stack(list(env.act(seen, env.label(seen).action).terms.values())).sum(0))
        return env.look().sights, torch.stack(rewards), env.episodes.tolist()


@pytest.mark.slow
def test_a_second_of_practice_is_that_of_the_cpu(monkeypatch):
    preferred = hv_sim.warp_physics.WarpPhysics
    monkeypatch.setattr(hv_sim.warp_physics, "WarpPhysics", lambda models: preferred(models, device=DEVICE))
    (sights, rewards, begun), (wanted, expected, begun_there) = practice("warp"), practice("cpu")
    assert begun == begun_there == [2, 3]
    assert expected.abs().mean() > 0.05
    torch.testing.assert_close(rewards, expected, atol=REWARD, rtol=0)
    torch.testing.assert_close(sights, wanted, atol=SIGHTS, rtol=0)
