"""Practice in getting up: robots that lie on an empty floor in any way, some of them held up a little at first.

What pulls them up (compare Huang et al., "Learning Humanoid Standing-up Control", 2025, section IV) becomes less as
they learn to get up with it; a quarter of them never has any, and only those count as having got up.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from hv_policy.motor import embodiment as body
from hv_policy.motor.get_up import (
    MOST,
    STANDING,
    STANDS_FOOT_M,
    STANDS_STEPS,
    is_on_left_side,
    is_up,
    seen_lying,
    targets_of,
)
from hv_policy.motor.proprioception import BodyState, read_proprioception
from hv_policy.motor.symmetry import JOINTS
from hv_sim.humanoid import standing_qpos
from hv_sim.mujoco_physics import MujocoPhysics
from hv_sim.observations import Heading, proprioception
from hv_teachers.motor_scenes import compile_ground

GRAVITY_M_S2 = 9.81
SETTLE_STEPS, NEW_POSE_STEPS = 60, 20
LOWEST_START_M = 0.6
"""Robots whose pelvis is lower than that after they were dropped lie."""
FREE_EVERY = 4
HEAD_M, PELVIS_M = 1.25, 0.84
"""Heights of who stands."""


@dataclass(frozen=True)
class GetUpRewards:
    """Weights a control step."""

    head: float = 0.6
    pelvis: float = 0.6
    upright: float = 0.3
    feet: float = 0.5
    """Flat on the floor, below the centre of mass; the more, the higher the pelvis."""
    stand: float = 1.5
    """And in the pose and at the rest of who stands."""
    rate: float = 0.02
    joint_speed: float = 0.0015
    speed: float = 0.02
    """Of the pelvis, above 1.5 m/s."""


@dataclass(frozen=True)
class GetUpConfig:
    """How it is practised."""

    num_envs: int = 512
    episode_s: float = 6.0
    lying: int = 1024
    """Ways to lie that episodes begin with."""
    pull_share: float = 0.8
    """Of the weight, at most, at the beginning; each robot is pulled by a random part of it."""
    pull_decay: float = 0.93
    """By so much less each time that `enough` of those pulled have stood up."""
    enough: float = 0.6
    counted: int = 1000
    """Episodes after which that is looked at."""
    num_threads: int = 0
    rewards: GetUpRewards = GetUpRewards()


def lying_poses(rng: np.random.Generator, count: int, num_threads: int) -> tuple[np.ndarray, np.ndarray]:
    """(n, 35) and (n, 34) positions and velocities, n <= `count`, of robots that were dropped in random poses and moved
    their limbs on the floor."""
    physics = MujocoPhysics([compile_ground(rng, None, randomize=False)] * count, num_threads=num_threads)
    low, high = body.JOINT_LOW.numpy(), body.JOINT_HIGH.numpy()
    dropped = []
    for _ in range(count):
        pose, turned = standing_qpos((0.0, 0.0), 0.0), rng.normal(size=4)
        pose[2], pose[3:7] = rng.uniform(0.7, 1.0), turned / np.linalg.norm(turned)
        pose[7:] = np.clip(STANDING.numpy() + rng.normal(0, 0.5, 28), low, high)
        dropped.append(pose)
    physics.reset(np.arange(count), dropped)
    targets = torch.tensor(np.stack(dropped)[:, 7:], dtype=torch.float32)
    for step in range(SETTLE_STEPS):
        if step % NEW_POSE_STEPS == NEW_POSE_STEPS // 2:
            moved = STANDING + torch.tensor(rng.normal(0, 0.5, (count, 28)), dtype=torch.float32)
            targets = moved.clamp(body.JOINT_LOW, body.JOINT_HIGH)
        physics.step(targets)
    found = [physics.data(i) for i in range(count)]
    lie = [d for d in found if np.isfinite(d.qpos).all() and d.qpos[2] < LOWEST_START_M]
    return np.stack([d.qpos for d in lie]), np.stack([d.qvel for d in lie])


class GetUpPractice:
    """`hv_teachers.motor_practice.Practice` of getting up; an episode ends when the robot stands, or is over."""

    def __init__(self, config: GetUpConfig, seed: int, pull_share: float | None = None) -> None:
        self.config = config
        self.num_envs = n = config.num_envs
        self.rng = np.random.default_rng(seed)
        self.physics = MujocoPhysics([compile_ground(self.rng, None) for _ in range(n)], num_threads=config.num_threads)
        self.lying = lying_poses(self.rng, config.lying, config.num_threads)
        self.has_load = self.dropped = torch.zeros(n, dtype=torch.bool)
        self.pull_share = config.pull_share if pull_share is None else pull_share
        self.pull_n = torch.zeros(n)
        """(N,) what pulls each robot's chest upward."""
        self.free = torch.arange(n) % FREE_EVERY == 0
        self.max_steps = int(config.episode_s * 30)
        self.last = torch.zeros(n, 28)
        self.stood = torch.zeros(n, dtype=torch.long)
        self.ended = {"free": [0, 0], "pulled": [0, 0]}
        """Episodes that ended, and how many of them on both feet."""
        self.episode_step = torch.zeros(n, dtype=torch.long)
        self._reset(torch.arange(n))
        self.episode_step = torch.as_tensor(self.rng.integers(0, self.max_steps, n))
        self._look()

    def step(self, residual: Tensor) -> tuple[Tensor, Tensor, Tensor, dict[str, Tensor]]:
        """One control step with the network's answers (N, 28), see `Practice`."""
        answer = JOINTS.where(self._mirrored, residual.clamp(-MOST, MOST))
        before, self.last = self.last, answer
        pulled = self.pull_n.nonzero()[:, 0]
        impulse = np.zeros((len(pulled), 3))
        impulse[:, 2] = self.pull_n[pulled].numpy() / 30.0
        self.physics.apply_impulse(pulled.numpy(), body.TORSO, impulse)
        self.physics.step(targets_of(answer))
        self.episode_step += 1
        state = self.physics.state()
        seen = read_proprioception(proprioception(state, Heading.of(state)))
        terms = get_up_rewards(seen, state.joint_pos, state.joint_vel, answer - before, self.config.rewards)
        reward = torch.nan_to_num(torch.stack(list(terms.values())).sum(0))
        self.stood = torch.where(is_up(seen), self.stood + 1, 0)
        up = self.stood >= STANDS_STEPS
        failed = ~torch.isfinite(seen.pos[:, 0, 2])
        timed_out = ((self.episode_step >= self.max_steps) | up) & ~failed
        self._count(failed | timed_out, up)
        self._reset((failed | timed_out).nonzero()[:, 0])
        self._look()
        return reward, failed, timed_out, terms

    def shares(self) -> dict[str, float]:
        """How many of the episodes since the last call ended on both feet, of those not pulled and those pulled."""
        shown = {f"{name}_up": up / max(1, ended) for name, (ended, up) in self.ended.items()}
        return shown | {"pull_share": self.pull_share}

    def _count(self, ended: Tensor, up: Tensor) -> None:
        for name, chosen in (("free", self.free), ("pulled", ~self.free)):
            self.ended[name][0] += int((ended & chosen).sum())
            self.ended[name][1] += int((up & chosen).sum())
        count, stood = self.ended["pulled"]
        if count >= self.config.counted:
            if stood / count >= self.config.enough:
                self.pull_share = max(0.0, self.pull_share * self.config.pull_decay - 0.005)
            self.ended = {"free": [0, 0], "pulled": [0, 0]}

    def _reset(self, ids: Tensor) -> None:
        if not len(ids):
            return
        rows = self.rng.integers(len(self.lying[0]), size=len(ids))
        self.physics.reset(ids.numpy(), list(self.lying[0][rows]), list(self.lying[1][rows]))
        self.last[ids], self.stood[ids], self.episode_step[ids] = 0.0, 0, 0
        weight = body.TOTAL_MASS_KG * GRAVITY_M_S2
        pull = torch.tensor(self.rng.uniform(0, self.pull_share, len(ids)), dtype=torch.float32) * weight
        self.pull_n[ids] = torch.where(self.free[ids], torch.zeros_like(pull), pull)

    def _look(self) -> None:
        state = self.physics.state()
        seen = proprioception(state, Heading.of(state))
        self._mirrored = is_on_left_side(read_proprioception(seen))
        self.features = torch.nan_to_num(seen_lying(seen, self.last, self._mirrored)).clamp(-20, 20)
        weight = body.TOTAL_MASS_KG * GRAVITY_M_S2
        self.critic_extra = torch.stack([self.pull_n / weight, self.episode_step / self.max_steps], -1)


def get_up_rewards(
    seen: BodyState, joint_pos: Tensor, joint_vel: Tensor, change: Tensor, weights: GetUpRewards
) -> dict[str, Tensor]:
    """Rewards (N,) of a state of the robots, with joints (N, 28) in rad and rad/s, and answers changed by (N, 28)."""
    pelvis, head = seen.pos[:, body.PELVIS, 2], seen.pos[:, body.HEAD, 2]
    upright = seen.rot[:, body.TORSO, 2, 2]
    feet, soles = seen.pos[:, body.FEET], seen.rot[:, body.FEET][..., 2, 2]
    away = (feet[..., :2].mean(1) - seen.com[:, :2]).norm(dim=-1)
    flat = (feet[..., 2] < STANDS_FOOT_M).float().mean(1) * soles.clamp(min=0).mean(1)
    under = torch.exp(-8 * away.square()) * flat
    high = (pelvis / PELVIS_M).clamp(0, 1)
    pose = torch.exp(-4 * (joint_pos - STANDING).square().mean(1))
    speed = seen.lin_vel[:, body.PELVIS].norm(dim=-1)
    tall = ((pelvis - 0.6) / 0.2).clamp(0, 1) * upright.clamp(min=0)
    return {
        "head": weights.head * (head / HEAD_M).clamp(0, 1),
        "pelvis": weights.pelvis * high,
        "upright": weights.upright * (upright + 1) / 2,
        "feet": weights.feet * under * (0.3 + high),
        "stand": weights.stand * tall * under * pose * torch.exp(-speed),
        "rate": -weights.rate * change.square().mean(1),
        "joint_speed": -weights.joint_speed * joint_vel.square().mean(1).clamp(max=100),
        "speed": -weights.speed * (speed - 1.5).clamp(0, 5),
    }
