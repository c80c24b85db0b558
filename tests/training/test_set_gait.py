"""The student gets the other motor prior and odometry and keeps everything else."""

import shutil
import subprocess
import sys
from pathlib import Path

import torch
from safetensors.torch import load_file, save_file

from hv_policy.belief.odometry import SHIPPED_ODOMETRY
from hv_policy.motor.prior import SHIPPED_MOTOR_PRIOR
from hv_policy.network_file import SHIPPED_STUDENT

SCRIPT = Path(__file__).parents[2] / "training" / "student" / "set_gait.py"


def run(*arguments: Path) -> subprocess.CompletedProcess:
    return subprocess.run([sys.executable, SCRIPT, *arguments], capture_output=True, text=True, check=False)


def test_only_prior_and_odometry_change(tmp_path: Path):
    shutil.copytree(SHIPPED_STUDENT, tmp_path / "student")
    before = load_file(tmp_path / "student" / "model.safetensors")
    wanted = {}
    for place, path in (("network.prior.", SHIPPED_MOTOR_PRIOR), ("network.odometry.", SHIPPED_ODOMETRY)):
        other = {name: value + 1.0 for name, value in load_file(path).items()}
        save_file(other, tmp_path / path.name)
        wanted |= {place + name: value for name, value in other.items()}
    others = (tmp_path / SHIPPED_MOTOR_PRIOR.name, tmp_path / SHIPPED_ODOMETRY.name)
    assert run(tmp_path / "student", *others).returncode == 0
    after = load_file(tmp_path / "student" / "model.safetensors")
    assert after.keys() == before.keys()
    for name, value in after.items():
        assert torch.equal(value, wanted.get(name, before[name])), name


def test_another_network_is_refused(tmp_path: Path):
    shutil.copytree(SHIPPED_STUDENT, tmp_path / "student")
    words = SHIPPED_MOTOR_PRIOR.parent / "words.safetensors"
    for networks, name in (((words, SHIPPED_ODOMETRY), "motor prior"), ((SHIPPED_MOTOR_PRIOR, words), "odometry")):
        before = (tmp_path / "student" / "model.safetensors").read_bytes()
        refused = run(tmp_path / "student", *networks)
        assert refused.returncode == 1
        assert f"is not of the form of the {name}" in refused.stderr
        assert refused.stderr.count("\n") == 1
        assert (tmp_path / "student" / "model.safetensors").read_bytes() == before
