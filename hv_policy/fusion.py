"""Attention that makes one thing of words and pictures."""

import torch.nn.functional as F
from torch import Tensor, nn


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
        return self.look_and_think(queries + self.read(queries, words, is_word), sights, is_sight)

    def look_and_think(self, queries: Tensor, sights: Tensor, is_sight: Tensor | None) -> Tensor:
        """What comes after reading."""
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
