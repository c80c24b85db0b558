"""What an expert knew when it decided, as columns of a recorded dataset: what a student is taught to see."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from hv_policy.belief.places import PLACES_DIM, WAY_DIM
from hv_policy.belief.task_places import places_of, way_of
from hv_policy.decision.memory import VECTOR_DIM
from hv_policy.decision.view import TaskView

KNOWLEDGE_COLUMNS = {
    "privileged.places": PLACES_DIM,
    "privileged.way": WAY_DIM,
    "privileged.memory": VECTOR_DIM,
    "privileged.phase": 1,
}


@dataclass
class Knowledge:
    """One row per environment; heading frame."""

    places: Tensor  # (N, 21), hv_policy.belief.places
    way: Tensor  # (N, 8)
    memory: Tensor  # (N, 18) before the phase went on, hv_policy.decision.memory
    phase: Tensor  # (N,) the one that it went on to

    @staticmethod
    def of(view: TaskView, leg_is_done: Tensor, memory: Tensor, phase: Tensor) -> Knowledge:
        """Of a view, whether the leg is done (N,), the memory (N, 18) and the phase decided (N,)."""
        return Knowledge(places_of(view), way_of(view, leg_is_done), memory, phase)

    def columns(self) -> dict[str, Tensor]:
        """`KNOWLEDGE_COLUMNS`, (N, size) each."""
        rows = (self.places, self.way, self.memory, self.phase[:, None].float())
        return dict(zip(KNOWLEDGE_COLUMNS, rows, strict=True))


def no_knowledge(num: int) -> dict[str, Tensor]:
    """`KNOWLEDGE_COLUMNS` of `num` environments where nobody can say: zeros."""
    return {name: torch.zeros(num, size) for name, size in KNOWLEDGE_COLUMNS.items()}
