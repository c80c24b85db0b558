"""Which of the things in a room each part of a picture shows, from their boxes and the pose of the camera."""

from __future__ import annotations

import torch
from torch import Tensor

from hv_policy.belief.camera import camera_position, ray_directions
from hv_policy.motor.proprioception import BodyState

MOVABLE_HALF_M = 0.24
"""Things to be moved are no wider than that, nearly all furniture is."""
BOX_DIM = 7
"""Middle 3 and half extents 3 in m, yaw in rad; heading frame with its origin on the floor."""


def can_be_carried(boxes: Tensor) -> Tensor:
    """(B, T) bool, of boxes (B, T, BOX_DIM)."""
    return boxes[..., 3:5].amax(-1) < MOVABLE_HALF_M


def first_box_hit(body: BodyState, rays: Tensor, boxes: Tensor, exists: Tensor) -> Tensor:
    """(B, R) int64 which box each ray of the camera meets first, -1 for none (slab method).

    Args:
        body: (B, ...) of the robots.
        rays: (R, 3) unit vectors, frame of the head (`pixel_rays`).
        boxes: (B, T, BOX_DIM).
        exists: (B, T) bool.
    """
    cos, sin = boxes[..., 6].cos(), boxes[..., 6].sin()

    def local(vector: Tensor) -> Tensor:  # (B, R, T, 3) in the frames of the boxes
        c, s = cos[:, None], sin[:, None]
        x, y, z = vector.unbind(-1)
        return torch.stack([c * x + s * y, c * y - s * x, z], -1)

    origin = local((camera_position(body)[:, None] - boxes[..., :3])[:, None])
    direction = local(ray_directions(body, rays)[:, :, None].expand(-1, -1, boxes.shape[1], -1))
    direction = torch.where(direction.abs() < 1e-6, torch.full_like(direction, 1e-6), direction)
    half = boxes[:, None, :, 3:6]
    one, other = (-half - origin) / direction, (half - origin) / direction
    enters, leaves = torch.minimum(one, other).amax(-1), torch.maximum(one, other).amin(-1)
    hit = (leaves > enters) & (enters > 0) & exists[:, None]
    nearest, index = torch.where(hit, enters, torch.full_like(enters, torch.inf)).min(-1)
    return torch.where(nearest.isfinite(), index, torch.full_like(index, -1))
