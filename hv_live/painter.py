"""Draws what the page shows, in a thread of its own: the third-person view and the head camera, as JPEG.

Large and without smoothed edges: the page shows them smaller, which smooths them. Processor time in a furnished living
room (OSMesa): 576 x 360 px with smoothed edges 24 ms, 768 x 480 px without 12 ms; 256 x 256 px with 10 ms, 384 x 384 px
without 7 ms. Both views and their compression take about 21 ms, beside the 12 ms of a teacher's control step.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor

import cv2
import mujoco
import numpy as np

from hv_live.protocol import Orbit
from hv_sim.rendering import CameraRenderer, third_person_camera

THIRD_PERSON_PX = (480, 768)
HEAD_PX = (384, 384)
_JPEG = [cv2.IMWRITE_JPEG_QUALITY, 80]
_EYE_HEIGHT_M = 0.8
_WALL_GAP_M, _NEAREST_M = 0.15, 0.7


class Painter:
    """Two pictures at a time, one job at a time.

    Args:
        publish: is given each finished picture, as `join_pictures` makes it, in the painter's thread.
        on_free: is called there when the painter would take another one.
    """

    def __init__(self, publish: Callable[[bytes], None], on_free: Callable[[], None]) -> None:
        self._publish, self._on_free = publish, on_free
        self._thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix="hv-live painter")
        self._third_person = CameraRenderer(*THIRD_PERSON_PX, max_scenes=1, samples=0)
        self._head = CameraRenderer(*HEAD_PX, max_scenes=1, samples=0)
        self._model: mujoco.MjModel | None = None
        self._data: mujoco.MjData | None = None
        self._job: Future[None] | None = None

    @property
    def is_free(self) -> bool:
        """It would take a picture now."""
        return self._job is None or self._job.done()

    def load(self, model: mujoco.MjModel) -> None:
        """Makes ready for another scene; returns when the contexts exist, so that nobody else makes theirs meanwhile.

        Raises:
            hv_sim.gl_backend.GLError: no OpenGL library can render off screen here.
        """
        self._wait()
        self._model, self._data = model, mujoco.MjData(model)
        self._thread.submit(self._warm_up).result()

    def paint(self, copy: Callable[[mujoco.MjData], None], camera: mujoco.MjvCamera) -> bool:
        """Takes a picture of what `copy` fills in, seen from the camera and the head; False when it is still busy."""
        if not self.is_free or self._data is None:
            return False
        if self._job is not None:
            self._job.result()  # what went wrong is not swallowed
        copy(self._data)
        self._job = self._thread.submit(self._draw, camera)
        self._job.add_done_callback(lambda job: self._on_free())
        return True

    def free(self) -> None:
        """Frees the contexts; `load` makes new ones."""
        self._wait()
        self._thread.submit(self._close_contexts).result()
        self._model = self._data = None

    def close(self) -> None:
        """Frees everything and ends the thread."""
        self.free()
        self._thread.shutdown()

    def _wait(self) -> None:
        if self._job is not None:
            self._job.exception()
            self._job = None

    def _warm_up(self) -> None:
        assert self._model is not None
        assert self._data is not None
        for renderer in (self._third_person, self._head):
            renderer.render_qpos(self._model, self._model.qpos0)

    def _draw(self, camera: mujoco.MjvCamera) -> None:
        model, data = self._model, self._data
        assert model is not None
        assert data is not None
        third_person = _jpeg(self._third_person.render(model, data, camera))
        self._publish(join_pictures(third_person, _jpeg(self._head.render(model, data))))

    def _close_contexts(self) -> None:
        self._third_person.close()
        self._head.close()


def join_pictures(third_person: bytes, head: bytes) -> bytes:
    """One message for two pictures: the first one's length in four bytes (the highest first), then both."""
    return len(third_person).to_bytes(4, "big") + third_person + head


def camera_of(
    robot_xy_m: tuple[float, float], corner_w: np.ndarray, room_size_m: tuple[float, float], orbit: Orbit | None
) -> mujoco.MjvCamera:
    """The third-person camera: from the corner, or from where the page's visitor dragged it; it follows the robot.

    It stays between the walls, which MuJoCo shows as a haze from behind.
    """
    look_at = np.array([*robot_xy_m, _EYE_HEIGHT_M])
    camera = third_person_camera(look_at, corner_w)
    if orbit is not None:
        azimuth, elevation = np.radians(orbit.azimuth_deg), np.radians(orbit.elevation_deg)
        away = -np.cos(elevation) * np.array([np.cos(azimuth), np.sin(azimuth)])
        walls = np.sign(away) * (np.asarray(room_size_m) / 2 - _WALL_GAP_M)
        room = (walls - look_at[:2]) / np.where(np.abs(away) < 1e-6, 1e-6, away)
        farthest = float(np.where(np.abs(away) < 1e-6, np.inf, room).min())
        camera.azimuth, camera.elevation = orbit.azimuth_deg, orbit.elevation_deg
        camera.distance = max(_NEAREST_M, min(orbit.distance_m, farthest))
    return camera


def _jpeg(picture: np.ndarray) -> bytes:
    return cv2.imencode(".jpg", cv2.cvtColor(picture, cv2.COLOR_RGB2BGR), _JPEG)[1].tobytes()
