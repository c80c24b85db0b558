"""Normalised numbers through linear layers, computed the same whatever the batch: what the motor prior learns."""

from __future__ import annotations

import itertools

import torch
from torch import Tensor, nn

from hv_policy.batch_invariant import BatchInvariantLinear


class NormalizedNetwork(nn.Module):
    """(N, I) -> (N, 28), an answer for each joint. Starts at zero.

    Args:
        inputs: I.
        hidden: widths.
    """

    def __init__(self, inputs: int, hidden: tuple[int, ...]) -> None:
        super().__init__()
        self.register_buffer("mean", torch.zeros(inputs))
        self.register_buffer("std", torch.ones(inputs))
        sizes = [inputs, *hidden]
        layers: list[nn.Module] = []
        for i, o in itertools.pairwise(sizes):
            layers += [BatchInvariantLinear(i, o), nn.ELU()]
        layers.append(BatchInvariantLinear(sizes[-1], 28))
        self.layers = nn.Sequential(*layers)
        nn.init.zeros_(self.layers[-1].weight)
        nn.init.zeros_(self.layers[-1].bias)

    def forward(self, values: Tensor) -> Tensor:
        return self.layers((values - self.mean) / self.std)
