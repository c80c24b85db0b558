"""Pictures seen in a mirror, with all that is known of them, and in other colours: more rooms out of those there are.

Left and right are the only handed words of an instruction (`hv_sim.places`: of a viewer before a front, or
of the robot), and the body is symmetrical.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import torch
from torch import Tensor

from hv_policy.belief.floor_patch import PATCH_CELLS
from hv_policy.belief.labels import Landmarks
from hv_policy.motor.symmetry import AXIAL, POLAR, Reflection

_HANDED = re.compile(r"\b(left|right)\b(?!\s+place\b)", re.IGNORECASE)
_OTHER = {"left": "right", "right": "left"}

STATE = Reflection().proprioception()
_SPAN, _TURN = (-1.0, 1.0, -1.0), (1.0, -1.0)
PLACES = Reflection().signs(*POLAR, *POLAR, *_SPAN, *POLAR, *_TURN * 4, 1.0)
"""The span leads from the right hand to the left one, which change places."""
ROTATION_6D = Reflection().signs(*POLAR, *AXIAL)
POINT = Reflection().signs(*POLAR)
BOX = Reflection().signs(*POLAR, 1.0, 1.0, 1.0, -1.0)

_GAIN, _TINT, _CONTRAST, _LEVEL, _GAMMA, _NOISE = 0.15, 0.06, 0.2, 0.05, 0.15, 0.015
_ALIKE = 8
"""Pictures of a batch that share their noise, each with its own strength."""


def mirrored_text(text: str) -> str:
    """Left for right and right for left."""
    return _HANDED.sub(lambda match: _OTHER[match[0].lower()], text)


def mirrored_texts(texts: Sequence[str], chosen: Tensor) -> list[str]:
    """Those `chosen` (B,) bool mirrored."""
    return [mirrored_text(t) if c else t for t, c in zip(texts, chosen.tolist(), strict=True)]


def mirrored_pictures(pictures: Tensor, chosen: Tensor) -> Tensor:
    """Those `chosen` (B,) bool of pictures (B, C, H, W)."""
    return torch.where(chosen[:, None, None, None], pictures.flip(3), pictures)


def mirrored_floor(taken: Tensor, chosen: Tensor) -> Tensor:
    """Those `chosen` (B,) bool of patches (B, P), `hv_policy.belief.floor_patch`."""
    grid = taken.unflatten(1, (PATCH_CELLS, PATCH_CELLS))
    return torch.where(chosen[:, None, None], grid.flip(2), grid).flatten(1)


def mirrored_landmarks(landmarks: Landmarks, chosen: Tensor) -> Landmarks:
    """Those of the pictures that are `chosen` (B,) bool."""
    here = chosen[:, None, None]
    boxes = torch.where(here, BOX(landmarks.boxes), landmarks.boxes)
    spots = torch.where(here, POINT(landmarks.spots), landmarks.spots)
    things, each = landmarks.boxes.shape[1], landmarks.spots.shape[1]
    return Landmarks(
        boxes,
        landmarks.exists,
        mirrored_texts(landmarks.names, chosen.repeat_interleave(things)),
        spots,
        landmarks.spot_exists,
        mirrored_texts(landmarks.spot_names, chosen.repeat_interleave(each)),
    )


def recoloured(pictures: Tensor) -> Tensor:
    """Pictures (B, 3, H, W), 0..1, each brighter or darker, in another light and with more or less contrast."""

    def drawn(*shape: int) -> Tensor:
        return 2 * torch.rand(len(pictures), *shape, 1, 1, device=pictures.device) - 1

    pictures = pictures * (1 + _GAIN * drawn(1) + _TINT * drawn(3))
    mean, contrast = pictures.mean((2, 3), keepdim=True), 1 + _CONTRAST * drawn(1)
    pictures.mul_(contrast).add_(mean * (1 - contrast) + _LEVEL * drawn(1))
    pictures.clamp_(1e-4, 1).pow_(1 + _GAMMA * drawn(1))
    # as much noise as for an eighth of the pictures, because drawing it takes longer than all else here
    noise = torch.randn_like(pictures[: -(-len(pictures) // _ALIKE)]).repeat(_ALIKE, 1, 1, 1)[: len(pictures)]
    return pictures.add_(noise.mul_(_NOISE * (drawn(1) + 1) / 2)).clamp_(0, 1)
