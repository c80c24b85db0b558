"""The student in the paper's form: networks straight from what is seen and read to 28 joint targets."""

import copy
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import torch
import torch.nn.functional as F
from lerobot.utils.constants import ACTION, OBS_STATE
from torch import Tensor, nn

from hv_policy.batches import Reader, read_instructions, read_observation
from hv_policy.configuration_hv import HVConfig
from hv_policy.fusion import FusionLayer
from hv_policy.image_encoder import ImageEncoder
from hv_policy.text_encoder import TextEncoder
from hv_policy.visual_memory import VisualMemory


class DirectStudent:
    """Trains a `DirectNetwork` and acts with it; see `hv_policy.modeling_hv.HVPolicy`.

    Args:
        config: the policy's configuration.
        dataset_stats: LeRobot's statistics per feature, of which `mean` and `std` become the network's units.
        dataset_meta: not needed in this form.
    """

    def __init__(
        self, config: HVConfig, dataset_stats: dict[str, dict[str, Any]] | None, dataset_meta: Any | None
    ) -> None:
        assert config.robot_state_feature is not None
        assert config.action_feature is not None
        self.config = config
        self.cameras = sorted(config.image_features)
        self.network = DirectNetwork(
            config,
            num_cameras=len(self.cameras),
            state_size=config.robot_state_feature.shape[0],
            action_size=config.action_feature.shape[0],
        )
        for key, units in ((OBS_STATE, self.network.state_units), (ACTION, self.network.action_units)):
            if dataset_stats and key in dataset_stats:
                units.set_(dataset_stats[key]["mean"], dataset_stats[key]["std"], config.min_std)
        self.reader = Reader(self.network.text)
        self._memory = VisualMemory(config.memory_frames, config.memory_stride)

    def reset(self) -> None:
        """Forgets what was seen."""
        self._memory.clear()
        self.reader.forget()

    def needs_picture(self, instructions: Sequence[str]) -> bool:
        """It looks at every picture."""
        return True

    @contextmanager
    def undone(self) -> Iterator[None]:
        """What is done inside leaves no trace."""
        before = copy.copy(self._memory)
        try:
            self._memory = copy.deepcopy(before)
            yield
        finally:
            self._memory = before

    def loss(self, batch: dict[str, Any]) -> tuple[Tensor, dict[str, float]]:
        """(B,) smooth L1 between predicted and recorded action, in units of the actions' deviation, and
        `action_error`: mean absolute error in the actions' own unit (rad)."""
        pictures, state = read_observation(batch, self.cameras, self.config.image_size)
        memory, remembered = self._memory_of_batch(pictures[:, :-1], state[:, :-1], batch)
        image_tokens = self.network.look(pictures[:, -1])
        words, is_word = self.reader.read(read_instructions(batch, len(state)))
        predicted = self.network.act(image_tokens, state[:, -1], words, is_word, memory, remembered)
        units = self.network.action_units
        action = batch[ACTION].reshape(predicted.shape)
        loss = F.smooth_l1_loss(predicted, units.normalise(action), reduction="none").mean(1)
        error = (units.restore(predicted.detach()) - action).abs().mean().item()
        return loss, {"action_error": error}

    def act(self, batch: dict[str, Any]) -> Tensor:
        """(N, A) actions in their own unit; the frame is remembered."""
        pictures, states = read_observation(batch, self.cameras, self.config.image_size)
        state = states[:, -1]
        instructions = read_instructions(batch, len(state))
        memory, remembered = self._memory.recall(instructions, self.network.dim, state.device)
        image_tokens = self.network.look(pictures[:, -1])
        words, is_word = self.reader.recall(instructions)
        predicted = self.network.act(image_tokens, state, words, is_word, memory, remembered)
        self._memory.store(self.network.embed(image_tokens, state))
        return self.network.action_units.restore(predicted)

    def _memory_of_batch(self, pictures: Tensor, state: Tensor, batch: dict[str, Any]) -> tuple[Tensor, Tensor]:
        """Embeddings (B, M, dim) of a training batch's past frames and which of them the policy may use (B, M)."""
        samples, frames = state.shape[:2]
        exists = torch.ones(samples, frames, dtype=torch.bool, device=state.device)
        if frames == 0:
            return torch.zeros(samples, 0, self.network.dim, device=state.device), exists
        is_pad = batch.get(f"{OBS_STATE}_is_pad")
        if is_pad is not None:
            exists &= ~is_pad[:, :frames].bool()
        if self.network.training and self.config.memory_dropout:
            exists &= torch.rand(samples, 1, device=state.device) >= self.config.memory_dropout
        with torch.no_grad():  # the picture network learns from the present frame; doing so from the past costs 3 x
            tokens = self.network.look(pictures.flatten(0, 1))
        embedding = self.network.embed(tokens, state.flatten(0, 1))
        return embedding.unflatten(0, (samples, frames)), exists


class DirectNetwork(nn.Module):
    """Picture, words, proprioception and memory -> actions, in one go: the form of the paper's student."""

    def __init__(self, config: HVConfig, num_cameras: int, state_size: int, action_size: int):
        super().__init__()
        size = config.architecture
        self.dim = dim = size.dim
        self.clip_state = config.clip_state
        self.state_units = Units(state_size)
        self.action_units = Units(action_size)
        self.image = ImageEncoder(config.image_size, size.image_channels, size.image_blocks, dim)
        self.camera = nn.Parameter(torch.randn(num_cameras, 1, dim) * 0.1)
        self.text = TextEncoder(
            config.vocabulary, config.max_words, dim, size.heads, size.text_layers, config.word_dropout
        )
        self.state = nn.Sequential(nn.Linear(state_size, 2 * dim), nn.GELU(), nn.Linear(2 * dim, dim))
        self.queries = nn.Parameter(torch.randn(size.queries, dim) * 0.5)
        self.state_to_queries = nn.Linear(dim, size.queries * dim)
        self.memory_query = nn.Parameter(torch.randn(4, dim) * 0.5)
        self.memory_embedding = nn.Linear(5 * dim, dim)
        self.memory_age = nn.Parameter(torch.randn(config.memory_frames, dim) * 0.1)
        self.fusion = nn.ModuleList(FusionLayer(dim, size.heads) for _ in range(size.fusion_layers))
        self.join = nn.Linear((size.queries + 1) * dim, size.hidden)
        self.blocks = nn.ModuleList(ResidualMLP(size.hidden) for _ in range(size.hidden_blocks))
        self.head = nn.Sequential(nn.LayerNorm(size.hidden), nn.Linear(size.hidden, action_size))
        nn.init.normal_(self.head[1].weight, std=0.01)  # the untrained policy holds the data's mean pose
        nn.init.zeros_(self.head[1].bias)

    def look(self, pictures: Tensor) -> Tensor:
        """Pictures (B, cameras, 3, H, W) -> tokens (B, cameras * grid, dim)."""
        batch, cameras = pictures.shape[:2]
        tokens = self.image(pictures.flatten(0, 1)).unflatten(0, (batch, cameras))
        return (tokens + self.camera).flatten(1, 2)

    def embed(self, image_tokens: Tensor, state: Tensor) -> Tensor:
        """One frame in brief, (B, dim): what the memory keeps of it. Does not depend on the instruction."""
        weight = (self.memory_query @ image_tokens.transpose(1, 2) / self.dim**0.5).softmax(-1)
        seen = (weight @ image_tokens).flatten(1)
        return self.memory_embedding(torch.cat([seen, self._feel(state)], 1))

    def act(
        self,
        image_tokens: Tensor,
        state: Tensor,
        words: Tensor,
        is_word: Tensor,
        memory: Tensor,
        remembered: Tensor,
    ) -> Tensor:
        """Normalised actions (B, A).

        Args:
            image_tokens: (B, G, dim) of the present frame.
            state: (B, S) in its own units.
            words, is_word: (B, L, dim) and (B, L) bool.
            memory, remembered: (B, M, dim), oldest first, and (B, M) bool.
        """
        feeling = self._feel(state)
        queries = self.queries + self.state_to_queries(feeling).unflatten(1, self.queries.shape)
        sights = image_tokens
        is_sight = None
        if memory.shape[1]:
            sights = torch.cat([image_tokens, memory + self.memory_age], 1)
            is_sight = torch.cat([remembered.new_ones(image_tokens.shape[:2]), remembered], 1)
        for layer in self.fusion:
            queries = layer(queries, words, is_word, sights, is_sight)
        hidden = self.join(torch.cat([queries.flatten(1), feeling], 1))
        for block in self.blocks:
            hidden = block(hidden)
        return self.head(hidden)

    def _feel(self, state: Tensor) -> Tensor:
        return self.state(self.state_units.normalise(state).clamp(-self.clip_state, self.clip_state))


class ResidualMLP(nn.Module):
    """x + MLP(norm(x)), width kept."""

    def __init__(self, width: int):
        super().__init__()
        self.change = nn.Sequential(nn.LayerNorm(width), nn.Linear(width, width), nn.GELU(), nn.Linear(width, width))

    def forward(self, x: Tensor) -> Tensor:
        return x + self.change(x)


class Units(nn.Module):
    """Mean and standard deviation (size,) of a vector, kept with the weights; identity until they are set."""

    mean: Tensor
    std: Tensor

    def __init__(self, size: int):
        super().__init__()
        self.register_buffer("mean", torch.zeros(size))
        self.register_buffer("std", torch.ones(size))

    def set_(self, mean: Any, std: Any, min_std: float) -> None:
        """Takes over statistics (size,); deviations below `min_std` count as that much."""
        self.mean.copy_(torch.as_tensor(mean, dtype=torch.float32).reshape(self.mean.shape))
        self.std.copy_(torch.as_tensor(std, dtype=torch.float32).reshape(self.std.shape).clamp(min=min_std))

    def normalise(self, value: Tensor) -> Tensor:
        return (value - self.mean) / self.std

    def restore(self, value: Tensor) -> Tensor:
        return value * self.std + self.mean
