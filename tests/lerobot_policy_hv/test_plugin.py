import importlib.metadata
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from hv_policy.modeling_hv import CheckpointError
from lerobot_policy_hv.error_lines import report_input_errors_in_one_line

ROOT = Path(__file__).parents[2]


def test_the_distribution_has_the_name_that_lerobot_looks_for():
    """LeRobot compares the metadata's own spelling: a hyphen there would make the plugin invisible."""
    names = [distribution.metadata["Name"] for distribution in importlib.metadata.distributions()]
    assert "lerobot_policy_hv" in names


def test_the_plugin_is_cheap_to_import():
    code = (
        "import sys, lerobot.policies, lerobot.envs; before = set(sys.modules); import lerobot_policy_hv;"
        "print(*sorted({name.partition('.')[0] for name in set(sys.modules) - before}))"
    )
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert "hv_policy" in loaded
    assert not {"mujoco", "transformers", "datasets", "cv2", "rsl_rl", "hv_teachers"} & set(loaded)


def test_every_package_is_part_of_the_distribution():
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]
    folders = {settings["package-dir"].get(name, name.replace(".", "/")) for name in settings["packages"]}
    sources = [path for top in folders if "/" not in top for path in (ROOT / top).rglob("*.py")]
    assert {str(path.parent.relative_to(ROOT)) for path in sources} == folders


@pytest.mark.parametrize(
    ("program", "error", "has_traceback"),
    [
        ("/bin/lerobot-eval", CheckpointError("what is wrong"), False),
        ("/bin/lerobot-eval", ValueError("what is wrong"), True),
        ("/bin/other", CheckpointError("what is wrong"), True),
    ],
)
def test_only_our_own_errors_lose_their_traceback(monkeypatch, capsys, program, error, has_traceback):
    monkeypatch.setattr(sys, "argv", [program])
    monkeypatch.setattr(sys, "excepthook", sys.__excepthook__)
    report_input_errors_in_one_line()
    try:
        raise error
    except ValueError:
        sys.excepthook(*sys.exc_info())
    shown = capsys.readouterr().err
    assert ("Traceback" in shown) == has_traceback
    assert has_traceback or shown == "error: what is wrong\n"
