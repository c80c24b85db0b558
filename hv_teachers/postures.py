"""How far to bend for the hands to reach somewhere: the least that brings both within the arms' length."""

from __future__ import annotations

import torch
from torch import Tensor

from hv_policy.motor.embodiment import FOREARM_M, SHOULDER_OFFSET_M, TORSO_OFFSET_M, UPPER_ARM_M
from hv_policy.motor.gait import PELVIS_PITCH_SHARE
from hv_policy.motor.reference import feet_ahead

REACH_M = UPPER_ARM_M + FOREARM_M - 0.07
"""From shoulder to hand, the elbow far from straight: with 2 cm instead of 7 the hands ended 3 cm short."""
HINGE = 0.6
"""The bend at which the knees begin to take part."""
DEEPEST = 1.06
"""Deepest bend: pelvis at .32 m, torso at 1.52 rad. Below that the knees are in the way of the chest."""
_CANDIDATES = 54


def bent_posture(bend: Tensor) -> tuple[Tensor, Tensor]:
    """Pelvis height in m and torso pitch in rad of a bend between 0 (upright) and `DEEPEST` (hands on the floor).

    First the hips bend and the knees stay back, so that they do not push the table that stands before them; only what
    lies lower than that is squatted for.
    """
    hinge, squat = (bend / HINGE).clamp(0, 1), ((bend - HINGE) / (1 - HINGE)).clamp(min=0)
    return 0.84 - 0.11 * hinge - 0.35 * squat, 0.1 + 1.2 * hinge + 0.2 * squat


def reach_posture(
    hand_height_m: Tensor, ahead_of_feet_m: Tensor | None = None, apart_m: Tensor | None = None
) -> tuple[Tensor, Tensor]:
    """Pelvis height and torso pitch that bring both hands to a place.

    Args:
        hand_height_m: (N,) above the floor.
        ahead_of_feet_m: (N,) of the hands before the ankles; left out, they are wherever is comfortable.
        apart_m: (N,) between the hands; left out, they are as far apart as the shoulders.

    Returns:
        height (N,) in m and pitch (N,) in rad.
    """
    bend = ((0.95 - hand_height_m) / 0.8).clamp(0, 1)
    if ahead_of_feet_m is not None:
        shoulders = 2 * SHOULDER_OFFSET_M[1]
        aside = torch.zeros_like(bend) if apart_m is None else (apart_m - shoulders).abs() / 2
        bend = torch.maximum(bend, _least_bend(hand_height_m, ahead_of_feet_m, aside))
    return bent_posture(bend)


def _least_bend(hand_height_m: Tensor, ahead_of_feet_m: Tensor, aside_m: Tensor) -> Tensor:
    """(N,) smallest bend whose shoulders are within `REACH_M` of the hands; the nearest one where none is."""
    bends = torch.linspace(0.0, DEEPEST, _CANDIDATES, dtype=hand_height_m.dtype, device=hand_height_m.device)
    height, pitch = bent_posture(bends)
    lean = PELVIS_PITCH_SHARE * pitch
    # the pelvis stands back so far that the centre of mass stays over the feet
    ahead = TORSO_OFFSET_M[2] * lean.sin() + SHOULDER_OFFSET_M[2] * pitch.sin() - feet_ahead(height, pitch)
    above = height + TORSO_OFFSET_M[2] * lean.cos() + SHOULDER_OFFSET_M[2] * pitch.cos()
    gap = (ahead_of_feet_m[:, None] - ahead).square() + (hand_height_m[:, None] - above).square()
    gap = gap + aside_m[:, None].square()
    reached = gap <= REACH_M**2
    first = torch.where(reached.any(1), reached.to(torch.uint8).argmax(1), gap.argmin(1))
    return bends[first]
