"""A decision network in a file: weights and configuration as safetensors."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

from safetensors import SafetensorError, safe_open
from safetensors.torch import save_file

from hv_policy.decision.network import DecisionConfig, DecisionNetwork


def save_decision(network: DecisionNetwork, path: Path, metadata: dict[str, str] | None = None) -> None:
    """Weights and configuration as one safetensors file, written whole or not at all."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_suffix(".tmp")
    header = {"format": "hv_teacher/1", "config": json.dumps(asdict(network.config)), **(metadata or {})}
    save_file({k: v.contiguous() for k, v in network.state_dict().items()}, temporary, metadata=header)
    temporary.replace(path)


def load_decision(path: Path) -> DecisionNetwork:
    """Reads what `save_decision` wrote.

    Raises:
        ValueError: the file is not a teacher, or its weights do not fit its configuration.
    """
    try:
        with safe_open(str(path), framework="pt") as file:
            header = file.metadata() or {}
            weights = {k: file.get_tensor(k) for k in file.keys()}
    except (OSError, SafetensorError) as error:
        raise ValueError(f"{path}: cannot be read: {' '.join(str(error).split())}") from error
    if header.get("format") != "hv_teacher/1":
        raise ValueError(f"{path}: format is {header.get('format')!r}; valid: 'hv_teacher/1'")
    try:
        values = json.loads(header["config"])
        plain: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in values.items()}
        config = DecisionConfig(**plain)
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"{path}: its configuration is of another version: {error}") from error
    network = DecisionNetwork(config)
    expected = {k: tuple(v.shape) for k, v in network.state_dict().items()}
    found = {k: tuple(v.shape) for k, v in weights.items()}
    if expected != found:
        wrong = sorted(k for k in expected.keys() | found.keys() if expected.get(k) != found.get(k))
        raise ValueError(
            f"{path}: weights {wrong} do not fit the configuration; expected {[expected.get(k) for k in wrong]}"
        )
    network.load_state_dict(weights, strict=True)
    network.eval()
    return network
