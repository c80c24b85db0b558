"""What a recorded dataset says that only the simulator knew, looked up by a frame's index.

`lerobot-train` hands a policy the observations, the action and the frame's index; every other column is dropped on the
way. They are read here from the dataset's own files, once.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from hv_policy.belief.places import PLACES_DIM, WAY_DIM
from hv_policy.decision.memory import VECTOR_DIM

LABELS = {"places": PLACES_DIM, "way": WAY_DIM, "memory": VECTOR_DIM}
LANDMARKS = "landmarks"
"""Column of names of things and spots and where they are, a JSON list of [phrase, is a spot, x, y, z] for each frame;
a dataset may come without it."""
PREFIX = "privileged."
_NOTHING = "nothing"


class LabelTable:
    """Labels of every frame of a dataset.

    Args:
        dataset_meta: LeRobot's metadata of a dataset that is on this machine.

    Raises:
        ValueError: the dataset lacks one of the columns, or has it in another size.
    """

    def __init__(self, dataset_meta: Any) -> None:
        import pyarrow.parquet as pq

        root = Path(dataset_meta.root)
        for name, size in LABELS.items():
            feature = dataset_meta.features.get(PREFIX + name)
            if feature is None:
                known = ", ".join(k for k in dataset_meta.features if k.startswith(PREFIX)) or "none"
                raise ValueError(
                    f"dataset {root}: has no column {PREFIX}{name}; valid: a dataset of hv-record (found: {known})"
                )
            if tuple(feature["shape"]) != (size,):
                raise ValueError(f"dataset {root}: {PREFIX}{name} has shape {feature['shape']}; valid: ({size},)")
        self.has_landmarks = PREFIX + LANDMARKS in dataset_meta.features
        columns = ["index", *(PREFIX + name for name in LABELS), *([PREFIX + LANDMARKS] * self.has_landmarks)]
        tables = [pq.read_table(file, columns=columns) for file in sorted((root / "data").rglob("*.parquet"))]
        index = np.concatenate([t["index"].to_numpy() for t in tables])
        order = np.argsort(index, kind="stable")
        self._index = torch.from_numpy(index[order])
        self._rows = {
            name: torch.from_numpy(np.concatenate([_matrix(t[PREFIX + name], size) for t in tables])[order])
            for name, size in LABELS.items()
        }
        texts = [text for t in tables for text in t[PREFIX + LANDMARKS].to_pylist()] if self.has_landmarks else []
        self._landmarks = [texts[i] for i in order] if self.has_landmarks else []

    def landmarks(self, index: Tensor) -> list[str] | None:
        """The texts of `LANDMARKS` for the frames with these indices (B,); None if the dataset has none.

        Raises:
            ValueError: there is no such frame.
        """
        return [self._landmarks[row] for row in self._row_of(index).tolist()] if self.has_landmarks else None

    def __call__(self, index: Tensor) -> dict[str, Tensor]:
        """(B, size) of each of `LABELS` for the frames with these indices (B,).

        Raises:
            ValueError: there is no such frame.
        """
        rows = self._row_of(index)
        return {name: values[rows].to(index.device) for name, values in self._rows.items()}

    def _row_of(self, index: Tensor) -> Tensor:
        where = index.reshape(-1).cpu().long()
        rows = torch.searchsorted(self._index, where).clamp(max=len(self._index) - 1)
        if not torch.equal(self._index[rows], where):
            raise ValueError(f"index: {int(where[self._index[rows] != where][0])} is no frame of the dataset")
        return rows


def draw_landmarks(texts: Sequence[str], count: int) -> tuple[list[str], Tensor, Tensor, Tensor]:
    """`count` of each frame's landmarks, drawn at random: their phrases (B * count), whether they are spots (B, count),
    where they are, heading frame, m (B, count, 3), and whether there are so many (B, count)."""
    phrases: list[str] = []
    is_spot = torch.zeros(len(texts), count, dtype=torch.bool)
    places = torch.zeros(len(texts), count, 3)
    exists = torch.zeros(len(texts), count, dtype=torch.bool)
    for row, text in enumerate(texts):
        named = json.loads(text)
        chosen = [named[i] for i in torch.randperm(len(named))[:count].tolist()]
        for k, (_, spot, *place) in enumerate(chosen):
            is_spot[row, k] = bool(spot)
            places[row, k], exists[row, k] = torch.tensor(place), True
        phrases += [phrase for phrase, *_ in chosen] + [_NOTHING] * (count - len(chosen))
    return phrases, is_spot, places, exists


def _matrix(column: Any, size: int) -> np.ndarray:
    flat = column.combine_chunks()
    while hasattr(flat, "flatten") and not isinstance(flat, np.ndarray) and flat.type.num_fields:
        flat = flat.flatten()
    return np.asarray(flat.to_numpy(zero_copy_only=False), dtype=np.float32).reshape(-1, size)
