"""Rewards of the motor prior: what is asked for is worth more than anything else."""

import math

import torch

from hv_policy.motor import embodiment as body
from hv_policy.motor.prior import MotorPrior
from hv_sim.observations import Heading
from hv_teachers.motor_env import MotorEnv, MotorEnvConfig
from hv_teachers.motor_rewards import RewardConfig, motor_reward


def terms_of(env, residual=None, **changes):
    """The terms of the state as it is, with some of it changed."""
    from dataclasses import replace

    state = replace(env._state, **changes)
    residual = torch.zeros(env.num_envs, 28) if residual is None else residual
    return motor_reward(
        state, Heading.of(state), env.motor_step, residual, env, env.object_target, RewardConfig()
    )


def test_each_term_falls_with_its_error():
    env = MotorEnv(MotorPrior(), MotorEnvConfig(num_envs=4, num_threads=1, load_share=0.5, push_n_s=0.0), 0)
    for _ in range(5):
        env.step(torch.zeros(4, 28))
    plain = terms_of(env)
    faster = env._state.link_lin_vel_w + torch.tensor([0.0, 1.5, 0.0])
    assert (terms_of(env, link_lin_vel_w=faster)["velocity"] < plain["velocity"]).all()
    spinning = env._state.link_ang_vel_w + torch.tensor([0.0, 0.0, 3.0])
    assert (terms_of(env, link_ang_vel_w=spinning)["yaw_rate"] < plain["yaw_rate"]).all()
    raised = env._state.link_pos_w + torch.tensor([0.0, 0.0, 0.3])
    assert (terms_of(env, link_pos_w=raised)["posture"] < plain["posture"]).all()
    hands = env._state.link_pos_w.clone()
    hands[:, body.HANDS] += torch.tensor([0.5, 0.0, 0.0])  # more than they may be away on the other side
    assert (terms_of(env, link_pos_w=hands)["hands"] < plain["hands"]).all()
    feet = env._state.link_pos_w.clone()
    feet[:, body.FEET] += torch.tensor([0.0, 0.0, 0.2])
    assert (terms_of(env, link_pos_w=feet)["feet"] < plain["feet"]).all()
    c, s = math.cos(0.5), math.sin(0.5)
    leant = torch.tensor([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]) @ env._state.link_rot_w
    assert (terms_of(env, link_rot_w=leant)["orientation"] < plain["orientation"]).all()
    restless = terms_of(env, residual=torch.ones(4, 28))
    assert (restless["residual"] < plain["residual"]).all()
    assert (restless["residual_rate"] < plain["residual_rate"]).all()
    assert (terms_of(env, joint_vel=env._state.joint_vel + 5.0)["joint_speed"] < plain["joint_speed"]).all()


def test_only_those_with_a_load_are_paid_for_it():
    env = MotorEnv(MotorPrior(), MotorEnvConfig(num_envs=4, num_threads=1, load_share=0.5, push_n_s=0.0), 0)
    plain = terms_of(env)
    assert (plain["load"][env.has_load] > 0).all()
    assert (plain["load"][~env.has_load] == 0).all()
    away = env._state.object_pos_w + torch.tensor([0.5, 0.0, 0.0])
    env._state = type(env._state)(**{**vars(env._state), "object_pos_w": away})
    assert (terms_of(env)["load"] < plain["load"])[env.has_load].all()


def test_a_box_that_stands_at_its_goal_is_paid_once():
    env = MotorEnv(MotorPrior(), MotorEnvConfig(num_envs=2, num_threads=1, load_share=1.0, push_n_s=0.0), 0)
    env._state.object_pos_w[:, 0] = env.goal_pos
    paid = []
    for steps in (44, 45, 46):
        env.idle_steps[:] = steps
        paid.append(bool(env.placed().all()))
    assert paid == [False, True, False]
