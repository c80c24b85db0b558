import os
import subprocess
import sys

from hv_scripts import check_gl


def run(**environment: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, check_gl.__file__]
    return subprocess.run(command, env={**os.environ, **environment}, capture_output=True, text=True)


def test_names_the_library_that_works():
    done = run(MUJOCO_GL="")
    assert done.returncode == 0
    assert done.stdout.startswith("Headless rendering works with MUJOCO_GL=")


def test_without_a_library_it_names_the_package_in_one_line():
    done = run(MUJOCO_GL="nonsense")
    assert done.returncode == 1
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    assert "install the package libosmesa6" in done.stderr
