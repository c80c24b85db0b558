"""Which OpenGL library renders without a screen.

MuJoCo reads `MUJOCO_GL` once, when it is first imported, and fails in obscure ways when the library behind it is
missing. So the choice is made here, before MuJoCo is imported, and only ever for a library that loads. A machine
without any still runs physics; what needs a picture raises `GLError`, one line that names the package to install.
"""

from __future__ import annotations

import ctypes
import ctypes.util
import glob
import os
import sys
from collections.abc import Callable

_LIBRARIES = {"egl": ("EGL", "libEGL.so.1"), "osmesa": ("OSMesa", "libOSMesa.so.8", "libOSMesa.so.6")}
_DISABLED = ("disable", "disabled", "off", "false", "0")
_WINDOWED = ("glfw", "glx", "wgl", "cgl", "on", "true", "1")
_REFUSED = "HV_REFUSED_MUJOCO_GL"
_PACKAGES = {"egl": "libegl1", "osmesa": "libosmesa6"}


class GLError(RuntimeError):
    """No OpenGL library can render off screen; the message is one line that names the package to install."""


def library_loads(backend: str) -> bool:
    """Whether the shared library of `backend` (`egl` or `osmesa`) can be opened on this machine."""
    short_name, *sonames = _LIBRARIES[backend]
    for name in (ctypes.util.find_library(short_name), *sonames):
        if name is None:
            continue
        try:
            ctypes.CDLL(name)
        except OSError:
            continue
        return True
    return False


def select_gl_backend(loads: Callable[[str], bool] = library_loads) -> str:
    """Sets `MUJOCO_GL` where it is unset and no screen is present, and guards against a library that is missing.

    EGL comes first where a graphics device exists, OSMesa first elsewhere (its software rendering is the faster one).
    With no usable library `MUJOCO_GL` becomes `disable`: MuJoCo then imports, and only rendering is refused.

    Args:
        loads: tells whether a backend's library can be opened; a parameter for the tests.

    Returns:
        The value of `MUJOCO_GL` afterwards; empty where MuJoCo's own default (a window system) is left alone.
    """
    asked = os.environ.get("MUJOCO_GL", "").lower().strip()
    if not sys.platform.startswith("linux"):
        return asked
    if asked in _LIBRARIES:
        if not loads(asked):
            os.environ["MUJOCO_GL"] = "disable"
        return os.environ["MUJOCO_GL"]
    if asked and asked not in _WINDOWED + _DISABLED:
        # MuJoCo would refuse to be imported; say it in one line when something is to be drawn
        os.environ["MUJOCO_GL"] = "disable"
        os.environ[_REFUSED] = asked
        return "disable"
    if asked or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
        return asked
    has_device = bool(glob.glob("/dev/nvidia[0-9]*") or glob.glob("/dev/dri/renderD*"))
    order = ("egl", "osmesa") if has_device else ("osmesa", "egl")
    os.environ["MUJOCO_GL"] = next((backend for backend in order if loads(backend)), "disable")
    return os.environ["MUJOCO_GL"]


def require_gl(loads: Callable[[str], bool] = library_loads) -> None:
    """Makes MuJoCo use the selected backend even when it was imported before this package.

    Raises:
        GLError: nothing can render off screen here.
    """
    backend = os.environ.get("MUJOCO_GL", "").lower().strip()
    refused = os.environ.get(_REFUSED)
    if refused and backend in _DISABLED:
        raise GLError(f"MUJOCO_GL: {refused!r} is not valid; valid: egl, osmesa, glfw, disable")
    if backend in _DISABLED or (backend in _LIBRARIES and not loads(backend)):
        raise GLError(_missing_library_line())
    if backend not in _LIBRARIES:
        return
    try:
        from mujoco.rendering.classic import gl_context, renderer

        if backend == "egl":
            from mujoco.egl import GLContext
        else:
            from mujoco.osmesa import GLContext
    except (ImportError, AttributeError, OSError) as error:
        raise GLError(_missing_library_line(str(error))) from error
    gl_context.GLContext = GLContext
    renderer.gl_context.GLContext = GLContext


def _missing_library_line(reason: str = "") -> str:
    packages = " or ".join(_PACKAGES[b] for b in ("osmesa", "egl"))
    detail = f" ({' '.join(reason.split())})" if reason else ""
    return f"no OpenGL library for off-screen rendering{detail}: install {packages} (`apt-get install libosmesa6`)"
