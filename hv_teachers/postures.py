"""How far to bend for the hands to reach somewhere: the least that brings both within the arms' length."""

from __future__ import annotations

import torch
from torch import Tensor

from hv_policy.motor.embodiment import FOREARM_M, SHOULDER_OFFSET_M, TORSO_OFFSET_M, UPPER_ARM_M
from hv_policy.motor.reference import PELVIS_PITCH_SHARE, feet_ahead

REACH_M = UPPER_ARM_M + FOREARM_M - 0.02
"""From shoulder to hand, the elbow not quite straight."""
DEEPEST = 1.06
"""Deepest bend: pelvis at .35 m, torso at 1.57 rad. Below that the knees are in the way of the chest."""
_CANDIDATES = 54


def bent_posture(bend: Tensor) -> tuple[Tensor, Tensor]:
    """Pelvis height in m and torso pitch in rad of a bend between 0 (upright) and `DEEPEST` (hands on the floor)."""
    return 0.84 - 0.46 * bend, 0.1 + 1.4 * bend**0.8


def reach_posture(hand_height_m: Tensor, ahead_of_feet_m: Tensor | None = None) -> tuple[Tensor, Tensor]:
    """Pelvis height and torso pitch that bring both hands to a place.

    Args:
        hand_height_m: (N,) above the floor.
        ahead_of_feet_m: (N,) of the hands before the ankles; left out, they are wherever is comfortable.

    Returns:
        height (N,) in m and pitch (N,) in rad.
    """
    bend = ((0.95 - hand_height_m) / 0.8).clamp(0, 1)
    if ahead_of_feet_m is not None:
        bend = torch.maximum(bend, _least_bend(hand_height_m, ahead_of_feet_m))
    return bent_posture(bend)


def _least_bend(hand_height_m: Tensor, ahead_of_feet_m: Tensor) -> Tensor:
    """(N,) smallest bend whose shoulders are within `REACH_M` of the hands; the nearest one where none is."""
    bends = torch.linspace(0.0, DEEPEST, _CANDIDATES, dtype=hand_height_m.dtype, device=hand_height_m.device)
    height, pitch = bent_posture(bends)
    lean = PELVIS_PITCH_SHARE * pitch
    # the pelvis stands back so far that the centre of mass stays over the feet
    ahead = TORSO_OFFSET_M[2] * lean.sin() + SHOULDER_OFFSET_M[2] * pitch.sin() - feet_ahead(height, pitch)
    above = height + TORSO_OFFSET_M[2] * lean.cos() + SHOULDER_OFFSET_M[2] * pitch.cos()
    gap = (ahead_of_feet_m[:, None] - ahead).square() + (hand_height_m[:, None] - above).square()
    reached = gap <= REACH_M**2
    first = torch.where(reached.any(1), reached.to(torch.uint8).argmax(1), gap.argmin(1))
    return bends[first]
