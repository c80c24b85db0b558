"""What is remembered from step to step: the phase of the work, its clock, and a few places of the past.

It is the scripted planner's own memory, held outside of it. With it in the input the planner is a function of what the
network sees, so that imitation has nothing hidden to guess; the network decides itself when a phase ends.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numba
import numpy as np
import torch
from torch import Tensor

from hv_policy.decision.view import Phase, TaskView
from hv_policy.motor.embodiment import CONTROL_DT_S
from hv_policy.motor.kinematics import Array, as_arrays
from hv_policy.motor.vectors import turned_xy

NUM_PHASES = len(Phase)
VECTOR_DIM = 1 + 1 + 6 + 6 + 3 + 1
_APPROACH, _REACH = int(Phase.APPROACH), int(Phase.REACH)
_SQUEEZE, _LIFT = int(Phase.SQUEEZE), int(Phase.LIFT)
_LOWER, _RELEASE = int(Phase.LOWER), int(Phase.RELEASE)


@dataclass
class TaskMemory:
    """One row per environment; heading frame with its origin on the floor below the pelvis unless said otherwise."""

    phase: Tensor  # (N,) int64, a `Phase`
    clock_s: Tensor  # (N,) time in the phase
    from_hands: Tensor  # (N, 2, 3) hands when the last squeeze, lift, lowering or letting go began
    offset: Tensor  # (N, 2, 3) hands relative to the object then
    from_object_w: Tensor  # (N, 3) the object then, world frame
    start_height: Tensor  # (N,) the object's height until it is squeezed; below 0: not looked yet

    @staticmethod
    def of(num: int) -> TaskMemory:
        """Fresh: about to approach."""
        return TaskMemory(
            phase=torch.zeros(num, dtype=torch.long),
            clock_s=torch.zeros(num),
            from_hands=torch.zeros(num, 2, 3),
            offset=torch.zeros(num, 2, 3),
            from_object_w=torch.zeros(num, 3),
            start_height=torch.full((num,), -1.0),
        )

    def reset(self, ids: Tensor) -> None:
        """Environments `ids` (n,) begin anew, and nothing of what was before shall matter."""
        self.phase[ids] = int(Phase.APPROACH)
        self.clock_s[ids] = 0.0
        self.from_hands[ids] = 0.0
        self.offset[ids] = 0.0
        self.from_object_w[ids] = 0.0
        self.start_height[ids] = -1.0

    def clone(self) -> TaskMemory:
        """A copy that shares nothing."""
        return TaskMemory(**{f.name: getattr(self, f.name).clone() for f in fields(self)})

    def where(self, chosen: Tensor, other: TaskMemory) -> TaskMemory:
        """These rows where `chosen` (N,) is true, the other's elsewhere."""
        merged = {}
        for f in fields(self):
            mine, theirs = getattr(self, f.name), getattr(other, f.name)
            merged[f.name] = torch.where(chosen.view(-1, *(1,) * (mine.ndim - 1)), mine, theirs)
        return TaskMemory(**merged)

    def advance(self, phase: Tensor, view: TaskView) -> Tensor:
        """Goes on to `phase` (N,), remembering what has to be; returns (N,) bool: the object was given up as lost.

        To hold something or to be done and then to approach again means that it was lost; such an environment needs a
        new route.
        """
        lost = torch.zeros(len(phase), dtype=torch.bool)
        remembered = self.clone()
        changing = (value.numpy() for value in (lost, *remembered._values))
        _advance(*as_arrays(phase, view.hands, view.object_pos, view.root_xy, view.root_yaw), *changing)
        remembered.phase = phase
        for f in fields(self):
            setattr(self, f.name, getattr(remembered, f.name))
        return lost

    @property
    def _values(self) -> list[Tensor]:
        return [getattr(self, f.name) for f in fields(self)]

    def tick(self) -> None:
        """A control step passes."""
        self.clock_s = self.clock_s + CONTROL_DT_S

    def vector(self, view: TaskView) -> Tensor:
        """(N, 18) phase, clock and places as numbers, heading frame."""
        vector = torch.empty(len(self.phase), VECTOR_DIM)
        _fill_vector(vector.numpy(), *as_arrays(*self._values, view.object_pos, view.root_xy, view.root_yaw))
        return vector


@numba.njit(cache=True)
def _advance(
    coming: Array,
    hands: Array,
    obj: Array,
    root_xy: Array,
    root_yaw: Array,
    lost: Array,
    phase: Array,
    clock_s: Array,
    from_hands: Array,
    offset: Array,
    from_object: Array,
    start_height: Array,
) -> None:
    """`TaskMemory.advance`: writes who lost the object (N,), and changes all but the phase (N,)."""
    for i in range(len(coming)):
        if start_height[i] < 0 or phase[i] <= _REACH:
            start_height[i] = obj[i, 2]
        if coming[i] == phase[i]:
            continue
        clock_s[i] = 0.0
        begun = coming[i] == _LIFT or coming[i] == _LOWER
        yaw, x, y = -np.float64(root_yaw[i]), np.float64(root_xy[i, 0]), np.float64(root_xy[i, 1])
        ahead, aside = turned_xy(yaw, obj[i, 0] - x, obj[i, 1] - y)
        if begun or coming[i] == _SQUEEZE or coming[i] == _RELEASE:
            for k in range(2):
                hand = turned_xy(yaw, hands[i, k, 0] - x, hands[i, k, 1] - y)
                from_hands[i, k, 0], from_hands[i, k, 1], from_hands[i, k, 2] = hand[0], hand[1], hands[i, k, 2]
                if begun:
                    offset[i, k, 0], offset[i, k, 1] = hand[0] - ahead, hand[1] - aside
                    offset[i, k, 2] = hands[i, k, 2] - obj[i, 2]
        if begun:
            from_object[i, 0], from_object[i, 1], from_object[i, 2] = obj[i, 0], obj[i, 1], obj[i, 2]
        lost[i] = coming[i] == _APPROACH and phase[i] >= _LIFT
        if lost[i]:
            start_height[i] = -1.0


@numba.njit(cache=True)
def _fill_vector(
    out: Array,
    phase: Array,
    clock_s: Array,
    from_hands: Array,
    offset: Array,
    from_object: Array,
    start_height: Array,
    obj: Array,
    root_xy: Array,
    root_yaw: Array,
) -> None:
    """`TaskMemory.vector`, (N, 18)."""
    for i in range(len(out)):
        out[i, 0], out[i, 1] = phase[i], clock_s[i]
        for k in range(2):
            for d in range(3):
                out[i, 2 + 3 * k + d] = from_hands[i, k, d]
                out[i, 8 + 3 * k + d] = offset[i, k, d]
        x, y = np.float64(from_object[i, 0]) - root_xy[i, 0], np.float64(from_object[i, 1]) - root_xy[i, 1]
        out[i, 14], out[i, 15] = turned_xy(-np.float64(root_yaw[i]), x, y)
        out[i, 16] = from_object[i, 2]
        out[i, 17] = obj[i, 2] if start_height[i] < 0 else start_height[i]
