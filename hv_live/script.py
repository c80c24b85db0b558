"""Plays a script of timed instructions without a page, and films it.

# seconds   what is said, or done in brackets
0           Take the red toaster from the coffee table to the console table.
6.5         Put the cardboard box in the middle of the room.
8           [push 90]
40          [end]
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import av
import numpy as np

from hv_live.simulation import Simulation
from hv_live.understanding import MAX_SENTENCE
from hv_sim.humanoid import CONTROL_HZ
from hv_sim.rendering import CameraRenderer, best_corner, compose_video_frame, follow_camera, third_person_size_px

VIDEO_FPS = 15
LONGEST_S = 3600.0
_MAX_BYTES = 1_000_000
_AFTER_S = 30.0
"""How long a script without an end goes on after its last line."""
_ACTIONS = "push [DEGREES], reset, instructor on, instructor off, policy NAME, end"


class ScriptError(ValueError):
    """A script that cannot be played; one line that names file, line and what is valid."""


@dataclass(frozen=True)
class Line:
    """What happens at a time: something is said, or done (`action` and its word)."""

    time_s: float
    text: str = ""
    action: str = ""
    word: str = ""


def read_script(path: Path) -> list[Line]:
    """The lines of a script, in order of time.

    Raises:
        ScriptError: it cannot be read, or a line is not valid.
    """
    try:
        if path.stat().st_size > _MAX_BYTES:
            raise ScriptError(f"script {path}: larger than {_MAX_BYTES} bytes")
        rows = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise ScriptError(f"script {path}: cannot be read ({error})") from None
    lines = []
    for number, row in enumerate(rows, 1):
        if row.strip() and not row.lstrip().startswith("#"):
            lines.append(_read_line(row.strip(), f"{path}:{number}"))
    if not lines:
        raise ScriptError(f"script {path}: holds no line; valid: SECONDS and an instruction, or [{_ACTIONS}]")
    return sorted(lines, key=lambda line: line.time_s)


def _read_line(row: str, where: str) -> Line:
    first, _, rest = row.partition(" ")
    if "\t" in first:
        first, _, rest = row.partition("\t")
    try:
        time_s = float(first)
    except ValueError:
        time_s = math.nan
    if not 0 <= time_s <= LONGEST_S:
        raise ScriptError(f"{where}: {first[:40]!r} is not a time; valid: seconds from 0 to {LONGEST_S:g}")
    rest = rest.strip()
    action = re.fullmatch(r"\[(push|reset|instructor|policy|end)(?:\s+(\S+))?\]", rest)
    if action is None:
        if rest.startswith("[") or not 1 <= len(rest) <= MAX_SENTENCE:
            raise ScriptError(f"{where}: {rest[:60]!r} is not valid; valid: an instruction, or [{_ACTIONS}]")
        return Line(time_s, text=rest)
    name, word = action[1], action[2] or ""
    if name == "instructor" and word not in ("on", "off"):
        raise ScriptError(f"{where}: [instructor {word}] is not valid; valid: on, off")
    if name == "push" and word and not re.fullmatch(r"-?\d{1,3}(\.\d+)?", word):
        raise ScriptError(f"{where}: [push {word}] is not valid; valid: degrees, 0 is forward")
    return Line(time_s, action=name, word=word)


def play_script(
    live: Simulation, script: list[Line], video: Path, on_event: Callable[[float, str], None] | None = None
) -> None:
    """Plays a script by the simulated clock and writes the film (672 x 336 px, 15 pictures a second), whole or not at
    all.

    Args:
        live: just reset.
        script: see `read_script`.
        video: the file, `.mp4`.
        on_event: is told what happened when (simulated seconds).

    Raises:
        ScriptError: something that is said or done in it is refused.
        hv_sim.gl_backend.GLError: no OpenGL library can render off screen here.
    """
    tell = on_event or (lambda time_s, text: None)
    end_s = next((line.time_s for line in script if line.action == "end"), script[-1].time_s + _AFTER_S)
    waiting = [line for line in script if line.action != "end" and line.time_s <= end_s]
    video.parent.mkdir(parents=True, exist_ok=True)
    draft = video.with_name(f".{video.stem}.{os.getpid()}.tmp{video.suffix}")
    camera = _Camera(live)
    was_done = True
    try:
        with av.open(str(draft), "w", format="mp4") as container:
            stream = container.add_stream("libx264", rate=VIDEO_FPS)
            stream.pix_fmt = "yuv420p"
            for step in range(round(end_s * CONTROL_HZ)):
                while waiting and waiting[0].time_s * CONTROL_HZ <= step:
                    line = waiting.pop(0)
                    _do(live, line)
                    tell(step / CONTROL_HZ, line.text or f"[{line.action} {line.word}".rstrip() + "]")
                if step % (CONTROL_HZ // VIDEO_FPS) == 0:
                    picture = camera.picture()
                    stream.height, stream.width = picture.shape[:2]
                    container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
                live.step()
                if live.done and not was_done:
                    tell(step / CONTROL_HZ, f"done: {live.instruction}")
                was_done = live.done
            container.mux(stream.encode())
        draft.replace(video)
    finally:
        camera.close()
        draft.unlink(missing_ok=True)


def _do(live: Simulation, line: Line) -> None:
    try:
        match line.action:
            case "":
                live.instruct(line.text)
            case "push":
                live.push(math.radians(float(line.word or 0.0)))
            case "reset":
                live.reset()
            case "instructor":
                live.set_instructor(line.word == "on")
            case "policy":
                live.set_policy(line.word)
    except ValueError as error:
        raise ScriptError(f"at {line.time_s:g} s: {line.text or line.action!r}: {error}") from None


class _Camera:
    def __init__(self, live: Simulation) -> None:
        self._live = live
        self._renderer = CameraRenderer(*third_person_size_px(), max_scenes=1)
        world, task = live.world, live.task
        places = [o.position_m[:2] for o in task.objects] + [s.goal_position_m[:2] for s in task.subtasks]
        self._bounds = world.room_bounds_xy_m(0)
        self._corner_w = best_corner(*self._bounds, np.array([task.robot.position_m, *places]))

    def picture(self) -> np.ndarray:
        physics = self._live.world.physics
        x, y, _ = self._live.world.robot_xy_yaw()
        model, data = physics.model(0), physics.data(0)
        camera, self._corner_w = follow_camera(model, data, np.array([x, y]), self._bounds, self._corner_w)
        third_person = self._renderer.render(model, data, camera)
        return compose_video_frame(third_person, self._live.head_picture(), self._live.instruction)

    def close(self) -> None:
        self._renderer.close()
