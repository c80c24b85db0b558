"""Practice for the motor prior in the rooms of a benchmark: the teachers say what to do there, as they will later.

On an empty floor (`hv_teachers.motor_env`) a robot never meets a table's edge, a chair's legs or a thing that slipped
out of its hands; most falls in rooms begin there. The teachers' sight may be wrong here, as a student's is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import torch
from torch import Tensor

from hv_policy.decision.network import DecisionNetwork
from hv_policy.decision.view import Phase
from hv_policy.motor.prior import MotorPrior, MotorStep
from hv_sim.task import Task
from hv_teachers.motor_critic import critic_sight
from hv_teachers.motor_rewards import RewardConfig, motor_reward
from hv_teachers.sight_noise import SightNoiseConfig
from hv_teachers.teacher_env import TeacherEnv, TeacherEnvConfig


@dataclass(frozen=True)
class RoomsConfig:
    """How many rooms, and what is practised in them."""

    num_envs: int = 0
    tasks: str = "seen"
    """Suites, tasks or files, separated by commas."""
    reward: RewardConfig = field(default_factory=RewardConfig)
    drop_penalty: float = 5.0
    """Taken off the reward when an object slips out of the hands; the teachers fetch it again."""
    noise: SightNoiseConfig = field(default_factory=lambda: SightNoiseConfig(near_m=0.04, per_m=0.05))
    num_threads: int = 0


class MotorRooms:
    """As `hv_teachers.motor_env.MotorEnv`: `step(residual)` -> rewards, ends; an episode is a task of a suite.

    Args:
        prior: whose residual is learned.
        network: a teacher's, who plays all sub-tasks.
        tasks: one for each room.
        config: what is practised.
        seed: of the episodes.
    """

    def __init__(
        self, prior: MotorPrior, network: DecisionNetwork, tasks: Sequence[Task], config: RoomsConfig, seed: int
    ) -> None:
        self.prior, self.network, self.config = prior, network, config
        self.num_envs = n = len(tasks)
        settings = TeacherEnvConfig(num_envs=n, num_threads=config.num_threads, noise=config.noise)
        self.env = TeacherEnv(tasks, settings, network.config, prior, seed)
        self.has_load = torch.ones(n, dtype=torch.bool)
        self.dropped = torch.zeros(n, dtype=torch.bool)
        self.start_pos, self._begun = torch.zeros(n, 3), torch.full((n,), -1)
        self._rows = torch.arange(n)
        self._look()

    @property
    def phase(self) -> Tensor:
        """(N,) of the teachers' memory."""
        return self.env.senses.memory.phase

    @property
    def goal_pos(self) -> Tensor:
        """(N, 3) of the sub-task in force."""
        return self.env.world.goal_pos_w[self._rows, self.env.world.subtask_index]

    @torch.no_grad()
    def step(self, residual: Tensor) -> tuple[Tensor, Tensor, Tensor, dict[str, Tensor]]:
        """As `MotorEnv.step`."""
        previous, world = self.motor_step, self.env.world
        targets = self.prior.apply_residual(previous, residual)
        target, holding = self.object_target, self.holding()
        outcome = self.env.move(self._action, targets)
        terms = motor_reward(world.state, world.heading, previous, residual, self, target, self.config.reward)
        self.env.renew(outcome)
        self._look()
        self.dropped = holding & self.env.senses.lost & ~outcome.failed & ~outcome.timed_out
        terms["placed"] = self.config.reward.placed * outcome.accepted.float()
        terms["dropped"] = -self.config.drop_penalty * self.dropped
        reward = torch.nan_to_num(torch.stack(list(terms.values())).sum(0))
        return reward, outcome.failed, outcome.timed_out, terms

    def object_pos(self) -> Tensor:
        """(N, 3) where the object of the sub-task is, world frame, m."""
        return self.env.world.state.object_pos_w[self._rows, self.env.world.object_index]

    def holding(self) -> Tensor:
        """(N,) bool: it should be in the hands."""
        return (self.phase >= Phase.LIFT) & (self.phase <= Phase.LOWER)

    def _look(self) -> None:
        env, world = self.env, self.env.world
        self._seen = env.look()
        env.label(self._seen)  # the planner says where the object should be now
        self.object_target = env.planner.object_target.clone()
        self._action = env.decide(self.network, self._seen).action
        new = (world.episode_step == 0) | (self._begun != world.subtask_index)
        self.start_pos = torch.where(new[:, None], self.object_pos(), self.start_pos)
        self._begun = world.subtask_index.clone()
        self.motor_step: MotorStep = self.prior.advance(self._seen.proprioception, env.units.from_units(self._action))
        load = {
            "object": self.object_pos(),
            "velocity": world.state.object_lin_vel_w[self._rows, world.object_index],
            "target": self.object_target,
            "half": self._seen.half_extents,
            "mass": torch.zeros(self.num_envs),
            "phase": self.phase,
            "present": self.has_load,
        }
        time = world.episode_step / env.max_steps
        self.features = self.motor_step.features
        self.critic_extra = critic_sight(world.state, world.heading, self.motor_step, load, time)
