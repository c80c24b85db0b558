"""A closer look at one place: where exactly the thing there is, how wide and how high it is, and where to hold it.

Whatever a thing is called, its edges and where it meets the floor tell where it stands. The head sees the picture as it
is on a screen through the place that is believed, square to the view and one metre wide: metres there are the same from
near and far, and from every side. So few weights learn from every thing that can be carried, kinds that have
a name and others.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from hv_policy.belief.attitude import UPRIGHT, attitude_of
from hv_policy.belief.camera import camera_position, project
from hv_policy.belief.outline import OUTLINE_DIM, axes_of, outline_of, turned_outline
from hv_policy.belief.places import MIDDLE, OBJECT
from hv_policy.motor.proprioception import BodyState

CELLS, WIDE_M = 48, 1.0
"""Cells along a side of the screen, and how wide it is."""
FARTHEST_M = 2.5
"""From farther away a picture of 128 px does not tell."""
NEAREST_M = 0.15
"""Nearer than that, on the floor, the camera looks straight down."""
REACH_M = 0.35
"""A thing so far from the place that is looked at, on the floor, is meant."""
HELD_SPREAD_M = 0.03
"""Deviation of how far above its middle a thing is held."""
_BEYOND_M = 0.1
_ABOVE = MIDDLE.stop - 1
CHANNELS = 6
"""Colours, whether that is in the picture, its height above the floor, and how far away the screen is."""
_WIDTHS, _STRIDES, _HIDDEN, _DROPOUT = (24, 32, 48, 64, 64), (2, 1, 2, 1, 2), 192, 0.1
_OFFSET_UNIT_M, _HALF_UNIT_M = 0.2, 0.2
_USUAL_SPREAD_M, _LEAST_LOG_SPREAD, _MOST_LOG_SPREAD = 0.05, math.log(0.008), math.log(0.5)
_OUTLINE_WEIGHT, _HEIGHT_WEIGHT, _UPRIGHT_WEIGHT, _SEEN_WEIGHT = 1.0, 1.0, 0.5, 0.5


@dataclass
class Closer:
    """What B closer looks tell, heading frame."""

    at: Tensor  # (B, 3) the middle of the thing, m
    log_spread: Tensor  # (B, 3) logarithm of its deviation along the view, across it and upward, m
    outline: Tensor  # (B, 3), `hv_policy.belief.outline`
    half_height_m: Tensor  # (B,)
    above_m: Tensor  # (B,) how far above its middle it is held
    upright: Tensor  # (B,) `hv_policy.belief.attitude`
    seen: Tensor  # (B,) logit of a thing that can be carried being there


class CloserLook(nn.Module):
    """Pictures and where a thing is believed to be in them -> where it is, and what it is like."""

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
            nn.Linear(_HIDDEN, 6 + OUTLINE_DIM + 4),
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
        xx, xy, yy = out[:, 6 : 6 + OUTLINE_DIM].unbind(1)
        yaw = torch.atan2(axes[:, 0, 1], axes[:, 0, 0])
        outline = turned_outline(torch.stack([xx, side * xy, yy], 1), yaw)
        half, above, upright, logit = out[:, 6 + OUTLINE_DIM :].unbind(1)
        spread = (out[:, 3:6] + math.log(_USUAL_SPREAD_M)).clamp(_LEAST_LOG_SPREAD, _MOST_LOG_SPREAD)
        return Closer(at, spread, outline, _HALF_UNIT_M * (1 + half), _HALF_UNIT_M * above, upright, logit)


@dataclass
class Thing:
    """What was so of B things, heading frame."""

    at_h: Tensor  # (B, 3) m
    rotation_6d: Tensor  # (B, 6)
    half_extents_m: Tensor  # (B, 3)
    above_m: Tensor  # (B,) how far above its middle it is held, NaN where nobody knows
    is_there: Tensor  # (B,) bool: it is near the place that is looked at, and in view


def closer_loss(seen: Closer, axes: Tensor, truth: Thing) -> tuple[Tensor, Tensor]:
    """(B,) how wrong a closer look is, and (B, 3) by how much its place is (m): along the view, across it, upward.

    The place's likelihood is that of a Laplace distribution under the deviation that is said, weighted by its square
    root (beta-NLL, Seitzer et al. 2022, beta = 0.5).

    Args:
        seen: what is said.
        axes: (B, 3, 3) of the views (`view_axes`).
        truth: what was so.
    """
    wrong = ((seen.at - truth.at_h)[:, None] @ axes.mT)[:, 0].abs()
    spread = seen.log_spread
    likely = ((wrong / spread.exp() + spread) * (0.5 * spread.detach()).exp()).sum(1) * 4.0
    outline = F.smooth_l1_loss(
        seen.outline, outline_of(truth.rotation_6d, truth.half_extents_m), reduction="none", beta=0.2
    ).mean(1)
    half = (axes_of(truth.rotation_6d)[..., 2] * truth.half_extents_m).square().sum(1).sqrt()
    high = (seen.half_height_m - half).abs() / _HALF_UNIT_M
    knows = truth.above_m.isfinite()
    held = (seen.above_m - truth.above_m.nan_to_num()).abs() / _HALF_UNIT_M * knows
    upright = attitude_of(truth.rotation_6d)[:, UPRIGHT]
    stands = F.smooth_l1_loss(seen.upright, upright, reduction="none", beta=0.3)
    shape = _OUTLINE_WEIGHT * outline + _HEIGHT_WEIGHT * (high + held) + _UPRIGHT_WEIGHT * stands
    there = F.binary_cross_entropy_with_logits(seen.seen, truth.is_there.float(), reduction="none")
    return (likely + shape) * truth.is_there + _SEEN_WEIGHT * there, wrong.detach()


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
class Refined:
    """What n pictures say of their objects, heading frame, after a closer look where one was possible."""

    is_so: Tensor  # (n,) bool: it was
    places: Tensor  # (n, 21)
    spread: Tensor  # (n, 21) deviations, m
    outline: Tensor  # (n, 3)
    upright: Tensor  # (n, 1)


def look_closer(
    head: CloserLook, pictures: Tensor, body: BodyState, at_h: Tensor, wanted: Tensor, before: Refined
) -> Refined:
    """A closer look at places (n, 3), m, heading frame, and then at what was found there.

    Args:
        head: looks.
        pictures: (n, 3, S, S).
        body: of the robots, on the CPU, as all that follows is.
        at_h: places.
        wanted: (n,) bool; the others are left as they are.
        before: what is known without it.
    """
    rows = (wanted & _may_look(body, at_h)).nonzero()[:, 0]
    if not len(rows):
        return before
    own, shown = body.rows(rows), pictures[rows.to(pictures.device)]
    found = _on_cpu(head(shown, own.to(shown), at_h[rows].to(shown)))
    again = torch.where((found.seen > 0)[:, None], found.at, at_h[rows])
    found = _on_cpu(head(shown, own.to(shown), again.to(shown)))
    sure = (found.seen > 0) & ((found.at - at_h[rows])[:, :2].norm(dim=1) < REACH_M + _BEYOND_M)
    rows, found, axes = rows[sure], Closer(*(v[sure] for v in vars(found).values())), view_axes(own, again)[sure]
    variance = (axes.square() * (2 * found.log_spread).exp()[..., None]).sum(1)  # (r, 3) in x, y, z
    level, high = variance[:, :2].mean(1, keepdim=True).sqrt(), variance[:, 2:].sqrt()
    out = Refined(*(value.clone() for value in vars(before).values()))
    out.is_so[rows] = True
    out.places[rows, OBJECT] = found.at
    out.spread[rows, OBJECT] = torch.cat([level, level, high], 1)
    out.places[rows, _ABOVE], out.spread[rows, _ABOVE] = found.above_m, HELD_SPREAD_M
    out.outline[rows], out.upright[rows] = found.outline, found.upright[:, None]
    return out


def _may_look(body: BodyState, at_h: Tensor) -> Tensor:
    """(n,) bool: a place (n, 3) is in view, and near enough."""
    away = (at_h - camera_position(body))[:, :2].norm(dim=1)
    _, visible = project(body, at_h[:, None])
    return visible[:, 0] & (away < FARTHEST_M) & (away > NEAREST_M)


def _on_cpu(found: Closer) -> Closer:
    return Closer(*(value.cpu() for value in vars(found).values()))
