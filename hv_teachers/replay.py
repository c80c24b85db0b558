"""Plays a recorded episode again, from its seed and its actions alone, and looks at it from outside."""

import json
from pathlib import Path

import numpy as np
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from tqdm import tqdm

from hv_sim.metrics import EpisodeRecord
from hv_sim.rearrange_env import RearrangeEnv
from hv_sim.task import Task
from hv_teachers.dataset_format import ACTION
from hv_teachers.recording import REPORT_FILE, Attempt


def recorded_attempts(root: Path) -> list[Attempt]:
    """The attempts behind the dataset at `root`, those that were left out of it included."""
    return [Attempt(**attempt) for attempt in json.loads((root / REPORT_FILE).read_text())["attempts"]]


def replay_episode(
    root: Path, task: Task, attempt: Attempt, *, frame_stride: int = 1
) -> tuple[EpisodeRecord, list[np.ndarray]]:
    """Runs the recorded actions of an attempt in a fresh environment.

    Args:
        root: the dataset's folder.
        task: the attempt's task.
        attempt: one that has an `episode_index`.
        frame_stride: take a picture every so many control steps.

    Returns:
        How the episode ended, the same as when it was recorded, and pictures of it: third person on the left, head
        camera on the right, the instruction underneath, (H, W, 3) uint8 each.
    """
    if attempt.episode_index is None:
        raise ValueError(f"attempt: {attempt.task}, repeat {attempt.repeat}, was left out of the dataset {root}")
    dataset = LeRobotDataset(root.name, root=root, episodes=[attempt.episode_index], video_backend="pyav")
    actions = np.asarray(dataset.hf_dataset.with_format("numpy")[ACTION], dtype=np.float32)
    env = RearrangeEnv(task, max_episode_steps=len(actions))
    try:
        env.reset(seed=attempt.seed)
        frames: list[np.ndarray] = []
        for step, action in enumerate(tqdm(actions, desc="Filming", unit="step")):
            if step % frame_stride == 0:
                picture = env.render()
                assert picture is not None  # rgb_array is the environment's default mode
                frames.append(picture)
            env.step(action)
        return env.world.records()[0], frames
    finally:
        env.close()
