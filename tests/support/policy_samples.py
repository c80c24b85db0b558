"""Small `hv` policies and random frames for tests."""

from types import SimpleNamespace

import pandas as pd
import torch
from lerobot.configs import FeatureType, PolicyFeature

from hv_policy.configuration_hv import HVConfig
from hv_policy.modeling_hv import HVPolicy

TASKS = ["Carry the red box from the left to the right.", "Put the blue vase on the shelf."]
HEAD = "observation.images.head"
STATE = "observation.state"


def make_config(**changes) -> HVConfig:
    settings = {
        "device": "cpu",
        "form": "direct",
        "image_size": 64,
        "memory_frames": 2,
        "memory_stride": 2,
        "input_features": {
            HEAD: PolicyFeature(FeatureType.VISUAL, (3, 64, 64)),
            STATE: PolicyFeature(FeatureType.STATE, (223,)),
        },
        "output_features": {"action": PolicyFeature(FeatureType.ACTION, (28,))},
    }
    return HVConfig(**(settings | changes))


def make_policy(*, with_stats: bool = True, **changes) -> HVPolicy:
    torch.manual_seed(0)
    meta = SimpleNamespace(tasks=pd.DataFrame({"task_index": [0, 1]}, index=TASKS))
    stats = {
        STATE: {"mean": torch.linspace(-1, 1, 223), "std": torch.linspace(0, 2, 223)},
        "action": {"mean": torch.full((28,), 0.3), "std": torch.full((28,), 0.5)},
    }
    policy = HVPolicy(make_config(**changes), dataset_stats=stats if with_stats else None, dataset_meta=meta)
    if with_stats:
        torch.nn.init.normal_(policy.network.head[1].weight, std=0.1)  # an untrained head hides what comes before it
    return policy


def make_frames(envs: int, steps: int, seed: int = 0) -> list[dict[str, torch.Tensor]]:
    generator = torch.Generator().manual_seed(seed)
    return [
        {
            HEAD: torch.rand(envs, 3, 64, 64, generator=generator),
            STATE: torch.randn(envs, 223, generator=generator),
        }
        for _ in range(steps)
    ]
