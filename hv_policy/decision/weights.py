"""A decision network in a file (`hv_policy.network_file`)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hv_policy.decision.network import DecisionConfig, DecisionNetwork
from hv_policy.network_file import load_network, save_network

_KIND = "hv_teacher/1"


def save_decision(network: DecisionNetwork, path: Path, metadata: dict[str, str] | None = None) -> None:
    """Weights and configuration as one safetensors file, written whole or not at all."""
    save_network(network, network.config, path, _KIND, metadata)


def load_decision(path: Path) -> DecisionNetwork:
    """Reads what `save_decision` wrote.

    Raises:
        ValueError: the file is not a teacher, or its weights do not fit its configuration.
    """
    return load_network(path, _KIND, _configured, DecisionNetwork)


def _configured(values: dict[str, Any]) -> DecisionConfig:
    plain: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in values.items()}
    return DecisionConfig(**plain)
