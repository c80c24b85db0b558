"""Checks that MuJoCo can render without a display: draws one small picture in a subprocess for each GL library.

    python scripts/check_gl.py [--quiet]

Prints the GL library that works and exits with 0, or says in one line which package to install and exits with 1.
A subprocess, because a GL library that fails to load can take the interpreter down with it.
"""

import argparse
import os
import subprocess
import sys

# EGL first: it uses the GPU where there is one. OSMesa draws on the CPU and needs no driver.
GL_LIBRARIES = ("egl", "osmesa")

_DRAW_ONE_PICTURE = """
import mujoco
model = mujoco.MjModel.from_xml_string(
    "<mujoco><worldbody><light pos='0 0 2'/><geom type='sphere' size='.3' rgba='1 1 1 1'/></worldbody></mujoco>"
)
data = mujoco.MjData(model)
mujoco.mj_forward(model, data)
with mujoco.Renderer(model, 16, 16) as renderer:
    renderer.update_scene(data)
    assert renderer.render().max() > 0, "the picture is black"
"""


def working_gl_library(libraries: tuple[str, ...] = GL_LIBRARIES) -> str | None:
    """The first of `libraries` (values of `MUJOCO_GL`) that can draw a picture here, or None."""
    for library in libraries:
        environment = {**os.environ, "MUJOCO_GL": library, "PYOPENGL_PLATFORM": library}
        try:
            drawn = subprocess.run(
                [sys.executable, "-c", _DRAW_ONE_PICTURE], env=environment, capture_output=True, timeout=120
            )
        except subprocess.TimeoutExpired:
            continue
        if drawn.returncode == 0:
            return library
    return None


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quiet", action="store_true", help="print nothing; only the exit status tells")
    arguments = parser.parse_args()
    chosen = os.environ.get("MUJOCO_GL")
    library = working_gl_library((chosen,) if chosen else GL_LIBRARIES)
    if not arguments.quiet:
        if library:
            print(f"Headless rendering works with MUJOCO_GL={library}.")
        else:
            tried = chosen or ", ".join(GL_LIBRARIES)
            print(
                f"error: no GL library for headless rendering (tried {tried}): install the package libosmesa6"
                " (Debian, Ubuntu: apt-get install libosmesa6)",
                file=sys.stderr,
            )
    return 0 if library else 1


if __name__ == "__main__":
    sys.exit(main())
