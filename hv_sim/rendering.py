"""Pictures of a scene: the robot's head camera, a third-person view, and the frame that a video shows.

What costs most in software rendering is left out where a policy does not need it. Measured on one core with a
furnished living room (194 shapes) at 128 px: MuJoCo's own settings 69 frames/s; round shapes of 12 by 6 facets
instead of 28 by 16 and undivided faces 230, which is what is used here; without smoothed edges 498. Shadows would
take two thirds of it.
"""

from __future__ import annotations

import atexit
import contextlib
import functools
import textwrap
import threading
import weakref
from collections import OrderedDict
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import cv2
import mujoco
import numpy as np

from hv_sim.gl_backend import GLError, require_gl

if TYPE_CHECKING:
    from hv_sim.looks import Look
    from hv_sim.physics import PhysicsBackend

HEAD_CAMERA = "head"
VIDEO_HEIGHT_PX, VIDEO_WIDTH_PX = 336, 672
_CAPTION_HEIGHT_PX = 48
THIRD_PERSON_DISTANCE_M, NEAR_VIEW_M = 3.8, 2.2
"""How far from the robot it is filmed; and from nearer than the second only where no corner of the room is better."""
_ONE_AT_A_TIME = threading.RLock()
"""Software OpenGL draws in one thread of a process at a time: in two it has crashed."""
_HANGS_ON_WALL_M = 0.058
"""What is nearer to a wall than this belongs to it; furniture keeps 6 cm."""


class CameraRenderer:
    """Renders MuJoCo scenes off screen, one OpenGL context per scene, kept and reused.

    The contexts are made when a picture is first asked for, in the thread (and process) that asks.

    Args:
        height_px: height of the pictures.
        width_px: width of the pictures.
        max_scenes: contexts kept at a time; the one used longest ago goes first.
        samples: per pixel, to smooth edges; 0 for none, which doubles the frame rate in software rendering.
        shadows: whether lights cast shadows.

    Raises:
        ValueError: a size is not positive.
    """

    def __init__(
        self,
        height_px: int = 128,
        width_px: int = 128,
        *,
        max_scenes: int = 32,
        samples: int = 4,
        shadows: bool = False,
    ) -> None:
        for name, value in (("height_px", height_px), ("width_px", width_px), ("max_scenes", max_scenes)):
            if value < 1:
                raise ValueError(f"{name}: {value} is not valid; valid: an integer >= 1")
        self.height_px, self.width_px = height_px, width_px
        self._max_scenes, self._samples, self._shadows = max_scenes, samples, shadows
        # a renderer is kept with its model, so that the model's id cannot be reused meanwhile
        self._renderers: OrderedDict[int, mujoco.Renderer] = OrderedDict()
        self._data: dict[int, mujoco.MjData] = {}

    def render(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        camera: str | mujoco.MjvCamera = HEAD_CAMERA,
        look: Look | None = None,
    ) -> np.ndarray:
        """One picture, (height, width, 3) uint8, of a state whose kinematics are computed (`mj_kinematics`,
        `mj_camlight`), seen as `look` has it.

        Raises:
            GLError: no OpenGL library can render off screen here.
        """
        renderer = self._renderer(model)
        renderer.update_scene(data, camera)
        if isinstance(camera, mujoco.MjvCamera):
            _leave_near_walls_out(renderer.scene, model)
        if look is not None:
            look.alter(renderer.scene, model)
        flags = renderer.scene.flags
        flags[mujoco.mjtRndFlag.mjRND_SHADOW] = self._shadows
        flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = False
        with _ONE_AT_A_TIME:
            return renderer.render()

    def render_qpos(
        self, model: mujoco.MjModel, qpos: np.ndarray, camera: str | mujoco.MjvCamera = HEAD_CAMERA
    ) -> np.ndarray:
        """One picture, (height, width, 3) uint8, of generalised position `qpos` (nq,)."""
        self._renderer(model)
        data = self._data[id(model)]
        data.qpos[:] = qpos
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_camlight(model, data)
        return self.render(model, data, camera)

    def render_batch(
        self,
        physics: PhysicsBackend,
        ids: Sequence[int] | None = None,
        camera: str = HEAD_CAMERA,
        looks: Sequence[Look] | None = None,
    ) -> np.ndarray:
        """Pictures of simulations `ids` (default: all), (n, height, width, 3) uint8; `looks` of all simulations."""
        chosen = range(physics.num_envs) if ids is None else ids
        images = np.empty((len(chosen), self.height_px, self.width_px, 3), dtype=np.uint8)
        for row, env in enumerate(chosen):
            model = physics.model(env)
            self._renderer(model)
            look = None if looks is None else looks[env]
            images[row] = self.render(model, physics.data(env, self._data[id(model)]), camera, look)
        return images

    def close(self) -> None:
        """Frees the OpenGL contexts; a later picture makes new ones."""
        while self._renderers:
            _close(self._renderers.popitem()[1])
        self._data.clear()

    def __del__(self) -> None:
        with contextlib.suppress(Exception):  # half-made objects and interpreter shutdown
            self.close()

    def _renderer(self, model: mujoco.MjModel) -> mujoco.Renderer:
        key = id(model)
        if key in self._renderers:
            self._renderers.move_to_end(key)
            return self._renderers[key]
        require_gl()
        while len(self._renderers) >= self._max_scenes:
            oldest, renderer = self._renderers.popitem(last=False)
            _close(renderer)
            del self._data[oldest]
        try:
            with _ONE_AT_A_TIME, self._look(model):
                self._renderers[key] = mujoco.Renderer(model, self.height_px, self.width_px)
        except (ImportError, RuntimeError, AttributeError, mujoco.FatalError) as error:
            reason = " ".join(str(error).split())
            raise GLError(
                f"OpenGL context could not be made ({reason}): install libosmesa6 and set MUJOCO_GL=osmesa"
            ) from error
        self._data[key] = mujoco.MjData(model)
        _OPEN.add(self)
        _close_at_exit()
        return self._renderers[key]

    @contextlib.contextmanager
    def _look(self, model: mujoco.MjModel) -> Iterator[None]:
        """The renderer's own visual settings, which MuJoCo reads from the model when it makes a context."""
        view, quality = model.vis.global_, model.vis.quality
        wanted = [
            # a buffer of the picture's size: MuJoCo refuses a smaller one, a larger one costs memory in every context
            (view, {"offheight": self.height_px, "offwidth": self.width_px}),
            (quality, {"offsamples": self._samples, "numslices": 12, "numstacks": 6, "numquads": 1}),
        ]
        before = [(group, {name: getattr(group, name) for name in values}) for group, values in wanted]
        try:
            _assign(wanted)
            yield
        finally:
            _assign(before)


class StepCamera:
    """The head cameras of a world's environments: each picture is rendered at most once a control step.

    Args:
        renderer: makes the pictures (`hv_sim.physics_backends.BatchRenderer`).
        physics: whose simulations are seen.
        looks: how each of them looks, if not as it is; for `CameraRenderer` only.
    """

    def __init__(self, renderer: Any, physics: PhysicsBackend, looks: Sequence[Look] | None = None) -> None:
        self._renderer, self._physics = renderer, physics
        self._more: dict[str, Any] = {} if looks is None else {"looks": looks}
        self._one_by_one = isinstance(renderer, CameraRenderer)
        self._pictures: dict[int, np.ndarray] = {}

    def forget(self) -> None:
        """A control step has passed."""
        self._pictures.clear()

    def picture(self, env: int) -> np.ndarray:
        """(height, width, 3) uint8 of environment `env`."""
        if env not in self._pictures:
            envs = [env] if self._one_by_one else range(self._physics.num_envs)  # others render all or none
            pictures = self._renderer.render_batch(self._physics, envs, **self._more)
            self._pictures.update(zip(envs, pictures, strict=True))
        return self._pictures[env]


_OPEN: weakref.WeakSet[CameraRenderer] = weakref.WeakSet()


@functools.cache
def _close_at_exit() -> None:
    """Frees what is still open while the OpenGL library is still there.

    Called when a context exists: MuJoCo then has registered its own end of EGL, which has to come after this one.
    """

    def close_all() -> None:
        for renderer in list(_OPEN):
            renderer.close()

    atexit.register(close_all)


def _assign(settings: list[tuple[Any, dict[str, int]]]) -> None:
    for group, values in settings:
        for name, value in values.items():
            setattr(group, name, value)


def _close(renderer: mujoco.Renderer) -> None:
    """Frees a renderer's context without harm to the others.

    `mujoco.Renderer.close` deletes textures and lists by number in whatever context is current, so its own has to be.
    Rendering is the public call that sees to that.
    """
    with _ONE_AT_A_TIME:
        renderer.render()
        renderer.close()


def _leave_near_walls_out(scene: mujoco.MjvScene, model: mujoco.MjModel) -> None:
    """Hides the walls between a camera outside a room and the room, and what hangs on them.

    MuJoCo draws a plane that is seen from behind half transparent, which would tint everything in the room.
    """
    eye = (np.array(scene.camera[0].pos) + np.array(scene.camera[1].pos)) / 2
    static = [g for g in scene.geoms[: scene.ngeom] if _is_static(g, model)]
    for wall in [g for g in static if g.type == mujoco.mjtGeom.mjGEOM_PLANE]:
        normal, foot = np.array(wall.mat).reshape(3, 3)[:, 2], np.array(wall.pos)
        if abs(normal[2]) > 0.5 or normal @ (eye - foot) > 0:
            continue
        for geom in static:
            if abs(normal @ (np.array(geom.pos) - foot)) < _HANGS_ON_WALL_M:
                geom.rgba[3] = 0.0


def _is_static(geom: mujoco.MjvGeom, model: mujoco.MjModel) -> bool:
    return geom.objtype == mujoco.mjtObj.mjOBJ_GEOM and model.geom_bodyid[geom.objid] == 0


def third_person_camera(
    look_at_w: np.ndarray, corner_w: np.ndarray, distance_m: float = THIRD_PERSON_DISTANCE_M
) -> mujoco.MjvCamera:
    """A camera on the line from the point looked at to an upper corner of the room, so no wall hides the robot.

    Args:
        look_at_w: (3,) the point in the middle of the picture, m, world.
        corner_w: (3,) the corner, m, world; the camera never goes beyond it.
        distance_m: distance from the point looked at, less where the corner is nearer.
    """
    view = np.asarray(look_at_w, dtype=float) - np.asarray(corner_w, dtype=float)
    length = max(float(np.linalg.norm(view)), 1e-6)
    camera = mujoco.MjvCamera()
    camera.type = mujoco.mjtCamera.mjCAMERA_FREE
    camera.lookat[:] = look_at_w
    camera.distance = min(distance_m, length)
    camera.azimuth = float(np.degrees(np.arctan2(view[1], view[0])))
    camera.elevation = float(np.degrees(np.arcsin(np.clip(view[2] / length, -1, 1))))
    return camera


def upper_corners(low_xy_m: np.ndarray, high_xy_m: np.ndarray, height_m: float = 2.3) -> np.ndarray:
    """(4, 3) places for a camera in the corners of a room, a little inside."""
    inset = np.minimum(0.3, (np.asarray(high_xy_m) - np.asarray(low_xy_m)) / 4)
    low, high = np.asarray(low_xy_m) + inset, np.asarray(high_xy_m) - inset
    return np.array([[x, y, height_m] for x in (low[0], high[0]) for y in (low[1], high[1])])


def best_corner(
    low_xy_m: np.ndarray, high_xy_m: np.ndarray, points_xy_m: np.ndarray, height_m: float = 2.3
) -> np.ndarray:
    """(3,) the upper corner of a room from which the points (P, 2), where things happen, are seen from nearest 4 m."""
    corners = upper_corners(low_xy_m, high_xy_m, height_m)
    distances = np.linalg.norm(corners[:, None, :2] - np.asarray(points_xy_m)[None], axis=-1)
    return corners[np.abs(distances - 4.0).mean(axis=1).argmin()]


def unhidden_m(model: mujoco.MjModel, data: mujoco.MjData, look_at_w: np.ndarray, corner_w: np.ndarray) -> float:
    """How far a camera may be from a point (3,), toward a corner (3,), with no furniture between them, m."""
    start, toward = np.asarray(look_at_w, dtype=float), np.asarray(corner_w, dtype=float) - look_at_w
    length = float(np.linalg.norm(toward))
    toward, gone, geom = toward / max(length, 1e-6), 0.0, np.zeros(1, dtype=np.int32)
    while gone < length:
        hit = mujoco.mj_ray(model, data, start + gone * toward, toward, None, 1, -1, geom)
        if hit < 0:
            return length
        gone += hit
        if model.geom_bodyid[geom[0]] == 0:
            return min(gone, length)
        gone += 0.02  # the robot itself, or what it carries
    return length


def clearest_corner(
    model: mujoco.MjModel, data: mujoco.MjData, look_at_w: np.ndarray, corners_w: np.ndarray, present_w: np.ndarray
) -> tuple[np.ndarray, float]:
    """The corner (3,) to film from, and how near the camera must be there: the present one, unless furniture hides the
    point looked at from nearer than `NEAR_VIEW_M`."""
    nearest = unhidden_m(model, data, look_at_w, present_w)
    if nearest < NEAR_VIEW_M:
        free = [unhidden_m(model, data, look_at_w, corner) for corner in corners_w]
        best = int(np.argmax(np.minimum(free, THIRD_PERSON_DISTANCE_M)))
        if free[best] > nearest + 0.5:
            return corners_w[best], free[best]
    return present_w, nearest


def follow_camera(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    robot_xy_m: np.ndarray,
    bounds_xy_m: tuple[np.ndarray, np.ndarray],
    corner_w: np.ndarray,
) -> tuple[mujoco.MjvCamera, np.ndarray]:
    """The camera of a film, and the corner (3,) that it is in, which is the one of the frame before if that will do.

    Args:
        model, data: of the scene.
        robot_xy_m: (2,) where the robot is.
        bounds_xy_m: lowest and highest x and y (2,) of the room.
        corner_w: (3,) of the frame before; of `best_corner` for the first.
    """
    look_at = np.append(robot_xy_m, 0.8)
    corner_w, free_m = clearest_corner(model, data, look_at, upper_corners(*bounds_xy_m), corner_w)
    return third_person_camera(look_at, corner_w, min(THIRD_PERSON_DISTANCE_M, free_m - 0.1)), corner_w


def compose_video_frame(third_person: np.ndarray, head: np.ndarray, caption: str) -> np.ndarray:
    """(336, 672, 3) uint8: third person on the left, head camera on the right, the instruction underneath."""
    height = VIDEO_HEIGHT_PX - _CAPTION_HEIGHT_PX
    frame = np.zeros((VIDEO_HEIGHT_PX, VIDEO_WIDTH_PX, 3), dtype=np.uint8)
    left_width = VIDEO_WIDTH_PX - height
    frame[:height, :left_width] = _resize(third_person, height, left_width)
    frame[:height, left_width:] = _resize(head, height, height)
    lines = textwrap.wrap(caption, width=84)[:2]
    for row, line in enumerate(lines):
        baseline = height + (30 if len(lines) == 1 else 20 + 20 * row)
        cv2.putText(frame, line, (10, baseline), cv2.FONT_HERSHEY_SIMPLEX, 0.45, (255, 255, 255), 1, cv2.LINE_AA)
    return frame


def third_person_size_px() -> tuple[int, int]:
    """(height, width) of the left part of a video frame."""
    height = VIDEO_HEIGHT_PX - _CAPTION_HEIGHT_PX
    return height, VIDEO_WIDTH_PX - height


def _resize(image: np.ndarray, height: int, width: int) -> np.ndarray:
    if image.shape[:2] == (height, width):
        return image
    shrinks = image.shape[0] > height
    return cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR)
