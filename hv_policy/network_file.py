"""A network in a file: weights and configuration as safetensors."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from safetensors import SafetensorError, safe_open
from safetensors.torch import save_file
from torch import nn

SHIPPED_STUDENT = Path(__file__).parent / "weights" / "student"
"""The folder of the LeRobot policy that comes with the package."""


def save_network(network: nn.Module, config: Any, path: Path, kind: str, metadata: dict[str, str] | None) -> None:
    """Weights and configuration as one safetensors file, written whole or not at all.

    Args:
        network: whose weights.
        config: the dataclass that it was built from.
        path: of the file; folders are made.
        kind: name and version of what it is, asked for again by `load_network`.
        metadata: what else to write down.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_suffix(".tmp")
    header = {"format": kind, "config": json.dumps(asdict(config)), **(metadata or {})}
    save_file({k: v.contiguous() for k, v in network.state_dict().items()}, temporary, metadata=header)
    temporary.replace(path)


def load_network[C, N: nn.Module](
    path: Path, kind: str, configure: Callable[[dict[str, Any]], C], build: Callable[[C], N]
) -> N:
    """Reads what `save_network` wrote; the network evaluates.

    Args:
        path, kind: as they were written.
        configure: makes the configuration of its fields, in which tuples have become lists.
        build: makes the network of its configuration.

    Raises:
        ValueError: the file is of another kind, or its weights do not fit its configuration.
    """
    try:
        with safe_open(str(path), framework="pt") as file:
            header = file.metadata() or {}
            weights = {k: file.get_tensor(k) for k in file.keys()}
    except (OSError, SafetensorError) as error:
        raise ValueError(f"{path}: cannot be read: {' '.join(str(error).split())}") from error
    if header.get("format") != kind:
        raise ValueError(f"{path}: format is {header.get('format')!r}; valid: {kind!r}")
    try:
        config = configure(json.loads(header["config"]))
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"{path}: its configuration is of another version: {error}") from error
    network = build(config)
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
