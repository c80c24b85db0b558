"""The two ways to drive the humanoid: 28 joint targets, or 14 intents that a controller turns into joint targets.

The paper's action is the 28 targets (Table 13). The intent is the narrow interface between deciding and moving: what a
planner, a teacher or a student says, and what a motor prior, trained once, knows how to do.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from torch import Tensor

INTENT_NAMES = (
    "velocity_forward", "velocity_left", "yaw_rate",
    "pelvis_height", "torso_pitch",
    "left_hand_x", "left_hand_y", "left_hand_z",
    "right_hand_x", "right_hand_y", "right_hand_z",
    "squeeze",
    "gaze_yaw", "gaze_pitch",
)  # fmt: skip
"""Root velocity in m/s and rad/s, pelvis height above the floor in m, torso pitch in rad (forward is positive), hand
targets in m in the heading frame with its origin on the floor below the pelvis (z is the height above the floor),
squeeze 0 to 1, gaze in rad (left and down are positive)."""

NUM_INTENTS = len(INTENT_NAMES)

_RANGES = {
    "velocity_forward": (-0.6, 1.2), "velocity_left": (-0.5, 0.5), "yaw_rate": (-1.5, 1.5),
    "pelvis_height": (0.3, 0.92), "torso_pitch": (-0.3, 1.6),
    "left_hand_x": (-0.3, 1.0), "left_hand_y": (-0.5, 0.9), "left_hand_z": (0.0, 1.9),
    "right_hand_x": (-0.3, 1.0), "right_hand_y": (-0.9, 0.5), "right_hand_z": (0.0, 1.9),
    "squeeze": (0.0, 1.0),
    "gaze_yaw": (-0.8, 0.8), "gaze_pitch": (-0.7, 1.0),
}  # fmt: skip

INTENT_LOW = np.array([_RANGES[name][0] for name in INTENT_NAMES], dtype=np.float32)
"""(14,) least value of each intent, in the units of `INTENT_NAMES`."""
INTENT_HIGH = np.array([_RANGES[name][1] for name in INTENT_NAMES], dtype=np.float32)
"""(14,) greatest value of each intent, in the units of `INTENT_NAMES`."""

CONTROL_MODES = ("joint", "intent")


class Controller(Protocol):
    """Turns intents into joint targets; may keep a memory (a gait clock) for each environment."""

    def reset(self, ids: Tensor | None = None) -> None:
        """Forgets what it remembers of environments `ids` (int64, default: all): a new episode begins there."""

    def __call__(self, proprioception: Tensor, intent: Tensor) -> Tensor:
        """Joint targets (N, 28) in radians from proprioception (N, 223) and intents (N, 14), float32."""
