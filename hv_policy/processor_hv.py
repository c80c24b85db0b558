"""LeRobot's processing pipelines around the `hv` policy."""

from typing import Any

import torch
from lerobot.processor import PolicyAction, PolicyProcessorPipeline, make_default_pre_post_processors

from hv_policy.configuration_hv import HVConfig


def make_hv_pre_post_processors(
    config: HVConfig,
    dataset_stats: dict[str, dict[str, torch.Tensor]] | None = None,
) -> tuple[
    PolicyProcessorPipeline[dict[str, Any], dict[str, Any]],
    PolicyProcessorPipeline[PolicyAction, PolicyAction],
]:
    """The stock steps (rename, add batch dimension, move to the device, normalise; and back), under the stock names.

    The normaliser does nothing here (`HVConfig.normalization_mapping` is IDENTITY throughout): the network carries
    the statistics that it was first trained with. The step stays, because `lerobot-train` and `lerobot-eval` override
    it by name. The instruction travels beside the observation as `task` (list of str) and is split into words by the
    policy itself, with the vocabulary in its checkpoint.

    Args:
        config: the policy's configuration; its device is where the batch is moved to.
        dataset_stats: statistics per feature, kept with the normaliser for information only.

    Returns:
        The pipeline before the policy and the one after it.
    """
    return make_default_pre_post_processors(config, dataset_stats, normalizer_device=config.device)
