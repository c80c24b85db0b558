"""The `hv` policy: camera picture, instruction and proprioception -> joint targets.

The student of the paper (HumanoidVerse, Stage 4), in two forms. `belief` says what it sees as places of the task, keeps
a belief about them, decides on an intent and lets the motor prior do it; `direct` is the paper's own, networks straight
to the 28 joint targets.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import torch
from lerobot.policies.pretrained import PreTrainedPolicy
from safetensors import SafetensorError, safe_open
from safetensors.torch import load_file
from torch import Tensor, nn

from hv_policy.belief.acting import BeliefStudent
from hv_policy.configuration_hv import HVConfig
from hv_policy.direct import DirectStudent
from hv_policy.text_encoder import build_vocabulary
from hv_policy.weight_decay import decay_groups


class CheckpointError(ValueError):
    """A checkpoint that does not fit the policy; the message is one line."""


class HVPolicy(PreTrainedPolicy):
    """Follows instructions from head camera pictures and proprioception; see `HVConfig` for the parameters.

    A batch holds `observation.images.*` (B, 3, H, W) floats 0..1 or uint8, `observation.state` (B, S), `task` (list of
    B str), and for training `action` (B, A). In training the observations may have a time axis after B, oldest first,
    the current frame last (`HVConfig.observation_delta_indices`), with `observation.state_is_pad` (B, T) telling frames
    from before the episode. The form `belief` is taught what `hv-record` writes as `privileged.*`, looked up by `index`
    (B,) in the dataset; acting, it never sees that.

    What is normalised is normalised inside the network, with numbers that stay with the weights: further rounds on
    other data (DAgger) continue in the same units.

    Args:
        config: the policy's configuration; an empty vocabulary in it is filled from `dataset_meta`.
        dataset_stats: LeRobot's statistics per feature, of which `mean` and `std` are used.
        dataset_meta: LeRobot's metadata of the dataset, of which the instructions are used, and the labels.

    Raises:
        ValueError: the features lack a camera, `observation.state` or `action`, or are not this body's.
    """

    config_class = HVConfig
    name = "hv"

    def __init__(
        self,
        config: HVConfig,
        dataset_stats: dict[str, dict[str, Any]] | None = None,
        dataset_meta: Any | None = None,
        **_: Any,
    ):
        super().__init__(config)
        config.validate_features()
        self.config: HVConfig = config
        if not config.vocabulary and dataset_meta is not None and config.pretrained_path is None:
            config.vocabulary = build_vocabulary(dataset_meta.tasks.index, config.max_vocabulary)
        student = BeliefStudent if config.form == "belief" else DirectStudent
        self.student: BeliefStudent | DirectStudent = student(config, dataset_stats, dataset_meta)
        self.network: nn.Module = self.student.network

    def get_optim_params(self) -> list[dict[str, Any]]:
        """Two groups: weight matrices decay; biases, norms, positions and embeddings do not."""
        return decay_groups(self)

    def train(self, mode: bool = True) -> "HVPolicy":
        self.student.reader.forget()
        return super().train(mode)

    def reset(self) -> None:
        """Forget what was seen and done; LeRobot calls this at the start of every rollout."""
        self.student.reset()

    def drop_queued_actions(self) -> None:
        """Forget plans made for an instruction that no longer holds.

        This policy decides anew at every step and notices by itself that its instruction has changed.
        """

    def forward(self, batch: dict[str, Any], reduction: str = "mean") -> tuple[Tensor, dict[str, float]]:
        """How wrong the policy is on recorded frames.

        Args:
            batch: see the class.
            reduction: `mean` over the batch, or `none` for one value per sample.

        Returns:
            The loss, () or (B,), and figures to watch.
        """
        loss, figures = self.student.loss(batch)
        return (loss.mean() if reduction == "mean" else loss), figures

    @torch.no_grad()
    def select_action(self, batch: dict[str, Any], **_: Any) -> Tensor:
        """The next action (N, A) of each of N environments; to be called once a control step.

        An environment whose instruction differs from the last call's forgets the old task; the others go on.
        """
        return self.student.act(batch)

    def needs_picture(self, instructions: Sequence[str]) -> bool:
        """Whether the next `select_action`, with these instructions, will look at its pictures at all: whoever draws
        them for this policy alone may show it the last ones again where it does not."""
        return self.student.needs_picture(instructions)

    @torch.no_grad()
    def predict_action_chunk(self, batch: dict[str, Any], **_: Any) -> Tensor:
        """The action (N, 1, A) that `select_action` would return, without a control step passing."""
        with self.student.undone():
            return self.student.act(batch).unsqueeze(1)

    @classmethod
    def _load_as_safetensor(cls, model: "HVPolicy", model_file: str, map_location: str, strict: bool) -> "HVPolicy":
        """Loads strictly, whatever `strict` says: a policy with some weights left random is never what was meant.

        Raises:
            CheckpointError: the file cannot be read, or weights are missing, not known or of another shape.
        """
        expected = {name: tuple(tensor.shape) for name, tensor in model.state_dict().items()}
        try:
            with safe_open(model_file, framework="pt") as file:
                found = {name: tuple(file.get_slice(name).get_shape()) for name in file.keys()}
        except (OSError, SafetensorError) as error:
            raise CheckpointError(f"checkpoint {model_file}: cannot be read: {_one_line(error)}") from error
        problems = [
            *(f"{name} is missing" for name in sorted(expected.keys() - found.keys())),
            *(f"{name} is not part of this policy" for name in sorted(found.keys() - expected.keys())),
            *(
                f"{name} has shape {found[name]} instead of {expected[name]}"
                for name in sorted(expected.keys() & found.keys())
                if found[name] != expected[name]
            ),
        ]
        if problems:
            more = f" (and {len(problems) - 1} more)" if len(problems) > 1 else ""
            raise CheckpointError(
                f"checkpoint {Path(model_file).parent}: {problems[0]}{more}; it was made with another configuration"
            )
        model.load_state_dict(load_file(model_file), strict=True)
        return model


def _one_line(error: BaseException) -> str:
    return " ".join(str(error).split())
