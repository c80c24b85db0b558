"""The outline of an object on the floor, as five numbers that are the same from whichever side it will be taken.

A box may be taken from four sides; which one is for the robot to choose (`hv_policy.belief.stands`), and a picture does
not tell. How it is turned up to a quarter turn, and how wide it is in each direction, a picture does tell.
"""

from __future__ import annotations

import torch
from torch import Tensor

OUTLINE_DIM = 5
_FOURFOLD, _SPREAD = slice(0, 2), slice(2, 5)
_SPREAD_UNIT_M2 = 0.05


def outline_of(rotation_6d: Tensor, half_extents_m: Tensor) -> Tensor:
    """(N, 5): cosine and sine of four times the yaw of the most level axis, and the symmetric matrix
    R diag(half_extents^2) R^T of the level directions (xx, xy, yy) in units of 0.05 m^2.

    Args:
        rotation_6d: (N, 6) first two columns of the rotation matrix, one after the other.
        half_extents_m: (N, 3).
    """
    first, second = rotation_6d[:, :3], rotation_6d[:, 3:]
    axes = torch.stack([first, second, torch.linalg.cross(first, second)], 1)
    level = axes[..., :2]
    flattest = level.norm(dim=-1).argmax(1)
    along = level[torch.arange(len(level)), flattest]
    yaw = torch.atan2(along[:, 1], along[:, 0])
    spread = (level[..., :, None] * level[..., None, :] * (half_extents_m**2)[..., None, None]).sum(1) / _SPREAD_UNIT_M2
    return torch.stack([(4 * yaw).cos(), (4 * yaw).sin(), spread[:, 0, 0], spread[:, 0, 1], spread[:, 1, 1]], 1)


def turned_outline(outline: Tensor, angle_rad: Tensor) -> Tensor:
    """(N, 5) outlines turned by (N,) angles."""
    c4, s4 = (4 * angle_rad).cos(), (4 * angle_rad).sin()
    c2, s2 = (2 * angle_rad).cos(), (2 * angle_rad).sin()
    x, y, xx, xy, yy = outline.unbind(1)
    mean, half, cross = (xx + yy) / 2, (xx - yy) / 2, xy
    half, cross = c2 * half - s2 * cross, s2 * half + c2 * cross
    return torch.stack([c4 * x - s4 * y, s4 * x + c4 * y, mean + half, cross, mean - half], 1)


def side_yaw_rad(outline: Tensor) -> Tensor:
    """(N,) yaw of one of the sides; the others are quarter turns away."""
    return torch.atan2(outline[:, 1], outline[:, 0]) / 4


def half_extent_m(outline: Tensor, yaw_rad: Tensor) -> Tensor:
    """(N,) half the extent along a side at yaws (N,)."""
    c, s = yaw_rad.cos(), yaw_rad.sin()
    _, _, xx, xy, yy = outline.unbind(1)
    return ((c * c * xx + 2 * c * s * xy + s * s * yy) * _SPREAD_UNIT_M2).clamp(min=0.03**2).sqrt()
