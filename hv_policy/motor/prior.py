"""pi_m(proprioception, intent) -> 28 servo targets: reference pose + balance through the legs + a learned residual."""

from __future__ import annotations

import copy
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import torch
from safetensors import safe_open
from torch import Tensor, nn

from hv_policy.motor import embodiment as body
from hv_policy.motor.balance import BalanceConfig, arm_torques, estimate_load, leg_torques
from hv_policy.motor.gait import GaitConfig
from hv_policy.motor.get_up import GettingUp, GetUpNetwork
from hv_policy.motor.normalized_network import NormalizedNetwork
from hv_policy.motor.proprioception import PROPRIOCEPTION_DIM, BodyState, read_proprioception
from hv_policy.motor.reference import Reference, ReferenceState, advance_reference, start_reference
from hv_policy.motor.symmetry import JOINTS, POLAR, Reflection
from hv_policy.network_file import load_network, save_network

FEATURE_DIM = PROPRIOCEPTION_DIM + 3 + 2 + 6 + 1 + 2 + 3 + 2 + 3 + 3 + 6 + 2 + 1 + 28 + 28
_SIDES = [1, 0]
FEATURES = (
    Reflection()
    .proprioception()
    .signs(1.0, -1.0, -1.0)  # velocity
    .signs(1.0, 1.0)  # posture
    .swapped(_SIDES, POLAR)  # hands
    .signs(1.0)  # squeeze
    .signs(1.0, 1.0)  # clock
    .signs(*POLAR)  # pelvis
    .swapped(_SIDES, (1.0,))  # stance
    .signs(*POLAR)  # lean
    .signs(-1.0, -1.0, 1.0)  # yaw and gaze
    .swapped(_SIDES, POLAR)  # feet
    .signs(1.0, -1.0)  # centre of mass
    .signs(1.0)  # load
    .joints()  # velocity of the reference
    .joints()  # last residual
)
"""How the features of a robot look in a mirror."""


@dataclass(frozen=True)
class MotorPriorConfig:
    """Sizes of the residual network and the parameters of what it corrects."""

    hidden: tuple[int, ...] = (256, 256)
    leg_residual_rad: float = 0.3
    trunk_residual_rad: float = 0.15
    arm_residual_rad: float = 0.05
    """How far one unit of the network's output moves a servo target. The arms are left to their inverse kinematics:
    with .3 rad on every joint the hands lost their millimetres and the boxes with them."""
    get_up_hidden: tuple[int, ...] = (256, 256)
    """Widths of the network that gets up from the floor (`hv_policy.motor.get_up`); none: it stays there."""
    gait: GaitConfig = field(default_factory=GaitConfig)
    balance: BalanceConfig = field(default_factory=BalanceConfig)


class ResidualNetwork(NormalizedNetwork):
    """Features (N, FEATURE_DIM) -> 28 residuals in units of the configuration's."""

    def __init__(self, hidden: tuple[int, ...]) -> None:
        super().__init__(FEATURE_DIM, hidden)


@dataclass
class MotorStep:
    """One step of the controller before its residual: what the network sees and what it corrects."""

    features: Tensor  # (N, FEATURE_DIM), of the reflected robot where `mirrored`
    mirrored: Tensor  # (N,) bool: the left foot swings, or did last
    targets: Tensor  # (N, 28) servo targets without the residual, rad
    reference: Reference
    state: BodyState


class MotorPrior(nn.Module):
    """A whole-body controller that goes where the intent says, bends, reaches, squeezes and balances.

    It needs proprioception (N, 223) and intent (N, 14) only and keeps the state of its reference, one row per robot.
    Call `reset(ids)` when robots start anew; the next call then begins from the pose it is shown.
    """

    def __init__(self, config: MotorPriorConfig | None = None) -> None:
        super().__init__()
        self.config = config or MotorPriorConfig()
        self.residual = ResidualNetwork(self.config.hidden)
        trunk, arm, leg = self.config.trunk_residual_rad, self.config.arm_residual_rad, self.config.leg_residual_rad
        self._residual_scale = torch.tensor([trunk] * 3 + [0.0] * 3 + [arm] * 8 + [leg] * 14)
        self.get_up = GetUpNetwork(self.config.get_up_hidden) if self.config.get_up_hidden else None
        self.getting_up = None if self.get_up is None else GettingUp(self.get_up)
        self.memory: ReferenceState | None = None
        self._last_residual: Tensor | None = None
        self._fresh: Tensor | None = None

    def reset(self, ids: Tensor | None = None) -> None:
        """Forgets the reference of robots `ids` (default: all, and with them the batch size)."""
        if self.getting_up is not None:
            self.getting_up.reset(ids)
        if ids is None or self._fresh is None:
            self.memory = self._last_residual = self._fresh = None
        else:
            self._fresh[ids] = True

    def copied(self) -> MotorPrior:
        """One in this one's state, with the same weights; what it does leaves this one alone."""
        other = copy.copy(self)
        other.memory = copy.deepcopy(self.memory)
        other._last_residual, other._fresh = copy.deepcopy((self._last_residual, self._fresh))
        other.getting_up = None if self.getting_up is None else self.getting_up.copy()
        return other

    @torch.no_grad()
    def forward(self, proprioception: Tensor, intent: Tensor) -> Tensor:
        """(N, 223), (N, 14) -> (N, 28) servo targets in rad, on the device of the intent.

        Whoever lies gets up first, whatever the intent is.
        """
        step = self.advance(proprioception, intent)
        residual = self.residual(step.features.to(self.residual.mean.device))
        targets = self.apply_residual(step, residual.cpu())
        if self.getting_up is not None:
            rows, rising = self.getting_up(proprioception.cpu())
            targets[rows] = rising
            assert self._fresh is not None
            self._fresh[rows] = True  # the reference begins from where it will stand
        return targets.to(intent.device)

    @torch.no_grad()
    def advance(self, proprioception: Tensor, intent: Tensor) -> MotorStep:
        """Moves the reference on by one control step, on the CPU; `apply_residual` must follow."""
        proprioception, intent = proprioception.cpu(), intent.cpu()
        n = len(intent)
        state = read_proprioception(proprioception)
        if self.memory is None or self._fresh is None or len(self._fresh) != n:
            self.memory = start_reference(state, intent, self.config.gait)
            self._last_residual = intent.new_zeros(n, 28)
            self._fresh = torch.zeros(n, dtype=torch.bool)
        elif self._fresh.any():
            ids = self._fresh.nonzero()[:, 0]
            rows = state.rows(ids)
            self.memory.assign(ids, start_reference(rows, intent[ids], self.config.gait))
            self._last_residual[ids] = 0.0  # type: ignore[index]
            self._fresh[ids] = False
        reference = advance_reference(self.memory, state, intent, self.config.gait)
        load = estimate_load(state, self.memory, self.config.balance)
        legs = leg_torques(state, reference, load, self.config.balance).flatten(1)
        arms = arm_torques(state, self.memory.squeeze, load, self.config.balance).flatten(1)
        torque = torch.cat([arms.new_zeros(n, 6), arms, legs], -1)
        limit = body.TORQUE_LIMIT.to(torque)
        offset = torque.clamp(-limit, limit) / body.KP.to(torque)
        targets = reference.joints + body.DAMPING_TIME_S * reference.joint_velocity + offset
        mirrored = self.memory.swing == 1
        features = FEATURES.where(mirrored, self._features(proprioception, state, reference))
        return MotorStep(features, mirrored, targets, reference, state)

    def apply_residual(self, step: MotorStep, residual: Tensor) -> Tensor:
        """(N, 28) what the network says of a step's features -> (N, 28) servo targets in rad."""
        residual = JOINTS.where(step.mirrored, residual.clamp(-3.0, 3.0))
        self._last_residual = residual
        targets = step.targets + self._residual_scale.to(residual) * residual
        low, high = body.JOINT_LOW.to(targets), body.JOINT_HIGH.to(targets)
        targets = targets.clamp(low - 0.5, high + 0.5)
        assert self.memory is not None
        self.memory.arm_targets = targets[:, 6:14].unflatten(-1, (2, 4)).contiguous()
        return targets

    def _features(self, proprioception: Tensor, state: BodyState, reference: Reference) -> Tensor:
        memory = self.memory
        assert memory is not None
        assert self._last_residual is not None
        pelvis = state.pos[:, body.PELVIS]
        hand_error = (memory.hands - state.pos[:, body.HANDS]).flatten(1)
        feet = (reference.foot_target - state.pos[:, body.FEET]).flatten(1)
        angle = 2 * torch.pi * memory.phase
        clock = torch.stack([angle.sin() * memory.moving, angle.cos() * memory.moving], -1)
        lean = reference.pelvis_rot.mT @ state.rot[:, body.PELVIS]
        parts = [
            proprioception,
            memory.velocity,
            memory.posture,
            hand_error,
            memory.squeeze[:, None],
            clock,
            reference.pelvis_pos - pelvis,
            reference.stance,
            lean[:, 2],
            torch.stack([memory.yaw, memory.gaze[:, 0], memory.gaze[:, 1]], -1),
            feet,
            memory.com,
            memory.load[:, None] / 50.0,
            reference.joint_velocity,
            self._last_residual,
        ]
        return torch.cat(parts, -1)


_KIND = "hv_motor_prior/1"


def save_motor_prior(prior: MotorPrior, path: Path, metadata: dict[str, str] | None = None) -> None:
    """Weights and configuration as one safetensors file, written whole or not at all."""
    save_network(prior, prior.config, path, _KIND, metadata)


def motor_prior_notes(path: Path) -> dict[str, str]:
    """How the networks in a file were trained, as `save_motor_prior` was told to write it down."""
    with safe_open(str(path), framework="pt") as file:
        notes = file.metadata()
    return {name: value for name, value in notes.items() if name not in ("format", "config")}


SHIPPED_MOTOR_PRIOR = Path(__file__).resolve().parents[1] / "weights" / "motor_prior.safetensors"


def load_shipped_motor_prior() -> MotorPrior:
    """The motor prior that comes with the package."""
    return load_motor_prior(SHIPPED_MOTOR_PRIOR)


def load_motor_prior(path: Path) -> MotorPrior:
    """Reads what `save_motor_prior` wrote.

    Raises:
        ValueError: the file is not a motor prior, or its weights do not fit its configuration.
    """
    return load_network(path, _KIND, _configured, MotorPrior)


def _configured(values: dict[str, Any]) -> MotorPriorConfig:
    return MotorPriorConfig(
        hidden=tuple(values["hidden"]),
        leg_residual_rad=values["leg_residual_rad"],
        trunk_residual_rad=values["trunk_residual_rad"],
        arm_residual_rad=values["arm_residual_rad"],
        get_up_hidden=tuple(values.get("get_up_hidden", ())),  # younger than the first files
        gait=GaitConfig(**{**values["gait"], "max_acceleration": tuple(values["gait"]["max_acceleration"])}),
        balance=BalanceConfig(**values["balance"]),
    )
