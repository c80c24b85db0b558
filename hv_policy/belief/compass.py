"""Which way the walls run, from the edges of one picture: nearly all lines of a furnished room are parallel to a wall
or upright (Coughlan & Yuille 1999, "Manhattan World").

An edge in a picture and the camera span a plane; the one level direction in that plane is where the edge runs, if it is
level. All edges vote. Nothing is learned. One picture of 128 px tells the direction to a degree and a half (median),
but for quarter turns, and that keeps odometry from drifting.
"""

from __future__ import annotations

import functools
import math

import torch
import torch.nn.functional as F
from torch import Tensor

from hv_policy.belief.camera import CAMERA_TILT_RAD, ray_directions
from hv_policy.motor.proprioception import BodyState

LEAST_CONTRAST, MOST_CONTRAST = 0.03, 0.15
LEAST_LEVEL = 0.3
"""An edge counts if the plane that it spans with the camera is at least so far from upright (sine): upright lines lie
in upright planes, and there the direction is badly known."""


def compass(pictures: Tensor, body: BodyState) -> Tensor:
    """(B, 2) mean of all edges' cosine and sine of four times their direction, heading frame; its length is how much
    they agree, 0..1.

    Args:
        pictures: (B, 3, S, S), values 0..1.
        body: of the robots, for the pose of the camera.
    """
    normals, contrast = _edge_planes(pictures)
    ahead, left, up = ray_directions(body, normals).unbind(-1)
    angle = torch.atan2(-ahead, left)  # of the normal crossed with the vertical
    weight = contrast.clamp(max=MOST_CONTRAST) * (contrast > LEAST_CONTRAST) * (up.abs() > LEAST_LEVEL)
    votes = torch.stack([(4 * angle).cos(), (4 * angle).sin()], -1)
    return (weight[..., None] * votes).sum(1) / weight.sum(1, keepdim=True).clamp(min=1e-6)


def _edge_planes(pictures: Tensor) -> tuple[Tensor, Tensor]:
    """(B, P, 3) unit normals, frame of the head, of the planes that each pixel's edge spans with the camera, and (B, P)
    the contrast of the edge in a pixel."""
    grey = F.avg_pool2d(F.pad(pictures.mean(1, keepdim=True), (1, 1, 1, 1), mode="replicate"), 3, 1)
    sobel = grey.new_tensor([[-1.0, 0.0, 1.0], [-2.0, 0.0, 2.0], [-1.0, 0.0, 1.0]]) / 8
    across, along = (F.conv2d(grey, kernel[None, None]).flatten(1) for kernel in (sobel, sobel.T.contiguous()))
    right, down = _pixels(grey.shape[-1])
    # the line through the pixel: across * (x - right) + along * (y - down) = 0, and the plane that holds it
    parts = torch.stack([-(across * right + along * down), -across, -along], -1)
    return F.normalize(parts @ _camera_axes(), dim=-1), (across * across + along * along).sqrt()


@functools.cache
def _pixels(size: int) -> tuple[Tensor, Tensor]:
    """Where the inner pixels of a picture are, right and down from its middle in halves of its width, (P,) each."""
    centre = (torch.arange(1, size - 1) + 0.5) / size * 2 - 1
    down, right = torch.meshgrid(centre, centre, indexing="ij")
    return right.flatten(), down.flatten()


@functools.cache
def _camera_axes() -> Tensor:
    """(3, 3) forward, left and up of the camera in the frame of the head."""
    c, s = math.cos(CAMERA_TILT_RAD), math.sin(CAMERA_TILT_RAD)
    return torch.tensor([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])
