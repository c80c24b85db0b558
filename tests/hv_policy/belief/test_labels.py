from types import SimpleNamespace

import pytest
import torch
from stand_still import StandStill

from hv_policy.belief.labels import LABELS, LabelTable, read_landmarks
from hv_sim.task import resolve_tasks
from hv_teachers.expert import PlannerExpert
from hv_teachers.recording import RecordingConfig, record_dataset


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    from lerobot.datasets.lerobot_dataset import LeRobotDataset

    root = tmp_path_factory.mktemp("data") / "planned"
    record_dataset(root, resolve_tasks("living_room")[:2], PlannerExpert, RecordingConfig(0, 32, 12), progress=False)
    return LeRobotDataset(root.name, root=root, video_backend="pyav")


def test_labels_are_those_of_the_frames_asked_for(dataset):
    table = LabelTable(dataset.meta)
    index = torch.tensor([len(dataset) - 1, 0, 13])
    found = table(index)
    assert set(found) == set(LABELS)
    for row, number in enumerate(index.tolist()):
        for name in LABELS:
            torch.testing.assert_close(found[name][row], dataset[number][f"privileged.{name}"])
    assert float(found["places"].abs().max()) > 0.1


def test_what_is_no_frame_is_named(dataset):
    with pytest.raises(ValueError, match=f"index: {len(dataset)} is no frame"):
        LabelTable(dataset.meta)(torch.tensor([0, len(dataset)]))


def test_a_dataset_without_labels_is_refused_in_one_line(tmp_path):
    meta = SimpleNamespace(root=tmp_path, features={"privileged.intent": {"shape": (14,)}})
    with pytest.raises(ValueError, match=r"no column privileged\.places; valid: a dataset of hv-record"):
        LabelTable(meta)
    meta.features["privileged.places"] = {"shape": (9,)}
    with pytest.raises(ValueError, match=r"privileged\.places has shape \(9,\); valid: \(21,\)"):
        LabelTable(meta)


def test_standing_still_is_recorded_with_no_knowledge(tmp_path):
    root = tmp_path / "standing"
    record_dataset(root, resolve_tasks("living_room")[:1], StandStill, RecordingConfig(0, 32, 6), progress=False)
    from lerobot.datasets.lerobot_dataset import LeRobotDataset

    table = LabelTable(LeRobotDataset(root.name, root=root, video_backend="pyav").meta)
    assert float(table(torch.arange(6))["places"].abs().max()) == 0


def test_landmarks_come_back_padded():
    first = '[["the box",1,2,3,0.1,0.2,0.3,0.5],["",4,5,6,1,1,1,0],["just behind the sofa",7,8,0.1]]'
    read = read_landmarks([first, "[]"], num_spots=2)
    assert read.names == ["the box", "", "", ""]
    assert read.exists.tolist() == [[True, True], [False, False]]
    torch.testing.assert_close(read.boxes[0, 0], torch.tensor([1, 2, 3, 0.1, 0.2, 0.3, 0.5]))
    assert read.spot_names == ["just behind the sofa", "", "", ""]
    assert read.spot_exists.tolist() == [[True, False], [False, False]]
    torch.testing.assert_close(read.spots[0, 0], torch.tensor([7, 8, 0.1]))
