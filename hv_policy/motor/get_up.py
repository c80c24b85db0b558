"""Getting up: brings who lies on the floor back onto its feet, from where the motor prior goes on.

A network of its own, from proprioception to servo targets: nothing of the reference that the motor prior follows, nor
of its balance, holds for a body that lies. It sees every robot reflected so that it lies on its right side, as far as
it lies on one (`hv_policy.motor.symmetry`).
"""

from __future__ import annotations

from collections.abc import Mapping

import torch
from torch import Tensor

from hv_policy.motor import embodiment as body
from hv_policy.motor.normalized_network import NormalizedNetwork
from hv_policy.motor.proprioception import PROPRIOCEPTION_DIM, BodyState, read_proprioception
from hv_policy.motor.symmetry import JOINTS, Reflection

GET_UP_DIM = PROPRIOCEPTION_DIM + 28
"""What the network sees: proprioception, and what it said last."""
SEEN = Reflection().proprioception().joints()
STANDING = torch.zeros(28)
"""(28,) rad, the pose that its answers are counted from: `hv_sim.humanoid.standing_qpos`."""
STANDING[body.ARM_JOINTS[0]] = torch.tensor([-0.12, 0.05, 0.0, -0.35])
STANDING[body.ARM_JOINTS[1]] = torch.tensor([0.12, 0.05, 0.0, -0.35])
for _leg in body.LEG_JOINTS:
    STANDING[_leg[1]], STANDING[_leg[3]], STANDING[_leg[5]] = -0.2, 0.4, -0.2
BEYOND_LIMIT_RAD = 0.3
MOST = 3.0
LIES_UPRIGHT, LIES_HEAD_M, LIES_STEPS = 0.5, 0.6, 10
"""Who lies: the pelvis upright by less than that (cosine), the head lower, for so many control steps."""
STANDS_HEIGHT_M, STANDS_UPRIGHT, STANDS_SPEED_M_S, STANDS_FOOT_M, STANDS_STEPS = 0.78, 0.93, 0.35, 0.13, 15
"""Who stands: pelvis and its uprightness above that, speed and feet below, for so many control steps."""


class GetUpNetwork(NormalizedNetwork):
    """(N, GET_UP_DIM) -> (N, 28) rad from `STANDING`."""

    def __init__(self, hidden: tuple[int, ...]) -> None:
        super().__init__(GET_UP_DIM, hidden)


def seen_lying(proprioception: Tensor, last: Tensor, mirrored: Tensor) -> Tensor:
    """(N, GET_UP_DIM) what the network sees of proprioception (N, 223) and its last answers (N, 28)."""
    return SEEN.where(mirrored, torch.cat([proprioception, last], -1))


def is_on_left_side(state: BodyState) -> Tensor:
    """(N,) bool: the left side of the pelvis is lower than the right one; who is so is seen in a mirror."""
    return state.rot[:, body.PELVIS, 2, 1] < 0


def targets_of(answer: Tensor) -> Tensor:
    """(N, 28) servo targets in rad of answers (N, 28), reflected back."""
    low, high = body.JOINT_LOW.to(answer) - BEYOND_LIMIT_RAD, body.JOINT_HIGH.to(answer) + BEYOND_LIMIT_RAD
    return (STANDING.to(answer) + answer).clamp(low, high)


def is_up(state: BodyState) -> Tensor:
    """(N,) bool: high and upright, at rest or not."""
    pelvis = state.pos[:, body.PELVIS, 2], state.rot[:, body.PELVIS, 2, 2]
    return (pelvis[0] > STANDS_HEIGHT_M) & (pelvis[1] > STANDS_UPRIGHT)


def stands(state: BodyState) -> Tensor:
    """(N,) bool: upright on both feet, and at rest."""
    rests = state.lin_vel[:, body.PELVIS].norm(dim=-1) < STANDS_SPEED_M_S
    return is_up(state) & rests & (state.pos[:, body.FEET, 2] < STANDS_FOOT_M).all(1)


class GettingUp:
    """Which of N robots are getting up, and what they do.

    Args:
        network: says how.
    """

    def __init__(self, network: GetUpNetwork) -> None:
        self.network = network
        self.active = torch.zeros(0, dtype=torch.bool)
        """(N,) it is getting up."""
        self.steps = torch.zeros(0, dtype=torch.long)
        """(N,) control steps for which it has lain, or, while it is getting up, stood."""
        self.last = torch.zeros(0, 28)
        """(N, 28) the network's last answers, reflected back."""

    def reset(self, ids: Tensor | None = None) -> None:
        """Robots `ids` (default: all, and with them their number) start anew, standing."""
        if ids is None:
            self.active, self.steps, self.last = self.active[:0], self.steps[:0], self.last[:0]
        elif len(self.active):
            self.active[ids], self.steps[ids], self.last[ids] = False, 0, 0.0

    def state(self) -> dict[str, Tensor]:
        """All that decides how it goes on, for `restore`."""
        return {"active": self.active.clone(), "steps": self.steps.clone(), "last": self.last.clone()}

    def restore(self, state: Mapping[str, Tensor]) -> None:
        """Goes on from what `state` gave."""
        self.active, self.steps, self.last = (state[name].clone() for name in ("active", "steps", "last"))

    def copy(self) -> GettingUp:
        """Another one in this one's state, with the same network."""
        other = GettingUp(self.network)
        other.restore(self.state())
        return other

    def __call__(self, proprioception: Tensor) -> tuple[Tensor, Tensor]:
        """From (N, 223), for this control step: who is getting up, as rows (n,), and their targets (n, 28) in rad."""
        n = len(proprioception)
        if len(self.active) != n:
            self.active, self.steps = torch.zeros(n, dtype=torch.bool), torch.zeros(n, dtype=torch.long)
            self.last = proprioception.new_zeros(n, 28)
        state = read_proprioception(proprioception)
        lies = state.rot[:, body.PELVIS, 2, 2] < LIES_UPRIGHT
        lies &= state.pos[:, body.HEAD, 2] < LIES_HEAD_M
        self.steps = torch.where(torch.where(self.active, stands(state), lies), self.steps + 1, 0)
        changes = self.steps >= torch.where(self.active, STANDS_STEPS, LIES_STEPS)
        self.active = self.active ^ changes
        self.steps[changes] = 0
        self.last[changes] = 0.0
        rows = self.active.nonzero()[:, 0]
        if not len(rows):
            return rows, self.last[rows]
        mirrored = is_on_left_side(state.rows(rows))
        seen = seen_lying(proprioception[rows], self.last[rows], mirrored)
        answer = self.network(seen.to(self.network.mean.device)).to(proprioception.device)
        answer = JOINTS.where(mirrored, answer.clamp(-MOST, MOST))
        self.last[rows] = answer
        return rows, targets_of(answer)
