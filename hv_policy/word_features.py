"""What the words of a sentence mean, by a small network distilled from a large language model's token features.

`TextEncoder` learns the words of the recorded instructions; of a word that none of them has it knows the spelling at
best. These features come from all-MiniLM-L6-v2 (`hv-distill-text`), which has read a lot: a couch is close to a sofa
there, and a hamper to a laundry basket. They are frozen.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import lru_cache
from pathlib import Path
from typing import Any

import torch
from safetensors import safe_open
from torch import Tensor, nn

from hv_policy.network_file import load_network, save_network

FEATURE_DIM = 96
SHIPPED_WORD_FEATURES = Path(__file__).parent / "weights" / "words.safetensors"
_KIND = "hv-words-1"
_BASIC = re.compile(r"[^\W_]+|[^\w\s]", re.UNICODE)
_LONGEST_WORD = 64
_REMEMBERED = 50_000
"""Sentences that are not read again."""
MAX_PIECES = 96
"""Pieces of a sentence that are read; longer ones are cut there."""


@dataclass(frozen=True)
class WordFeaturesConfig:
    """Sizes of `WordFeatures`.

    Attributes:
        pieces: how many word pieces it knows.
        embedding: width of a piece's embedding.
        dim, heads, layers: of the transformer.
    """

    pieces: int
    embedding: int = 64
    dim: int = 128
    heads: int = 4
    layers: int = 2


class WordFeatures(nn.Module):
    """Word pieces of a sentence (S, P) int64 -> features (S, P, FEATURE_DIM), about unit variance.

    Args:
        config: sizes.
        pieces: the word pieces by number; "##" marks those that go on. Without any, words cannot be looked up.
    """

    def __init__(self, config: WordFeaturesConfig, pieces: Sequence[str] = ()) -> None:
        super().__init__()
        self.config = config
        self.pieces = list(pieces)
        self._number = {piece: i for i, piece in enumerate(self.pieces)}
        self.embedding = nn.Embedding(config.pieces, config.embedding)
        self.widen = nn.Linear(config.embedding, config.dim)
        self.position = nn.Parameter(torch.randn(MAX_PIECES, config.dim) * 0.02)
        layer = nn.TransformerEncoderLayer(
            config.dim, config.heads, 2 * config.dim, 0.0, "gelu", batch_first=True, norm_first=True
        )
        self.transformer = nn.TransformerEncoder(layer, config.layers, enable_nested_tensor=False)
        self.out = nn.Linear(config.dim, FEATURE_DIM)
        self._known: dict[tuple[str, ...], Tensor] = {}

    def forward(self, numbers: Tensor, is_piece: Tensor) -> Tensor:
        tokens = self.widen(self.embedding(numbers).float()) + self.position[: numbers.shape[1]]
        return self.out(self.transformer(tokens, src_key_padding_mask=~is_piece))

    def pieces_of(self, words: Sequence[str]) -> list[list[int]]:
        """Numbers of the pieces of each word; a word without any has an empty list."""
        return [[n for part in _BASIC.findall(_plain(word)) for n in self._split(part)] for word in words]

    def _split(self, part: str) -> list[int]:
        """The longest pieces first, as WordPiece does; nothing where some letters are no piece's."""
        found: list[int] = []
        start = 0
        while start < len(part) <= _LONGEST_WORD:
            for end in range(len(part), start, -1):
                number = self._number.get(part[start:end] if start == 0 else "##" + part[start:end])
                if number is not None:
                    found.append(number)
                    start = end
                    break
            else:
                return []
        return found

    @torch.no_grad()
    def of(self, words: Sequence[str]) -> Tensor:
        """(L, FEATURE_DIM) of the L words of a sentence: the mean over each word's pieces, zeros without any.

        A sentence is read alone and once, so that its features depend on nothing else.
        """
        key = tuple(words)
        known = self._known.get(key)
        device = self.position.device
        if known is None or known.device != device:
            if len(self._known) >= _REMEMBERED:
                self._known.clear()
            known = self._known[key] = self._read(words, device)
        return known

    def _read(self, words: Sequence[str], device: torch.device) -> Tensor:
        lists = self.pieces_of(words)
        flat = [n for numbers in lists for n in numbers][:MAX_PIECES]
        owner = [i for i, numbers in enumerate(lists) for _ in numbers][:MAX_PIECES]
        features = torch.zeros(len(words), FEATURE_DIM, device=device)
        if not flat:
            return features
        numbers = torch.tensor([flat], device=device)
        read = self(numbers, torch.ones_like(numbers, dtype=torch.bool))[0]
        of = torch.tensor(owner, device=device)
        count = torch.zeros(len(words), device=device).index_add_(0, of, torch.ones_like(read[:, 0]))
        return features.index_add_(0, of, read) / count.clamp(min=1)[:, None]


@lru_cache(maxsize=65536)
def _plain(word: str) -> str:
    """Lower case, without accents."""
    return "".join(c for c in unicodedata.normalize("NFD", word.lower()) if unicodedata.category(c) != "Mn")


def save_word_features(network: WordFeatures, path: Path = SHIPPED_WORD_FEATURES) -> None:
    """Writes weights (half precision) and pieces."""
    metadata = {"pieces": "\n".join(network.pieces)}
    save_network(network.half(), network.config, path, _KIND, metadata)


def load_word_features(path: Path = SHIPPED_WORD_FEATURES) -> WordFeatures:
    """The frozen network of a file of `save_word_features`.

    Raises:
        ValueError: the file is not one.
    """
    names = {field.name for field in fields(WordFeaturesConfig)}

    def configure(values: dict[str, Any]) -> WordFeaturesConfig:
        return WordFeaturesConfig(**{k: v for k, v in values.items() if k in names})

    network = load_network(path, _KIND, configure, lambda config: WordFeatures(config, _pieces(path)))
    network.embedding.half()  # most of its weights
    return network.requires_grad_(False)


def _pieces(path: Path) -> list[str]:
    with safe_open(str(path), framework="pt") as file:
        return str((file.metadata() or {})["pieces"]).split("\n")
