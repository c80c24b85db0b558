"""Configuration of the `hv` policy, registered with LeRobot as `--policy.type=hv`."""

from dataclasses import dataclass, field

from lerobot.configs import NormalizationMode, PreTrainedConfig
from lerobot.optim import AdamWConfig, CosineDecayWithWarmupSchedulerConfig

from hv_policy.belief.perception_size import PERCEPTIONS, PerceptionSize


@dataclass(frozen=True)
class Architecture:
    """Widths of the networks; one per `HVConfig.size`.

    Attributes:
        image_channels: channels at 1/4, 1/8 and 1/16 of the picture's size.
        image_blocks: residual blocks at each of the two coarser sizes.
        dim: width of the tokens (text, image, memory) and of the attention that fuses them.
        heads: attention heads.
        text_layers: transformer layers over the words.
        fusion_layers: rounds of reading the words and looking at the picture.
        queries: tokens that do the reading and looking.
        hidden: width of the residual MLP that ends in the actions.
        hidden_blocks: residual blocks of that MLP.
    """

    image_channels: tuple[int, int, int]
    image_blocks: int
    dim: int
    heads: int
    text_layers: int
    fusion_layers: int
    queries: int
    hidden: int
    hidden_blocks: int


ARCHITECTURES: dict[str, Architecture] = {
    # Chosen for two CPU cores: see the figures in docs/policy.md.
    "small": Architecture((32, 64, 128), 1, 128, 4, 2, 2, 4, 512, 2),
    "base": Architecture((64, 128, 256), 2, 256, 8, 4, 4, 8, 1024, 3),
}


FORMS = ("belief", "direct")


@PreTrainedConfig.register_subclass("hv")
@dataclass
class HVConfig(PreTrainedConfig):
    """Image, instruction and proprioception -> 28 joint targets, with a short visual memory.

    Args:
        form: `belief` sees places, keeps a belief about them and decides from it; `direct` is the paper's own form,
            networks straight to the actions. The fields from `memory_frames` to `memory_dropout` and `min_std` to
            `clip_state` are about the latter.
        size: which of `ARCHITECTURES` to build: `small` trains on a CPU, `base` wants a GPU.
        image_size: side in pixels that every camera picture is resized to (a multiple of 16).
        memory_frames: how many past frames the policy remembers (0: none).
        memory_stride: control steps between two of them. At 30 Hz the default reaches 0.4 s back.
        memory_dropout: share of training samples whose memory is emptied, as it is in use right after an episode's
            start or a change of the instruction.
        vocabulary: the words that have an embedding of their own. Left empty, it is filled from the dataset's
            instructions when training starts; it is saved with the checkpoint, so nothing is looked up elsewhere.
        max_vocabulary: most words that are taken from the dataset (the most frequent).
        max_words: words of an instruction that are read; longer ones are cut there.
        word_dropout: share of words shown as unknown in training, half of them without their spelling, so that what
            they mean to `hv_policy.word_features` is learned as well.
        mirror_share: share of training pictures that are shown in a mirror, left for right in their instructions too.
        recolour: show them in other colours and lights, each time anew (both for the form `belief`).
        min_std: smallest standard deviation that a state or action entry is divided by. Entries that hardly vary in
            the data (the root's own yaw is always 0 in its heading frame) would otherwise blow up noise.
        clip_state: normalised state entries are limited to this many standard deviations.

    Raises:
        ValueError: a field holds a value that it cannot have (one line: field, value, valid choices).
    """

    n_obs_steps: int = 1
    form: str = "belief"
    size: str = "small"
    image_size: int = 128
    memory_frames: int = 2
    memory_stride: int = 6
    memory_dropout: float = 0.3
    vocabulary: list[str] = field(default_factory=list)
    max_vocabulary: int = 4096
    max_words: int = 48
    word_dropout: float = 0.25
    mirror_share: float = 0.35
    recolour: bool = True
    min_std: float = 0.02
    clip_state: float = 8.0

    # The statistics of state and action are part of the network's weights (see `HVPolicy`): LeRobot's own normaliser
    # would silently take those of whatever dataset comes next (another DAgger round), and ImageNet's for pictures.
    normalization_mapping: dict[str, NormalizationMode] = field(
        default_factory=lambda: {
            "VISUAL": NormalizationMode.IDENTITY,
            "STATE": NormalizationMode.IDENTITY,
            "ACTION": NormalizationMode.IDENTITY,
        }
    )

    # Training preset
    optimizer_lr: float = 3e-4  # at 1e-3 a toy task's pictures went unlearned for 300 steps
    optimizer_weight_decay: float = 1e-4
    optimizer_grad_clip_norm: float = 5.0
    scheduler_warmup_steps: int = 500
    scheduler_decay_steps: int = 50_000
    scheduler_decay_lr: float = 1e-5

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.form not in FORMS:
            raise ValueError(f"form: {self.form!r} is none of {', '.join(FORMS)}")
        if self.size not in ARCHITECTURES:
            raise ValueError(f"size: {self.size!r} is none of {', '.join(ARCHITECTURES)}")
        if self.image_size < 32 or self.image_size % 16:
            raise ValueError(f"image_size: {self.image_size} is not a multiple of 16 from 32 on")
        for name, least in (("memory_frames", 0), ("memory_stride", 1), ("max_words", 1), ("max_vocabulary", 0)):
            if getattr(self, name) < least:
                raise ValueError(f"{name}: {getattr(self, name)} is less than {least}")
        for name in ("memory_dropout", "word_dropout", "mirror_share"):
            if not 0 <= getattr(self, name) < 1:
                raise ValueError(f"{name}: {getattr(self, name)} is not in [0, 1)")
        if self.min_std <= 0 or self.clip_state <= 0:
            raise ValueError(f"min_std, clip_state: {self.min_std}, {self.clip_state} are not both positive")
        if self.n_obs_steps != 1:
            raise ValueError(f"n_obs_steps: {self.n_obs_steps} is not 1; use memory_frames for past frames")
        if any(mode is not NormalizationMode.IDENTITY for mode in self.normalization_mapping.values()):
            raise ValueError("normalization_mapping: hv normalises inside the network; only IDENTITY is possible")

    @property
    def architecture(self) -> Architecture:
        return ARCHITECTURES[self.size]

    @property
    def perception(self) -> PerceptionSize:
        """Widths of what the form `belief` sees with."""
        return PERCEPTIONS[self.size]

    @property
    def memory_steps(self) -> int:
        """Control steps that the memory reaches back."""
        return self.memory_frames * self.memory_stride

    @property
    def observation_delta_indices(self) -> list[int] | None:
        """Frames that training reads for a sample, oldest first: those remembered, then the current one."""
        if self.memory_frames == 0 or self.form == "belief":
            return None
        return list(range(-self.memory_steps, 1, self.memory_stride))

    @property
    def action_delta_indices(self) -> None:
        return None

    @property
    def reward_delta_indices(self) -> None:
        return None

    def get_optimizer_preset(self) -> AdamWConfig:
        return AdamWConfig(
            lr=self.optimizer_lr,
            weight_decay=self.optimizer_weight_decay,
            grad_clip_norm=self.optimizer_grad_clip_norm,
        )

    def get_scheduler_preset(self) -> CosineDecayWithWarmupSchedulerConfig:
        return CosineDecayWithWarmupSchedulerConfig(
            num_warmup_steps=self.scheduler_warmup_steps,
            num_decay_steps=self.scheduler_decay_steps,
            peak_lr=self.optimizer_lr,
            decay_lr=self.scheduler_decay_lr,
        )

    def validate_features(self) -> None:
        """Raises ValueError unless there are a camera, `observation.state` and `action` (any sizes)."""
        if not self.image_features:
            raise ValueError(f"input_features: no camera among {', '.join(self.input_features or {}) or 'none'}")
        if self.robot_state_feature is None:
            raise ValueError(f"input_features: no observation.state among {', '.join(self.input_features or {})}")
        if self.action_feature is None:
            raise ValueError(f"output_features: no action among {', '.join(self.output_features or {}) or 'none'}")
