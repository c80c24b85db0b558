"""One picture, the instruction and the pose of the body -> where the places of the task are, and how sure that is; and
which floor is free."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from hv_policy.belief.attitude import UPRIGHT, attitude_of
from hv_policy.belief.camera import RAY_DIM, pixel_rays, project, ray_features
from hv_policy.belief.closer_look import CloserLook
from hv_policy.belief.faces_head import FacesHead
from hv_policy.belief.floor import FloorHead
from hv_policy.belief.landmark_head import LandmarkHead, Piece
from hv_policy.belief.outline import OUTLINE_DIM, outline_of
from hv_policy.belief.perception_size import PerceptionSize
from hv_policy.belief.places import (
    GOAL,
    OBJECT,
    PICK,
    PLACE,
    PLACES_DIM,
    squash,
)  # fmt: skip
from hv_policy.fusion import FusionLayer
from hv_policy.half_precision import is_fast_in_half
from hv_policy.image_encoder import FineImageEncoder
from hv_policy.motor.proprioception import read_proprioception
from hv_policy.text_encoder import TextEncoder

LEAST_LOG_SPREAD, MOST_LOG_SPREAD = math.log(0.01), math.log(5.0)
NUM_POINTED = 4
"""Queries that are told which part of the picture to point at: object, goal, and the places to stand for either."""
OBJECT_QUERY, GOAL_QUERY = 0, 1
"""The first two of them."""
_BLUR, POINTING_WEIGHT = 0.6, 0.15
OUTLINE_WEIGHT, UPRIGHT_WEIGHT = 0.3, 0.3
_TRUST_UNIT = 10.0
"""What the trust in pointing is counted in, so that it is learned faster than a weight."""


@dataclass
class Measurement:
    """What a picture says, squashed (`hv_policy.belief.places.squash`), heading frame."""

    places: Tensor  # (B, 21)
    log_spread: Tensor  # (B, 21) logarithm of the deviation
    pointing: Tensor  # (B, NUM_POINTED, 1 + T) log-probabilities: not in the picture, or in this part of it
    spots: Tensor  # (B, J, 1 + T), the same for spots and things that were named by themselves
    outline: Tensor  # (B, 3) of the object, `hv_policy.belief.outline`
    upright: Tensor  # (B, 1) of the object, `hv_policy.belief.attitude`


@dataclass
class Sight:
    """What there is to see in B pictures."""

    tokens: Tensor  # (B, T, dim)
    rays: Tensor  # (B, T, RAY_DIM) where they look at
    keys: Tensor  # (B, T, dim) what is compared with what is looked for
    fine: Tensor  # (B, channels, H, W) finer features

    def of(self, rows: Tensor) -> Sight:
        """In some of the pictures."""
        return Sight(*(getattr(self, f.name)[rows] for f in fields(self)))


@dataclass
class NamedSpots:
    """Names of J spots and things of each of B pictures, and the query (`OBJECT_QUERY`, `GOAL_QUERY`) that asks."""

    queries: list[int]  # J
    words: Tensor  # (B * J, L, dim)
    is_word: Tensor  # (B * J, L) bool


class Perception(nn.Module):
    """Queries read the words, look at the picture and point at parts of it; a network makes places of what they found.

    Args:
        size: widths.
        image_size: of the pictures, px.
        vocabulary, max_words, word_dropout: see `TextEncoder`.
    """

    def __init__(
        self,
        size: PerceptionSize,
        image_size: int,
        vocabulary: Sequence[str],
        max_words: int,
        word_dropout: float,
    ) -> None:
        super().__init__()
        dim = size.dim
        self.image = FineImageEncoder(image_size, size.channels, dim)
        self.text = TextEncoder(vocabulary, max_words, dim, size.heads, size.text_layers, word_dropout)
        points = [i for part in (OBJECT, GOAL, PICK, PLACE) for i in range(part.start, part.start + 2)]
        self.register_buffer("points", torch.tensor(points), persistent=False)
        self.register_buffer("rays", pixel_rays(self.image.grid), persistent=False)
        self.ray = nn.Sequential(nn.Linear(RAY_DIM, dim), nn.GELU(), nn.Linear(dim, dim))
        self.queries = nn.Parameter(torch.randn(size.queries, dim) * 0.5)
        self.fusion = nn.ModuleList(FusionLayer(dim, size.heads) for _ in range(size.fusion_layers))
        self.point_query, self.point_key, self.nowhere = nn.Linear(dim, dim), nn.Linear(dim, dim), nn.Linear(dim, 1)
        self.background = nn.Linear(dim, 1)
        self.join = nn.Sequential(
            nn.Linear(size.queries * (2 * dim + RAY_DIM + 1), size.hidden),
            nn.GELU(),
            nn.Linear(size.hidden, size.hidden),
            nn.GELU(),
        )
        self.measure = nn.Linear(size.hidden, 2 * PLACES_DIM)
        self.outline = nn.Linear(size.hidden, OUTLINE_DIM)
        self.upright = nn.Linear(size.hidden, 1)
        self.faces = FacesHead()
        self.closer = CloserLook()
        self.landmarks = LandmarkHead(dim)
        self.movable = nn.Sequential(nn.Linear(dim, dim), nn.GELU(), nn.Linear(dim, 1))
        self.on_floor = nn.Linear(dim, 1)
        self.trust = nn.Parameter(torch.zeros(NUM_POINTED))
        self.floor = FloorHead(dim, size.channels[0], size.dim)

    def forward(self, pictures: Tensor, state: Tensor, words: Tensor, is_word: Tensor) -> Measurement:
        """What pictures say: `judge` of what `look` sees; see there."""
        return self.judge(self.look(pictures, state), words, is_word)

    def look(self, pictures: Tensor, state: Tensor) -> Sight:
        """What there is to see in pictures (B, 3, H, W), 0..1, from the head's pose in the proprioception (B, 223)."""
        rays = ray_features(read_proprioception(state), self.rays)
        half = self.training and is_fast_in_half(pictures.device.type)
        with torch.autocast(pictures.device.type, torch.bfloat16, enabled=half):
            tokens, fine = self.image(pictures)
        tokens = tokens.float() + self.ray(rays)
        return Sight(tokens, rays, self.point_key(tokens) / tokens.shape[-1] ** 0.5, fine.float())

    def judge(self, sight: Sight, words: Tensor, is_word: Tensor, spots: NamedSpots | None = None) -> Measurement:
        """What the pictures say.

        Of the body only the pose of the head counts here. Arms that reach out were in training always in front of the
        object: a network that could feel them believed it to be there, and reached for nothing.

        Args:
            sight: from `look`.
            words, is_word: (B, L, dim) and (B, L) bool, from `text`.
            spots: named by themselves, to be pointed at as objects and goals are.
        """
        tokens, own = sight.tokens, len(self.queries)
        asked = [] if spots is None else spots.queries
        queries = self.queries.expand(len(tokens), -1, -1)
        others = self.queries[asked].expand(len(tokens), -1, -1)
        for layer in self.fusion:
            queries = queries + layer.read(queries, words, is_word)
            if spots is not None:
                alone = others.flatten(0, 1)[:, None]
                others = others + layer.read(alone, spots.words, spots.is_word).view_as(others)
            together = layer.look_and_think(torch.cat([queries, others], 1), tokens, None)
            queries, others = together[:, :own], together[:, own:]
        of_objects = [OBJECT_QUERY, *(own + k for k, query in enumerate(asked) if query == OBJECT_QUERY)]
        pointing = self._pointing(torch.cat([queries, others], 1), sight, of_objects)
        there = pointing[:, :own].exp()
        with torch.autocast(tokens.device.type, enabled=False):  # metres need more digits
            found = there[..., 1:].float() @ torch.cat([tokens, sight.rays], -1)
        impression = self.join(torch.cat([queries, found, there[..., :1]], -1).flatten(1))
        places, log_spread = self.measure(impression).float().chunk(2, -1)
        places = places.index_add(1, self.points, self._pointed_at(queries, found).flatten(1))
        spread = log_spread.clamp(LEAST_LOG_SPREAD, MOST_LOG_SPREAD)
        pointed, spots_pointed = pointing[:, :NUM_POINTED], pointing[:, own:]
        outline, upright = self.outline(impression).float(), self.upright(impression).float()
        return Measurement(places, spread, pointed, spots_pointed, outline, upright)

    def named(self, words: Tensor, is_word: Tensor) -> Tensor:
        """(D, dim) what is looked for, of D different names, whose words are (D, L, dim) and (D, L)."""
        asked = self.queries[:1].expand(len(words), 1, -1)
        return self.point_query(asked + self.fusion[0].read(asked, words, is_word))[:, 0]

    def name(self, sight: Sight, named: Tensor) -> Tensor:
        """(B, T, 1 + J) logits of what each part of a picture shows: nothing of it, or one of J things.

        Args:
            sight: from `look`.
            named: (B, J, dim), from `named`.
        """
        return torch.cat([self.background(sight.tokens), sight.keys @ named.transpose(1, 2)], -1)

    def find_pieces(self, sight: Sight, named: Tensor) -> Piece:
        """Where J pieces of furniture are, which are looked for in each picture (`name`)."""
        logits = self.name(sight, named).detach()
        shows = (logits[..., 1:] - logits[..., :1]).transpose(1, 2)
        return self.landmarks(sight.tokens, sight.rays, named, shows)

    def find_movable(self, sight: Sight) -> Tensor:
        """(B, T) logits of each part of a picture showing something that can be carried, whatever its name."""
        return self.movable(sight.tokens)[..., 0]

    def _pointed_at(self, queries: Tensor, found: Tensor) -> Tensor:
        """(B, NUM_POINTED, 2) where what is pointed at would be, squashed: between where its ray meets the floor
        and where it meets a table, as far as that is to be trusted. All else the network has to add."""
        floor, table = found[:, :NUM_POINTED, -6:-4], found[:, :NUM_POINTED, -3:-1]
        share = self.on_floor(queries[:, :NUM_POINTED]).sigmoid()
        return (share * floor + (1 - share) * table) * (_TRUST_UNIT * self.trust)[:, None]

    def _pointing(self, queries: Tensor, sight: Sight, of_objects: Sequence[int]) -> Tensor:
        """(B, P, 1 + T) log-probabilities of where queries (B, P, dim) point; those `of_objects` point at nothing that
        cannot be carried."""
        scores = self.point_query(queries) @ sight.keys.transpose(1, 2)
        likely = F.logsigmoid(self.find_movable(sight).detach())[:, None].expand(-1, len(of_objects), -1)
        scores = scores.index_add(1, torch.tensor(of_objects, device=scores.device), likely.to(scores))
        return torch.cat([self.nowhere(queries), scores], -1).log_softmax(-1)


def measurement_loss(seen: Measurement, places_h: Tensor, known: Sequence[int] = range(PLACES_DIM)) -> Tensor:
    """(B,) negative log-likelihood of the `known` ones of the true places (B, 21), weighted by the deviation's square
    root so that what is still uncertain is learned as well (beta-NLL, Seitzer et al. 2022, beta = 0.5)."""
    columns = list(known)
    error = (seen.places - squash(places_h)).abs()[:, columns]
    log_spread = seen.log_spread[:, columns]
    spread = log_spread.exp()
    # Laplace far from the middle, normal near it: a few places that cannot be known must not decide
    likely = torch.where(error < 2 * spread, 0.5 * (error / spread) ** 2, 2 * error / spread - 2) + log_spread
    return (likely * spread.detach()).mean(1)


def outline_loss(seen: Measurement, rotation_6d: Tensor, half_extents_m: Tensor) -> Tensor:
    """(B,) how wrong the object's outline is, against how it is turned (B, 6) and its half extents (B, 3)."""
    truth = outline_of(rotation_6d, half_extents_m)
    return OUTLINE_WEIGHT * F.smooth_l1_loss(seen.outline, truth, reduction="none", beta=0.3).mean(1)


def upright_loss(seen: Measurement, rotation_6d: Tensor) -> Tensor:
    """(B,) how wrong it is whether the object stands, against how it is turned (B, 6)."""
    truth = attitude_of(rotation_6d)[:, UPRIGHT]
    return UPRIGHT_WEIGHT * F.smooth_l1_loss(seen.upright[:, 0], truth, reduction="none", beta=0.3)


def pointing_loss(seen: Measurement, state: Tensor, places_h: Tensor) -> Tensor:
    """(B,) `pointing_error` of the queries for the true places (B, 21), weighted."""
    floor = torch.zeros_like(places_h[:, :1])
    stands = [torch.cat([places_h[:, place], floor], 1) for place in (PICK, PLACE)]
    points = torch.stack([places_h[:, OBJECT], places_h[:, GOAL], *stands], 1)
    return POINTING_WEIGHT * pointing_error(seen.pointing, state, points).mean(1)


def pointing_error(pointing: Tensor, state: Tensor, points_h: Tensor) -> Tensor:
    """(B, P) cross-entropy of where in a picture something is said to be, against where it is.

    That is what finds things by their names: from the error of a place alone a network learns far more slowly what to
    look at.

    Args:
        pointing: (B, P, 1 + T) log-probabilities: not in the picture, or in this part of it.
        state: (B, 223) proprioception, for the pose of the camera.
        points_h: (B, P, 3), heading frame.
    """
    at, visible = project(read_proprioception(state), points_h)
    grid = round((pointing.shape[-1] - 1) ** 0.5)
    cells = torch.arange(grid, device=state.device) + 0.5
    away = (cells - ((at + 1) * grid / 2)[..., None]) / _BLUR  # (B, P, 2, grid)
    right, down = torch.exp(-0.5 * away * away).unbind(2)
    wanted = (down[..., :, None] * right[..., None, :]).flatten(2)
    wanted = wanted / wanted.sum(-1, keepdim=True).clamp(min=1e-9) * visible[..., None]
    return -(torch.cat([~visible[..., None], wanted], -1) * pointing).sum(-1)


def naming_error(logits: Tensor, label: Tensor, has_name: Tensor) -> Tensor:
    """(B,) cross-entropy of `Perception.name` (B, T, 1 + J), parts that show a thing and those that do not alike.

    Args:
        logits: of `Perception.name`.
        label: (B, T) int64 which of the J things is there, -1 for none (`hv_policy.belief.boxes.first_box_hit`).
        has_name: (B, J) bool; parts that show a thing without a name do not count.
    """
    absent = torch.cat([torch.zeros_like(has_name[:, :1]), ~has_name], 1)[:, None]
    likely = logits.masked_fill(absent, -1e4).log_softmax(-1)
    wrong = -likely.gather(-1, label[..., None] + 1)[..., 0]
    empty = label < 0
    named = ~empty & has_name.gather(1, label.clamp(min=0))

    def mean(parts: Tensor) -> Tensor:
        return (wrong * parts).sum(1) / parts.sum(1).clamp(min=1)

    return (mean(named) + mean(empty)) / 2
