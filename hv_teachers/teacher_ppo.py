"""The teacher's network as rsl_rl's actor, and PPO with the style reward around it."""

from __future__ import annotations

import os
from contextlib import redirect_stdout
from types import SimpleNamespace
from typing import Any

import torch
from rsl_rl.algorithms import PPO
from rsl_rl.models import MLPModel
from rsl_rl.modules.distribution import GaussianDistribution
from tensordict import TensorDict
from torch import Tensor, nn

from hv_policy.decision.memory import NUM_PHASES
from hv_policy.decision.network import DecisionNetwork
from hv_teachers.amp import AmpPPO, StyleConfig
from hv_teachers.ranks import Ranks
from hv_teachers.style import MotionSet
from hv_teachers.teacher import Decision, Sight
from hv_teachers.teacher_config import PpoConfig
from hv_teachers.teacher_env import Label, TeacherEnv

SEEN = ("sights", "anchors", "geometry", "memory")
"""Groups of an observation that the actor reads, in the order of `DecisionNetwork.forward`."""


class TeacherActor(MLPModel):
    """Wraps a `DecisionNetwork`: its action is the mean of a Gaussian of fixed spread.

    Which phase it is has been decided before; PPO improves what is done in it. What it draws for each environment
    does not depend on how many processes share them.
    """

    def __init__(
        self, obs: TensorDict, obs_groups: dict[str, list[str]], obs_set: str, output_dim: int,
        network: DecisionNetwork, noise: float, ranks: Ranks,
    ) -> None:  # fmt: skip
        nn.Module.__init__(self)
        self.obs_groups, self.obs_dim = self._get_obs_dim(obs, obs_groups, obs_set)
        self.obs_normalization = False
        self.network, self.ranks = network, ranks
        self.distribution = GaussianDistribution(output_dim, init_std=noise, learn_std=False)

    def forward(
        self, obs: TensorDict, masks: Tensor | None = None, hidden_state: Any = None, stochastic_output: bool = False
    ) -> Tensor:
        mean = self.network(*(obs[group] for group in SEEN))
        if stochastic_output:
            self.distribution.update(mean)
            if not torch.is_grad_enabled():  # an update only wants the distribution
                total = self.ranks.count * len(mean)
                drawn = torch.randn(total, mean.shape[1])[self.ranks.share(total)]
                return mean + self.distribution.std * drawn
        return mean


def observations(env: TeacherEnv, seen: Sight, decision: Decision, label: Label | None) -> TensorDict:
    """What PPO stores of one step: the networks' inputs, what only the critic sees, and the planner's answer."""
    n = env.num_envs
    phase = nn.functional.one_hot(env.senses.memory.phase, NUM_PHASES).float()
    left = 1.0 - env.world.episode_step[:, None] / env.max_steps[:, None]
    groups = {
        "sights": seen.sights,
        "anchors": decision.anchors,
        "geometry": seen.geometry,
        "memory": decision.memory,
        "critic": torch.cat([phase, left, (env.world.subtask_index[:, None] > 0).float()], -1),
    }
    if label is not None:
        groups |= {
            "label_anchors": label.anchors,
            "label_memory_before": label.memory_before,
            "label_memory": label.memory,
            "label_phase": label.phase[:, None].float(),
            "label_action": label.action,
        }
    return TensorDict(groups, batch_size=[n])


def build_ppo(
    network: DecisionNetwork,
    first: TensorDict,
    config: PpoConfig,
    style: StyleConfig,
    motion_set: MotionSet | None,
    ranks: Ranks | None = None,
) -> AmpPPO:
    """rsl_rl's PPO around a network; `first` is any observation of the environment."""
    ranks = ranks or Ranks()
    others = {"global_rank": ranks.rank, "world_size": ranks.count} if ranks.count > 1 else None
    cfg = {
        "algorithm": {
            "class_name": "hv_teachers.amp:AmpPPO",
            "motion_set": motion_set,
            "style": style,
            "ranks": ranks,
            "reward_scale": config.reward_scale,
            "num_learning_epochs": config.epochs,
            "num_mini_batches": config.mini_batches,
            "learning_rate": config.learning_rate,
            "critic_learning_rate": config.critic_learning_rate,
            "schedule": "fixed",
            "gamma": config.gamma,
            "lam": config.lam,
            "clip_param": config.clip,
            "entropy_coef": 0.0,
        },
        "actor": {
            "class_name": "hv_teachers.teacher_ppo:TeacherActor",
            "network": network,
            "noise": config.noise,
            "ranks": ranks,
        },
        "critic": {
            "class_name": "rsl_rl.models:MLPModel",
            "hidden_dims": list(config.critic_hidden),
            "activation": "elu",
            "obs_normalization": True,
        },
        "obs_groups": {"actor": list(SEEN), "critic": ["sights", "anchors", "critic"]},
        "num_steps_per_env": config.steps_per_iteration,
        "multi_gpu": others,
        "torch_compile_mode": None,
    }
    env = SimpleNamespace(num_actions=network.config.num_actions, num_envs=first.batch_size[0])
    with open(os.devnull, "w") as quiet, redirect_stdout(quiet):
        ppo = PPO.construct_algorithm(first, env, cfg, "cpu")
    assert isinstance(ppo, AmpPPO)
    return ppo


def network_of(ppo: AmpPPO) -> DecisionNetwork:
    """The network that PPO trains: a copy of the one that it was built with."""
    actor = ppo.actor
    assert isinstance(actor, TeacherActor)
    return actor.network
