"""One picture, the instruction and the pose of the body -> where the places of the task are, and how sure that is."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from hv_policy.belief.camera import RAY_DIM, pixel_rays, ray_features
from hv_policy.belief.places import FLAGS, PLACES_DIM, WAY_DIM, squash, squash_waypoint
from hv_policy.configuration_hv import PerceptionSize
from hv_policy.decision.memory import NUM_PHASES
from hv_policy.fusion import FusionLayer
from hv_policy.image_encoder import FineImageEncoder
from hv_policy.motor.proprioception import read_proprioception
from hv_policy.text_encoder import TextEncoder

LEAST_LOG_SPREAD, MOST_LOG_SPREAD = math.log(0.01), math.log(5.0)
BELIEF_DIM = 2 * PLACES_DIM + NUM_PHASES + 2


@dataclass
class Measurement:
    """What a picture says, squashed (`hv_policy.belief.places.squash`), heading frame."""

    places: Tensor  # (B, 21)
    log_spread: Tensor  # (B, 21) logarithm of the deviation
    impression: Tensor  # (B, hidden), for `Perception.way`


class Perception(nn.Module):
    """Queries read the words, look at the picture and point at parts of it; a network makes places of what they found.

    Args:
        size: widths.
        image_size: of the pictures, px.
        vocabulary, max_words, word_dropout: see `TextEncoder`.
        state_size: of the proprioception.
    """

    def __init__(
        self,
        size: PerceptionSize,
        image_size: int,
        vocabulary: Sequence[str],
        max_words: int,
        word_dropout: float,
        state_size: int,
    ) -> None:
        super().__init__()
        dim = size.dim
        self.image = FineImageEncoder(image_size, size.channels, dim)
        self.text = TextEncoder(vocabulary, max_words, dim, size.heads, size.text_layers, word_dropout)
        self.register_buffer("rays", pixel_rays(self.image.grid), persistent=False)
        self.ray = nn.Sequential(nn.Linear(RAY_DIM, dim), nn.GELU(), nn.Linear(dim, dim))
        self.state = nn.Sequential(nn.Linear(state_size, 2 * dim), nn.GELU(), nn.Linear(2 * dim, dim))
        self.queries = nn.Parameter(torch.randn(size.queries, dim) * 0.5)
        self.state_to_queries = nn.Linear(dim, size.queries * dim)
        self.fusion = nn.ModuleList(FusionLayer(dim, size.heads) for _ in range(size.fusion_layers))
        self.point_query, self.point_key = nn.Linear(dim, dim), nn.Linear(dim, dim)
        self.join = nn.Sequential(
            nn.Linear(size.queries * (dim + RAY_DIM) + dim, size.hidden),
            nn.GELU(),
            nn.Linear(size.hidden, size.hidden),
            nn.GELU(),
        )
        self.measure = nn.Linear(size.hidden, 2 * PLACES_DIM)
        self.consider = nn.Sequential(
            nn.Linear(size.hidden + BELIEF_DIM + dim, size.hidden // 2),
            nn.GELU(),
            nn.Linear(size.hidden // 2, size.hidden // 2),
            nn.GELU(),
            nn.Linear(size.hidden // 2, WAY_DIM),
        )

    def forward(self, pictures: Tensor, state: Tensor, words: Tensor, is_word: Tensor) -> Measurement:
        """What the pictures say.

        Args:
            pictures: (B, 3, H, W), 0..1.
            state: (B, 223) proprioception.
            words, is_word: (B, L, dim) and (B, L) bool, from `text`.
        """
        body = read_proprioception(state)
        rays = ray_features(body, self.rays)
        half = self.training and _is_fast_in_half(pictures.device.type)
        with torch.autocast(pictures.device.type, torch.bfloat16, enabled=half):
            tokens = self.image(pictures)
        tokens = tokens.float() + self.ray(rays)
        feeling = self.feel(state)
        queries = self.queries + self.state_to_queries(feeling).unflatten(1, self.queries.shape)
        for layer in self.fusion:
            queries = layer(queries, words, is_word, tokens, None)
        scores = self.point_query(queries) @ self.point_key(tokens).transpose(1, 2)
        pointed = (scores / tokens.shape[-1] ** 0.5).softmax(-1) @ rays
        impression = self.join(torch.cat([torch.cat([queries, pointed], -1).flatten(1), feeling], 1))
        places, log_spread = self.measure(impression).chunk(2, -1)
        return Measurement(places, log_spread.clamp(LEAST_LOG_SPREAD, MOST_LOG_SPREAD), impression)

    def feel(self, state: Tensor) -> Tensor:
        """(B, dim) of the proprioception (B, 223)."""
        return self.state((state / 2).clamp(-3.0, 3.0))

    def way(self, seen: Measurement, state: Tensor, belief: Tensor) -> Tensor:
        """(B, 8) the waypoint (squashed), the direction away from what is near, how far that is (m), and the logits of
        the three flags (`hv_policy.belief.places`).

        Args:
            seen: what the picture says.
            state: (B, 223).
            belief: (B, BELIEF_DIM), see `belief_features`.
        """
        return self.consider(torch.cat([seen.impression, belief, self.feel(state)], 1))


@functools.cache
def _is_fast_in_half(device: str) -> bool:
    """Convolutions in bfloat16 train 1.6 times as fast where the processor has instructions for them."""
    return device == "cuda" or (device == "cpu" and bool(torch.ops.mkldnn._is_mkldnn_bf16_supported()))


def belief_features(places: Tensor, log_spread: Tensor, phase: Tensor, clock_s: Tensor) -> Tensor:
    """(B, BELIEF_DIM) what is believed, as inputs of a network.

    Args:
        places: (B, 21) squashed.
        log_spread: (B, 21) logarithm of the deviation of that.
        phase: (B,) int64, `hv_policy.decision.view.Phase`.
        clock_s: (B,) time in it.
    """
    known = F.one_hot(phase, NUM_PHASES).to(places)
    clock = torch.stack([torch.tanh(clock_s), torch.tanh(clock_s / 4)], -1)
    return torch.cat([places.clamp(-5, 5), log_spread.clamp(LEAST_LOG_SPREAD, MOST_LOG_SPREAD), known, clock], 1)


def measurement_loss(seen: Measurement, places_h: Tensor) -> Tensor:
    """(B,) negative log-likelihood of the true places (B, 21), weighted by the deviation's square root so that what is
    still uncertain is learned as well (beta-NLL, Seitzer et al. 2022, beta = 0.5)."""
    error = (seen.places - squash(places_h)).abs()
    spread = seen.log_spread.exp()
    # Laplace far from the middle, normal near it: a few places that cannot be known must not decide
    likely = torch.where(error < 2 * spread, 0.5 * (error / spread) ** 2, 2 * error / spread - 2) + seen.log_spread
    return (likely * spread.detach()).mean(1)


def way_loss(predicted: Tensor, way: Tensor) -> Tensor:
    """(B,) loss of `Perception.way` against the recorded numbers (B, 8) (`hv_policy.belief.places`)."""
    flags = F.binary_cross_entropy_with_logits(predicted[:, FLAGS], way[:, FLAGS], reduction="none").mean(1)
    waypoint = F.smooth_l1_loss(predicted[:, :2], squash_waypoint(way[:, :2]), reduction="none", beta=0.1).mean(1)
    rest = F.smooth_l1_loss(predicted[:, 2:5], way[:, 2:5], reduction="none", beta=0.1).mean(1)
    return waypoint + 0.5 * rest + 0.5 * flags
