"""What a motor prior is told: 14 numbers, in the robot's heading frame (origin on the floor below the pelvis).

| number | what it is |
|---|---|
| 0, 1, 2 | velocity forward and to the left, m/s, and turning to the left, rad/s |
| 3, 4 | height of the pelvis above the floor, m; pitch of the torso, forward, rad |
| 5-7, 8-10 | where the left and the right hand should be, m (everywhere else the right one comes first) |
| 11 | squeeze, 0 to 1: how strongly the hands press toward each other |
| 12, 13 | gaze to the left and down, rad |
"""

from __future__ import annotations

import torch
from torch import Tensor

INTENT_DIM = 14
VELOCITY, HEIGHT, PITCH = slice(0, 3), 3, 4
LEFT_HAND, RIGHT_HAND, SQUEEZE, GAZE = slice(5, 8), slice(8, 11), 11, slice(12, 14)
INTENT_LOW = (-0.6, -0.5, -1.5, 0.3, -0.3, -0.3, -0.5, 0.0, -0.3, -0.9, 0.0, 0.0, -0.8, -0.7)
INTENT_HIGH = (1.2, 0.5, 1.5, 0.92, 1.6, 1.0, 0.9, 1.9, 1.0, 0.5, 1.9, 1.0, 0.8, 1.0)
"""Least and greatest value of each number that deciders say, in its own unit; a motor prior does not cut off."""


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
