"""What LeRobot hands a policy, as tensors: pictures, proprioception and words."""

from collections.abc import Callable, Sequence
from typing import Any

import torch
import torch.nn.functional as F
from lerobot.utils.constants import OBS_STATE
from torch import Tensor, nn

from hv_policy.text_encoder import TextEncoder


def read_observation(batch: dict[str, Any], cameras: Sequence[str], image_size: int) -> tuple[Tensor, Tensor]:
    """Pictures (B, T, cameras, 3, H, W) floats 0..1 and state (B, T, S); T is 1 without a time axis.

    Args:
        batch: `observation.images.*` and `observation.state`.
        cameras: names of the pictures wanted.
        image_size: that all are resized to if they differ in size.

    Raises:
        ValueError: one of them is missing.
    """
    missing = [key for key in (OBS_STATE, *cameras) if key not in batch]
    if missing:
        given = ", ".join(sorted(key for key in batch if key.startswith("observation."))) or "none"
        raise ValueError(f"observation: {', '.join(missing)} is missing (given: {given})")
    state = batch[OBS_STATE]
    has_time = state.ndim == 3
    views = [batch[camera] if has_time else batch[camera].unsqueeze(1) for camera in cameras]
    size = (image_size, image_size)
    if len({view.shape[-2:] for view in views}) > 1:
        views = [
            F.interpolate(view.flatten(0, 1).float(), size=size, mode="bilinear", antialias=True)
            .unflatten(0, view.shape[:2])
            .to(view.dtype)
            for view in views
        ]
    pictures = torch.stack(views, 2)
    if pictures.dtype == torch.uint8:
        pictures = pictures.float() / 255
    return pictures, state if has_time else state.unsqueeze(1)


def read_instructions(batch: dict[str, Any], count: int) -> list[str]:
    """The batch's `task`, one per sample; a single string is everyone's; none given means no instruction.

    Raises:
        ValueError: there are more or fewer than `count`.
    """
    task = batch.get("task")
    if task is None:
        return [""] * count
    if isinstance(task, str):
        return [task] * count
    if len(task) != count:
        raise ValueError(f"task: {len(task)} instructions for {count} samples")
    return list(task)


class Reader:
    """Reads instructions with a text encoder, each one only once.

    Args:
        encoder: what makes tokens of words.
        reword: says an instruction in words that the encoder knows; by default it stays as it is.
    """

    def __init__(self, encoder: TextEncoder, reword: Callable[[str], str] = str) -> None:
        self._encoder = encoder
        self._reword = reword
        self._words_of: dict[str, Tensor] = {}  # instruction -> word tokens (L, dim), while acting
        self._recalled: tuple[list[str], Tensor, Tensor] | None = None  # the last ones together

    def forget(self) -> None:
        """What was read was read with other weights."""
        self._words_of.clear()
        self._recalled = None

    def read(self, instructions: Sequence[str]) -> tuple[Tensor, Tensor]:
        """Word tokens (B, L, dim) and mask (B, L), with gradients; each distinct instruction is read once."""
        said = [self._reword(text) for text in instructions]
        distinct = sorted(set(said))
        words, is_word = self._encoder(distinct)
        row = {text: i for i, text in enumerate(distinct)}
        index = torch.tensor([row[text] for text in said], device=words.device)
        return words[index], is_word[index]

    def recall(self, instructions: Sequence[str]) -> tuple[Tensor, Tensor]:
        """As `read`, but an instruction that was read before is not read again."""
        for text in instructions:
            if text not in self._words_of:
                self._words_of[text] = self._encoder([self._reword(text)])[0][0]
        if self._recalled is None or self._recalled[0] != list(instructions):
            lines = [self._words_of[text] for text in instructions]
            words = nn.utils.rnn.pad_sequence(lines, batch_first=True)
            lengths = torch.tensor([len(line) for line in lines], device=words.device)
            is_word = torch.arange(words.shape[1], device=words.device) < lengths.unsqueeze(1)
            self._recalled = list(instructions), words, is_word
        return self._recalled[1:]
