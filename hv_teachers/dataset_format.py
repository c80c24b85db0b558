"""The columns of a recorded LeRobot dataset, and the check of a written one against what was recorded.

A stock policy sees the camera, `observation.state`, `action` and the instruction (`task`). What only a simulator knows
is kept under `privileged.*`, names that no stock policy turns into inputs.
"""

from __future__ import annotations

import io
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from tqdm import tqdm

from hv_teachers.knowledge import KNOWLEDGE_COLUMNS

if TYPE_CHECKING:
    from lerobot.datasets.lerobot_dataset import LeRobotDataset

FPS = 30
HEAD_IMAGE = "observation.images.head"
STATE = "observation.state"
ACTION = "action"

# Flat float32 vectors and their sizes; frames and units as in hv_sim.observations (heading frame, m, rad, s).
VECTOR_COLUMNS: dict[str, int] = {
    STATE: 223,
    ACTION: 28,  # joint targets, rad
    "privileged.object": 15,  # position 3, rotation 6, linear 3 and angular velocity 3 of the object in hand
    "privileged.goal": 9,  # position 3, rotation 6
    "privileged.waypoint": 3,
    "privileged.half_extents": 3,  # of the object
    "privileged.intent": 14,  # hv_sim.control.INTENT_NAMES
    "privileged.subtask_index": 1,
    **KNOWLEDGE_COLUMNS,
}

LANDMARKS = "privileged.landmarks"
"""Names of things and spots and where they are, JSON (`hv_teachers.landmark_labels`)."""
FLOOR = "privileged.floor"
"""Which floor around the robot is taken (`hv_policy.belief.floor_patch`)."""
TEXT_COLUMNS = (LANDMARKS, FLOOR)


class RecordingError(ValueError):
    """A dataset that cannot be recorded or does not hold what was recorded; the message is one line."""


def features(image_size_px: int) -> dict[str, dict[str, Any]]:
    """LeRobot's feature specification of a recorded dataset; pictures are square, stored as PNG."""
    image = {"dtype": "image", "shape": (image_size_px, image_size_px, 3), "names": ["height", "width", "channels"]}
    vectors = {name: {"dtype": "float32", "shape": (size,), "names": None} for name, size in VECTOR_COLUMNS.items()}
    texts = {name: {"dtype": "string", "shape": (1,), "names": None} for name in TEXT_COLUMNS}
    return {HEAD_IMAGE: image, **vectors, **texts}


@dataclass(frozen=True)
class FrameDigest:
    """Checksums of one recorded frame: enough to recognise it bit for bit, small enough to keep for every frame."""

    image_crc32: int
    vectors_crc32: int
    instruction: str


def digest(image: np.ndarray, columns: Mapping[str, Any], instruction: str) -> FrameDigest:
    """Digest of a picture (H, W, 3) uint8, the columns of `VECTOR_COLUMNS` (float32) and `TEXT_COLUMNS`, and the
    instruction."""
    checksum = 0
    for name in VECTOR_COLUMNS:
        checksum = zlib.crc32(np.ascontiguousarray(columns[name], dtype=np.float32).tobytes(), checksum)
    for name in TEXT_COLUMNS:
        checksum = zlib.crc32(columns[name].encode(), checksum)
    return FrameDigest(zlib.crc32(np.ascontiguousarray(image).tobytes()), checksum, instruction)


def verify_dataset(
    root: Path, repo_id: str, episodes: Mapping[int, Sequence[FrameDigest]], *, progress: bool = True
) -> None:
    """Opens the dataset at `root` as a user would and compares every frame of `episodes` with what was recorded.

    Args:
        root: the finalised dataset's folder.
        repo_id: its name.
        episodes: episode index -> digests of its frames, in order.
        progress: show a bar.

    Raises:
        RecordingError: an episode has another length, or a frame another picture, vector or instruction.
    """
    from lerobot.datasets.lerobot_dataset import LeRobotDataset  # who only makes frames needs nothing of LeRobot

    if not episodes:
        return
    dataset = LeRobotDataset(repo_id, root=root, video_backend="pyav")
    starts = dataset.meta.episodes["dataset_from_index"]
    ends = dataset.meta.episodes["dataset_to_index"]
    frames = sum(map(len, episodes.values()))
    with tqdm(total=frames, desc="Checking", unit="frame", disable=not progress) as bar:
        for index, digests in episodes.items():
            if ends[index] - starts[index] != len(digests):
                found = ends[index] - starts[index]
                raise RecordingError(f"dataset {root}: episode {index} has {found} frames instead of {len(digests)}")
            first = dataset[starts[index]]
            rows = _rows(dataset, starts[index], ends[index])
            for frame, (row, recorded) in enumerate(zip(rows, digests, strict=True)):
                if digest(*row) != recorded or (frame == 0 and not _same(first, *row)):
                    raise RecordingError(f"dataset {root}: episode {index}, frame {frame} is not what was recorded")
                bar.update()


def _rows(dataset: LeRobotDataset, start: int, end: int) -> Iterator[tuple[np.ndarray, dict[str, Any], str]]:
    """Picture, columns and instruction of frames `start` to `end`, read at once: `dataset[i]` takes 2 ms a frame."""
    import PIL.Image

    table = dataset.hf_dataset.with_format("arrow")[start:end]
    columns: dict[str, Any] = {}
    for name, size in VECTOR_COLUMNS.items():
        column = table[name].combine_chunks()
        columns[name] = (column.flatten() if size > 1 else column).to_numpy().reshape(-1, size)
    columns |= {name: table[name].to_pylist() for name in TEXT_COLUMNS}
    instructions = list(dataset.meta.tasks.index)
    said = table["task_index"].to_pylist()
    for i, picture in enumerate(table[HEAD_IMAGE].to_pylist()):
        image = np.asarray(PIL.Image.open(io.BytesIO(picture["bytes"])))
        yield image, {name: column[i] for name, column in columns.items()}, instructions[said[i]]


def _same(item: Mapping[str, Any], image: np.ndarray, columns: Mapping[str, Any], instruction: str) -> bool:
    """Whether a user of the dataset is given the frame that its table holds."""
    given = (item[HEAD_IMAGE] * 255).round().byte().permute(1, 2, 0).numpy()
    vectors = {name: np.atleast_1d(item[name].numpy()) for name in VECTOR_COLUMNS}
    texts = {name: item[name] for name in TEXT_COLUMNS}
    return digest(given, {**vectors, **texts}, item["task"]) == digest(image, columns, instruction)
