"""Linear layers whose answer to a row does not depend, in a single bit, on the rows beside it.

A matrix product picks its kernel, and with it the order of its sums, by the number of rows; in a simulation that is
chaotic the last bit decides an episode. Everything else that the controllers compute works element by element or on
small matrices of fixed size, which PyTorch already treats alike in any company.
"""

from __future__ import annotations

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
