"""Who gives up what it was bent for stands up before it walks: who walks while it rises falls."""

from __future__ import annotations

import torch
from torch import Tensor

from hv_policy.decision.view import Phase
from hv_policy.motor.embodiment import CONTROL_DT_S
from hv_policy.motor.intent import VELOCITY

RISE_S = 1.5


class Rising:
    """Keeps, for each of N robots, how long it has still to rise, and the intent that it rises from."""

    def __init__(self, num_envs: int) -> None:
        self.left_s = torch.zeros(num_envs)
        """(N,)."""
        self.intent = torch.zeros(num_envs, 14)
        """(N, 14) the last one."""

    def reset(self, ids: Tensor) -> None:
        """Robots `ids` (n,) stand."""
        self.left_s[ids] = 0.0

    def begin(self, bent: Tensor) -> None:
        """Those that are `bent` (N,) bool rise from now on."""
        self.left_s = torch.where(bent, torch.full_like(self.left_s, RISE_S), self.left_s)

    def begin_where_given_up(self, before: Tensor, phase: Tensor) -> None:
        """From phases (N,) before and after a step."""
        self.begin((before >= Phase.REACH) & (before <= Phase.RELEASE) & (phase < Phase.REACH))

    def __call__(self, intent: Tensor) -> Tensor:
        """(N, 14) the intent, but who rises comes to it bit by bit, and to a stop."""
        share = (CONTROL_DT_S / self.left_s.clamp(min=CONTROL_DT_S))[:, None]
        rising = self.intent + share * (intent - self.intent)
        rising[:, VELOCITY] = (1 - share) * self.intent[:, VELOCITY]
        self.intent = torch.where((self.left_s > 0)[:, None], rising, intent)
        self.left_s = (self.left_s - CONTROL_DT_S).clamp(min=0.0)
        return self.intent
