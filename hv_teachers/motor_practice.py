"""The motor prior's practice, on the ground and in rooms, as one batch of environments."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import torch
from torch import Tensor


class Practice(Protocol):
    """Environments in which the residual of a motor prior is practised."""

    num_envs: int
    has_load: Tensor
    """(N,) bool: it is about a load."""

    @property
    def dropped(self) -> Tensor:
        """(N,) bool: the load slipped out of the hands in the last step."""

    @property
    def features(self) -> Tensor:
        """(N, FEATURE_DIM) what the residual network sees."""

    @property
    def critic_extra(self) -> Tensor:
        """(N, E) what the critic sees besides (`hv_teachers.motor_critic`)."""

    def step(self, residual: Tensor) -> tuple[Tensor, Tensor, Tensor, dict[str, Tensor]]:
        """One control step. (N, 28) -> rewards (N,), failures (N,) bool, time-outs (N,) bool, terms {name: (N,)}."""


class Practices:
    """Several of them, one after the other in the batch."""

    def __init__(self, parts: Sequence[Practice]) -> None:
        self.parts = parts
        self._sizes = [part.num_envs for part in parts]
        self.num_envs = sum(self._sizes)
        self.has_load = torch.cat([part.has_load for part in parts])

    @property
    def dropped(self) -> Tensor:
        """See `Practice`."""
        return torch.cat([part.dropped for part in self.parts])

    @property
    def features(self) -> Tensor:
        """See `Practice`."""
        return torch.cat([part.features for part in self.parts])

    @property
    def critic_extra(self) -> Tensor:
        """See `Practice`."""
        return torch.cat([part.critic_extra for part in self.parts])

    def step(self, residual: Tensor) -> tuple[Tensor, Tensor, Tensor, dict[str, Tensor]]:
        """See `Practice`; a term that a part does not have is 0 there."""
        steps = [part.step(own) for part, own in zip(self.parts, residual.split(self._sizes), strict=True)]
        reward, failed, timed_out = (torch.cat([s[i] for s in steps]) for i in range(3))
        names = dict.fromkeys(name for s in steps for name in s[3])
        terms = {
            name: torch.cat([s[3].get(name, torch.zeros_like(s[0])) for s in steps]) for name in names
        }
        return reward, failed, timed_out, terms
