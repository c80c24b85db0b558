"""The `hv` policy: camera picture, instruction and proprioception -> joint targets.

The student of the paper (HumanoidVerse, Stage 4) in its small form. Pictures become a grid of tokens, the instruction
one token per word; a few query tokens, made from the proprioception, read the words and then look at the picture and
at what is remembered of the last fractions of a second; a residual MLP turns them into actions.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import torch
import torch.nn.functional as F
from lerobot.policies.pretrained import PreTrainedPolicy
from lerobot.utils.constants import ACTION, OBS_STATE
from safetensors import SafetensorError, safe_open
from safetensors.torch import load_file
from torch import Tensor, nn

from hv_policy.configuration_hv import HVConfig
from hv_policy.image_encoder import ImageEncoder
from hv_policy.text_encoder import TextEncoder, build_vocabulary
from hv_policy.visual_memory import VisualMemory


class CheckpointError(ValueError):
    """A checkpoint that does not fit the policy; the message is one line."""


class HVPolicy(PreTrainedPolicy):
    """Follows instructions from head camera pictures and proprioception; see `HVConfig` for the parameters.

    A batch holds `observation.images.*` (B, 3, H, W) floats 0..1 or uint8, `observation.state` (B, S), `task` (list of
    B str), and for training `action` (B, A). In training the observations may have a time axis after B, oldest first,
    the current frame last (`HVConfig.observation_delta_indices`), with `observation.state_is_pad` (B, T) telling frames
    from before the episode.

    The mean and standard deviation of state and action are buffers of the network: they are taken from the first
    dataset it is trained on and stay with the weights from then on, so that further rounds on other data (DAgger)
    continue in the same units.

    Args:
        config: the policy's configuration; an empty vocabulary in it is filled from `dataset_meta`.
        dataset_stats: LeRobot's statistics per feature, of which `mean` and `std` are used.
        dataset_meta: LeRobot's metadata of the dataset, of which the instructions are used.

    Raises:
        ValueError: the features lack a camera, `observation.state` or `action`.
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
        assert config.robot_state_feature is not None
        assert config.action_feature is not None
        self.cameras = sorted(config.image_features)
        self.network = HVNetwork(
            config,
            num_cameras=len(self.cameras),
            state_size=config.robot_state_feature.shape[0],
            action_size=config.action_feature.shape[0],
        )
        for key, units in ((OBS_STATE, self.network.state_units), (ACTION, self.network.action_units)):
            if dataset_stats and key in dataset_stats:
                units.set_(dataset_stats[key]["mean"], dataset_stats[key]["std"], config.min_std)
        self._memory = VisualMemory(config.memory_frames, config.memory_stride)
        self._words_of: dict[str, Tensor] = {}  # instruction -> word tokens (L, dim), while acting

    def get_optim_params(self) -> list[dict[str, Any]]:
        """Two groups: weight matrices decay; biases, norms, positions and embeddings do not."""
        decays = {id(module.weight) for module in self.modules() if isinstance(module, nn.Linear | nn.Conv2d)}
        trained = [p for p in self.parameters() if p.requires_grad]
        return [
            {"params": [p for p in trained if id(p) in decays]},
            {"params": [p for p in trained if id(p) not in decays], "weight_decay": 0.0},
        ]

    def train(self, mode: bool = True) -> "HVPolicy":
        self._words_of.clear()  # what was read with other weights
        return super().train(mode)

    def reset(self) -> None:
        """Forget what was seen; LeRobot calls this at the start of every rollout."""
        self._memory.clear()
        self._words_of.clear()

    def drop_queued_actions(self) -> None:
        """Forget plans made for an instruction that no longer holds.

        This policy decides anew at every step, so all that it carries over is what it has seen.
        """
        self._memory.clear()

    def forward(self, batch: dict[str, Any], reduction: str = "mean") -> tuple[Tensor, dict[str, float]]:
        """Imitation loss: smooth L1 between predicted and recorded action, in units of the actions' deviation.

        Args:
            batch: see the class.
            reduction: `mean` over the batch, or `none` for one value per sample.

        Returns:
            The loss, () or (B,), and `action_error`: mean absolute error in the actions' own unit (rad).
        """
        pictures, state = self._observation(batch)
        picture_now, state_now = pictures[:, -1], state[:, -1]
        memory, remembered = self._memory_of_batch(pictures[:, :-1], state[:, :-1], batch)
        image_tokens = self.network.look(picture_now)
        words, is_word = self._read_batch(_instructions(batch, len(state)))
        predicted = self.network.act(image_tokens, state_now, words, is_word, memory, remembered)

        units = self.network.action_units
        action = batch[ACTION].reshape(predicted.shape)
        loss = F.smooth_l1_loss(predicted, units.normalise(action), reduction="none").mean(1)
        error = (units.restore(predicted.detach()) - action).abs().mean().item()
        return (loss.mean() if reduction == "mean" else loss), {"action_error": error}

    @torch.no_grad()
    def select_action(self, batch: dict[str, Any], **_: Any) -> Tensor:
        """The next action (N, A) of each of N environments; to be called once a control step.

        An environment whose instruction differs from the last call's loses its memory; the others keep theirs.
        """
        action, embedding = self._decide(batch)
        self._memory.store(embedding)
        return action

    @torch.no_grad()
    def predict_action_chunk(self, batch: dict[str, Any], **_: Any) -> Tensor:
        """The action (N, 1, A) that `select_action` would return, without remembering the frame."""
        return self._decide(batch)[0].unsqueeze(1)

    def _decide(self, batch: dict[str, Any]) -> tuple[Tensor, Tensor]:
        """Actions (N, A) in their own unit, and the present frame's embeddings (N, dim) for the memory."""
        pictures, state = self._observation(batch)
        picture, state = pictures[:, -1], state[:, -1]
        instructions = _instructions(batch, len(state))
        memory, remembered = self._memory.recall(instructions, self.network.dim, state.device)
        image_tokens = self.network.look(picture)
        words, is_word = self._read_cached(instructions)
        predicted = self.network.act(image_tokens, state, words, is_word, memory, remembered)
        return self.network.action_units.restore(predicted), self.network.embed(image_tokens, state)

    def _observation(self, batch: dict[str, Any]) -> tuple[Tensor, Tensor]:
        """Pictures (B, T, cameras, 3, H, W) floats 0..1 and state (B, T, S); T is 1 without a time axis."""
        missing = [key for key in (OBS_STATE, *self.cameras) if key not in batch]
        if missing:
            given = ", ".join(sorted(key for key in batch if key.startswith("observation."))) or "none"
            raise ValueError(f"observation: {', '.join(missing)} is missing (given: {given})")
        state = batch[OBS_STATE]
        has_time = state.ndim == 3
        views = [batch[camera] if has_time else batch[camera].unsqueeze(1) for camera in self.cameras]
        size = (self.config.image_size, self.config.image_size)
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

    def _memory_of_batch(self, pictures: Tensor, state: Tensor, batch: dict[str, Any]) -> tuple[Tensor, Tensor]:
        """Embeddings (B, M, dim) of a training batch's past frames and which of them the policy may use (B, M)."""
        samples, frames = state.shape[:2]
        exists = torch.ones(samples, frames, dtype=torch.bool, device=state.device)
        if frames == 0:
            return torch.zeros(samples, 0, self.network.dim, device=state.device), exists
        is_pad = batch.get(f"{OBS_STATE}_is_pad")
        if is_pad is not None:
            exists &= ~is_pad[:, :frames].bool()
        if self.training and self.config.memory_dropout:
            exists &= torch.rand(samples, 1, device=state.device) >= self.config.memory_dropout
        with torch.no_grad():  # the picture network learns from the present frame; doing so from the past costs 3 x
            tokens = self.network.look(pictures.flatten(0, 1))
        embedding = self.network.embed(tokens, state.flatten(0, 1))
        return embedding.unflatten(0, (samples, frames)), exists

    def _read_batch(self, instructions: Sequence[str]) -> tuple[Tensor, Tensor]:
        """Word tokens (B, L, dim) and mask (B, L); each distinct instruction is read once."""
        distinct = sorted(set(instructions))
        words, is_word = self.network.text(distinct)
        row = {text: i for i, text in enumerate(distinct)}
        index = torch.tensor([row[text] for text in instructions], device=words.device)
        return words[index], is_word[index]

    def _read_cached(self, instructions: Sequence[str]) -> tuple[Tensor, Tensor]:
        """As `_read_batch`, but an instruction that was read before is not read again."""
        for text in instructions:
            if text not in self._words_of:
                self._words_of[text] = self.network.text([text])[0][0]
        lines = [self._words_of[text] for text in instructions]
        words = nn.utils.rnn.pad_sequence(lines, batch_first=True)
        lengths = torch.tensor([len(line) for line in lines], device=words.device)
        return words, torch.arange(words.shape[1], device=words.device) < lengths.unsqueeze(1)

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


class HVNetwork(nn.Module):
    """The networks of `HVPolicy`; everything here is batched and knows nothing of environments or time."""

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


class FusionLayer(nn.Module):
    """Queries read the words, look at the picture, and think it over (pre-norm attention, attention, MLP)."""

    def __init__(self, dim: int, heads: int):
        super().__init__()
        self.read = CrossAttention(dim, heads)
        self.look = CrossAttention(dim, heads)
        self.think = nn.Sequential(nn.LayerNorm(dim), nn.Linear(dim, 2 * dim), nn.GELU(), nn.Linear(2 * dim, dim))

    def forward(
        self, queries: Tensor, words: Tensor, is_word: Tensor, sights: Tensor, is_sight: Tensor | None
    ) -> Tensor:
        queries = queries + self.read(queries, words, is_word)
        queries = queries + self.look(queries, sights, is_sight)
        return queries + self.think(queries)


class CrossAttention(nn.Module):
    """Multi-head attention of queries (B, Q, dim) to tokens (B, K, dim) where `exists` (B, K) holds."""

    def __init__(self, dim: int, heads: int):
        super().__init__()
        self.heads = heads
        self.query_norm = nn.LayerNorm(dim)
        self.token_norm = nn.LayerNorm(dim)
        self.query = nn.Linear(dim, dim)
        self.key_value = nn.Linear(dim, 2 * dim)
        self.out = nn.Linear(dim, dim)

    def forward(self, queries: Tensor, tokens: Tensor, exists: Tensor | None) -> Tensor:
        key, value = self.key_value(self.token_norm(tokens)).chunk(2, -1)
        query, key, value = (
            x.unflatten(-1, (self.heads, -1)).transpose(1, 2)
            for x in (self.query(self.query_norm(queries)), key, value)
        )
        mask = None if exists is None else exists[:, None, None, :]
        attended = F.scaled_dot_product_attention(query, key, value, attn_mask=mask)
        return self.out(attended.transpose(1, 2).flatten(2))


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


def _instructions(batch: dict[str, Any], count: int) -> list[str]:
    """The batch's `task`, one per sample; a single string is everyone's; none given means no instruction."""
    task = batch.get("task")
    if task is None:
        return [""] * count
    if isinstance(task, str):
        return [task] * count
    if len(task) != count:
        raise ValueError(f"task: {len(task)} instructions for {count} samples")
    return list(task)


def _one_line(error: BaseException) -> str:
    return " ".join(str(error).split())
