"""Without a GPU the check says so and fails; what it writes is readable."""

import subprocess
import sys

import pytest

from hv_scripts.gpu_check import find_gpu, main, table


def test_without_a_gpu_it_says_so_and_fails(tmp_path):
    warp = pytest.importorskip("warp", reason="Warp is not installed here: pip install 'lerobot_policy_hv[gpu]'")
    if warp.get_cuda_devices():
        pytest.skip("this machine has a GPU")
    command = [sys.executable, "-m", "hv_scripts.gpu_check", "--output", tmp_path / "out"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 1
    [line] = [line for line in done.stderr.splitlines() if line.startswith("error: ")]
    assert "no NVIDIA GPU was found" in line
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()


def test_without_warp_it_is_said_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco_warp", None)
    with pytest.raises(ValueError, match="pip install"):
        find_gpu()
    assert main(["--output", "nowhere"]) == 1


def test_the_table_has_a_line_for_each_measurement():
    row = {
        "physics": "warp",
        "num_envs": 64,
        "control_steps_per_s": 1234.5,
        "physics_steps_per_s": 2e4,
        "pictures_per_s": 9,
    }
    assert table([row]).splitlines()[2] == "| warp | 64 | 1,234 | 20,000 | 9 |"
