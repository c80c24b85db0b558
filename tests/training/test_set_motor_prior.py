"""The student gets the other prior and keeps everything else."""

import shutil
import subprocess
import sys
from pathlib import Path

import torch
from safetensors.torch import load_file, save_file

from hv_policy.motor.prior import SHIPPED_MOTOR_PRIOR
from hv_policy.network_file import SHIPPED_STUDENT

SCRIPT = Path(__file__).parents[2] / "training" / "student" / "set_motor_prior.py"


def run(*arguments: Path) -> subprocess.CompletedProcess:
    return subprocess.run([sys.executable, SCRIPT, *arguments], capture_output=True, text=True, check=False)


def test_only_the_prior_changes(tmp_path: Path):
    shutil.copytree(SHIPPED_STUDENT, tmp_path / "student")
    before = load_file(tmp_path / "student" / "model.safetensors")
    other = {name: value + 1.0 for name, value in load_file(SHIPPED_MOTOR_PRIOR).items()}
    save_file(other, tmp_path / "other.safetensors")
    assert run(tmp_path / "student", tmp_path / "other.safetensors").returncode == 0
    after = load_file(tmp_path / "student" / "model.safetensors")
    assert after.keys() == before.keys()
    for name, value in after.items():
        own = name.removeprefix("network.prior.")
        assert torch.equal(value, before[name] if own == name else other[own]), name


def test_another_network_is_refused(tmp_path: Path):
    shutil.copytree(SHIPPED_STUDENT, tmp_path / "student")
    refused = run(tmp_path / "student", SHIPPED_MOTOR_PRIOR.parent / "words.safetensors")
    assert refused.returncode == 1
    assert "is not of the form of the motor prior" in refused.stderr
    assert refused.stderr.count("\n") == 1
