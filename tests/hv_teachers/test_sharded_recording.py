"""Shards: the same dataset whatever the processes, gone on with after kill -9, joined and compared."""

import multiprocessing
import os
import random
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
import torch
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from stand_still import StandStill

from hv_sim.task import resolve_tasks
from hv_teachers.dataset_format import RecordingError
from hv_teachers.engines import Slice
from hv_teachers.recording import REPORT_FILE, RecordingConfig, read_attempts, record_dataset
from hv_teachers.sealed_folders import seal
from hv_teachers.sharded_recording import _runs, record_shards

CONFIG = RecordingConfig(seed=3, image_size_px=48, max_episode_steps=6)


@pytest.fixture(scope="module")
def tasks():
    return resolve_tasks("living_room")[:3]


@pytest.fixture(scope="module")
def whole(tmp_path_factory, tasks) -> Path:
    """Two attempts of each task, recorded by one process in one go."""
    root = tmp_path_factory.mktemp("whole") / "standing"
    record_dataset(root, tasks, StandStill, CONFIG, repeats=2)
    return root


def rows(root: Path) -> list[dict]:
    dataset = LeRobotDataset(root.name, root=root, video_backend="pyav")
    return [dataset[i] for i in range(len(dataset))]


def assert_same(one: Path, other: Path) -> None:
    first, second = rows(one), rows(other)
    assert len(first) == len(second)
    for a, b in zip(first, second, strict=True):
        for key, value in a.items():
            if key != "task_index":
                assert value == b[key] if isinstance(value, str) else torch.equal(value, b[key]), key
    assert read_attempts(one / REPORT_FILE, CONFIG) == read_attempts(other / REPORT_FILE, CONFIG)


@pytest.mark.parametrize("workers", [1, 2])
def test_the_dataset_is_the_same_whatever_the_processes(tmp_path, tasks, whole, workers):
    report = record_shards(
        tmp_path / "standing", tasks, StandStill, CONFIG, repeats=2, num_envs=2 if workers == 2 else 1, workers=workers
    )
    assert (report.num_episodes, report.frames_recorded) == (6, 36)
    assert_same(tmp_path / "standing", whole)
    assert [p.name for p in tmp_path.iterdir()] == ["standing"], "shards and drafts are gone"


def test_finished_shards_are_used_and_unfinished_ones_recorded_again(tmp_path, tasks, whole):
    root, folder = tmp_path / "standing", tmp_path / ".standing.shards"
    record_dataset(folder / "shard_000_00001", tasks[1:2], StandStill, CONFIG, repeats=[0])
    seal(folder / "shard_000_00001")
    shutil.copytree(folder / "shard_000_00001", folder / ".shard_001_00000.partial-x" / "shard_001_00000")
    report = record_shards(root, tasks, StandStill, CONFIG, repeats=2, num_envs=2, workers=1)
    assert report.frames_recorded == 30, "one of six was there"
    assert_same(root, whole)
    assert not folder.exists()


def test_killed_at_any_moment_it_goes_on(tmp_path, whole):
    """The command itself, in its own processes, killed twice."""
    root = tmp_path / "planner"
    command = [
        sys.executable, "-m", "hv_scripts.record", f"--root={root}", "--tasks", "living_room_1", "living_room_2",
        "living_room_3", "--max-episode-steps=6", "--image-size=48", "--num-envs=1", "--workers=2", "--seed=3",
    ]  # fmt: skip
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "PYTHONHASHSEED": "0"}
    for patience in (1, 2):
        process = subprocess.Popen(command, env=environment, start_new_session=True, stderr=subprocess.DEVNULL)
        deadline = time.time() + 90
        shards = tmp_path / ".planner.shards"
        while len(list(shards.glob("shard_*"))) < patience and process.poll() is None and time.time() < deadline:
            time.sleep(0.01)
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
    done = subprocess.run(command + (["--resume"] if root.exists() else []), env=environment, capture_output=True)
    assert done.returncode == 0, done.stderr[-2000:]
    other = tmp_path / "other"
    from hv_teachers.expert import PlannerExpert

    config = RecordingConfig(seed=3, image_size_px=48, max_episode_steps=6)
    record_dataset(other, resolve_tasks("living_room")[:3], PlannerExpert, config)
    assert_same(root, other)


@pytest.mark.slow
def test_workers_killed_at_random_change_nothing(tmp_path, tasks, whole):
    """Whenever a shard is there, one of the processes, by chance, is killed a moment later."""
    chance, over, killed = random.Random(0), threading.Event(), []
    shards = tmp_path / ".standing.shards"

    def kill() -> None:
        for number in (1, 2):
            while not over.is_set() and len(list(shards.glob("shard_*"))) < number:
                over.wait(0.005)
            over.wait(chance.uniform(0.0, 0.1))
            workers: list[int] = []
            while not over.is_set() and not workers:
                workers = sorted(p.pid for p in multiprocessing.active_children() if p.pid and p.pid not in killed)
                over.wait(0.005)
            if workers:
                killed.append(chance.choice(workers))
                os.kill(killed[-1], signal.SIGKILL)

    killer = threading.Thread(target=kill)
    killer.start()
    try:
        record_shards(tmp_path / "standing", tasks, StandStill, CONFIG, repeats=2, num_envs=1, workers=2)
    finally:
        over.set()
        killer.join()
    assert len(killed) == 2
    assert_same(tmp_path / "standing", whole)
    assert not shards.exists()


def test_failed_attempts_are_dropped_and_counted(tmp_path, tasks):
    config = RecordingConfig(seed=3, image_size_px=48, max_episode_steps=6, drop_failed=True)
    with pytest.raises(RecordingError, match="all 3 attempts failed and were dropped"):
        record_shards(tmp_path / "none", tasks, StandStill, config, num_envs=2, workers=1)
    assert list(tmp_path.iterdir()) == []


def test_resume_adds_to_a_dataset(tmp_path, tasks, whole):
    root = tmp_path / "standing"
    record_shards(root, tasks, StandStill, CONFIG, workers=1)
    with pytest.raises(RecordingError, match="exists already"):
        record_shards(root, tasks, StandStill, CONFIG, repeats=2, workers=1)
    report = record_shards(root, tasks, StandStill, CONFIG, repeats=2, workers=1, resume=True)
    assert (report.num_episodes, report.frames_recorded) == (6, 18)
    assert_same(root, whole)


def test_shards_of_another_recording_are_refused(tmp_path, tasks):
    folder = tmp_path / ".standing.shards"
    folder.mkdir()
    (folder / "plan.json").write_text('{"seed": 4}')
    with pytest.raises(RecordingError, match="seed=4, not 3"):
        record_shards(tmp_path / "standing", tasks, StandStill, CONFIG, workers=1)
    with pytest.raises(RecordingError, match="is the name of more than one"):
        record_shards(tmp_path / "standing", [tasks[0], tasks[0]], StandStill, CONFIG, workers=1)


def test_runs_cover_what_is_missing_and_no_more():
    missing = [True, True, True, False, True, False, False, True, True]
    assert list(_runs(missing, 2)) == [(0, 2), (2, 1), (4, 1), (7, 2)]
    assert list(_runs([False] * 4, 2)) == []


def test_slices_of_many_machines_are_joined_and_what_is_wrong_is_redone(tmp_path, tasks, whole):
    """One slice is never recorded, one shard is damaged by a bit, one is there twice."""
    root, folder = tmp_path / "standing", tmp_path / ".standing.shards"
    settings = {"repeats": 2, "num_envs": 1, "workers": 1}
    for index in (0, 1):
        report = record_shards(root, tasks, StandStill, CONFIG, **settings, only=Slice(index, 3))
        assert (len(report.attempts), report.frames_recorded) == (2, 12)
    again = record_shards(root, tasks, StandStill, CONFIG, **settings, only=Slice(1, 3))
    assert (len(again.attempts), again.frames_recorded) == (2, 0), "a slice is gone on with"
    assert not root.exists()
    shards = sorted(p.name for p in folder.glob("shard_*"))
    assert shards == ["shard_000_00000", "shard_000_00001", "shard_001_00000", "shard_001_00001"]
    file = next((folder / shards[0] / "data").rglob("*.parquet"))
    data = bytearray(file.read_bytes())
    data[len(data) // 2] ^= 1
    file.write_bytes(data)
    shutil.copytree(folder / shards[3], folder / "shard_001_00002")
    with pytest.raises(RecordingError, match="num_envs=1, not 2"):
        record_shards(root, tasks, StandStill, CONFIG, repeats=2, num_envs=2, workers=1, only=Slice(0, 3))
    report = record_shards(root, tasks, StandStill, CONFIG, **settings)
    assert (report.damaged, report.doubled, report.frames_recorded) == (1, 1, 18)
    assert_same(root, whole)
    assert not folder.exists()
