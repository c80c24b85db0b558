"""What the policy has seen lately, kept separately for every environment of a batch."""

from collections import deque
from collections.abc import Sequence

import torch
from torch import Tensor


class VisualMemory:
    """Embeddings of the last `frames * stride` control steps; recalls every `stride`-th of them.

    An environment's memory is emptied by itself, and only for that environment, when its instruction changes: what was
    seen while following the last instruction must not steer the next. Call `clear` at the start of every rollout.

    Args:
        frames: how many past frames are recalled.
        stride: control steps between two of them.
    """

    def __init__(self, frames: int, stride: int):
        self.frames = frames
        self.stride = stride
        self._embeddings: deque[Tensor] = deque(maxlen=max(1, frames * stride))  # each (N, dim), newest last
        self._instructions: list[str] = []
        self._steps_known: list[int] = []  # per environment: steps stored since its memory was last emptied

    def clear(self) -> None:
        """Forget everything, of every environment."""
        self._embeddings.clear()
        self._instructions = []
        self._steps_known = []

    def recall(self, instructions: Sequence[str], dim: int, device: torch.device) -> tuple[Tensor, Tensor]:
        """Memory for the coming action, given each environment's present instruction.

        Args:
            instructions: of the N environments. Another number of environments than last time empties everything.
            dim: width of an embedding.
            device: where the result lives.

        Returns:
            Embeddings (N, frames, dim), oldest first, and which of them exist (N, frames) bool.
        """
        if len(instructions) != len(self._instructions):
            self.clear()
            self._steps_known = [0] * len(instructions)
        else:
            changed = (new != old for new, old in zip(instructions, self._instructions, strict=True))
            self._steps_known = [
                0 if is_new else known for is_new, known in zip(changed, self._steps_known, strict=True)
            ]
        self._instructions = list(instructions)

        recalled = torch.zeros(len(instructions), self.frames, dim, device=device)
        exists = torch.zeros(len(instructions), self.frames, dtype=torch.bool, device=device)
        known = torch.tensor(self._steps_known, device=device)
        for slot in range(self.frames):
            steps_back = (self.frames - slot) * self.stride
            if steps_back <= len(self._embeddings):
                recalled[:, slot] = self._embeddings[-steps_back]
                exists[:, slot] = known >= steps_back
        return recalled, exists

    def store(self, embedding: Tensor) -> None:
        """Remember the present frame, embedding (N, dim); to be called once a control step, after `recall`."""
        if self.frames:
            self._embeddings.append(embedding)
            self._steps_known = [known + 1 for known in self._steps_known]
