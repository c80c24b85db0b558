"""Which floor around the robot is taken, as a small grid in the heading frame: a label of recorded frames."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor

PATCH_CELLS, PATCH_CELL_M = 64, 0.125
PATCH_ORIGIN_M = (-2.0, -4.0)
"""Of its corner, x (ahead) and y (left), heading frame."""
NO_PATCH = ""
_BYTES = PATCH_CELLS * PATCH_CELLS // 8


def patch_points() -> Tensor:
    """(P, 2) middles of the patch's P cells, m, heading frame; those with the same x follow each other."""
    axes = [origin + (torch.arange(PATCH_CELLS) + 0.5) * PATCH_CELL_M for origin in PATCH_ORIGIN_M]
    return torch.stack(torch.meshgrid(*axes, indexing="ij"), -1).flatten(0, 1)


def write_patch(taken: np.ndarray) -> str:
    """The text of (P,) bool, in the order of `patch_points`."""
    return base64.b64encode(zlib.compress(np.packbits(taken).tobytes(), 9)).decode()


def read_patches(texts: Sequence[str]) -> tuple[Tensor, Tensor]:
    """(B, P) bool what is taken, and (B,) bool whether that is known, from texts of `write_patch` or `NO_PATCH`.

    Raises:
        ValueError: a text is neither.
    """
    rows = np.zeros((len(texts), _BYTES), dtype=np.uint8)
    known = np.zeros(len(texts), dtype=bool)
    for row, text in enumerate(texts):
        if text == NO_PATCH:
            continue
        try:
            rows[row] = np.frombuffer(zlib.decompress(base64.b64decode(text, validate=True)), dtype=np.uint8)
        except (ValueError, zlib.error) as error:
            raise ValueError(f"floor: {text[:20]!r} is no patch of {PATCH_CELLS} x {PATCH_CELLS} cells") from error
        known[row] = True
    taken = np.unpackbits(rows, axis=1).astype(bool)
    return torch.from_numpy(taken), torch.from_numpy(known)
