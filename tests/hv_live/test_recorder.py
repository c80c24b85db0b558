import numpy as np
import pytest
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from live_cast import SpyCast

from hv_live.simulation import Simulation
from hv_teachers.dataset_format import HEAD_IMAGE, VECTOR_COLUMNS, RecordingError


def test_what_happens_becomes_a_lerobot_dataset(tmp_path):
    """Two episodes, an instruction that changes on the way, in the columns of `hv-record`."""
    root = tmp_path / "mine"
    with Simulation("living_room_1", SpyCast()) as live:
        first = live.instruction
        live.start_recording(root)
        live.run(0.1)
        live.instruct("please wave")
        live.run(0.1)
        live.reset()
        live.run(0.2)
        recorder = live.stop_recording()
        live.run(0.1)
    assert not root.exists(), "until it is finished"
    told: list[str] = []
    thread = recorder.finish_behind(told.append)
    thread.join()
    assert told == [f"Recorded 2 episodes, 12 control steps: {root}"]
    dataset = LeRobotDataset("mine", root=root, video_backend="pyav")
    assert dataset.num_episodes == 2
    assert [dataset[i]["task"] for i in range(6)] == [first] * 3 + ["please wave"] * 3
    item = dataset[0]
    assert item[HEAD_IMAGE].shape == (3, 128, 128)
    assert all(np.atleast_1d(item[name]).shape == (size,) for name, size in VECTOR_COLUMNS.items())
    assert [p.name for p in tmp_path.iterdir()] == ["mine"]


def test_nothing_recorded_leaves_nothing(tmp_path):
    with Simulation("living_room_1", SpyCast()) as live:
        live.start_recording(tmp_path / "mine")
        recorder = live.stop_recording()
        with pytest.raises(RecordingError, match="nothing was recorded"):
            recorder.finish()
        assert not list(tmp_path.iterdir())
        (tmp_path / "mine").mkdir()
        with pytest.raises(RecordingError, match="exists"):
            live.start_recording(tmp_path / "mine")
        assert live.recorder is None
