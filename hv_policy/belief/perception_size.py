"""How large the networks of `hv_policy.belief.perception` are, by name."""

from dataclasses import dataclass


@dataclass(frozen=True)
class PerceptionSize:
    """Widths of `hv_policy.belief.perception.Perception`.

    Attributes:
        channels: at 1/4, 1/8 and 1/16 of the picture's size.
        dim: width of the tokens.
        heads: attention heads.
        text_layers: transformer layers over the words.
        fusion_layers: rounds of reading the words and looking at the picture.
        queries: tokens that do the reading and looking.
        hidden: width of the network that they end in.
    """

    channels: tuple[int, int, int] = (32, 48, 96)
    dim: int = 96
    heads: int = 4
    text_layers: int = 2
    fusion_layers: int = 2
    queries: int = 8
    hidden: int = 384


PERCEPTIONS: dict[str, PerceptionSize] = {
    "small": PerceptionSize(),
    "base": PerceptionSize((64, 128, 256), 256, 8, 4, 4, 12, 1024),
}
