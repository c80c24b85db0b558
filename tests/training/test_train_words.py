"""A student taught to read other sentences: nothing but its reading changes, and it reads what it read before."""

import csv
import subprocess
import sys
from pathlib import Path

import pytest
import torch
from safetensors.torch import load_file

from hv_policy.network_file import SHIPPED_STUDENT
from hv_sim.suites import load_suite
from hv_teachers.expert import PlannerExpert
from hv_teachers.recording import RecordingConfig, record_dataset

FOLDER = Path(__file__).resolve().parents[2] / "training" / "student"
sys.path.insert(0, str(FOLDER))
import train_words  # noqa: E402


@pytest.fixture(scope="module")
def frames(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("frames")
    record_dataset(
        folder / "glances", load_suite("seen")[:2], PlannerExpert, RecordingConfig(glances=6), progress=False
    )
    command = [sys.executable, FOLDER / "pack_frames.py", folder / "new.npz", "1", folder / "glances"]
    subprocess.run(command, check=True, capture_output=True)
    return folder


def test_only_the_reading_of_words_is_trained(frames, tmp_path):
    command = [sys.executable, FOLDER / "train_words.py", "--init", SHIPPED_STUDENT, "--frames", frames]
    options = ["--output", tmp_path, "--seconds", "12", "--pictures", "12", "--batch", "8", "--report-s", "4"]
    done = subprocess.run([*command, *options], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    before, after = load_file(SHIPPED_STUDENT / "model.safetensors"), load_file(tmp_path / "model.safetensors")
    assert before.keys() == after.keys()
    changed = {name for name in before if not torch.equal(before[name], after[name])}
    assert changed
    assert all(name.startswith("network.perception.text.") and ".features." not in name for name in changed)
    rows = list(csv.DictReader((tmp_path / "words.csv").open()))
    assert len(rows) >= 2
    assert float(rows[-1]["difference_of_known"]) < 0.2 * float(rows[0]["difference_of_unread"])


def test_strangers_differ_and_are_otherwise_read_as_before():
    teacher = train_words.load_perception(SHIPPED_STUDENT).eval()
    phrases = train_words.Phrases(teacher.text)
    rows = phrases.add(["put", "the red vase", "on the desk", ""]).tolist()
    torch.manual_seed(0)
    with torch.no_grad():
        plain, is_word = train_words.read(phrases, [rows[:3], rows[1:3]], False)
        strange, also_word = train_words.read(phrases, [rows[:3], rows[1:3]], True)
        again, _ = train_words.read(phrases, [rows[:3], rows[1:3]], False)
    assert torch.equal(is_word, also_word)
    assert torch.equal(plain, again)
    assert not torch.allclose(plain[is_word], strange[is_word])
