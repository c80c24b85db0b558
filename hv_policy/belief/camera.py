"""Where the parts of a head camera's picture look at, from the pose of the head: what makes distances readable.

The camera is the robot's (hv_sim.humanoid): square pictures, 90 degrees wide, 0.1 m before and 0.175 m above the head's
joint, looking 20 degrees down.
"""

from __future__ import annotations

import math

import torch
from torch import Tensor

from hv_policy.belief.places import squash_waypoint
from hv_policy.motor.embodiment import BODY_NAMES
from hv_policy.motor.proprioception import BodyState

_HEAD = BODY_NAMES.index("head")
CAMERA_POSITION_M = (0.10, 0.0, 0.175)
CAMERA_TILT_RAD = math.radians(20.0)
PLANES_M = (0.0, 0.75)
"""Heights at which rays are cut: the floor, and a table."""
RAY_DIM = 3 + 1 + 3 * len(PLANES_M)
_FAR_M = 20.0


def pixel_rays(grid: int) -> Tensor:
    """(grid^2, 3) unit vectors through the middles of a picture's cells, row by row from the top; frame of the head."""
    centre = (torch.arange(grid) + 0.5) / grid * 2 - 1
    down, right = torch.meshgrid(centre, centre, indexing="ij")
    forward = torch.tensor([math.cos(CAMERA_TILT_RAD), 0.0, -math.sin(CAMERA_TILT_RAD)])
    up = torch.tensor([math.sin(CAMERA_TILT_RAD), 0.0, math.cos(CAMERA_TILT_RAD)])
    rays = forward + right[..., None] * torch.tensor([0.0, -1.0, 0.0]) - down[..., None] * up
    return torch.nn.functional.normalize(rays.flatten(0, 1), dim=-1)


def project(body: BodyState, points_h: Tensor) -> tuple[Tensor, Tensor]:
    """Where points are in the picture, and whether they are: (N, P, 2) right and down from its middle in halves of its
    width, and (N, P) bool.

    Args:
        body: of the robot.
        points_h: (N, P, 3), heading frame with its origin on the floor.
    """
    local = (points_h - camera_position(body)[:, None]) @ body.rot[:, _HEAD]
    c, s = math.cos(CAMERA_TILT_RAD), math.sin(CAMERA_TILT_RAD)
    depth = c * local[..., 0] - s * local[..., 2]
    down = -(s * local[..., 0] + c * local[..., 2])
    at = torch.stack([-local[..., 1], down], -1) / depth.clamp(min=1e-3)[..., None]
    return at, (depth > 1e-3) & (at.abs() < 1).all(-1)


def camera_position(body: BodyState) -> Tensor:
    """(N, 3) of the camera, heading frame with its origin on the floor."""
    offset = body.pos.new_tensor(CAMERA_POSITION_M)
    return body.pos[:, _HEAD] + body.rot[:, _HEAD] @ offset


def ray_directions(body: BodyState, rays: Tensor) -> Tensor:
    """(N, R, 3) rays (R, 3) of the head's frame in the heading frame."""
    return rays @ body.rot[:, _HEAD].transpose(1, 2)


def ray_features(body: BodyState, rays: Tensor) -> Tensor:
    """(N, R, 10) for each ray (R, 3) of the head's frame: its direction in the heading frame, the camera's height, and
    for each of two heights where the ray is there (squashed as the labels are) and whether it gets there at all."""
    position = camera_position(body)
    direction = ray_directions(body, rays)
    height = position[:, 2:, None].expand(-1, len(rays), 1)
    features = [direction, height]
    for plane in PLANES_M:
        down = (height[..., 0] - plane) / (-direction[..., 2]).clamp(min=1e-3)
        hits = (direction[..., 2] < -0.01) & (down > 0) & (down < _FAR_M)
        reach = torch.where(hits, down, torch.full_like(down, _FAR_M))
        point = position[:, None, :2] + direction[..., :2] * reach[..., None]
        features += [squash_waypoint(point), hits[..., None].to(point)]
    return torch.cat(features, -1)
