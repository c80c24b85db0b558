"""What trained the student on a GPU trains it as `lerobot-train` does."""

import importlib.util
import subprocess
import sys
from multiprocessing.pool import ThreadPool
from pathlib import Path
from types import ModuleType

import pytest
import torch
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from hv_policy.belief.other_tasks import SHAPES, sentence
from hv_sim.suites import load_suite
from hv_teachers.corrected_student import load_student
from hv_teachers.expert import PlannerExpert
from hv_teachers.recording import RecordingConfig, record_dataset

FOLDER = Path(__file__).resolve().parents[2] / "training" / "student"


@pytest.fixture(scope="module")
def trainer() -> ModuleType:
    spec = importlib.util.spec_from_file_location("train_on_gpu", FOLDER / "train_on_gpu.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_sentences_put_together_are_read_as_whole_ones(trainer):
    text = trainer.load_perception(FOLDER).text.eval()
    phrases = trainer.Phrases(text)
    things, spots = ["the red waste bin", "the extraordinarily old armchair"], ["on the bookcase", "to the left of it"]
    rows = torch.from_numpy(phrases.add([*things, *spots]))
    shapes = torch.from_numpy(phrases.add([part for shape in SHAPES for part in shape])).view(-1, 3)
    for k in (0, 4, 8, 9):
        before, between, after = shapes[k]
        joined = torch.stack([torch.stack([before, rows[i], between, rows[2 + i], after]) for i in range(2)])
        with torch.no_grad():
            tokens, is_word = phrases.read_joined(joined)
            wanted, is_wanted = text([sentence(things[i], spots[i], k) for i in range(2)])
        assert torch.equal(is_word, is_wanted)
        torch.testing.assert_close(tokens[is_word], wanted[is_word], atol=1e-4, rtol=1e-4)


def test_frames_packed_for_the_gpu_teach_what_the_dataset_teaches(trainer, tmp_path):
    root, packed = tmp_path / "glances", tmp_path / "new.npz"
    record_dataset(root, load_suite("seen")[:2], PlannerExpert, RecordingConfig(glances=4), progress=False)
    subprocess.run([sys.executable, FOLDER / "pack_frames.py", packed, "1", root], check=True, capture_output=True)
    perception = trainer.load_perception(FOLDER).eval()
    frames = trainer.Frames(trainer.Phrases(perception.text))
    with ThreadPool(1) as pool:
        frames.add(packed, trainer.read_file(packed, pool))
    policy = load_student(FOLDER).eval()
    dataset = LeRobotDataset("local/glances", root=root)
    policy.student._meta = dataset.meta
    batch = torch.utils.data.default_collate([dataset[i] for i in range(8)])
    with torch.no_grad():
        _, wanted = policy.forward(batch)
        _, found = frames.loss(perception, torch.arange(8))
    for name in ("seeing_loss", "pointing_loss", "outline_loss", "object_error_m", "goal_error_m"):  # nothing is drawn
        assert float(found[name]) == pytest.approx(wanted[name], abs=0.05, rel=0.1), name
