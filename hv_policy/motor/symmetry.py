"""Left-right symmetry by construction: the residual network always sees the right foot as the one that swings.

A robot whose left foot swings is shown to the network reflected in its sagittal plane, and what the network answers is
reflected back. So the controller cannot favour a side, and has half as much to learn (canonicalisation; compare
Abdolhosseini et al., "On Learning Symmetric Locomotion", 2019, section 3.4).
"""

from __future__ import annotations

import torch
from torch import Tensor

from hv_policy.motor import embodiment as body

_MIRROR_BODIES = [0, 1, 2, 6, 7, 8, 3, 4, 5, 12, 13, 14, 9, 10, 11]
_POLAR, _AXIAL = (1.0, -1.0, 1.0), (-1.0, 1.0, -1.0)
_X_COLUMN, _Y_COLUMN = _POLAR, _AXIAL  # of a rotation matrix R, which becomes S R S with S = diag(1, -1, 1)


class Reflection:
    """A signed permutation, built block by block; `reflection(x)` reflects (N, D)."""

    def __init__(self) -> None:
        self._index: list[int] = []
        self._sign: list[float] = []
        self.index = torch.zeros(0, dtype=torch.long)
        self.sign = torch.zeros(0)

    def signs(self, *signs: float) -> Reflection:
        """Numbers that stay where they are and take these signs."""
        return self.swapped(1, signs)

    def swapped(self, order: int | list[int], signs: tuple[float, ...]) -> Reflection:
        """Rows of numbers, each with these signs, in another order (their number, or where each comes from)."""
        rows = list(range(order)) if isinstance(order, int) else order
        start, width = len(self._index), len(signs)
        for row in rows:
            self._index += [start + row * width + k for k in range(width)]
            self._sign += list(signs)
        self.index, self.sign = torch.tensor(self._index), torch.tensor(self._sign)
        return self

    def joints(self) -> Reflection:
        """The 28 joints."""
        start = len(self._index)
        self._index += [start + int(j) for j in body.MIRROR_JOINTS]
        self._sign += body.MIRROR_JOINT_SIGN.tolist()
        self.index, self.sign = torch.tensor(self._index), torch.tensor(self._sign)
        return self

    def proprioception(self) -> Reflection:
        """The 223 numbers of `hv_policy.motor.proprioception`."""
        links = [b - 1 for b in _MIRROR_BODIES[1:]]
        self.signs(1.0).swapped(links, _POLAR).swapped(_MIRROR_BODIES, (*_X_COLUMN, *_Y_COLUMN))
        return self.swapped(_MIRROR_BODIES, _POLAR).swapped(_MIRROR_BODIES, _AXIAL)

    def intent(self) -> Reflection:
        """The 14 numbers of an intent: the hands change places."""
        self.signs(1.0, -1.0, -1.0, 1.0, 1.0).swapped([1, 0], _POLAR)
        return self.signs(1.0, -1.0, 1.0)

    def __len__(self) -> int:
        return len(self._index)

    def __call__(self, values: Tensor) -> Tensor:
        return values[..., self.index.to(values.device)] * self.sign.to(values)

    def where(self, chosen: Tensor, values: Tensor) -> Tensor:
        """Reflects the rows `chosen` (N,) bool of (N, D)."""
        return torch.where(chosen[:, None], self(values), values)


JOINTS = Reflection().joints()
POLAR, AXIAL = _POLAR, _AXIAL
