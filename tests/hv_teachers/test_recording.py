from pathlib import Path

import numpy as np
import pytest
import torch
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from stand_still import StandStill

from hv_sim.task import Task, resolve_tasks
from hv_teachers.dataset_format import ACTION, HEAD_IMAGE, STATE, VECTOR_COLUMNS
from hv_teachers.recording import (
    RecordingConfig,
    RecordingError,
    attempt_seed,
    record_dataset,
    roll_attempts,
)
from hv_teachers.replay import recorded_attempts, replay_episode

CONFIG = RecordingConfig(seed=3, image_size_px=48, max_episode_steps=12)


@pytest.fixture(scope="module")
def tasks() -> list[Task]:
    return resolve_tasks("living_room")[:2]


@pytest.fixture(scope="module")
def recorded(tmp_path_factory, tasks: list[Task]) -> Path:
    root = tmp_path_factory.mktemp("recorded") / "standing"
    report = record_dataset(root, tasks, StandStill, CONFIG, num_envs=2)
    assert (report.num_episodes, report.num_failed, report.frames_recorded) == (2, 2, 24)
    return root


def rows(root: Path) -> list[dict]:
    dataset = LeRobotDataset(root.name, root=root, video_backend="pyav")
    return [dataset[i] for i in range(len(dataset))]


def assert_same_rows(first: list[dict], second: list[dict]) -> None:
    assert len(first) == len(second)
    for one, other in zip(first, second, strict=True):
        assert one.keys() == other.keys()
        for key, value in one.items():
            assert value == other[key] if isinstance(value, str) else torch.equal(value, other[key]), key


class Crash(StandStill):
    def __call__(self, world):
        if int(world.episode_step[0]) == 5:
            raise RuntimeError("the expert tripped")
        return super().__call__(world)


def test_holds_what_the_world_showed(recorded: Path, tasks: list[Task]):
    """Compared with an independent roll of the first attempt through the environment's own observations."""
    dataset = LeRobotDataset(recorded.name, root=recorded, video_backend="pyav")
    assert dataset.fps == 30
    assert set(VECTOR_COLUMNS) | {HEAD_IMAGE} < set(dataset.features)
    from hv_sim.rearrange_env import RearrangeEnv

    env = RearrangeEnv(tasks[0], observation_height=48, observation_width=48)
    observation, _ = env.reset(seed=attempt_seed(CONFIG.seed, tasks[0].name, 0))
    for step in range(12):
        row = dataset[step]
        image = (row[HEAD_IMAGE] * 255).round().byte().permute(1, 2, 0).numpy()
        np.testing.assert_array_equal(image, observation["pixels"]["head"])
        np.testing.assert_array_equal(row[STATE].numpy(), observation["agent_pos"])
        np.testing.assert_allclose(row[ACTION].numpy(), np.full(28, 0.05 * np.sin(step / 5)), atol=1e-6)
        assert row["task"] == env.task_description == tasks[0].subtasks[0].instruction
        observation, *_ = env.step(row[ACTION].numpy())
    env.close()


def test_no_privileged_column_becomes_an_input_of_a_stock_policy(recorded: Path):
    from lerobot.utils.feature_utils import dataset_to_policy_features

    dataset = LeRobotDataset(recorded.name, root=recorded, video_backend="pyav")
    assert set(dataset_to_policy_features(dataset.features)) == {HEAD_IMAGE, STATE, ACTION}


def test_the_company_does_not_matter(recorded: Path, tasks: list[Task], tmp_path: Path):
    record_dataset(tmp_path / "standing", tasks, StandStill, CONFIG, num_envs=1)
    assert_same_rows(rows(recorded), rows(tmp_path / "standing"))


def test_other_seeds_and_repeats_start_differently(tasks: list[Task]):
    seeds = {attempt_seed(seed, task.name, repeat) for seed in (0, 1) for task in tasks for repeat in (0, 1)}
    assert len(seeds) == 8
    [(_, first)], [(_, second)] = (roll_attempts([(tasks[0], r)], StandStill, CONFIG) for r in (0, 1))
    assert not np.array_equal(first[0][STATE], second[0][STATE])


def test_an_existing_folder_is_kept_as_it_is(tmp_path: Path, tasks: list[Task]):
    root = tmp_path / "mine"
    root.mkdir()
    (root / "precious.txt").write_text("do not touch")
    with pytest.raises(RecordingError, match="exists already; choose another folder, or add to it with --resume"):
        record_dataset(root, tasks, StandStill, CONFIG)
    with pytest.raises(RecordingError, match=r"cannot be resumed, meta/hv_recording\.json is missing or damaged"):
        record_dataset(root, tasks, StandStill, CONFIG, resume=True)
    assert [path.name for path in tmp_path.rglob("*")] == ["mine", "precious.txt"]
    assert (root / "precious.txt").read_text() == "do not touch"


def test_resume_adds_what_is_missing(tmp_path: Path, tasks: list[Task]):
    root = tmp_path / "standing"
    record_dataset(root, tasks[:1], StandStill, CONFIG)
    first = rows(root)
    report = record_dataset(root, tasks, StandStill, CONFIG, repeats=2, resume=True)
    assert report.num_episodes == 4
    assert report.frames_recorded == 36
    assert_same_rows(rows(root)[:12], first)
    assert [(a.task, a.repeat) for a in recorded_attempts(root)] == [
        (tasks[0].name, 0),
        (tasks[1].name, 0),
        (tasks[0].name, 1),
        (tasks[1].name, 1),
    ]
    again = record_dataset(root, tasks, StandStill, CONFIG, repeats=2, resume=True)
    assert again.frames_recorded == 0
    assert [path.name for path in tmp_path.iterdir()] == ["standing"]
    with pytest.raises(RecordingError, match="was recorded with image_size_px=48, not 64"):
        record_dataset(root, tasks, StandStill, RecordingConfig(3, 64, 12), repeats=3, resume=True)


def test_a_crash_leaves_nothing_and_spoils_nothing(tmp_path: Path, recorded: Path, tasks: list[Task]):
    with pytest.raises(RuntimeError, match="the expert tripped"):
        record_dataset(tmp_path / "new", tasks, Crash, CONFIG)
    assert list(tmp_path.iterdir()) == []
    before = rows(recorded)
    with pytest.raises(RuntimeError, match="the expert tripped"):
        record_dataset(recorded, tasks, Crash, CONFIG, repeats=2, resume=True)
    assert_same_rows(rows(recorded), before)
    assert [path.name for path in recorded.parent.iterdir()] == ["standing"]


def test_failed_attempts_can_be_dropped_and_are_counted(tmp_path: Path, tasks: list[Task]):
    with pytest.raises(RecordingError, match="all 2 attempts failed and were dropped"):
        record_dataset(tmp_path / "new", tasks, StandStill, RecordingConfig(3, 48, 12, drop_failed=True))
    assert list(tmp_path.iterdir()) == []


def test_two_tasks_of_one_name_are_refused(tmp_path: Path, tasks: list[Task]):
    with pytest.raises(RecordingError, match=f"tasks: '{tasks[0].name}' is the name of more than one"):
        record_dataset(tmp_path / "new", [tasks[0], tasks[0]], StandStill, CONFIG)


def test_a_replay_ends_where_the_recording_did(recorded: Path, tasks: list[Task]):
    attempt = recorded_attempts(recorded)[1]
    record, frames = replay_episode(recorded, tasks[1], attempt, frame_stride=4)
    assert record.distances_m == tuple(attempt.distances_m)
    assert (record.seed, record.num_steps, record.fallen) == (attempt.seed, 12, attempt.fallen)
    assert len(frames) == 3
    assert not np.array_equal(frames[0], frames[-1])
