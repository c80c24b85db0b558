from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from hv_teachers.dataset_format import (
    FLOOR,
    FPS,
    HEAD_IMAGE,
    LANDMARKS,
    TEXT_COLUMNS,
    VECTOR_COLUMNS,
    FrameDigest,
    RecordingError,
    digest,
    features,
    verify_dataset,
)
from hv_teachers.recording import _write_episode

INSTRUCTIONS = ["Then put the vase on the shelf.", "Carry the box to the table."]  # not in alphabetical order


@pytest.fixture
def written(tmp_path: Path) -> tuple[Path, list[FrameDigest]]:
    """One episode of ten random frames whose instruction changes after six."""
    rng = np.random.default_rng(0)
    root = tmp_path / "random"
    frames = [
        {
            HEAD_IMAGE: rng.integers(0, 256, (32, 32, 3), dtype=np.uint8),
            **{name: rng.standard_normal(size).astype(np.float32) for name, size in VECTOR_COLUMNS.items()},
            LANDMARKS: f'[["the vase", 0, {step}, 0, 0.5]]',
            FLOOR: "" if step == 3 else f"{step}",
            "task": INSTRUCTIONS[step >= 6],
        }
        for step in range(10)
    ]
    dataset = LeRobotDataset.create(
        "random", fps=FPS, features=features(32), root=root, use_videos=False, video_backend="pyav"
    )
    digests = _write_episode(dataset, frames)
    dataset.finalize()
    return root, digests


def test_two_instructions_in_one_episode_come_back_frame_by_frame(written):
    root, digests = written
    dataset = LeRobotDataset("random", root=root, video_backend="pyav")
    assert [dataset[i]["task"] for i in range(10)] == [INSTRUCTIONS[0]] * 6 + [INSTRUCTIONS[1]] * 4
    assert list(dataset.meta.tasks.index) == INSTRUCTIONS  # numbered as they appear
    verify_dataset(root, "random", {0: digests})


@pytest.mark.parametrize("field", ["image_crc32", "vectors_crc32", "instruction"])
def test_any_difference_is_found_and_its_frame_named(written, field: str):
    root, digests = written
    other = "Something else." if field == "instruction" else getattr(digests[7], field) ^ 1
    digests[7] = replace(digests[7], **{field: other})
    with pytest.raises(RecordingError, match="episode 0, frame 7 is not what was recorded"):
        verify_dataset(root, "random", {0: digests})


def test_a_missing_frame_is_found(written):
    root, digests = written
    with pytest.raises(RecordingError, match="episode 0 has 10 frames instead of 11"):
        verify_dataset(root, "random", {0: [*digests, digests[0]]})


def test_a_digest_tells_every_entry_apart():
    image = np.zeros((4, 4, 3), np.uint8)
    vectors = {name: np.zeros(size, np.float32) for name, size in VECTOR_COLUMNS.items()} | {LANDMARKS: "[]", FLOOR: ""}
    seen = {digest(image, vectors, "a"), digest(image, vectors, "b")}
    for name in VECTOR_COLUMNS:
        changed = {key: np.copy(value) if key not in TEXT_COLUMNS else value for key, value in vectors.items()}
        changed[name][-1] = np.nextafter(np.float32(0), np.float32(1))
        seen.add(digest(image, changed, "a"))
    image[3, 3, 2] = 1
    seen.add(digest(image, vectors, "a"))
    seen.add(digest(image, vectors | {LANDMARKS: "[[]]"}, "a"))
    seen.add(digest(image, vectors | {FLOOR: "x"}, "a"))
    assert len(seen) == 5 + len(VECTOR_COLUMNS)
