"""A picture -> which points of the floor are taken by walls, furniture or things."""

from __future__ import annotations

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from hv_policy.belief.camera import camera_position, project
from hv_policy.belief.floor_map import SEEN_FROM_M, SEEN_TO_M
from hv_policy.belief.floor_patch import patch_points
from hv_policy.motor.proprioception import BodyState

_POINT_DIM = 6
POINTS_A_PICTURE = 96


class FloorHead(nn.Module):
    """Reads what a picture shows where points of the floor would be in it.

    Args:
        dim, fine_dim: channels of the picture's tokens and of its finer features.
        hidden: width.
    """

    def __init__(self, dim: int, fine_dim: int, hidden: int) -> None:
        super().__init__()
        self.judge = nn.Sequential(
            nn.Linear(dim + fine_dim + _POINT_DIM, hidden),
            nn.GELU(),
            nn.Linear(hidden, hidden),
            nn.GELU(),
            nn.Linear(hidden, 1),
        )

    def forward(self, tokens: Tensor, fine: Tensor, body: BodyState, points_h: Tensor) -> Tensor:
        """(B, P) logarithms of the odds that points are taken; they must be in the picture (`floor_in_view`).

        Args:
            tokens: (B, T, dim), row by row.
            fine: (B, fine_dim, H, W).
            body: of the robots.
            points_h: (B, P, 2) on the floor, heading frame, m.
        """
        at, _ = _in_picture(body, points_h)
        side = round(tokens.shape[1] ** 0.5)
        coarse = tokens.transpose(1, 2).unflatten(2, (side, side))
        read = [_sampled(features, at) for features in (coarse, fine)]
        eye = camera_position(body)
        distance = (points_h - eye[:, None, :2]).norm(dim=-1)
        dip = torch.atan2(eye[:, None, 2].expand_as(distance), distance)
        within = at * side / 2  # where within its token
        seen_at = torch.stack([torch.asinh(distance), dip, *at.unbind(-1)], -1)
        return self.judge(torch.cat([*read, seen_at, within - within.floor() - 0.5], -1))[..., 0]


def floor_in_view(body: BodyState, points_h: Tensor) -> Tensor:
    """(B, P) bool which points of the floor (B, P, 2) are in the picture, and neither too near nor too far."""
    distance = points_h.norm(dim=-1)
    return _in_picture(body, points_h)[1] & (distance > SEEN_FROM_M) & (distance < SEEN_TO_M)


def points_to_learn(body: BodyState, count: int) -> tuple[Tensor, Tensor, Tensor]:
    """Cells (B, count) of the patch (`floor_patch`), drawn from those in view, as many of them near as far; their
    places (B, count, 2); and whether they are in view at all, (B, count)."""
    points = patch_points().to(body.pos)
    in_view = floor_in_view(body, points.expand(len(body.pos), -1, -1))
    # Gumbel's trick: in proportion to one by the distance, because there are the more points the farther it is
    score = -points.norm(dim=-1).log() - (-torch.rand_like(in_view.float()).log()).log()
    cells = score.masked_fill(~in_view, -torch.inf).topk(count, 1).indices
    return cells, points[cells], in_view.gather(1, cells)


def _in_picture(body: BodyState, points_h: Tensor) -> tuple[Tensor, Tensor]:
    """`project` of points of the floor (B, P, 2)."""
    return project(body, torch.cat([points_h, torch.zeros_like(points_h[..., :1])], -1))


def _sampled(features: Tensor, at: Tensor) -> Tensor:
    """(B, P, C) of features (B, C, H, W) at places (B, P, 2) right and down from the middle in halves of the width."""
    return F.grid_sample(features, at[:, None], mode="bilinear", padding_mode="border", align_corners=False)[
        :, :, 0
    ].transpose(1, 2)
