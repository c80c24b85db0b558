"""What a recorded dataset says that only the simulator knew, looked up by a frame's index.

`lerobot-train` hands a policy the observations, the action and the frame's index; every other column is dropped on the
way. They are read here from the dataset's own files, once.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from hv_policy.belief.boxes import BOX_DIM
from hv_policy.belief.places import PLACES_DIM

LABELS = {"places": PLACES_DIM, "object": 15, "half_extents": 3}
LANDMARKS = "landmarks"
"""Column of names of things and spots and where they are; a dataset may come without it. JSON, for each frame
[phrase, x, y, z, half extents 3, yaw] for things, phrase "" without words of its own, [phrase, x, y, z] for spots."""
FLOOR = "floor"
"""Column of what of the floor is taken (`hv_policy.belief.floor_patch`); a dataset may come without it."""
PREFIX = "privileged."


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
        texts = [name for name in (LANDMARKS, FLOOR) if PREFIX + name in dataset_meta.features]
        columns = ["index", *(PREFIX + name for name in (*LABELS, *texts))]
        tables = [pq.read_table(file, columns=columns) for file in sorted((root / "data").rglob("*.parquet"))]
        index = np.concatenate([t["index"].to_numpy() for t in tables])
        order = np.argsort(index, kind="stable")
        self._index = torch.from_numpy(index[order])
        self._rows = {
            name: torch.from_numpy(np.concatenate([_matrix(t[PREFIX + name], size) for t in tables])[order])
            for name, size in LABELS.items()
        }
        self._texts = {
            name: np.concatenate([t[PREFIX + name].to_numpy() for t in tables])[order].tolist() for name in texts
        }

    def texts(self, name: str, index: Tensor) -> list[str] | None:
        """The texts of column `LANDMARKS` or `FLOOR` for the frames with these indices (B,); None if the dataset has
        none.

        Raises:
            ValueError: there is no such frame.
        """
        texts = self._texts.get(name)
        return None if texts is None else [texts[row] for row in self._row_of(index).tolist()]

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


@dataclass
class Landmarks:
    """What else is in B pictures, and what it is called."""

    boxes: Tensor  # (B, T, 7) of things, `hv_policy.belief.boxes`
    exists: Tensor  # (B, T) bool
    names: list[str]  # B * T, "" where nothing names a thing alone
    spots: Tensor  # (B, S, 3), heading frame, m
    spot_exists: Tensor  # (B, S) bool
    spot_names: list[str]  # B * S


def read_landmarks(texts: Sequence[str], num_spots: int) -> Landmarks:
    """The landmarks of frames from their texts, and `num_spots` of the spots, drawn at random."""
    rows = [json.loads(text) for text in texts]
    things = [[entry for entry in row if len(entry) == 1 + BOX_DIM] for row in rows]
    drawn = []
    for row in rows:
        spots = [entry for entry in row if len(entry) == 4]
        drawn.append([spots[i] for i in torch.randperm(len(spots))[:num_spots].tolist()])
    count = max(1, max(map(len, things), default=0))
    boxes, exists, names = _padded(things, count, BOX_DIM)
    spots, spot_exists, spot_names = _padded(drawn, num_spots, 3)
    return Landmarks(boxes, exists, names, spots, spot_exists, spot_names)


def _padded(rows: Sequence[Sequence[Sequence[Any]]], count: int, size: int) -> tuple[Tensor, Tensor, list[str]]:
    numbers = torch.zeros(len(rows), count, size)
    exists = torch.zeros(len(rows), count, dtype=torch.bool)
    names: list[str] = []
    for i, row in enumerate(rows):
        if row:
            numbers[i, : len(row)] = torch.tensor([entry[1:] for entry in row])
            exists[i, : len(row)] = True
        names += [entry[0] for entry in row] + [""] * (count - len(row))
    return numbers, exists, names


def _matrix(column: Any, size: int) -> np.ndarray:
    flat = column.combine_chunks()
    while hasattr(flat, "flatten") and not isinstance(flat, np.ndarray) and flat.type.num_fields:
        flat = flat.flatten()
    return np.asarray(flat.to_numpy(zero_copy_only=False), dtype=np.float32).reshape(-1, size)
