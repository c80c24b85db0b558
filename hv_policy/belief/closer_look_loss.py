"""Where `hv_policy.belief.closer_look` looks in training, and how wrong it is there."""

from __future__ import annotations

import math

import torch
import torch.nn.functional as F
from torch import Tensor

from hv_policy.belief.boxes import can_be_carried
from hv_policy.belief.camera import camera_position, project
from hv_policy.belief.closer_look import FARTHEST_M, NEAREST_M, REACH_M, CloserLook, Thing, closer_loss, view_axes
from hv_policy.belief.places import MIDDLE, OBJECT
from hv_policy.motor.proprioception import BodyState

_SAME_M = 0.05
_NEAR_M, _FAR_SHARE, _ANYWHERE_SHARE, _HEIGHT_M = 0.03, 0.05, 0.5, 0.07
"""By how much a place is believed wrongly: so far, so much more for each metre of distance; half of the time anywhere
within reach; and so much in height."""
_ELSEWHERE_SHARE, _ELSEWHERE_M = 0.15, (0.4, 1.0)
"""So often it is believed so far from where the thing is."""
_OTHERS_SHARE = 0.3
"""So often another thing than the task's object is looked at where that is in view."""


def things_of(boxes: Tensor, places: Tensor, rotation_6d: Tensor, half_extents_m: Tensor) -> tuple[Thing, Tensor]:
    """T things in each of B pictures (`is_there`: they can be carried), and (B, T) bool which is the task's object: of
    that alone it is known how it is turned, if it fell, and where it is held.

    Args:
        boxes: (B, T, 7), `hv_policy.belief.boxes`.
        places: (B, 21) of the task, `hv_policy.belief.places`.
        rotation_6d, half_extents_m: (B, 6) and (B, 3) of its object.
    """
    cos, sin = boxes[..., 6].cos(), boxes[..., 6].sin()
    zero = torch.zeros_like(cos)
    standing = torch.stack([cos, sin, zero, -sin, cos, zero], -1)
    is_object = (boxes[..., :3] - places[:, None, OBJECT]).norm(dim=-1) < _SAME_M
    here = is_object[..., None]
    above = torch.where(is_object, places[:, None, MIDDLE.stop - 1], torch.nan)
    half = torch.where(here, half_extents_m[:, None], boxes[..., 3:6])
    rotation = torch.where(here, rotation_6d[:, None], standing)
    return Thing(boxes[..., :3], rotation, half, above, is_object | can_be_carried(boxes)), is_object


def looks_to_learn(body: BodyState, things: Thing, in_view: Tensor, is_object: Tensor) -> tuple[Tensor, Thing, Tensor]:
    """A place that is looked at in each of B pictures, (B, 3) in m, heading frame; what is there; and (B,) bool whether
    it counts.

    Args:
        body: of the robots.
        things: T in each picture, as `things_of` has them.
        in_view: (B, T) bool.
        is_object: (B, T) bool.
    """
    camera = camera_position(body)
    distance = (things.at_h - camera[:, None])[..., :2].norm(dim=-1)
    there = things.is_there & in_view & (distance < FARTHEST_M)
    likely = torch.rand_like(distance) + 2 * there
    other = torch.rand(len(distance), 1, device=distance.device) < _OTHERS_SHARE
    likely = likely + (is_object & there & ~other)
    chosen = likely.argmax(1)
    rows = torch.arange(len(chosen), device=chosen.device)
    at, away = things.at_h[rows, chosen], distance[rows, chosen]

    def disc(least_m: float, most_m: float) -> Tensor:
        angle, share = 2 * math.pi * torch.rand_like(away), torch.rand_like(away)
        radius = (least_m**2 + share * (most_m**2 - least_m**2)).sqrt()
        return radius[:, None] * torch.stack([angle.cos(), angle.sin()], 1)

    near = (_NEAR_M + _FAR_SHARE * away)[:, None] * torch.randn_like(at[:, :2])
    moved = torch.where(torch.rand_like(away)[:, None] < _ANYWHERE_SHARE, disc(0.0, REACH_M), near)
    moved = torch.where(torch.rand_like(away)[:, None] < _ELSEWHERE_SHARE, disc(*_ELSEWHERE_M), moved)
    place = torch.cat([at[:, :2] + moved, at[:, 2:] + _HEIGHT_M * torch.randn_like(at[:, 2:])], 1)
    apart = (things.at_h[..., :2] - place[:, None, :2]).norm(dim=-1).masked_fill(~there, torch.inf)
    nearest, row = apart.min(1)
    known = Thing(
        things.at_h[rows, row],
        things.rotation_6d[rows, row],
        things.half_extents_m[rows, row],
        things.above_m[rows, row],
        nearest < REACH_M,
    )
    _, visible = project(body, place[:, None])
    counts = visible[:, 0] & ((place - camera)[:, :2].norm(dim=1) > NEAREST_M)
    return place, known, counts


def closer_look_loss(
    head: CloserLook, pictures: Tensor, body: BodyState, things: Thing, in_view: Tensor, is_object: Tensor
) -> tuple[Tensor, dict[str, Tensor]]:
    """(B,) how wrong a closer look at one place of each of B pictures (B, 3, S, S) is, and figures to watch; for the
    other arguments see `looks_to_learn`."""
    place, known, counts = looks_to_learn(body, things, in_view, is_object)
    mirrored = (torch.rand_like(place[:, 0]) < 0.5) if head.training else None
    seen = head(pictures, body, place, mirrored)
    loss, wrong = closer_loss(seen, view_axes(body, place), known)
    there = counts & known.is_there
    with torch.no_grad():
        missed = F.logsigmoid(seen.seen) < math.log(0.5)
        figures = {f"closer_{name}_m": _median(wrong[there][:, k]) for k, name in enumerate(("ahead", "aside", "up"))}
        figures["closer_missed"] = missed[there].float().mean()
        figures["closer_imagined"] = (~missed[counts & ~known.is_there]).float().mean()
        held = (seen.above_m - known.above_m).abs()
        figures["closer_held_m"] = _median(held[there & held.isfinite()])
    return loss * counts, figures


def _median(values: Tensor) -> Tensor:
    return values.median() if values.numel() else torch.tensor(float("nan"))
