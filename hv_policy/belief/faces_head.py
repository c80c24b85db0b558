"""Which way the faces of an object run, seen in a plan view of the picture around the place where it should be.

Level lines keep their direction in a view from above, at whatever height they are: one level plane is seen from the
camera as any other is, but for its size. Upright lines point away from the camera, and which way that is the network
is told. A plan may be drawn turned anyhow: in training each one is, so that one fall shows many.
"""

from __future__ import annotations

import math

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from hv_policy.belief.attitude import FACES, attitude_of, turned_faces
from hv_policy.belief.camera import camera_position, project
from hv_policy.motor.proprioception import BodyState

CELLS, WIDE_M = 32, 1.2
"""Cells along a side of the plan, and how wide it is."""
FARTHEST_M = 2.2
"""From farther away a picture of 128 px does not tell."""
CHANNELS = 6
"""Colours, whether the place is in the picture, and the level direction away from the camera."""
_WIDTHS, _HIDDEN, _DROPOUT = (24, 32, 48, 64), 128, 0.2


class FacesHead(nn.Module):
    """Pictures and where the object is in them -> its faces (`hv_policy.belief.attitude`)."""

    def __init__(self) -> None:
        super().__init__()
        layers: list[nn.Module] = []
        for k, (inside, outside) in enumerate(zip((CHANNELS, *_WIDTHS), _WIDTHS, strict=False)):
            layers += [nn.Conv2d(inside, outside, 3, stride=1 if k == 0 else 2, padding=1), nn.GELU()]
        self.conv = nn.Sequential(*layers)
        cells = (CELLS >> (len(_WIDTHS) - 1)) ** 2
        self.out = nn.Sequential(
            nn.Dropout(_DROPOUT),
            nn.Linear(_WIDTHS[-1] * cells + 2, _HIDDEN),
            nn.GELU(),
            nn.Linear(_HIDDEN, 2),
        )

    def forward(self, pictures: Tensor, body: BodyState, at_h: Tensor, turn_rad: Tensor) -> Tensor:
        """(B, 2) cosine and sine of four times the yaw of a face, heading frame.

        Args:
            pictures: (B, 3, S, S), values 0..1.
            body: of the robots, for the pose of the camera.
            at_h: (B, 3) where the object is, m, heading frame.
            turn_rad: (B,) how the plan is drawn.
        """
        with torch.autocast(pictures.device.type, enabled=False):  # metres need more digits
            plan = plan_view(pictures.float(), body, at_h, turn_rad)
            place = torch.stack([at_h[:, 2], at_h[:, :2].norm(dim=1)], 1)
        seen = self.conv(plan.contiguous(memory_format=torch.channels_last)).flatten(1).float()
        return turned_faces(self.out(torch.cat([seen, place], 1)).float(), turn_rad)


def faces_loss(
    head: FacesHead, pictures: Tensor, body: BodyState, at_h: Tensor, truth_h: Tensor, rotation_6d: Tensor
) -> Tensor:
    """(B,) how wrong the head is where the object is in view and not too far; in training on plans drawn anyhow.

    Args:
        head, pictures, body, at_h: see `FacesHead`; `at_h` is where the object is believed to be,
        truth_h: (B, 3) and this is where it is, m, heading frame,
        rotation_6d: (B, 6) and how it is turned.
    """
    turn = torch.zeros_like(at_h[:, 0])
    if head.training:
        turn = 2 * math.pi * torch.rand_like(turn)
    seen, truth = head(pictures, body, at_h, turn), attitude_of(rotation_6d)[:, FACES]
    wrong = F.smooth_l1_loss(seen, truth, reduction="none", beta=0.3)
    _, visible = project(body, truth_h[:, None])
    return wrong.mean(1) * (visible[:, 0] & (truth_h[:, :2].norm(dim=1) < FARTHEST_M))


def plan_view(pictures: Tensor, body: BodyState, at_h: Tensor, turn_rad: Tensor) -> Tensor:
    """(B, CHANNELS, CELLS, CELLS) the level plane through places (B, 3), m, heading frame, from above, as pictures
    (B, 3, S, S) show it; the first axis of the plan is turned by (B,) from straight ahead."""
    along = ((torch.arange(CELLS, device=pictures.device) + 0.5) / CELLS - 0.5) * WIDE_M
    right, down = torch.meshgrid(along, along, indexing="ij")
    cos, sin = turn_rad.cos()[:, None, None], turn_rad.sin()[:, None, None]
    ahead, aside, height = at_h[..., None, None].unbind(1)
    x, y = cos * right - sin * down + ahead, sin * right + cos * down + aside
    points = torch.stack([x, y, height.expand_as(x)], -1).flatten(1, 2)
    at, visible = project(body, points)
    shown = visible.view(-1, 1, CELLS, CELLS).float()
    colours = F.grid_sample(pictures, at.view(-1, CELLS, CELLS, 2), align_corners=False)
    away = F.normalize(points[..., :2] - camera_position(body)[:, None, :2], dim=-1).view(-1, CELLS, CELLS, 2)
    turned = torch.stack([cos * away[..., 0] + sin * away[..., 1], cos * away[..., 1] - sin * away[..., 0]], 1)
    return torch.cat([(colours - 0.5) * shown, shown, turned], 1)
