"""The outline of an object on the floor and the directions of the walls, as numbers that are the same from every side.

A box may be taken from four sides; which one is for the robot to choose (`hv_policy.belief.stands`), and a picture does
not tell. How wide a thing is in each direction a picture does tell, and which way walls and furniture run
(`hv_policy.belief.compass`), and with them nearly all that stands in a room.
"""

from __future__ import annotations

import torch
from torch import Tensor

OUTLINE_DIM, COMPASS_DIM = 3, 2
_SPREAD_UNIT_M2 = 0.05


def outline_of(rotation_6d: Tensor, half_extents_m: Tensor) -> Tensor:
    """(N, 3) the symmetric matrix R diag(half_extents^2) R^T of the level directions (xx, xy, yy), in 0.05 m^2.

    Args:
        rotation_6d: (N, 6) first two columns of the rotation matrix, one after the other.
        half_extents_m: (N, 3).
    """
    level = axes_of(rotation_6d)[..., :2]
    spread = (level[..., :, None] * level[..., None, :] * (half_extents_m**2)[..., None, None]).sum(1) / _SPREAD_UNIT_M2
    return torch.stack([spread[:, 0, 0], spread[:, 0, 1], spread[:, 1, 1]], 1)


def axes_of(rotation_6d: Tensor) -> Tensor:
    """(N, 3, 3) an object's own axes, one in each row, of its rotation (N, 6)."""
    first, second = rotation_6d[:, :3], rotation_6d[:, 3:]
    return torch.stack([first, second, torch.linalg.cross(first, second)], 1)


def turned_outline(outline: Tensor, angle_rad: Tensor) -> Tensor:
    """(N, 3) outlines turned by (N,) angles."""
    c, s = (2 * angle_rad).cos(), (2 * angle_rad).sin()
    xx, xy, yy = outline.unbind(1)
    mean, half = (xx + yy) / 2, (xx - yy) / 2
    half, cross = c * half - s * xy, s * half + c * xy
    return torch.stack([mean + half, cross, mean - half], 1)


def half_extent_m(outline: Tensor, yaw_rad: Tensor) -> Tensor:
    """(N,) half the extent in the direction of yaws (N,) along a side."""
    c, s = yaw_rad.cos(), yaw_rad.sin()
    xx, xy, yy = outline.unbind(1)
    return ((c * c * xx + 2 * c * s * xy + s * s * yy) * _SPREAD_UNIT_M2).clamp(min=0.03**2).sqrt()


def half_sides_m(outline: Tensor, yaw_rad: Tensor) -> Tensor:
    """(N, 2) half the extents along yaws (N,) and across them, of which `outline_along` is the inverse."""
    return torch.stack([half_extent_m(outline, yaw_rad), half_extent_m(outline, yaw_rad + torch.pi / 2)], 1)


def outline_along(half_m: Tensor, yaw_rad: Tensor) -> Tensor:
    """(N, 3) the outline that has half extents (N, 2) along yaws (N,) and across them."""
    along, across = (half_m.square() / _SPREAD_UNIT_M2).unbind(1)
    return turned_outline(torch.stack([along, torch.zeros_like(along), across], 1), yaw_rad)


def compass_yaw_rad(compass: Tensor) -> Tensor:
    """(N,) one of the four directions."""
    return torch.atan2(compass[:, 1], compass[:, 0]) / 4
