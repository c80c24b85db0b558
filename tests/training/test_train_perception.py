"""What trains the student from frames in memory trains it as `lerobot-train` does."""

import importlib.util
import subprocess
import sys
from multiprocessing.pool import ThreadPool
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import torch
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from safetensors.torch import load_file

from hv_policy.belief.mirror import mirrored_text
from hv_policy.belief.other_tasks import ALL_SHAPES, sentence
from hv_policy.half_precision import in_half
from hv_policy.network_file import SHIPPED_STUDENT
from hv_policy.rewording import Lexicon, Reworder, load_rewording
from hv_sim.suites import load_suite
from hv_teachers.corrected_student import load_student
from hv_teachers.expert import PlannerExpert
from hv_teachers.recording import RecordingConfig, record_dataset

FOLDER = Path(__file__).resolve().parents[2] / "training" / "student"


WITHOUT_LEROBOT = """
import runpy, sys
for name in ("lerobot", "datasets", "pyarrow"):
    sys.modules[name] = None
sys.path.insert(0, sys.argv[1])
sys.argv = sys.argv[2:]
runpy.run_path(sys.argv[0], run_name="__main__")
"""


@pytest.fixture(scope="module")
def trainer() -> ModuleType:
    spec = importlib.util.spec_from_file_location("train_perception", FOLDER / "train_perception.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_sentences_put_together_are_read_as_whole_ones(trainer):
    text = trainer.load_perception(SHIPPED_STUDENT).text.eval()
    phrases = trainer.Phrases(text)
    frames = trainer.Frames(phrases)
    filling = {
        "thing": ["the red waste bin", "the extraordinarily old armchair"],
        "spot": ["on the bookcase", "to the left of it"],
        "other": ["under the window", "beside the very first desk"],
    }
    rows = torch.from_numpy(phrases.add([name for names in filling.values() for name in names])).view(3, 2)
    rows = torch.cat([rows, frames._empty.expand(1, 2)])
    for k in range(len(ALL_SHAPES)):
        told = rows[frames.slots[k]]
        around = frames.shapes[k][:, None].expand(-1, 2)
        joined = torch.cat([torch.stack([around[:-1], told], 1).flatten(0, 1), around[-1:]]).T
        with torch.no_grad():
            tokens, is_word = phrases.read_joined(joined)
            wanted, is_wanted = text([sentence(k, **{s: names[i] for s, names in filling.items()}) for i in range(2)])
        assert torch.equal(is_word, is_wanted)
        torch.testing.assert_close(tokens[is_word], wanted[is_word], atol=1e-4, rtol=1e-4)


def test_frames_packed_teach_what_the_dataset_teaches(trainer, tmp_path):
    root, packed = tmp_path / "glances", tmp_path / "new.npz"
    record_dataset(root, load_suite("seen")[:2], PlannerExpert, RecordingConfig(glances=32), progress=False)
    subprocess.run([sys.executable, FOLDER / "pack_frames.py", packed, "1", root], check=True, capture_output=True)
    perception = trainer.load_perception(SHIPPED_STUDENT).eval()
    frames = trainer.Frames(trainer.Phrases(perception.text), Reworder(load_rewording()).say)
    with ThreadPool(1) as pool:
        frames.add(packed, trainer.read_file(packed, pool))
    policy = load_student(SHIPPED_STUDENT).eval()
    dataset = LeRobotDataset("local/glances", root=root)
    policy.student._meta = dataset.meta
    batch = torch.utils.data.default_collate([dataset[i] for i in range(64)])
    with torch.no_grad():
        _, wanted = policy.forward(batch)
        _, found = frames.loss(perception, torch.arange(64))
    for name in ("seeing_loss", "pointing_loss", "outline_loss"):  # nothing is drawn
        assert float(found[name]) == pytest.approx(wanted[name], abs=0.01, rel=0.05), name
    assert float(found["near_object_error_m"]) == pytest.approx(wanted["near_object_error_m"], abs=0.015)
    for name in ("object_error_m", "goal_error_m"):  # guesses of what is out of view hang on how pictures are packed
        assert float(found[name]) == pytest.approx(wanted[name], abs=0.05, rel=0.1), name


def test_strangers_keep_the_color_and_have_an_unknown_name(trainer):
    lexicon = Lexicon({"bin": "bin", "trash bin": "bin"}, {}, {"red": "red", "dark red": "red"}, {"big": "large"}, ())
    strangers = trainer.Strangers(lexicon, ["dromedary"])
    for phrase, wanted in (
        ("the red trash bin", "the red dromedary"),
        ("put the big dark red bin on the desk.", "put the big dark red dromedary on the desk."),
        ("the trash bin that is on the desk", "the dromedary that is on the desk"),
        ("put the stool just behind the red sofa.", "put the stool just behind the red sofa."),
    ):
        assert strangers.of(phrase) == wanted
    phrases = trainer.Phrases(trainer.load_perception(SHIPPED_STUDENT).text.eval())
    names = ["the red trash bin", "the armchair"]
    red, plain = phrases.add(names).tolist()
    phrases.rename({name: strangers.of(name) for name in names})
    assert phrases.renamed[plain] == plain
    assert phrases.renamed[red] == phrases.row["the red dromedary"]


def test_rendered_frames_are_those_of_a_recording_and_need_no_lerobot(trainer, tmp_path):
    script, options = FOLDER / "render_frames.py", ["--workers=1", "--files=1", "--rooms=2", "--glances=3", "--seed=4"]
    for name in ("a", "b"):
        command = [script, "--tasks", "seen:0-1", "--output", tmp_path / name, *options]
        subprocess.run([sys.executable, "-c", WITHOUT_LEROBOT, FOLDER, *command], check=True, capture_output=True)
    (first,), (again,) = ((tmp_path / name).glob("*") for name in "ab")
    assert first.read_bytes() == again.read_bytes()
    with np.load(first) as held:
        assert sorted(set(held["texts"][held["task"]])) == sorted(set(held["texts"]))
        assert set(held["texts"]) <= {p for task in load_suite("seen")[:2] for s in task.subtasks for p in s.phrasings}
        assert len(held["state"]) == len(held["sizes"]) == 6
        assert len(set(held["episode"])) == 2
        boxes, places = held["boxes"][..., :3].astype(float), held["places"][:, None, :3].astype(float)
        assert np.linalg.norm(boxes - places, axis=-1).min(1).max() < 0.02  # the object is one of the things


def test_files_that_arrive_one_after_the_other_are_held_as_one(trainer, tmp_path):
    command = [sys.executable, FOLDER / "render_frames.py", "--tasks", "seen:0-1", "--output", tmp_path]
    options = ["--workers=1", "--files=3", "--rooms=1", "--glances=2"]
    subprocess.run([*command, *options], check=True, capture_output=True)
    text = trainer.load_perception(SHIPPED_STUDENT).text.eval()
    grows, is_large = trainer.Frames(trainer.Phrases(text)), trainer.Frames(trainer.Phrases(text), capacity=20)
    with ThreadPool(1) as pool:
        for file in sorted(tmp_path.glob("*.npz")):
            for frames in (grows, is_large):
                frames.add(file, trainer.read_file(file, pool))
    assert len(grows) == len(is_large) == 6
    for name, values in grows.held.items():
        assert torch.equal(values, is_large.held[name]), name
    assert set(grows.draw(500).tolist()) == set(range(6))
    phrases = grows.phrases
    for text, row in phrases.row.items():
        assert int(phrases.mirrored[row]) == phrases.row.get(mirrored_text(text), row), text


@pytest.fixture(scope="module")
def packed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("packed")
    command = [sys.executable, FOLDER / "render_frames.py", "--tasks", "seen:0-1", "--output", folder]
    options = ["--workers=1", "--files=4", "--rooms=1", "--glances=3", "--beginnings=1"]
    subprocess.run([*command, *options], check=True, capture_output=True)
    return folder


def shipped_and_frames(trainer, packed):
    perception = trainer.load_perception(SHIPPED_STUDENT).eval()
    frames = trainer.Frames(trainer.Phrases(perception.text))
    with ThreadPool(1) as pool:
        for file in sorted(packed.glob("*.npz")):
            frames.add(file, trainer.read_file(file, pool))
    return perception, frames


def test_what_is_learned_in_half_precision_is_what_is_learned_in_full(trainer, packed):
    perception, frames = shipped_and_frames(trainer, packed)
    gradients = []
    for half in (False, True):
        torch.manual_seed(3)
        perception.zero_grad()
        with in_half("cpu" if half else "nowhere"):
            loss, _ = frames.loss(perception, torch.arange(12))
        loss.mean().backward()
        gradients.append(torch.cat([p.grad.flatten() for p in perception.parameters() if p.grad is not None]))
    assert torch.nn.functional.cosine_similarity(*gradients, dim=0) > 0.98


def test_what_stays_as_it_is_costs_nothing(trainer, packed):
    perception, frames = shipped_and_frames(trainer, packed)
    losses, figures = [], []
    for trains in (True, False):
        torch.manual_seed(3)
        perception.faces.requires_grad_(trains)
        loss, found = frames.loss(perception, torch.arange(12), with_things=False)
        losses.append(loss.detach().mean())
        figures.append(found)
    assert float(figures[0]["faces_loss"]) > 0.0 == float(figures[1]["faces_loss"])
    torch.testing.assert_close(losses[0] - figures[0]["faces_loss"], losses[1])


def test_weights_may_go_part_of_the_way(trainer, tmp_path):
    perception = trainer.load_perception(SHIPPED_STUDENT)
    before, wanted = load_file(SHIPPED_STUDENT / "model.safetensors"), {}
    with torch.no_grad():
        for parameter in perception.parameters():
            parameter.add_(0.4)
    for share in (1.0, 0.25):
        trainer.save(perception, SHIPPED_STUDENT, tmp_path, share)
        wanted[share] = load_file(tmp_path / "model.safetensors")
    for name, value in before.items():
        gone = [(wanted[share][name].float() - value.float()).mean().item() for share in (1.0, 0.25)]
        assert gone[1] == pytest.approx(gone[0] / 4, abs=1e-3), name
    changed = [name for name in before if not torch.equal(wanted[1.0][name], before[name])]
    assert len(changed) == len(list(perception.parameters()))


@pytest.mark.parametrize("head", ["faces", "closer"])
def test_a_head_is_trained_alone(head, packed, tmp_path):
    script, options = FOLDER / f"train_{head}.py", ["--seconds=2", "--batch=8"]
    folders = ["--init", SHIPPED_STUDENT, "--frames", packed, "--output", tmp_path]
    done = subprocess.run([sys.executable, script, *folders, *options], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr[-2000:]
    before, after = (load_file(folder / "model.safetensors") for folder in (SHIPPED_STUDENT, tmp_path))
    changed = {name for name in before if not torch.equal(before[name], after[name])}
    assert changed == {name for name in before if name.startswith(f"network.perception.{head}.")}
    assert load_student(tmp_path).student is not None


@pytest.mark.slow
def test_two_processes_train_one_network(packed, tmp_path):
    script, options = FOLDER / "train_perception.py", ["--seconds=8", "--batch=8", "--decoders=1", "--report-s=0.1"]
    folders = ["--init", SHIPPED_STUDENT, "--frames", packed, "--output", tmp_path]
    launcher = [sys.executable, "-m", "torch.distributed.run", "--standalone", "--nproc-per-node=2"]
    done = subprocess.run([*launcher, script, *folders, *options], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr[-2000:]
    before, after = (load_file(folder / "model.safetensors") for folder in (SHIPPED_STUDENT, tmp_path))
    changed = [name for name in before if not torch.equal(before[name], after[name])]
    assert changed
    assert all(name.startswith("network.perception.") for name in changed)
    assert all(torch.isfinite(after[name]).all() for name in changed)
    assert int((tmp_path / "done").read_text()) % 16 == 0


def test_frames_of_what_has_fallen_over_are_packed_apart(tmp_path):
    root = tmp_path / "glances"
    record_dataset(root, load_suite("seen")[:2], PlannerExpert, RecordingConfig(glances=24), progress=False)
    count, held = {}, {}
    for only in ("fallen", "others"):
        out = tmp_path / f"{only}.npz"
        command = [sys.executable, FOLDER / "pack_frames.py", out, "1", root, "--only", only]
        subprocess.run(command, check=True, capture_output=True)
        with np.load(out) as opened:
            held[only], count[only] = opened["rotation"].astype(float), len(opened["sizes"])
    up = {only: np.cross(six[:, :3], six[:, 3:])[:, 2] for only, six in held.items()}
    assert (up["fallen"] < 0.6).all()
    assert (up["others"] >= 0.6).all()
    assert sum(count.values()) == 48
    assert count["fallen"] > 0
