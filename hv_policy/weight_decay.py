"""Which weights decay while a network is trained."""

from typing import Any

from torch import nn


def decay_groups(network: nn.Module, **of_matrices: Any) -> list[dict[str, Any]]:
    """Two groups for an optimizer: weight matrices decay; biases, norms, positions and embeddings do not.

    Args:
        network: whose weights that are trained are meant.
        of_matrices: settings of the first group, such as `weight_decay`; without any the optimizer's own hold.
    """
    decays = {id(module.weight) for module in network.modules() if isinstance(module, nn.Linear | nn.Conv2d)}
    trained = [p for p in network.parameters() if p.requires_grad]
    return [
        {"params": [p for p in trained if id(p) in decays], **of_matrices},
        {"params": [p for p in trained if id(p) not in decays], "weight_decay": 0.0},
    ]
