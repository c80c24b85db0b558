"""What is remembered from step to step: the phase of the work, its clock, and a few places of the past.

It is the scripted planner's own memory, held outside of it. With it in the input the planner is a function of what the
network sees, so that imitation has nothing hidden to guess; the network decides itself when a phase ends.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import torch
from torch import Tensor

from hv_policy.decision.view import Phase, TaskView, to_heading
from hv_policy.motor.embodiment import CONTROL_DT_S

NUM_PHASES = len(Phase)
VECTOR_DIM = 1 + 1 + 6 + 6 + 3 + 1


@dataclass
class TaskMemory:
    """One row per environment; heading frame with its origin on the floor below the pelvis unless said otherwise."""

    phase: Tensor  # (N,) int64, a `Phase`
    clock_s: Tensor  # (N,) time in the phase
    from_hands: Tensor  # (N, 2, 3) hands when the last squeeze, lift, lowering or letting go began
    offset: Tensor  # (N, 2, 3) hands relative to the object then
    from_object_w: Tensor  # (N, 3) the object then, world frame
    start_height: Tensor  # (N,) the object's height at the first look; below 0: not looked yet

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
        unset = self.start_height < 0
        self.start_height = torch.where(unset, view.object_pos[:, 2], self.start_height)
        changed = phase != self.phase
        lost = changed & (phase == Phase.APPROACH) & (self.phase >= Phase.LIFT)
        begun = changed & ((phase == Phase.LIFT) | (phase == Phase.LOWER))
        hands = to_heading(view, view.hands)
        offset = hands - to_heading(view, view.object_pos[:, None])
        pressed = changed & ((phase == Phase.SQUEEZE) | (phase == Phase.RELEASE))
        self.from_hands = torch.where((begun | pressed)[:, None, None], hands, self.from_hands)
        self.offset = torch.where(begun[:, None, None], offset, self.offset)
        self.from_object_w = torch.where(begun[:, None], view.object_pos, self.from_object_w)
        self.start_height = torch.where(lost, -torch.ones_like(self.start_height), self.start_height)
        self.clock_s = torch.where(changed, torch.zeros_like(self.clock_s), self.clock_s)
        self.phase = phase
        return lost

    def tick(self) -> None:
        """A control step passes."""
        self.clock_s = self.clock_s + CONTROL_DT_S

    def vector(self, view: TaskView) -> Tensor:
        """(N, 18) phase, clock and places as numbers, heading frame."""
        return torch.cat(
            [
                self.phase[:, None].to(torch.float32),
                self.clock_s[:, None],
                self.from_hands.flatten(1),
                self.offset.flatten(1),
                to_heading(view, self.from_object_w[:, None])[:, 0],
                torch.where(self.start_height < 0, view.object_pos[:, 2], self.start_height)[:, None],
            ],
            -1,
        )
