"""Instructions -> one token per word, in order, with a vocabulary that travels in the checkpoint.

Every word has three parts: an embedding of its own if it is in the vocabulary; the mean of embeddings of its letter
trigrams, hashed into a fixed table, so that "mugs" is close to "mug"; and what it means in its sentence
(`hv_policy.word_features`), so that a couch is close to a sofa. The words stay apart until the policy reads them, and
carry positions: "from the left to the right" and its reverse differ.
"""

import re
import zlib
from collections import Counter
from collections.abc import Iterable, Sequence
from functools import lru_cache

import numpy as np
import torch
from torch import Tensor, nn

from hv_policy.word_features import FEATURE_DIM, load_word_features

_WORD = re.compile(r"\d+(?:\.\d+)?|[^\W\d_]+(?:'[^\W\d_]+)?|[^\w\s]", re.UNICODE)
_TRIGRAM_BUCKETS = 2048
_MAX_TRIGRAMS = 16  # of one word; enough for 16 letters
PAD, UNKNOWN = 0, 1  # word numbers that are no word's; the vocabulary begins at 2


def split_words(text: str) -> list[str]:
    """Lower-case words, numbers and punctuation marks of `text`, in order."""
    return _WORD.findall(text.lower())


def build_vocabulary(texts: Iterable[str], max_words: int) -> list[str]:
    """The `max_words` most frequent words of `texts`, in alphabetical order (ties in frequency: alphabetical too)."""
    counts = Counter(word for text in sorted(set(texts)) for word in split_words(text))
    frequent = sorted(counts, key=lambda word: (-counts[word], word))[:max_words]
    return sorted(frequent)


@lru_cache(maxsize=65536)
def trigram_buckets(word: str) -> tuple[int, ...]:
    """Table rows (1.._TRIGRAM_BUCKETS) of the letter trigrams of `word`, the same on every machine."""
    marked = f"<{word}>"
    trigrams = [marked[i : i + 3] for i in range(max(1, len(marked) - 2))][:_MAX_TRIGRAMS]
    return tuple(1 + zlib.crc32(trigram.encode()) % _TRIGRAM_BUCKETS for trigram in trigrams)


class TextEncoder(nn.Module):
    """Instructions (list of T str) -> (tokens (T, L, dim), is_word (T, L) bool); L is the longest one's word count.

    Args:
        vocabulary: words with an embedding of their own.
        max_words: words read of each instruction.
        dim, heads, layers: of the transformer over the words.
        word_dropout: share of words shown as unknown while training, half of them without their spelling.
    """

    def __init__(
        self, vocabulary: Sequence[str], max_words: int, dim: int, heads: int, layers: int, word_dropout: float
    ):
        super().__init__()
        self.max_words = max_words
        self.word_dropout = word_dropout
        self._number = {word: 2 + i for i, word in enumerate(vocabulary)}
        self.word = nn.Embedding(2 + len(vocabulary), dim, padding_idx=PAD)
        self.trigram = nn.Embedding(1 + _TRIGRAM_BUCKETS, dim, padding_idx=PAD)
        self.position = nn.Parameter(torch.randn(max_words, dim) * 0.1)
        self.features = load_word_features()
        self.meaning = nn.Linear(FEATURE_DIM, dim, bias=False)
        nn.init.normal_(self.word.weight, std=0.5)
        nn.init.normal_(self.trigram.weight, std=0.5)
        layer = nn.TransformerEncoderLayer(
            dim, heads, 2 * dim, dropout=0.0, activation="gelu", batch_first=True, norm_first=True
        )
        self.transformer = nn.TransformerEncoder(layer, layers, norm=nn.LayerNorm(dim), enable_nested_tensor=False)

    def forward(self, texts: Sequence[str]) -> tuple[Tensor, Tensor]:
        words = self.words_of(texts)
        numbers, buckets = self.tokenize(words)
        meanings = nn.utils.rnn.pad_sequence([self.features.of(line) for line in words], batch_first=True)
        return self.read(numbers, buckets, meanings)

    def words_of(self, texts: Sequence[str]) -> list[list[str]]:
        """The words that are read of each text."""
        return [split_words(text)[: self.max_words] or [""] for text in texts]

    def read(self, numbers: Tensor, buckets: Tensor, meanings: Tensor) -> tuple[Tensor, Tensor]:
        """As `forward`, of texts that were looked up before: word numbers (T, L) and trigram rows (T, L, G) from
        `tokenize`, and what the words mean (T, L, FEATURE_DIM)."""
        is_word = numbers != PAD
        if self.training and self.word_dropout:
            drawn = torch.rand(numbers.shape, device=numbers.device)
            numbers = numbers.masked_fill((drawn < self.word_dropout) & is_word, UNKNOWN)
            buckets = buckets.masked_fill((drawn < self.word_dropout / 2)[..., None], PAD)
        there = (buckets != PAD)[..., None]  # how wide the longest word makes the table must not matter
        trigrams = (self.trigram(buckets) * there).sum(2) / there.sum(2).clamp(min=1).sqrt()
        tokens = self.word(numbers) + trigrams + self.meaning(meanings)
        tokens = tokens + self.position[: numbers.shape[1]]
        return self.transformer(tokens, src_key_padding_mask=~is_word), is_word

    def tokenize(self, words: Sequence[Sequence[str]]) -> tuple[Tensor, Tensor]:
        """Word numbers (T, L) and trigram rows (T, L, G), padded with PAD."""
        rows = [[trigram_buckets(word) for word in line] for line in words]
        length = max(len(line) for line in words)
        width = max(len(row) for line in rows for row in line)
        nothing = (PAD,) * width
        numbers = [[self._number.get(word, UNKNOWN) for word in line] + [PAD] * (length - len(line)) for line in words]
        buckets = [[row + nothing[len(row) :] for row in line] + [nothing] * (length - len(line)) for line in rows]
        device = self.position.device
        # by way of numpy, which reads nested lists many times as fast
        return torch.from_numpy(np.array(numbers)).to(device), torch.from_numpy(np.array(buckets)).to(device)
