"""Reads the 223 numbers of proprioception back into link poses and velocities."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from hv_policy.motor import embodiment as body

PROPRIOCEPTION_DIM = 223
_ROTATIONS, _ANGULAR = 1 + 42, 1 + 42 + 90 + 45


@dataclass
class BodyState:
    """Link kinematics in the heading frame, origin on the floor under the pelvis; metres, m/s, rad/s."""

    pos: Tensor  # (N, 15, 3)
    rot: Tensor  # (N, 15, 3, 3)
    lin_vel: Tensor  # (N, 15, 3)
    ang_vel: Tensor  # (N, 15, 3)

    def rows(self, ids: Tensor | slice) -> BodyState:
        """Of robots `ids` alone."""
        return BodyState(self.pos[ids], self.rot[ids], self.lin_vel[ids], self.ang_vel[ids])

    def to(self, like: Tensor) -> BodyState:
        """On the device of `like`, with its precision."""
        return BodyState(*(value.to(like) for value in (self.pos, self.rot, self.lin_vel, self.ang_vel)))

    @property
    def com(self) -> Tensor:
        """(N, 3) centre of mass of the robot."""
        mass, offset = body.BODY_MASS_KG.to(self.pos), body.BODY_COM_M.to(self.pos)
        centres = self.pos + (self.rot @ offset[..., None])[..., 0]
        return (centres * mass[:, None]).sum(1) / mass.sum()

    @property
    def heading_rate(self) -> Tensor:
        """(N,) rad/s: rate of the yaw of the pelvis' x axis (not its angular velocity's z component when it is
        pitched)."""
        return _heading_rate(self.rot[:, body.PELVIS, :, 0], self.ang_vel[:, body.PELVIS])


def read_heading_rate(proprioception: Tensor) -> Tensor:
    """(N,) `BodyState.heading_rate` of (N, 223), the rest left unread."""
    forward = _ROTATIONS + 6 * body.PELVIS
    turning = _ANGULAR + 3 * body.PELVIS
    return _heading_rate(proprioception[:, forward : forward + 3], proprioception[:, turning : turning + 3])


def _heading_rate(forward: Tensor, ang_vel: Tensor) -> Tensor:
    return ang_vel[:, 2] - ang_vel[:, 0] * forward[:, 2] / forward[:, 0].clamp(min=0.2)


def read_proprioception(proprioception: Tensor) -> BodyState:
    """(N, 223): root height 1, link positions 14 x 3, rotations 15 x 6, linear and angular velocities 15 x 3 each.

    Raises:
        ValueError: the last dimension is not 223.
    """
    if proprioception.shape[-1] != PROPRIOCEPTION_DIM:
        raise ValueError(f"proprioception: last dimension is {proprioception.shape[-1]}; valid: {PROPRIOCEPTION_DIM}")
    height, links, six, lin, ang = proprioception.split([1, 42, 90, 45, 45], -1)
    pos = torch.cat(
        [torch.zeros_like(height), torch.zeros_like(height), torch.zeros_like(height), links], -1
    ).unflatten(-1, (15, 3))
    pos = torch.cat([pos[..., :2], pos[..., 2:] + height[:, None]], -1)
    x, y = six.unflatten(-1, (15, 2, 3)).unbind(-2)
    rot = torch.stack([x, y, torch.linalg.cross(x, y)], -1)
    return BodyState(pos, rot, lin.unflatten(-1, (15, 3)), ang.unflatten(-1, (15, 3)))
