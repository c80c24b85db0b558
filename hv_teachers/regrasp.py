"""How to take a box that lies anywhere, on any of its sides: which two faces to press, and where to stand for it."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from hv_policy.batch_invariant import atan2
from hv_sim.navigation import LOW_SUPPORT_M, SQUAT_ROOM_M, SQUAT_STAND_M
from hv_sim.objects import AHEAD_M, EDGE_M

WIDEST_M = 0.5
"""Between the hands."""


def grip_ahead(half_depth_m: Tensor) -> Tensor:
    """(N,) how far beyond its middle a side so deep is gripped, m; as any object is (`hv_sim.objects`)."""
    return (half_depth_m - EDGE_M).clamp(0.0, max(AHEAD_M))


@dataclass
class Regrasp:
    """N boxes as they are to be taken."""

    local: Tensor  # (N, 2, 3) where the (right, left) hand touches, in the box's frame, m
    depth_m: Tensor  # (N,) extent along the robot's view
    stand: Tensor  # (N, 3) x, y, yaw of the robot, world frame


def regrasp(pos_w: Tensor, rot_w: Tensor, half_m: Tensor, raise_m: Tensor, robot_xy: Tensor) -> Regrasp:
    """The way to take a box that turns the robot least and that its arms can span.

    Args:
        pos_w: (N, 3) centres, world frame, m.
        rot_w: (N, 3, 3) orientations.
        half_m: (N, 3) half extents in the boxes' frames.
        raise_m: (N,) how far above the centre the hands shall press, where the box is tall enough.
        robot_xy: (N, 2) where the robots are.
    """
    n = len(pos_w)
    rows = torch.arange(n)
    vertical = rot_w[:, 2].abs().argmax(-1)
    up_sign = torch.sign(rot_w[rows, 2, vertical])
    toward = pos_w[:, :2] - robot_xy
    toward = toward / toward.norm(dim=-1, keepdim=True).clamp(min=1e-6)
    best_cost = torch.full((n,), torch.inf)
    local, depth, stand = torch.zeros(n, 2, 3), torch.zeros(n), torch.zeros(n, 3)
    for turn in (1, 2):  # the axis across the robot's view; the one along it is the third
        across, along = (vertical + turn) % 3, (vertical + 3 - turn) % 3
        for sign in (-1.0, 1.0):
            facing = sign * rot_w[rows, :, along][:, :2]
            facing = facing / facing.norm(dim=-1, keepdim=True).clamp(min=1e-6)
            cost = 1.0 - (facing * toward).sum(-1) + 10.0 * (2 * half_m[rows, across] > WIDEST_M)
            left = torch.stack([-facing[:, 1], facing[:, 0]], -1)
            side = torch.sign((rot_w[rows, :, across][:, :2] * left).sum(-1))
            touch = torch.zeros(n, 2, 3)
            touch[rows, 0, across] = -side * half_m[rows, across]
            touch[rows, 1, across] = side * half_m[rows, across]
            forward = torch.sign((rot_w[rows, :, along][:, :2] * facing).sum(-1)) * grip_ahead(half_m[rows, along])
            touch[rows, :, along] = forward[:, None]
            highest = (half_m[rows, vertical] - 0.05).clamp(min=0.0)
            touch[rows, :, vertical] = (up_sign * torch.minimum(raise_m, highest))[:, None]
            extent = 2 * half_m[rows, along]
            low = pos_w[:, 2] - half_m[rows, vertical] < LOW_SUPPORT_M
            away = torch.where(
                low,
                (0.2 + SQUAT_ROOM_M + extent / 2).clamp(min=SQUAT_STAND_M),
                (0.25 + extent / 2).clamp(min=0.4),
            )
            place = torch.cat([pos_w[:, :2] - away[:, None] * facing, atan2(facing[:, 1:], facing[:, :1])], -1)
            better = cost < best_cost
            best_cost = torch.where(better, cost, best_cost)
            local = torch.where(better[:, None, None], touch, local)
            depth = torch.where(better, extent, depth)
            stand = torch.where(better[:, None], place, stand)
    return Regrasp(local, depth, stand)
