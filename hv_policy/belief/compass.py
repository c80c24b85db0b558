"""Which way the walls run, from the edges of one picture: nearly all lines of a furnished room are parallel to a wall
or upright (Coughlan & Yuille 1999, "Manhattan World").

An edge in a picture and the camera span a plane; the one level direction in that plane is where the edge runs, if it is
level. All edges vote. Nothing is learned. One picture of 128 px tells the direction to a degree and a half (median),
but for quarter turns, and that keeps odometry from drifting.
"""

from __future__ import annotations

import functools
import math

import numba
import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from hv_policy.belief.camera import CAMERA_TILT_RAD
from hv_policy.motor.embodiment import BODY_NAMES
from hv_policy.motor.kinematics import Array, as_arrays
from hv_policy.motor.proprioception import BodyState

_HEAD = BODY_NAMES.index("head")

LEAST_CONTRAST, MOST_CONTRAST = 0.03, 0.15
LEAST_LEVEL = 0.3
"""An edge counts if the plane that it spans with the camera is at least so far from upright (sine): upright lines lie
in upright planes, and there the direction is badly known."""


def compass(pictures: Tensor, body: BodyState) -> Tensor:
    """(B, 2) mean of all edges' cosine and sine of four times their direction, heading frame; its length is how much
    they agree, 0..1; on the CPU.

    Args:
        pictures: (B, 3, S, S), values 0..1.
        body: of the robots, for the pose of the camera.
    """
    grey = pictures.mean(1, keepdim=True).cpu()
    smooth = F.avg_pool2d(F.pad(grey, (1, 1, 1, 1), mode="replicate"), 3, 1)[:, 0]
    camera = _camera_axes() @ body.rot[:, _HEAD].mT.cpu()  # rows: its forward, left and up
    votes = torch.zeros(len(pictures), 2)
    _count_votes(*as_arrays(smooth, camera), votes.numpy())
    return votes


@numba.njit(cache=True)
def _count_votes(grey: Array, camera: Array, out: Array) -> None:
    """The mean vote (B, 2) of the edges in pictures (B, S, S), where the camera's axes are the rows of (B, 3, 3)."""
    size = grey.shape[1]
    for b in range(len(grey)):
        picture, axes = grey[b], camera[b].astype(np.float64)
        total, cosine, sine = 0.0, 0.0, 0.0
        for row in range(1, size - 1):
            for column in range(1, size - 1):
                # Sobel's operator
                left = picture[row - 1, column - 1] + 2 * picture[row, column - 1] + picture[row + 1, column - 1]
                right = picture[row - 1, column + 1] + 2 * picture[row, column + 1] + picture[row + 1, column + 1]
                above = picture[row - 1, column - 1] + 2 * picture[row - 1, column] + picture[row - 1, column + 1]
                below = picture[row + 1, column - 1] + 2 * picture[row + 1, column] + picture[row + 1, column + 1]
                across, along = np.float64(right - left) / 8, np.float64(below - above) / 8
                contrast = math.sqrt(across * across + along * along)
                if contrast <= LEAST_CONTRAST:
                    continue
                # the line through the pixel: across * (x - right) + along * (y - down) = 0, and the plane that holds it
                x, y = (2 * column + 1) / size - 1, (2 * row + 1) / size - 1
                forward = -(across * x + along * y)
                ahead = forward * axes[0, 0] - across * axes[1, 0] - along * axes[2, 0]
                aside = forward * axes[0, 1] - across * axes[1, 1] - along * axes[2, 1]
                up = forward * axes[0, 2] - across * axes[1, 2] - along * axes[2, 2]
                level = ahead * ahead + aside * aside
                if up * up <= LEAST_LEVEL * LEAST_LEVEL * (level + up * up) or level == 0.0:
                    continue
                # it runs along (aside, -ahead), the plane's normal crossed with the vertical: that angle, doubled twice
                c, s = (aside * aside - ahead * ahead) / level, -2 * ahead * aside / level
                weight = min(contrast, MOST_CONTRAST)
                total += weight
                cosine += weight * (c * c - s * s)
                sine += weight * 2 * c * s
        out[b, 0], out[b, 1] = cosine / max(total, 1e-6), sine / max(total, 1e-6)


@functools.cache
def _camera_axes() -> Tensor:
    """(3, 3) forward, left and up of the camera in the frame of the head."""
    c, s = math.cos(CAMERA_TILT_RAD), math.sin(CAMERA_TILT_RAD)
    return torch.tensor([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])
