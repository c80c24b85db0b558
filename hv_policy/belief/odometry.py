"""How far the robot has turned in a control step, from what it felt before and after it.

The pelvis sways at every step and is felt thirty times a second: adding up its rate of turning loses a quarter of a
right angle in half a minute. What all other links do tells most of what is lost; a small network learned it
(`hv-train-odometry`).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import torch
from torch import Tensor, nn

from hv_policy.batch_invariant import BatchInvariantLinear
from hv_policy.motor.embodiment import CONTROL_DT_S
from hv_policy.motor.proprioception import read_heading_rate
from hv_policy.network_file import load_network, save_network

SHIPPED_ODOMETRY = Path(__file__).resolve().parents[1] / "weights" / "odometry.safetensors"
STATE_DIM = 223
CORRECTION_UNIT_RAD = 0.0035
"""About the deviation of what the rate of turning misses in a control step."""
_MOST_SPREADS = 6.0
_KIND = "hv_odometry/1"


@dataclass(frozen=True)
class OdometryConfig:
    """Widths of the network."""

    hidden: tuple[int, int] = (96, 64)


class Odometry(nn.Module):
    """(N,) rad that the heading has turned between two proprioceptions (N, 223) a control step apart."""

    def __init__(self, config: OdometryConfig | None = None) -> None:
        super().__init__()
        self.config = config or OdometryConfig()
        self.register_buffer("mean", torch.zeros(2 * STATE_DIM))
        self.register_buffer("std", torch.ones(2 * STATE_DIM))
        first, second = self.config.hidden
        self.correct = nn.Sequential(
            BatchInvariantLinear(2 * STATE_DIM, first),
            nn.ELU(),
            BatchInvariantLinear(first, second),
            nn.ELU(),
            BatchInvariantLinear(second, 1),
        )

    def set_moments(self, felt: Tensor) -> None:
        """Takes mean and deviation of `features` (B, 446)."""
        self.mean.copy_(felt.mean(0))
        self.std.copy_(felt.std(0).clamp(min=1e-3))

    def forward(self, before: Tensor, now: Tensor) -> Tensor:
        return rate_turn(before, now) + CORRECTION_UNIT_RAD * self.correction(features(before, now))

    def correction(self, felt: Tensor) -> Tensor:
        """(B,) in `CORRECTION_UNIT_RAD`, of `features` (B, 446)."""
        return self.correct(((felt - self.mean) / self.std).clamp(-_MOST_SPREADS, _MOST_SPREADS))[:, 0]


def features(before: Tensor, now: Tensor) -> Tensor:
    """(N, 446) of two proprioceptions (N, 223): the first, and how the second differs."""
    return torch.cat([before, now - before], -1)


def rate_turn(before: Tensor, now: Tensor) -> Tensor:
    """(N,) rad by the mean of the heading's rates before and after."""
    return (read_heading_rate(before) + read_heading_rate(now)) / 2 * CONTROL_DT_S


def save_odometry(odometry: Odometry, path: Path, metadata: dict[str, str] | None = None) -> None:
    """Weights and configuration as one safetensors file, written whole or not at all."""
    save_network(odometry, odometry.config, path, _KIND, metadata)


def load_odometry(path: Path = SHIPPED_ODOMETRY) -> Odometry:
    """Reads what `save_odometry` wrote.

    Raises:
        ValueError: the file is something else, or its weights do not fit its configuration.
    """
    return load_network(path, _KIND, lambda values: OdometryConfig(tuple(values["hidden"])), Odometry)
