"""What a motor prior is told: 14 numbers, in the robot's heading frame."""

from __future__ import annotations

import torch
from torch import Tensor

INTENT_DIM = 14
VELOCITY, HEIGHT, PITCH = slice(0, 3), 3, 4
LEFT_HAND, RIGHT_HAND, SQUEEZE, GAZE = slice(5, 8), slice(8, 11), 11, slice(12, 14)
INTENT_LOW = (-0.6, -0.5, -1.5, 0.3, -0.3, -0.3, -0.5, 0.0, -0.3, -0.9, 0.0, 0.0, -0.8, -0.7)
INTENT_HIGH = (1.2, 0.5, 1.5, 0.92, 1.6, 1.0, 0.9, 1.9, 1.0, 0.5, 1.9, 1.0, 0.8, 1.0)
"""Least and greatest value of each number of an intent, in its own unit."""


def neutral_intent(num: int) -> Tensor:
    """(num, 14): stand upright, arms hanging, looking ahead and a little down."""
    intent = torch.zeros(num, INTENT_DIM)
    intent[:, HEIGHT] = 0.84
    intent[:, LEFT_HAND] = torch.tensor([0.10, 0.24, 0.86])
    intent[:, RIGHT_HAND] = torch.tensor([0.10, -0.24, 0.86])
    intent[:, GAZE] = torch.tensor([0.0, 0.3])
    return intent


def split_hands(intent: Tensor) -> Tensor:
    """(N, 14) -> (N, 2, 3) hand targets, right then left."""
    return torch.stack([intent[:, RIGHT_HAND], intent[:, LEFT_HAND]], 1)
