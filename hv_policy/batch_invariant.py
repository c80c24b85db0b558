"""Operations whose answer to a row does not depend, in a single bit, on the rows beside it.

A matrix product picks its kernel, and with it the order of its sums, by the number of rows, and in a simulation that is
chaotic the last bit decides an episode. So do some functions of single elements: PyTorch computes 32 at a time one way
and what is left over another, and for atan2, sinh, elu and sigmoid the two differ. (They are alike for sin, cos, exp,
tanh, roots, norms and small matrices; elu is safe where a row has a multiple of 32 elements.)
"""

from __future__ import annotations

import math

import numba
import torch
from torch import Tensor, nn


class BatchInvariantLinear(nn.Linear):
    """`nn.Linear`, computed row by row (`torch.bmm`) in `eval` mode without gradients: the cost is about twofold.

    In training it is `nn.Linear`, for speed. Inputs are (N, in_features).
    """

    def forward(self, rows: Tensor) -> Tensor:
        if self.training or torch.is_grad_enabled() or rows.ndim != 2:
            return super().forward(rows)
        product = torch.bmm(rows[:, None], self.weight.t().expand(len(rows), -1, -1))[:, 0]
        return product if self.bias is None else product + self.bias


def atan2(y: Tensor, x: Tensor) -> Tensor:
    """`torch.atan2` of tensors on the CPU, without gradients, element by element."""
    return torch.from_numpy(_atan2(y.numpy(), x.numpy()))


@numba.vectorize(["float32(float32, float32)", "float64(float64, float64)"], cache=True)
def _atan2(y: float, x: float) -> float:
    return math.atan2(y, x)
