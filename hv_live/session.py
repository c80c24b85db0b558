"""The simulation as a visitor meets it: it runs by the clock in a thread of its own, and nobody's tab means nobody's
simulation."""

from __future__ import annotations

import contextlib
import queue
import threading
import time
from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
import torch

from hv_live import protocol
from hv_live.actors import Cast
from hv_live.clock import Clock, Rate
from hv_live.floor_map import room_message, state_message
from hv_live.painter import Painter, camera_of
from hv_live.simulation import Simulation
from hv_sim.rendering import best_corner
from hv_sim.task import Task

PICTURE_S, SLOW_PICTURE_S, STATE_S = 1 / 20, 1 / 16, 1 / 10
"""Between pictures: where the machine keeps up, and where drawing them would slow the clock."""
PAUSED_PICTURE_S = 1.0
AFTER_ERROR_S = 2.0
MOST_WAITING = 64
"""Commands that wait for the next control step; further ones are refused."""
REAL_TIME = 0.95
"""Slower than so many simulated seconds a second the page says that this machine cannot keep up."""

Publish = Callable[[dict[str, Any] | bytes], None]


class Session:
    """Plays while somebody is there.

    Everything it says goes to `publish`, called in its threads: dictionaries (`room`, `state`, `notice`, `error`) and
    pictures (`hv_live.painter.join_pictures`).

    Args:
        tasks: the rooms that can be chosen, by name.
        task: the first one.
        cast: who can play.
        recordings: folder for the datasets.
        publish: see above.
        linger_s: how long the simulation outlives its last visitor, who may only have reloaded the page.
    """

    def __init__(
        self,
        tasks: dict[str, Task],
        task: str,
        cast: Cast,
        recordings: Path,
        publish: Publish,
        linger_s: float = 3.0,
    ) -> None:
        self.tasks, self.cast = tasks, cast
        self.task = task
        self.simulation: Simulation | None = None
        """None while nobody is there."""
        self.step_ms = 0.0
        """What a control step cost lately: seeing, deciding and physics; without waiting for the clock."""
        self.pictures = Rate()
        self._publish = publish
        self._recordings, self._linger_s = recordings, linger_s
        self._commands: queue.Queue[protocol.Command] = queue.Queue(MOST_WAITING)
        self._wake = threading.Event()
        self._visitors = 0
        self._empty_since = 0.0
        self._closing = False
        self._paused = False
        self._orbit: protocol.Orbit | None = None
        self._corner_w = np.zeros(3)
        self._clock = Clock()
        self._painter = Painter(self._publish_picture, self._wake.set)
        self._finishing: list[threading.Thread] = []
        self._thread = threading.Thread(target=self._run, name="hv-live session", daemon=True)
        self._thread.start()

    # called from outside, in any thread

    def send(self, command: protocol.Command) -> bool:
        """Has a command carried out before the next control step; False when too many wait already."""
        try:
            self._commands.put_nowait(command)
        except queue.Full:
            return False
        self._wake.set()
        return True

    def set_visitors(self, count: int) -> None:
        """So many are there now."""
        if count == 0 and self._visitors:
            self._empty_since = time.monotonic()
        self._visitors = count
        self._wake.set()

    def introduce(self) -> None:
        """Says everything again, for somebody who has just come."""
        self._introduced = False
        self._wake.set()

    def close(self) -> None:
        """Frees everything and ends the thread; a recording that still runs is kept."""
        self._closing = True
        self._wake.set()
        self._thread.join()

    # in the session's thread

    _introduced = False

    def _run(self) -> None:
        torch.set_num_threads(1)  # the painter needs the other core
        try:
            while not self._closing:
                try:
                    self._turn()
                except Exception as error:  # whatever a policy does, the page goes on and says so
                    reason = " ".join(str(error).split())[:300] or type(error).__name__
                    self._say("error", f"The simulation stopped and begins anew: {reason}")
                    self._free()
                    self._wait(AFTER_ERROR_S)
        finally:
            self._free()
            for thread in self._finishing:
                thread.join()
            self._painter.close()

    def _turn(self) -> None:
        """One control step, or a little waiting."""
        if not self._visitors and time.monotonic() - self._empty_since >= self._linger_s:
            self._free()
            self._drop_commands()
            self._wait(None)
            return
        if self.simulation is None:
            self._load(self.task)
        self._obey()
        live = self.simulation
        if live is None:
            return
        if self._paused:
            self._wait(PICTURE_S)
        else:
            started = time.perf_counter()
            live.step()
            self.step_ms += 0.05 * ((time.perf_counter() - started) * 1e3 - self.step_ms)
            self._clock.tick()
        self._show(live)
        while not self._paused and (left_s := self._clock.wait_s()) > 0.0:
            self._wait(left_s)
            self._show(live)  # the painter is free again, perhaps

    def _wait(self, seconds: float | None) -> None:
        self._wake.wait(seconds)
        self._wake.clear()

    def _load(self, name: str) -> None:
        task = self.tasks[name]
        self._stop_recording()
        policy = self.simulation.policy if self.simulation is not None else self.cast.first
        if self.simulation is not None:
            self.simulation.close()
            self.simulation = None
        self._say("notice", f"Building {name} ...")
        live = Simulation(task, self.cast)
        if policy != live.policy:
            live.set_policy(policy)
        world = live.world
        self._painter.load(world.physics.model(0))
        self._corner_w = best_corner(*world.room_bounds_xy_m(0), self._places_xy_m(live))
        self.task, self.simulation, self._orbit = name, live, None
        self._introduced, self._paused = False, False
        self._clock.start()
        self._say("notice", self.cast.warning)

    def _places_xy_m(self, live: Simulation) -> np.ndarray:
        task = live.task
        places = [task.robot.position_m, *(o.position_m[:2] for o in task.objects)]
        return np.array([*places, *(s.goal_position_m[:2] for s in task.subtasks)], dtype=float)

    def _free(self) -> None:
        """Nobody is there: no world, no OpenGL context, no recording."""
        self._stop_recording()
        if self.simulation is not None:
            self.simulation.close()
            self.simulation = None
            self._painter.free()

    def _drop_commands(self) -> None:
        with contextlib.suppress(queue.Empty):
            while True:
                self._commands.get_nowait()

    # commands

    def _obey(self) -> None:
        while True:
            try:
                command = self._commands.get_nowait()
            except queue.Empty:
                return
            try:
                self._do(command)
            except ValueError as error:
                self._say("error", str(error))

    def _do(self, command: protocol.Command) -> None:
        live = self.simulation
        if live is None:
            return
        match command:
            case protocol.Instruct(text):
                live.instruct(text)
                self._pause(False)
            case protocol.Pause(on):
                self._pause(on)
            case protocol.Reset():
                live.reset()
                self._pause(False)
            case protocol.Load(name):
                if name not in self.tasks:
                    raise ValueError(f"task: {name!r} is not here; valid: one of {len(self.tasks)} names in the list")
                self._load(name)
            case protocol.Policy(name):
                live.set_policy(name)
                self._clock.start()
            case protocol.PlayUser(on):
                live.set_instructor(on)
            case protocol.Push(direction_deg, speed_m_s):
                live.push(float(np.radians(direction_deg)), speed_m_s)
            case protocol.Record(on):
                self._record(live, on)
            case protocol.Orbit():
                self._orbit = command
            case protocol.OrbitHome():
                self._orbit = None
        self._state_due = self._picture_due = 0.0

    def _pause(self, on: bool) -> None:
        if self._paused and not on:
            self._clock.start()
        self._paused = on

    def _record(self, live: Simulation, on: bool) -> None:
        if not on:
            self._stop_recording()
        elif live.recorder is None:
            root = self._recordings / datetime.now().strftime("live_%Y%m%d_%H%M%S_%f")[:-3]
            live.start_recording(root)
            self._say("notice", f"Recording to {root}")

    def _stop_recording(self) -> None:
        recorder = self.simulation.stop_recording() if self.simulation is not None else None
        if recorder is None:
            return
        self._finishing = [thread for thread in self._finishing if thread.is_alive()]
        self._finishing.append(recorder.finish_behind(lambda text: self._say("notice", text)))

    # what is shown

    _state_due = 0.0
    _picture_due = 0.0

    def _show(self, live: Simulation) -> None:
        now = time.perf_counter()
        if not self._introduced:
            self._introduced = True
            self._state_due = self._picture_due = 0.0
            self._publish(room_message(live))
        if now >= self._picture_due and self._painter.is_free:
            # on time, or as soon as the painter is free again; nothing moves in a pause but the camera
            between = PICTURE_S if self._clock.speed >= REAL_TIME else SLOW_PICTURE_S
            self._picture_due = now + PAUSED_PICTURE_S if self._paused else max(self._picture_due + between, now)
            self._painter.paint(live.copy_data, self._camera(live))
        if now >= self._state_due:
            self._state_due = now + STATE_S
            self._publish(self.state(live))

    def state(self, live: Simulation) -> dict[str, Any]:
        """What `state_message` says, and how the session is."""
        camera = self._camera(live)
        speed = 1.0 if self._paused else self._clock.speed
        return {
            **state_message(live),
            "paused": self._paused,
            "speed": round(speed, 2),
            "slow": speed < REAL_TIME,
            "pictures_per_s": round(self.pictures.per_second, 1),
            "step_ms": round(self.step_ms, 1),
            "camera": {
                "azimuth_deg": round(camera.azimuth, 1),
                "elevation_deg": round(camera.elevation, 1),
                "distance_m": round(camera.distance, 2),
                "home": self._orbit is None,
            },
        }

    def _camera(self, live: Simulation) -> Any:
        x, y, _ = live.world.robot_xy_yaw()
        return camera_of((x, y), self._corner_w, live.task.room.size_m, self._orbit)

    def _publish_picture(self, picture: bytes) -> None:
        self.pictures.tick()
        self._publish(picture)

    def _say(self, kind: str, text: str) -> None:
        if text:
            self._publish({"type": kind, "text": text})
