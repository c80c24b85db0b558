"""The student gets the other motor prior, odometry and decisions and keeps everything else."""

import shutil
import subprocess
import sys
from pathlib import Path

import torch
from safetensors.torch import load_file, save_file

from hv_policy.belief.odometry import SHIPPED_ODOMETRY
from hv_policy.belief.student import SHIPPED_DECISION
from hv_policy.motor.prior import SHIPPED_MOTOR_PRIOR
from hv_policy.network_file import SHIPPED_STUDENT
from hv_policy.rewording import SHIPPED_REWORDING

SHIPPED = {
    "network.prior.": SHIPPED_MOTOR_PRIOR, "network.odometry.": SHIPPED_ODOMETRY, "network.decision.": SHIPPED_DECISION,
    "network.rewording.": SHIPPED_REWORDING,
}  # fmt: skip
SCRIPT = Path(__file__).parents[2] / "training" / "student" / "set_networks.py"


def run(*arguments: Path) -> subprocess.CompletedProcess:
    return subprocess.run([sys.executable, SCRIPT, *arguments], capture_output=True, text=True, check=False)


def test_only_those_networks_change(tmp_path: Path):
    shutil.copytree(SHIPPED_STUDENT, tmp_path / "student")
    before = load_file(tmp_path / "student" / "model.safetensors")
    wanted = {}
    for place, path in SHIPPED.items():
        other = {name: value if value.dtype == torch.bool else value + 1.0 for name, value in load_file(path).items()}
        save_file(other, tmp_path / path.name)
        wanted |= {place + name: value for name, value in other.items()}
    assert run(tmp_path / "student", *(tmp_path / path.name for path in SHIPPED.values())).returncode == 0
    after = load_file(tmp_path / "student" / "model.safetensors")
    assert after.keys() == before.keys()
    for name, value in after.items():
        assert torch.equal(value, wanted.get(name, before[name])), name


def test_another_network_is_refused(tmp_path: Path):
    shutil.copytree(SHIPPED_STUDENT, tmp_path / "student")
    words, right = SHIPPED_MOTOR_PRIOR.parent / "words.safetensors", list(SHIPPED.values())
    for place, name in enumerate(("motor prior", "odometry", "decisions", "rewording")):
        before = (tmp_path / "student" / "model.safetensors").read_bytes()
        refused = run(tmp_path / "student", *right[:place], words, *right[place + 1 :])
        assert refused.returncode == 1
        assert f"is not of the form of the {name}" in refused.stderr
        assert refused.stderr.count("\n") == 1
        assert (tmp_path / "student" / "model.safetensors").read_bytes() == before
