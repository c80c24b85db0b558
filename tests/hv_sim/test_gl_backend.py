"""The choice of OpenGL library, with the libraries that load given by hand."""

import os
import subprocess
import sys

import pytest

from hv_sim import gl_backend
from hv_sim.gl_backend import GLError, require_gl, select_gl_backend

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the choice is made on Linux only")


@pytest.fixture
def headless(monkeypatch):
    for name in ("MUJOCO_GL", "DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(gl_backend.glob, "glob", lambda pattern: [])
    return monkeypatch


def test_the_only_library_that_loads_is_chosen(headless):
    assert select_gl_backend(lambda b: b == "egl") == "egl" == os.environ["MUJOCO_GL"]


def test_software_rendering_comes_first_without_a_graphics_device(headless):
    assert select_gl_backend(lambda b: True) == "osmesa"


def test_egl_comes_first_with_a_graphics_device(headless):
    headless.setattr(gl_backend.glob, "glob", lambda pattern: ["/dev/nvidia0"])
    assert select_gl_backend(lambda b: True) == "egl"


def test_the_users_choice_stays(headless):
    headless.setenv("MUJOCO_GL", "egl")
    assert select_gl_backend(lambda b: True) == "egl"


def test_a_screen_is_left_alone(headless):
    headless.setenv("DISPLAY", ":0")
    assert select_gl_backend(lambda b: True) == ""
    assert "MUJOCO_GL" not in os.environ


@pytest.mark.parametrize("asked", ["", "egl", "osmesa"])
def test_no_library_gives_one_line_that_names_the_package(headless, asked):
    if asked:
        headless.setenv("MUJOCO_GL", asked)
    assert select_gl_backend(lambda b: False) == "disable"
    with pytest.raises(GLError, match="install libosmesa6 or libegl1") as caught:
        require_gl(lambda b: False)
    assert "\n" not in str(caught.value)


def test_without_any_library_physics_still_imports():
    code = (
        "import hv_sim.gl_backend as g, hv_sim.mujoco_physics\ntry: g.require_gl()\nexcept g.GLError as e: print(e)\n"
    )
    env = {**os.environ, "MUJOCO_GL": "disable"}
    out = subprocess.run([sys.executable, "-c", code], env=env, capture_output=True, text=True, check=True).stdout
    assert "libosmesa6" in out


def test_the_package_imports_without_mujoco_and_torch():
    code = "import hv_sim, sys; print([m for m in ('mujoco', 'torch') if m in sys.modules])"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert out.strip() == "[]"
