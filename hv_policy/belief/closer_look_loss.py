"""Where `hv_policy.belief.closer_look` looks in training, and how wrong it is there."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import torch
import torch.nn.functional as F
from torch import Tensor

from hv_policy.belief.attitude import FACES, UPRIGHT, attitude_of
from hv_policy.belief.camera import camera_position, project
from hv_policy.belief.closer_look import NEAREST_M, REACH_M, Closer, CloserLook, view_axes
from hv_policy.belief.outline import axes_of, compass_yaw_rad, half_sides_m, outline_of
from hv_policy.motor.proprioception import BodyState

SEEN_WEIGHT, OUTLINE_WEIGHT, FACES_WEIGHT, UPRIGHT_WEIGHT = 0.15, 0.5, 0.4, 0.6
_NEAR_M, _FAR_SHARE, _ANYWHERE_SHARE, _HEIGHT_M = 0.03, 0.05, 0.35, 0.07
"""By how much a place is believed wrongly: so far, so much more for each metre of distance; sometimes anywhere within
reach; and so much in height."""
_ELSEWHERE_SHARE, _ELSEWHERE_M = 0.12, (0.4, 1.0)
"""So often it is believed so far from where the thing is."""
FELL_SHARE = 0.6
"""So often, where the task's object lies on its side, it is that which is looked at."""
_SAME_M, _STANDS_FROM = 0.03, 0.97
"""The task's object is the thing that is so near to where it is; what is less upright than the second has fallen."""


@dataclass
class Things:
    """What there is in each of B pictures, heading frame."""

    boxes: Tensor  # (B, T, 7) as they stand or lie (`hv_policy.belief.boxes`)
    outline: Tensor  # (B, T, 3)
    attitude: Tensor  # (B, T, 3)
    fell: Tensor  # (B,) int64 which of them lies on its side, -1 for none
    near: Tensor  # (B, T) bool: it can be carried, is in view and near enough

    @staticmethod
    def of(boxes: Tensor, exists: Tensor, object_h: Tensor, rotation_6d: Tensor, half_extents_m: Tensor) -> Things:
        """From boxes (B, T, 7) of things that stand, of which `exists` (B, T), and where the task's object is (B, 3),
        how it is turned (B, 6) and its half extents (B, 3). What is in view is not known yet."""
        cos, sin, none = boxes[..., 6].cos(), boxes[..., 6].sin(), torch.zeros_like(boxes[..., 6])
        stands = torch.stack([cos, sin, none, -sin, cos, none], -1).flatten(0, 1)
        outline = outline_of(stands, boxes[..., 3:6].flatten(0, 1)).view(*boxes.shape[:2], 3)
        attitude = attitude_of(stands).view(*boxes.shape[:2], 3)
        away = (boxes[..., :3] - object_h[:, None]).norm(dim=-1).masked_fill(~exists, torch.inf)
        own, is_known = away.argmin(1), away.amin(1) < _SAME_M
        tilted = attitude_of(rotation_6d)
        fell = torch.where(is_known & (tilted[:, UPRIGHT] < _STANDS_FROM), own, -1)
        rows, boxes = (fell >= 0).nonzero()[:, 0], boxes.clone()
        at = rows, own[rows]
        outline[at], attitude[at] = outline_of(rotation_6d[rows], half_extents_m[rows]), tilted[rows]
        yaw = compass_yaw_rad(tilted[rows][:, FACES])
        high = (axes_of(rotation_6d[rows])[..., 2].abs() * half_extents_m[rows]).sum(1)
        lying = boxes[at].clone()
        lying[:, 3:] = torch.cat([half_sides_m(outline[at], yaw), high[:, None], yaw[:, None]], 1)
        boxes[at] = lying
        return Things(boxes, outline, attitude, fell, exists)

    def rows(self, rows: Tensor) -> Things:
        """Of some of the pictures."""
        return Things(*(getattr(self, f.name)[rows] for f in fields(self)))


@dataclass
class Looked:
    """A place that is looked at in each of B pictures, and what is there, heading frame."""

    place: Tensor  # (B, 3) m
    at: Tensor  # (B, 3) m, the middle of the thing that is nearest
    outline: Tensor  # (B, 3) of it
    attitude: Tensor  # (B, 3) of it
    is_there: Tensor  # (B,) bool: it is within reach
    counts: Tensor  # (B,) bool: the place is in view


def looks_to_learn(body: BodyState, things: Things) -> Looked:
    """A look in each of B pictures, mostly near a thing that can be carried."""
    camera = camera_position(body)
    middles, there = things.boxes[..., :3], things.near
    distance = (middles - camera[:, None])[..., :2].norm(dim=-1)
    rows = torch.arange(len(distance), device=distance.device)
    chosen = (torch.rand_like(distance) + there).argmax(1)
    fell = (things.fell >= 0) & there[rows, things.fell] & (torch.rand_like(distance[:, 0]) < FELL_SHARE)
    chosen = torch.where(fell, things.fell, chosen)
    at, away = middles[rows, chosen], distance[rows, chosen]

    def disc(least_m: float, most_m: float) -> Tensor:
        angle, share = 2 * math.pi * torch.rand_like(away), torch.rand_like(away)
        radius = (least_m**2 + share * (most_m**2 - least_m**2)).sqrt()
        return radius[:, None] * torch.stack([angle.cos(), angle.sin()], 1)

    near = (_NEAR_M + _FAR_SHARE * away)[:, None] * torch.randn_like(at[:, :2])
    moved = torch.where(torch.rand_like(away)[:, None] < _ANYWHERE_SHARE, disc(0.0, REACH_M), near)
    moved = torch.where(torch.rand_like(away)[:, None] < _ELSEWHERE_SHARE, disc(*_ELSEWHERE_M), moved)
    place = torch.cat([at[:, :2] + moved, at[:, 2:] + _HEIGHT_M * torch.randn_like(at[:, 2:])], 1)
    apart = (middles[..., :2] - place[:, None, :2]).norm(dim=-1).masked_fill(~there, torch.inf)
    nearest, row = apart.min(1)
    _, visible = project(body, place[:, None])
    counts = visible[:, 0] & ((place - camera)[:, :2].norm(dim=1) > NEAREST_M)
    found = middles[rows, row], things.outline[rows, row], things.attitude[rows, row]
    return Looked(place, *found, nearest < REACH_M, counts)


def closer_loss(seen: Closer, axes: Tensor, truth: Looked) -> tuple[Tensor, Tensor]:
    """(B,) how wrong closer looks are, and (B, 3) by how much their places are (m): along the view, across it, upward.

    The place's likelihood is that of a Laplace distribution under the deviation that is said, weighted by its square
    root (beta-NLL, Seitzer et al. 2022, beta = 0.5).

    Args:
        seen: what is said.
        axes: (B, 3, 3) of the views (`view_axes`).
        truth: what is so.
    """
    wrong = ((seen.at - truth.at)[:, None] @ axes.mT)[:, 0].abs()
    spread = seen.log_spread
    likely = ((wrong / spread.exp() + spread) * (0.5 * spread.detach()).exp()).sum(1)
    turned = (seen.attitude - truth.attitude).square()
    shape = OUTLINE_WEIGHT * (seen.outline - truth.outline).abs().sum(1)
    shape = shape + FACES_WEIGHT * turned[:, FACES].sum(1) + UPRIGHT_WEIGHT * turned[:, UPRIGHT]
    there = F.binary_cross_entropy_with_logits(seen.seen, truth.is_there.float(), reduction="none")
    return ((likely + shape) * truth.is_there + SEEN_WEIGHT * there) * truth.counts, wrong.detach()


def closer_look_loss(
    head: CloserLook, pictures: Tensor, body: BodyState, things: Things
) -> tuple[Tensor, dict[str, Tensor]]:
    """(B,) how wrong a closer look at one place of each of B pictures (B, 3, S, S) is, and figures to watch."""
    truth = looks_to_learn(body, things)
    mirrored = (torch.rand_like(truth.place[:, 0]) < 0.5) if head.training else None
    seen = head(pictures, body, truth.place, mirrored)
    loss, wrong = closer_loss(seen, view_axes(body, truth.place), truth)
    with torch.no_grad():
        believed, there = seen.seen > 0, truth.counts & truth.is_there
        none = truth.counts & ~truth.is_there
        figures = {f"closer_{name}_m": _median(wrong[there][:, k]) for k, name in enumerate(("ahead", "aside", "up"))}
        yaw = compass_yaw_rad(truth.attitude[:, FACES])
        said, is_so = (half_sides_m(x.outline, yaw)[there] for x in (seen, truth))
        figures["closer_width_m"] = _median(2 * (said - is_so).abs())
        figures["closer_upright"] = _median((seen.attitude - truth.attitude)[there, UPRIGHT].abs())
        figures["closer_missed"] = (~believed)[there].float().mean()
        figures["closer_imagined"] = believed[none].float().mean()
    return loss, figures


def _median(values: Tensor) -> Tensor:
    return values.median() if values.numel() else torch.tensor(float("nan"))
