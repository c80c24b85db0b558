"""Where `hv_policy.belief.closer_look` looks in training, and how wrong it is there."""

from __future__ import annotations

import math

import torch
from torch import Tensor

from hv_policy.belief.boxes import can_be_carried
from hv_policy.belief.camera import camera_position, project
from hv_policy.belief.closer_look import FARTHEST_M, NEAREST_M, REACH_M, CloserLook, closer_loss, view_axes
from hv_policy.motor.proprioception import BodyState

_NEAR_M, _FAR_SHARE, _ANYWHERE_SHARE, _HEIGHT_M = 0.03, 0.05, 0.5, 0.07
"""By how much a place is believed wrongly: so far, so much more for each metre of distance; half of the time anywhere
within reach; and so much in height."""
_ELSEWHERE_SHARE, _ELSEWHERE_M = 0.15, (0.4, 1.0)
"""So often it is believed so far from where the thing is,"""
_FURNITURE_SHARE, _ABOVE_M = 0.2, 0.2
"""and so often somewhere in a piece of furniture, or so far above it at most."""


def looks_to_learn(body: BodyState, boxes: Tensor, in_view: Tensor) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    """A place that is looked at in each of B pictures, (B, 3) in m, heading frame; (B, 3) where the thing there is, and
    (B,) bool whether there is one that can be carried; and (B,) bool whether the look counts.

    Args:
        body: of the robots.
        boxes: (B, T, 7) of things (`hv_policy.belief.boxes`).
        in_view: (B, T) bool.
    """
    camera = camera_position(body)
    middles = boxes[..., :3]
    distance = (middles - camera[:, None])[..., :2].norm(dim=-1)
    there = can_be_carried(boxes) & in_view & (distance < FARTHEST_M)
    rows = torch.arange(len(distance), device=distance.device)
    chosen = (torch.rand_like(distance) + there).argmax(1)
    at, away = middles[rows, chosen], distance[rows, chosen]

    def disc(least_m: float, most_m: float) -> Tensor:
        angle, share = 2 * math.pi * torch.rand_like(away), torch.rand_like(away)
        radius = (least_m**2 + share * (most_m**2 - least_m**2)).sqrt()
        return radius[:, None] * torch.stack([angle.cos(), angle.sin()], 1)

    near = (_NEAR_M + _FAR_SHARE * away)[:, None] * torch.randn_like(at[:, :2])
    moved = torch.where(torch.rand_like(away)[:, None] < _ANYWHERE_SHARE, disc(0.0, REACH_M), near)
    moved = torch.where(torch.rand_like(away)[:, None] < _ELSEWHERE_SHARE, disc(*_ELSEWHERE_M), moved)
    place = torch.cat([at[:, :2] + moved, at[:, 2:] + _HEIGHT_M * torch.randn_like(at[:, 2:])], 1)
    furniture = in_view & ~can_be_carried(boxes) & (distance < FARTHEST_M)
    chosen = (torch.rand_like(distance) + furniture).argmax(1)
    inside = boxes[rows, chosen, 3:6] * (2 * torch.rand_like(at) - 1)
    inside[:, 2] += _ABOVE_M * torch.rand_like(away)
    instead = furniture.any(1) & (torch.rand_like(away) < _FURNITURE_SHARE)
    place = torch.where(instead[:, None], middles[rows, chosen] + inside, place)
    apart = (middles[..., :2] - place[:, None, :2]).norm(dim=-1).masked_fill(~there, torch.inf)
    nearest, row = apart.min(1)
    _, visible = project(body, place[:, None])
    counts = visible[:, 0] & ((place - camera)[:, :2].norm(dim=1) > NEAREST_M)
    return place, middles[rows, row], nearest < REACH_M, counts


def closer_look_loss(
    head: CloserLook, pictures: Tensor, body: BodyState, boxes: Tensor, in_view: Tensor
) -> tuple[Tensor, dict[str, Tensor]]:
    """(B,) how wrong a closer look at one place of each of B pictures (B, 3, S, S) is, and figures to watch; for the
    other arguments see `looks_to_learn`."""
    place, truth, is_there, counts = looks_to_learn(body, boxes, in_view)
    mirrored = (torch.rand_like(place[:, 0]) < 0.5) if head.training else None
    seen = head(pictures, body, place, mirrored)
    loss, wrong = closer_loss(seen, view_axes(body, place), truth, is_there)
    with torch.no_grad():
        believed, there, none = seen.seen > 0, counts & is_there, counts & ~is_there
        figures = {f"closer_{name}_m": _median(wrong[there][:, k]) for k, name in enumerate(("ahead", "aside", "up"))}
        figures["closer_missed"] = (~believed)[there].float().mean()
        figures["closer_imagined"] = believed[none].float().mean()
    return loss * counts, figures


def _median(values: Tensor) -> Tensor:
    return values.median() if values.numel() else torch.tensor(float("nan"))
