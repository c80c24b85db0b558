import json
from pathlib import Path
from types import SimpleNamespace

import pandas as pd
import pytest
import torch
import yaml
from policy_samples import TASKS, make_config, make_policy

from hv_policy.modeling_hv import HVPolicy
from hv_teachers.corrected_student import load_student
from hv_teachers.evaluated_policies import checkpoint_fingerprint
from hv_teachers.student_package import pack_student

METRICS = {
    "n_episodes": 8, "fall_rate": 0.125, "dist_1": 0.31, "dist_2": 0.62,
    "at_0.4": {"success_1": 0.75, "success_2": 0.5, "success_all": 0.5},
    "at_0.2": {"success_1": 0.5, "success_2": 0.25, "success_all": 0.25},
}  # fmt: skip


@pytest.fixture
def checkpoint(tmp_path: Path) -> Path:
    torch.manual_seed(0)
    meta = SimpleNamespace(tasks=pd.DataFrame({"task_index": [0, 1]}, index=TASKS))
    HVPolicy(make_config(form="belief"), dataset_meta=meta).save_pretrained(tmp_path / "checkpoint")
    (tmp_path / "checkpoint" / "train_config.json").write_text('{"root": "/home/somebody"}')
    return tmp_path / "checkpoint"


@pytest.fixture
def evaluation(tmp_path: Path, checkpoint: Path) -> Path:
    (tmp_path / "seen").mkdir()
    plan = {"seed": 7, "policy_hash": checkpoint_fingerprint(checkpoint, "hv")}
    (tmp_path / "seen" / "metrics.json").write_text(json.dumps(METRICS | {"plan": plan}))
    return tmp_path / "seen"


def test_package_acts_as_the_checkpoint_and_its_card_says_what_was_measured(checkpoint, evaluation, tmp_path):
    folder = tmp_path / "student"
    for _ in range(2):  # the second time it replaces the first
        pack_student(checkpoint, folder, {"seen": evaluation}, "hv-record --root a\nlerobot-train --x=1\n")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["checkpoint", "seen", "student"]
    assert not (folder / "train_config.json").exists()
    before, after = load_student(checkpoint).state_dict(), load_student(folder).state_dict()
    assert before.keys() == after.keys()
    for name, values in before.items():
        torch.testing.assert_close(after[name], values, atol=0, rtol=0)
    _, front, text = (folder / "README.md").read_text().split("---\n", 2)
    about = yaml.safe_load(front)
    assert about["library_name"] == "lerobot"
    assert about["pipeline_tag"] == "robotics"
    assert "| seen | 75.0% | 50.0% | **50.0%** | 25.0% | 0.31 / 0.62 | 12.5% | 8 | 7 |" in text
    assert "    hv-record --root a\n    lerobot-train --x=1\n" in text
    assert "somebody" not in "".join(p.read_text() for p in folder.glob("*.json"))


def test_what_is_missing_is_said_and_nothing_is_left(checkpoint, evaluation, tmp_path):
    folder = tmp_path / "student"
    with pytest.raises(ValueError, match="a folder that hv-eval has finished"):
        pack_student(checkpoint, folder, {"seen": tmp_path}, "")
    (tmp_path / "other").mkdir()
    other = METRICS | {"plan": {"seed": 7, "policy_hash": "hv-0123456789abcdef"}}
    (tmp_path / "other" / "metrics.json").write_text(json.dumps(other))
    with pytest.raises(ValueError, match="other is of another policy"):
        pack_student(checkpoint, folder, {"seen": evaluation, "unseen": tmp_path / "other"}, "")
    make_policy().save_pretrained(tmp_path / "direct")
    with pytest.raises(ValueError, match="form direct"):
        pack_student(tmp_path / "direct", folder, {"seen": evaluation}, "")
    assert not folder.exists()
