"""What only the critic of the motor prior's training sees: the load, its target, the phase of the work."""

from __future__ import annotations

import torch
from torch import Tensor

from hv_policy.decision.view import Phase
from hv_policy.motor.prior import MotorStep
from hv_policy.motor.symmetry import POLAR, Reflection
from hv_sim.observations import Heading
from hv_sim.physics import PhysicsState

CRITIC_EXTRA = (
    Reflection()
    .swapped(3, POLAR)  # object, its velocity, its target
    .signs(1.0, 1.0, 1.0, 1.0)  # size and mass
    .signs(*POLAR)  # velocity of the pelvis
    .signs(*[1.0] * (len(Phase) + 1))
)
"""What only the critic sees, and how it looks in a mirror."""


def critic_sight(
    state: PhysicsState, heading: Heading, step: MotorStep, load: dict[str, Tensor], time: Tensor
) -> Tensor:
    """(N, len(CRITIC_EXTRA)).

    Args:
        state: of the bodies.
        heading: the robots' frames.
        step: of the base controller, which says who is seen in a mirror.
        load: `object`, `velocity`, `target` (N, 3), world frame; `half` (N, 3), `mass` (N,), `phase` (N,) int64, and
            `present` (N,) bool: rows without a load are zero.
        time: (N,) share of the episode that has passed.
    """
    phase = torch.nn.functional.one_hot(load["phase"], len(Phase)).float()
    seen = [heading.relative(load["object"]), heading.rotate(load["velocity"]), heading.relative(load["target"])]
    seen += [load["half"], load["mass"][:, None]]
    present = load["present"][:, None]
    root = heading.rotate(state.link_lin_vel_w[:, 0])
    extra = torch.cat([*(x * present for x in seen), root, phase * present, time[:, None]], -1)
    return CRITIC_EXTRA.where(step.mirrored, extra)
