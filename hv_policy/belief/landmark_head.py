"""Where a piece of furniture that is named stands, how large it is and where its front looks; and which spot words like
"just to the left of" it mean.

A picture shows a dozen pieces, whose boxes are all known in training, and one goal. What a relation means is the same
beside every piece, so that it is better said than learned: left and right are those of somebody who stands before the
front and looks at it.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from hv_policy.belief.camera import RAY_DIM
from hv_policy.belief.places import unsquash_waypoint

GAP_M = 0.22
"""Between a piece and what stands just beside it."""
END_SHARE = 0.27
"""How far from the middle of a long top its left and right sides are, as a share of the top's width."""
OFFSETS: dict[str, tuple[float, float, float, float]] = {
    "on": (0.0, 0.0, 0.0, 0.0),
    "on_left": (0.0, -2 * END_SHARE, 0.0, 0.0),
    "on_middle": (0.0, 0.0, 0.0, 0.0),
    "on_right": (0.0, 2 * END_SHARE, 0.0, 0.0),
    "left_of": (0.0, -1.0, 0.0, -1.0),
    "right_of": (0.0, 1.0, 0.0, 1.0),
    "in_front_of": (1.0, 0.0, 1.0, 0.0),
    "front_middle": (1.0, 0.0, 1.0, 0.0),
    "behind": (-1.0, 0.0, -1.0, 0.0),
    "back_middle": (-1.0, 0.0, -1.0, 0.0),
}
"""Relation (`hv_policy.rewording.RELATIONS`) -> where its spot is from the middle of a piece, toward its front and to
its own left: in half extents, and in how far the middle of what stands beside a piece is from that."""
_LEARNED = ("on_left", "on_right", "left_of", "right_of", "in_front_of", "behind")
"""Relations whose spots the head is judged by."""
_HEADS, _WIDTH, _HIDDEN = 6, 96, 192
_USUAL_HALF_M = (0.25, 0.5, 0.45)
_LEAST_LOG_SPREAD, _MOST_LOG_SPREAD = -4.0, 1.5
_OBJECT_HALF_M = 0.17
_SIZE_WEIGHT, _FRONT_WEIGHT, _SEEN_WEIGHT = 0.3, 0.3, 0.3


@dataclass
class Piece:
    """J pieces in each of B pictures, heading frame."""

    middle: Tensor  # (B, J, 2) m, on the floor
    half_extents_m: Tensor  # (B, J, 3) depth, width, height
    front: Tensor  # (B, J, 2) unit vector
    log_spread: Tensor  # (B, J) logarithm of the deviation of spots beside it, m
    seen: Tensor  # (B, J) logit of its being in the picture

    def spot(self, offset: Tensor, object_half_m: Tensor) -> Tensor:
        """(B, J, 2) where something shall go, m.

        Args:
            offset: (..., 4) of `OFFSETS`.
            object_half_m: (...) half of the width of what shall go there.
        """
        beside = object_half_m + GAP_M
        ahead = offset[..., 0] * self.half_extents_m[..., 0] + offset[..., 2] * beside
        left = offset[..., 1] * self.half_extents_m[..., 1] + offset[..., 3] * beside
        aside = torch.stack([-self.front[..., 1], self.front[..., 0]], -1)
        return self.middle + ahead[..., None] * self.front + left[..., None] * aside


class LandmarkHead(nn.Module):
    """Looks twice at the parts of a picture that fit a name, with several heads, for its middle and its ends.

    Args:
        dim: of the picture's tokens and of the names.
    """

    def __init__(self, dim: int) -> None:
        super().__init__()
        self.key_value = nn.Linear(dim + RAY_DIM, 2 * _WIDTH)
        self.ask = nn.ModuleList(nn.Linear(width, _WIDTH) for width in (dim, dim + _HEADS * RAY_DIM + _WIDTH))
        self.fits = nn.Parameter(torch.ones(2, _HEADS))
        self.out = nn.Sequential(
            nn.Linear(dim + 1 + 2 * (_HEADS * RAY_DIM + _WIDTH), _HIDDEN),
            nn.GELU(),
            nn.Linear(_HIDDEN, _HIDDEN),
            nn.GELU(),
            nn.Linear(_HIDDEN, 9),
        )

    def forward(self, tokens: Tensor, rays: Tensor, named: Tensor, shows: Tensor) -> Piece:
        """The pieces that J names mean.

        Args:
            tokens, rays: (B, T, dim), (B, T, RAY_DIM) of `hv_policy.belief.perception.Sight`.
            named: (B, J, dim) what is looked for (`Perception.named`).
            shows: (B, J, T) logits of each part of the picture showing it and not the background.
        """
        with torch.autocast(tokens.device.type, enabled=False):  # metres need more digits
            tokens, rays, named, shows = tokens.float(), rays.float(), named.float(), shows.float()
            key, value = self.key_value(torch.cat([tokens, rays], -1)).chunk(2, -1)
            key = key.unflatten(-1, (_HEADS, -1))
            likely = F.logsigmoid(shows)
            found = [named, likely.amax(-1, keepdim=True).exp()]
            asked = named
            for ask, fits in zip(self.ask, self.fits, strict=True):
                query = ask(asked).unflatten(-1, (_HEADS, -1))
                score = torch.einsum("bjhd,bthd->bjht", query, key) / query.shape[-1] ** 0.5
                share = (score + fits[:, None] * likely[:, :, None]).softmax(-1)
                looked_at = torch.einsum("bjht,btr->bjhr", share, rays)
                read = torch.einsum("bjht,bthd->bjhd", share, value.unflatten(-1, (_HEADS, -1))).flatten(2)
                looked = torch.cat([looked_at.flatten(2), read], -1)
                found.append(looked)
                asked = torch.cat([named, looked], -1)
            out = self.out(torch.cat(found, -1))
            middle = unsquash_waypoint(looked_at[:, :, 0, -6:-4] + out[..., :2])
            usual = torch.log(out.new_tensor(_USUAL_HALF_M))
            half = (usual + out[..., 2:5].clamp(-2.0, 2.0)).exp()
            front = F.normalize(out[..., 5:7], dim=-1, eps=1e-4)
            return Piece(middle, half, front, out[..., 7].clamp(_LEAST_LOG_SPREAD, _MOST_LOG_SPREAD), out[..., 8])


def landmark_loss(piece: Piece, boxes: Tensor, in_view: Tensor, has_name: Tensor) -> tuple[Tensor, Tensor]:
    """(B,) how wrong pieces (B, J) are, and (B, J) by how much the spots on and around them are, m.

    The spots' likelihood is that of a Laplace distribution under the deviation that is said, weighted by its square
    root (beta-NLL, Seitzer et al. 2022, beta = 0.5).

    Args:
        piece: what is said.
        boxes: (B, J, 7) what is so (`hv_policy.belief.boxes`).
        in_view, has_name: (B, J) bool; pieces without a name do not count.
    """
    front = torch.stack([boxes[..., 6].cos(), boxes[..., 6].sin()], -1)
    nothing = torch.zeros_like(piece.seen)
    truth = Piece(boxes[..., :2], boxes[..., 3:6], front, nothing, nothing)
    half = boxes.new_tensor(_OBJECT_HALF_M)
    offsets = [boxes.new_tensor(OFFSETS[name]) for name in _LEARNED]
    apart = [(piece.spot(o, half) - truth.spot(o, half)).square().sum(-1).add(1e-6).sqrt() for o in offsets]
    wrong = torch.stack(apart).mean(0)
    likely = (wrong / piece.log_spread.exp() + piece.log_spread) * (0.5 * piece.log_spread.detach()).exp()
    size = (piece.half_extents_m.log() - boxes[..., 3:6].clamp(min=0.02).log()).abs().mean(-1)
    turned = 1 - (piece.front * front).sum(-1)
    told = in_view & has_name
    where = (likely + _SIZE_WEIGHT * size + _FRONT_WEIGHT * turned) * told
    seen = F.binary_cross_entropy_with_logits(piece.seen, in_view.float(), reduction="none") * has_name
    count = has_name.sum(1).clamp(min=1)
    return where.sum(1) / told.sum(1).clamp(min=1) + _SEEN_WEIGHT * seen.sum(1) / count, wrong.detach()
