"""Rewards of the motor prior: follow the intent, stay close to the reference, keep hold of the load. Each is (N,)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import torch
from torch import Tensor

from hv_policy.decision.view import Phase
from hv_policy.motor import embodiment as body
from hv_policy.motor.prior import MotorPrior, MotorStep
from hv_sim.observations import Heading
from hv_sim.physics import PhysicsState


class Work(Protocol):
    """What is done with a load in N environments, as the rewards see it; world frame, m."""

    prior: MotorPrior
    has_load: Tensor
    """(N,) bool."""

    @property
    def phase(self) -> Tensor:
        """(N,) int64, see `Phase`."""

    @property
    def start_pos(self) -> Tensor:
        """(N, 3) where the load was taken from."""

    @property
    def goal_pos(self) -> Tensor:
        """(N, 3) where it belongs."""

    def holding(self) -> Tensor:
        """(N,) bool: it should be in the hands."""

    def object_pos(self) -> Tensor:
        """(N, 3) where it is."""


@dataclass(frozen=True)
class RewardConfig:
    """Weights; positive ones sum to one while nothing is carried."""

    alive: float = 0.2
    velocity: float = 0.3
    yaw_rate: float = 0.1
    posture: float = 0.15
    orientation: float = 0.1
    hands: float = 0.15
    feet: float = 0.1
    load: float = 0.3
    residual: float = 0.004
    residual_rate: float = 0.004
    joint_speed: float = 2e-4
    placed: float = 3.0
    """Once, for a load that was put down where it belongs."""


def motor_reward(
    state: PhysicsState,
    heading: Heading,
    step: MotorStep,
    residual: Tensor,
    env: Work,
    object_target: Tensor,
    weight: RewardConfig,
) -> dict[str, Tensor]:
    """The weighted terms of one step; `step` holds the reference that was to be reached by it."""
    reference = step.reference
    memory = env.prior.memory
    assert memory is not None
    velocity = heading.rotate(state.link_lin_vel_w[:, 0])[:, :2]
    planar = (velocity - reference.velocity[:, :2]).square().sum(-1)
    turn = state.link_ang_vel_w[:, 0, 2] - reference.velocity[:, 2]
    height = state.link_pos_w[:, 0, 2] - reference.pelvis_pos[:, 2]
    torso = state.link_rot_w[:, body.TORSO]
    pitch = torch.asin((-torso[:, 2, 0]).clamp(-1, 1)) - memory.posture[:, 1].clamp(max=1.5)
    lean = (state.link_rot_w[:, 0, 2, :] - reference.pelvis_rot[:, 2, :]).square().sum(-1)
    origin = heading.origin_w * heading.origin_w.new_tensor([1.0, 1.0, 0.0])
    hands = heading.rotate(state.link_pos_w[:, body.HANDS] - origin[:, None])
    hand_error = (hands - memory.hands).norm(dim=-1)
    # the feet are judged where the reference, one step old, wanted them; the root has moved on since
    moved = reference.velocity[:, :2] * body.CONTROL_DT_S
    feet = heading.rotate(state.link_pos_w[:, body.FEET] - origin[:, None])
    wanted = torch.cat([reference.foot_target[..., :2] - moved[:, None], reference.foot_target[..., 2:]], -1)
    foot_error = (feet - wanted).square().sum((-1, -2))
    holding = env.holding()
    load_error = (env.object_pos() - object_target).norm(dim=-1)
    # before it is lifted a load is left where it is, after it was let go it is left at its goal
    rest = torch.where((env.phase < Phase.LIFT)[:, None], env.start_pos, env.goal_pos)
    disturbed = (env.object_pos() - rest).norm(dim=-1)
    load = torch.where(holding, torch.exp(-6.0 * load_error), 0.9 * torch.exp(-6.0 * disturbed))
    change = residual - step.features[:, -28:]
    return {
        "alive": torch.full_like(turn, weight.alive),
        "velocity": weight.velocity * torch.exp(-6.0 * planar),
        "yaw_rate": weight.yaw_rate * torch.exp(-1.5 * turn.square()),
        "posture": weight.posture * 0.5 * (torch.exp(-200.0 * height.square()) + torch.exp(-10.0 * pitch.square())),
        "orientation": weight.orientation * torch.exp(-12.0 * lean - 8.0 * memory.yaw.square()),
        "hands": weight.hands * torch.exp(-20.0 * hand_error).mean(-1),
        "feet": weight.feet * torch.exp(-25.0 * foot_error),
        "load": weight.load * load * env.has_load,
        "residual": -weight.residual * residual.square().sum(-1),
        "residual_rate": -weight.residual_rate * change.square().sum(-1),
        "joint_speed": -weight.joint_speed * state.joint_vel.square().sum(-1),
    }
