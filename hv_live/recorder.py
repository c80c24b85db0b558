"""Records what happens as a LeRobot dataset, in the columns of `hv-record`, one episode from reset to reset."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from datasets.utils.logging import disable_progress_bar
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from torch import Tensor

from hv_live.actors import HEAD_SIZE_PX
from hv_policy.belief.floor_patch import NO_PATCH
from hv_sim.world import RearrangeWorld
from hv_teachers.dataset_format import (
    FLOOR,
    FPS,
    HEAD_IMAGE,
    LANDMARKS,
    FrameDigest,
    RecordingError,
    digest,
    features,
    verify_dataset,
)
from hv_teachers.knowledge import Knowledge
from hv_teachers.landmark_labels import NO_LANDMARKS
from hv_teachers.recording import moved_into_place, vector_columns

MAX_FRAMES = 30 * 60 * 30
"""Half an hour in one recording: about 500 MB of pictures."""


class LiveRecorder:
    """Writes control steps into a dataset beside its place; `finish` checks it and moves it there.

    Args:
        root: the dataset's folder; its last part is the dataset's name.

    Raises:
        RecordingError: it exists.
    """

    def __init__(self, root: Path) -> None:
        if root.exists():
            raise RecordingError(f"dataset {root}: exists already")
        root.parent.mkdir(parents=True, exist_ok=True)
        disable_progress_bar()
        self.root = root
        self.num_frames = 0
        self._place = contextlib.ExitStack()
        written = self._place.enter_context(moved_into_place(root))
        self._dataset = LeRobotDataset.create(
            root.name,
            fps=FPS,
            features=features(HEAD_SIZE_PX),
            root=written,
            robot_type="hv_humanoid",
            use_videos=False,
            image_writer_threads=1,
            video_backend="pyav",
        )
        self._written = written
        self._episode: list[FrameDigest] = []
        self._episodes: dict[int, list[FrameDigest]] = {}

    @property
    def is_full(self) -> bool:
        """No more frames are taken."""
        return self.num_frames >= MAX_FRAMES

    def add(
        self,
        world: RearrangeWorld,
        picture: np.ndarray,
        intent: Tensor,
        targets: Tensor,
        knowledge: Knowledge | None = None,
    ) -> None:
        """One control step: what was seen, felt and told before it, the servo targets (1, 28) in rad, and what whoever
        played knew; zeros where that cannot be said, which are no labels to a student."""
        columns = vector_columns(world, knowledge, intent, targets)
        row: dict[str, Any] = {key: value[0].copy() for key, value in columns.items()}
        row |= {LANDMARKS: NO_LANDMARKS, FLOOR: NO_PATCH}
        [instruction] = world.instructions()
        self._episode.append(digest(picture, row, instruction))
        self._dataset.add_frame({HEAD_IMAGE: picture.copy(), **row, "task": instruction})
        self.num_frames += 1

    def end_episode(self) -> None:
        """What comes next belongs to another episode."""
        if not self._episode:
            return
        meta = self._dataset.meta
        meta.save_episode_tasks(list(dict.fromkeys(frame.instruction for frame in self._episode)))
        self._episodes[meta.total_episodes] = self._episode
        self._episode = []
        self._dataset.save_episode()

    def finish(self) -> Path | None:
        """Writes the rest, reads everything back and moves the dataset into place; None where there is no frame.

        Raises:
            RecordingError: the dataset does not hold what was recorded.
        """
        with self._place:
            try:
                self.end_episode()
            finally:
                self._dataset.finalize()
                if self._dataset.writer is not None and self._dataset.writer.image_writer is not None:
                    self._dataset.writer.image_writer.stop()
            if not self._episodes:
                raise RecordingError(f"dataset {self.root}: nothing was recorded")
            verify_dataset(self._written, self.root.name, self._episodes, progress=False)
        return self.root

    def finish_behind(self, tell: Callable[[str], None]) -> threading.Thread:
        """`finish` in a thread of its own, which tells what came of it in a sentence."""

        def work() -> None:
            try:
                self.finish()
            except (RecordingError, OSError) as error:
                tell(f"The recording was not kept: {error}")
            else:
                tell(f"Recorded {len(self._episodes)} episodes, {self.num_frames} control steps: {self.root}")

        thread = threading.Thread(target=work, name="hv-live recording")
        thread.start()
        return thread
