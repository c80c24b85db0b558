"""How an object is turned, as numbers that are the same from every side of it: which way its faces run, and whether it
stands.

What stands in a room is turned as its walls are, which edges tell better than the thing itself
(`hv_policy.belief.compass`). What fell over is turned anyhow, and can be held by its faces alone.
"""

from __future__ import annotations

import math

import torch
from torch import Tensor

from hv_policy.belief.outline import axes_of, compass_yaw_rad
from hv_policy.belief.places import turned

FACES, UPRIGHT = slice(0, 2), 2
"""Cosine and sine of four times the yaw of a face, and the vertical part of the thing's own vertical axis: 1 if it
stands, 0 if it lies on its side."""
STANDS = torch.tensor([0.0, 0.0, 1.0])
"""(3,) of what stands, whichever way it is turned."""
LIES = 0.6
"""What is less upright lies."""
_SURE_LYING, _SURE_STANDING, _TURNED_RAD = 0.4, 0.7, math.radians(15)
"""The faces of what lies are believed from this on (1 is certain), those of what stands from the second, and if the
walls run otherwise by more than the third."""


def attitude_of(rotation_6d: Tensor) -> Tensor:
    """(N, 3) of rotations (N, 6), the first two columns of the matrix, one after the other."""
    axes = axes_of(rotation_6d)
    x, y = axes[..., 0], axes[..., 1]
    level = x * x + y * y  # of each axis; its angle counts so much
    c2, s2 = x * x - y * y, 2 * x * y  # level * (cos, sin) of twice the angle
    unit = level.clamp(min=1e-6)
    faces = torch.stack([((c2 * c2 - s2 * s2) / unit).sum(1), (2 * c2 * s2 / unit).sum(1)], 1)
    return torch.cat([faces / level.sum(1, keepdim=True).clamp(min=1e-6), axes[:, 2:, 2]], 1)


def turned_attitude(attitude: Tensor, angle_rad: Tensor) -> Tensor:
    """(N, 3) attitudes turned by (N,) angles."""
    return torch.cat([turned_faces(attitude[:, FACES], angle_rad), attitude[:, UPRIGHT:]], 1)


def turned_faces(faces: Tensor, angle_rad: Tensor) -> Tensor:
    """(N, 2) faces turned by (N,) angles."""
    return turned(faces, (4 * angle_rad[:, None]).cos(), (4 * angle_rad[:, None]).sin())


def lies(attitude: Tensor) -> Tensor:
    """(N,) bool, of attitudes (N, 3)."""
    return attitude[:, UPRIGHT] < LIES


def face_yaw_rad(attitude: Tensor, compass: Tensor) -> Tensor:
    """(N,) one of the four ways in which the faces of things run: as the walls do, `compass` (N, 2), unless attitudes
    (N, 3) say otherwise."""
    faces = attitude[:, FACES]
    sure = faces.norm(dim=1)
    of_thing, of_walls = compass_yaw_rad(faces), compass_yaw_rad(compass)
    otherwise = (4 * (of_thing - of_walls)).cos() < math.cos(4 * _TURNED_RAD)
    own = torch.where(lies(attitude), sure > _SURE_LYING, otherwise & (sure > _SURE_STANDING))
    return torch.where(own, of_thing, of_walls)
