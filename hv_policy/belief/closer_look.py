"""A closer look at one place: where exactly the thing there is, and how it stands or lies.

Whatever a thing is called, its edges and where it meets the floor tell where it is and how wide. The head sees the
picture as it is on a screen through the place that is believed, square to the view and one metre wide: metres there are
the same from near and far, and from every side. So few weights learn from every thing that can be carried, whether its
kind has a name or not.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from hv_policy.belief.attitude import turned_attitude
from hv_policy.belief.camera import camera_position, project
from hv_policy.belief.outline import turned_outline
from hv_policy.motor.proprioception import BodyState

CELLS, WIDE_M = 48, 1.0
"""Cells along a side of the screen, and how wide it is."""
FARTHEST_M = 2.5
"""From farther away a picture of 128 px does not tell."""
NEAREST_M = 0.15
"""Nearer than that, on the floor, the camera looks straight down."""
REACH_M = 0.35
"""A thing so far from the place that is looked at, on the floor, is meant."""
TIMES, _BEYOND_M = 2, 0.1
"""It looks so many times, each time at what it found before; what is so far beyond reach is another thing."""
CHANNELS = 6
"""Colours, whether that is in the picture, its height above the floor, and how far away the screen is."""
_WIDTHS, _STRIDES, _HIDDEN, _DROPOUT = (24, 32, 48, 64, 64), (2, 1, 2, 1, 2), 192, 0.1
_OFFSET_UNIT_M = 0.2
_USUAL_OUTLINE = torch.tensor([0.45, 0.0, 0.45])
_USUAL_SPREAD_M, _LEAST_LOG_SPREAD, _MOST_LOG_SPREAD = 0.05, math.log(0.008), math.log(0.5)
_OUT_DIM = 13


@dataclass
class Closer:
    """What B closer looks tell, heading frame."""

    at: Tensor  # (B, 3) the middle of the thing, m
    log_spread: Tensor  # (B, 3) logarithm of its deviation along the view, across it and upward, m
    seen: Tensor  # (B,) logit of a thing that can be carried being there
    outline: Tensor  # (B, 3) of it (`hv_policy.belief.outline`)
    attitude: Tensor  # (B, 3) of it (`hv_policy.belief.attitude`)


class CloserLook(nn.Module):
    """Pictures and where a thing is believed to be in them -> where it is."""

    def __init__(self) -> None:
        super().__init__()
        layers: list[nn.Module] = []
        for inside, outside, stride in zip((CHANNELS, *_WIDTHS), _WIDTHS, _STRIDES, strict=False):
            layers += [nn.Conv2d(inside, outside, 3, stride, padding=1), nn.GELU()]
        self.conv = nn.Sequential(*layers)
        cells = (CELLS // math.prod(_STRIDES)) ** 2
        self.out = nn.Sequential(
            nn.Dropout(_DROPOUT),
            nn.Linear(_WIDTHS[-1] * cells + 4, _HIDDEN),
            nn.GELU(),
            nn.Linear(_HIDDEN, _OUT_DIM),
        )

    def forward(self, pictures: Tensor, body: BodyState, at_h: Tensor, mirrored: Tensor | None = None) -> Closer:
        """What there is.

        Args:
            pictures: (B, 3, S, S), values 0..1.
            body: of the robots, for the pose of the camera.
            at_h: (B, 3) where the thing is believed to be, m, heading frame.
            mirrored: (B,) bool: the screen is shown left for right; what is told is not.
        """
        with torch.autocast(pictures.device.type, enabled=False):  # metres need more digits
            axes = view_axes(body, at_h)
            screen = screen_through(pictures.float(), body, at_h, axes)
        camera = camera_position(body)
        known = torch.stack([(at_h - camera).norm(dim=1), at_h[:, 2], camera[:, 2], axes[:, 0, 2]], 1)
        side = torch.ones_like(at_h[:, 0])
        if mirrored is not None:
            screen = torch.where(mirrored[:, None, None, None], screen.flip(3), screen)
            side = torch.where(mirrored, -1.0, 1.0)
        seen = self.conv(screen.contiguous(memory_format=torch.channels_last)).flatten(1).float()
        out = self.out(torch.cat([seen, known], 1)).float()
        along, left, up = (_OFFSET_UNIT_M * out[:, :3]).unbind(1)
        at = at_h + (torch.stack([along, side * left, up], 1)[:, None] @ axes)[:, 0]
        spread = (out[:, 3:6] + math.log(_USUAL_SPREAD_M)).clamp(_LEAST_LOG_SPREAD, _MOST_LOG_SPREAD)
        flips = torch.stack([torch.ones_like(side), side, torch.ones_like(side)], 1)
        yaw = torch.atan2(axes[:, 0, 1], axes[:, 0, 0])
        outline = turned_outline(flips * (out[:, 7:10] + _USUAL_OUTLINE.to(out)), yaw)
        attitude = turned_attitude(flips * out[:, 10:13], yaw)
        return Closer(at, spread, out[:, 6], outline, attitude)


def view_axes(body: BodyState, at_h: Tensor) -> Tensor:
    """(B, 3, 3) unit vectors, heading frame: along the view from the camera to places (B, 3), m, level to the left of
    it, and upward."""
    along = F.normalize(at_h - camera_position(body), dim=-1)
    left = F.normalize(torch.stack([-along[:, 1], along[:, 0], torch.zeros_like(along[:, 0])], 1), dim=-1)
    return torch.stack([along, left, torch.linalg.cross(along, left)], 1)


def screen_through(pictures: Tensor, body: BodyState, at_h: Tensor, axes: Tensor) -> Tensor:
    """(B, CHANNELS, CELLS, CELLS) what pictures (B, 3, S, S) show on screens through places (B, 3), m, heading frame,
    square to the view (`view_axes`), from the top and from the left."""
    reach = ((torch.arange(CELLS, device=pictures.device) + 0.5) / CELLS - 0.5) * WIDE_M
    down, right = (cells.flatten()[None, :, None] for cells in torch.meshgrid(reach, reach, indexing="ij"))
    points = at_h[:, None] - right * axes[:, None, 1] - down * axes[:, None, 2]
    at, visible = project(body, points)
    shown = visible.view(-1, 1, CELLS, CELLS).float()
    colours = F.grid_sample(pictures, at.view(-1, CELLS, CELLS, 2), align_corners=False)
    away = (at_h - camera_position(body)).norm(dim=1).view(-1, 1, 1, 1).expand_as(shown)
    return torch.cat([(colours - 0.5) * shown, shown, points[..., 2].view_as(shown), away - 1.0], 1)


@dataclass
class Found:
    """What closer looks at places of n pictures led to."""

    rows: Tensor  # (r,) pictures in which a thing was found
    at_h: Tensor  # (r, 3) its middle, m, heading frame
    deviation_m: Tensor  # (r, 3) of that
    outline: Tensor  # (r, 3), heading frame
    attitude: Tensor  # (r, 3), heading frame


def look_closer(head: CloserLook, pictures: Tensor, body: BodyState, at_h: Tensor, wanted: Tensor) -> Found:
    """A closer look at places (n, 3), m, heading frame, and again at what was found there.

    Args:
        head: looks.
        pictures: (n, 3, S, S).
        body: of the robots, on the CPU, as all that follows is.
        at_h: places.
        wanted: (n,) bool: at the others nobody looks.
    """
    rows = (wanted & _may_look(body, at_h)).nonzero()[:, 0]
    at = first = at_h[rows]
    if not len(rows):
        return Found(rows, first, first, first, first)
    own, shown = body.rows(rows), pictures[rows.to(pictures.device)]
    for _ in range(TIMES):
        axes = view_axes(own, at)
        found = head(shown, own.to(shown), at.to(shown))
        sure = (found.seen > 0).cpu()
        at = torch.where(sure[:, None], found.at.cpu(), at)
    sure = sure & ((at - first)[:, :2].norm(dim=1) < REACH_M + _BEYOND_M)
    variance = (axes * found.log_spread.exp().cpu()[..., None]).square().sum(1)
    level = variance[:, :2].mean(1, keepdim=True).expand(-1, 2)
    deviation = torch.cat([level, variance[:, 2:]], 1).sqrt()
    return Found(rows[sure], at[sure], deviation[sure], found.outline.cpu()[sure], found.attitude.cpu()[sure])


def _may_look(body: BodyState, at_h: Tensor) -> Tensor:
    """(n,) bool: a place (n, 3) is in view, and near enough."""
    away = (at_h - camera_position(body))[:, :2].norm(dim=1)
    _, visible = project(body, at_h[:, None])
    return visible[:, 0] & (away < FARTHEST_M) & (away > NEAREST_M)
