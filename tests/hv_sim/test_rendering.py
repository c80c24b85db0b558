"""Pictures against a bare mujoco.Renderer, and the frame of a video."""

import copy
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import mujoco
import numpy as np
import pytest

from hv_sim.humanoid import add_humanoid, configure_physics, standing_qpos
from hv_sim.mujoco_physics import MujocoPhysics
from hv_sim.rendering import (
    CameraRenderer,
    best_corner,
    clearest_corner,
    compose_video_frame,
    third_person_camera,
    third_person_size_px,
    unhidden_m,
    upper_corners,
)


def room_model(box_rgb: tuple[float, float, float] = (1, 0, 0)) -> mujoco.MjModel:
    """A humanoid that looks at a coloured box."""
    spec = mujoco.MjSpec()
    add_humanoid(spec)
    spec.worldbody.add_light(pos=[0, 0, 4], type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL)
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[10, 10, 1], contype=2, conaffinity=3)
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=[2, 0, 1],
        size=[0.4, 0.4, 0.4],
        rgba=[*box_rgb, 1],
        contype=2,
        conaffinity=3,
    )
    configure_physics(spec)
    return spec.compile()


@pytest.fixture(scope="module")
def physics():
    models = [room_model((1, 0, 0)), room_model((0, 0, 1))]
    backend = MujocoPhysics(models, num_threads=1)
    backend.reset([0, 1], [standing_qpos((0.0, 0.0), 0.0)] * 2)
    return backend


@pytest.fixture
def renderer():
    made = CameraRenderer(48, 64)
    yield made
    made.close()


def bare_picture(model: mujoco.MjModel, qpos: np.ndarray) -> np.ndarray:
    model = copy.copy(model)
    model.vis.quality.numslices, model.vis.quality.numstacks, model.vis.quality.numquads = 12, 6, 1
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_forward(model, data)
    with mujoco.Renderer(model, 48, 64) as bare:
        bare.update_scene(data, "head")
        bare.scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = False
        bare.scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = False
        return bare.render()


def test_the_head_camera_sees_what_a_bare_renderer_sees(physics, renderer):
    qpos = standing_qpos((0.3, -0.2), 0.2)
    picture = renderer.render_qpos(physics.model(0), qpos)
    assert picture.shape == (48, 64, 3)
    assert picture.dtype == np.uint8
    np.testing.assert_array_equal(picture, bare_picture(physics.model(0), qpos))


def test_a_batch_renders_each_simulation_with_its_own_scene(physics, renderer):
    pictures = renderer.render_batch(physics)
    for env in range(2):
        expected = bare_picture(physics.model(env), standing_qpos((0.0, 0.0), 0.0))
        np.testing.assert_array_equal(pictures[env], expected)
    red, blue = pictures[:, 20:28, 28:36].reshape(2, -1, 3).mean(axis=1)
    assert red[0] > 2 * red[2]
    assert blue[2] > 2 * blue[0]
    np.testing.assert_array_equal(renderer.render_batch(physics, [1])[0], pictures[1])


def test_fewer_contexts_than_scenes_give_the_same_pictures(physics, renderer):
    few = CameraRenderer(48, 64, max_scenes=1)
    for _ in range(2):
        np.testing.assert_array_equal(few.render_batch(physics), renderer.render_batch(physics))
    few.close()


def test_dropping_one_renderer_does_not_spoil_another(physics, renderer):
    before = renderer.render_batch(physics)
    other = CameraRenderer(48, 64)
    other.render_batch(physics)
    renderer.render_batch(physics)
    del other
    np.testing.assert_array_equal(renderer.render_batch(physics), before)


def test_a_closed_renderer_opens_again(physics, renderer):
    before = renderer.render_batch(physics)
    renderer.close()
    np.testing.assert_array_equal(renderer.render_batch(physics), before)


def test_rendering_leaves_the_model_as_it_was(physics, renderer):
    before = str(physics.model(0).vis.quality) + str(physics.model(0).vis.global_)
    renderer.render_batch(physics)
    assert str(physics.model(0).vis.quality) + str(physics.model(0).vis.global_) == before


def test_fewer_samples_are_a_rougher_picture_of_the_same(physics, renderer):
    rough = CameraRenderer(48, 64, samples=0)
    smooth_picture, rough_picture = renderer.render_batch(physics, [0])[0], rough.render_batch(physics, [0])[0]
    rough.close()
    difference = np.abs(smooth_picture.astype(int) - rough_picture)
    assert difference.max() > 10
    assert difference.mean() < 5


def test_nothing_is_said_when_the_interpreter_ends_with_open_renderers():
    code = (
        "import mujoco\n"
        "from hv_sim.rendering import CameraRenderer\n"
        "m = mujoco.MjModel.from_xml_string('<mujoco><worldbody><camera name=\"head\"/></worldbody></mujoco>')\n"
        "r = CameraRenderer(8, 8)\n"
        "r.render_qpos(m, [])\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stderr == ""


def test_a_picture_may_be_larger_than_the_models_buffer(physics):
    large = CameraRenderer(16, 1500)
    assert large.render_batch(physics, [0]).shape == (1, 16, 1500, 3)
    large.close()


def test_third_person_camera_lies_towards_the_corner(physics):
    look_at, corner = np.array([1.0, 0.5, 0.8]), np.array([-3.0, -2.0, 2.3])
    camera = third_person_camera(look_at, corner, distance_m=3.0)
    model = physics.model(0)
    data = physics.data(0)
    height, width = third_person_size_px()
    renderer = CameraRenderer(height, width)
    assert renderer.render(model, data, camera).shape == (height, width, 3)
    scene = mujoco.MjvScene(model, 100)
    option = mujoco.MjvOption()
    mujoco.mjv_updateScene(model, data, option, None, camera, int(mujoco.mjtCatBit.mjCAT_ALL), scene)
    eye = np.mean([np.array(c.pos) for c in scene.camera], axis=0)
    expected = look_at + 3.0 * (corner - look_at) / np.linalg.norm(corner - look_at)
    np.testing.assert_allclose(eye, expected, atol=1e-3)
    renderer.close()


def test_from_outside_a_room_the_near_wall_and_what_hangs_on_it_are_left_out(renderer):
    def picture(wall: bool, away_m: float = 0.02) -> np.ndarray:
        spec = mujoco.MjSpec.from_string("<mujoco><worldbody><light pos='0 0 4' dir='0 0 -1'/></worldbody></mujoco>")
        spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, pos=[0, 0, 0], size=[0.5, 0.5, 0.5], rgba=[1, 0, 0, 1])
        if wall:  # its normal looks along +y, into the room
            turn = [np.sqrt(0.5), -np.sqrt(0.5), 0, 0]
            kind = mujoco.mjtGeom.mjGEOM_PLANE
            spec.worldbody.add_geom(type=kind, pos=[0, -2, 0], size=[3, 3, 1], quat=turn, rgba=[0, 0, 1, 1])
            on_it = [0, -2 + away_m, 0]
            spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, pos=on_it, size=[1, 0.01, 1], rgba=[0, 1, 0, 1])
        camera = mujoco.MjvCamera()
        camera.type = mujoco.mjtCamera.mjCAMERA_FREE
        camera.azimuth, camera.elevation, camera.distance = 90.0, 0.0, 5.0
        model = spec.compile()
        return renderer.render_qpos(model, np.zeros(model.nq), camera)

    np.testing.assert_array_equal(picture(wall=True), picture(wall=False))
    assert (picture(wall=True, away_m=0.3) != picture(wall=False)).any(), "what stands in the room stays"


def test_the_best_corner_is_inside_the_room_and_not_on_top_of_the_action():
    corner = best_corner(np.array([-3.0, -3.0]), np.array([3.0, 3.0]), np.array([[2.5, 2.5], [2.0, 1.0]]))
    assert corner[2] > 2
    assert (np.abs(corner[:2]) < 3).all()
    assert np.linalg.norm(corner[:2] - [2.5, 2.5]) > 3


def test_a_shelf_between_moves_the_camera_to_another_corner():
    spec = mujoco.MjSpec()
    body = spec.worldbody.add_body(pos=[0, 0, 0.8])
    body.add_freejoint()
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.2, 0, 0], mass=1)
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, pos=[1.2, 0, 1], size=[0.1, 3, 1])
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    corners = upper_corners(np.array([-3.0, -3.0]), np.array([3.0, 3.0]))
    robot, hidden = np.array([0.0, 0.0, 0.8]), corners[3]
    along = np.linalg.norm(hidden - robot) / hidden[0]
    assert unhidden_m(model, data, robot, hidden) == pytest.approx(1.1 * along), "the shelf's face, not the robot's own"
    assert unhidden_m(model, data, robot, corners[0]) == pytest.approx(np.linalg.norm(corners[0] - robot))
    corner, free_m = clearest_corner(model, data, robot, corners, hidden)
    assert corner[0] < 0
    assert free_m > 3.8
    # from there it stays, and where all is free it never moves
    assert (clearest_corner(model, data, robot, corners, corner)[0] == corner).all()


def test_video_frame_has_three_parts():
    height, width = third_person_size_px()
    left, right = np.full((height, width, 3), 200, np.uint8), np.full((128, 128, 3), 100, np.uint8)
    frame = compose_video_frame(left, right, "Carry the box to the table.")
    assert frame.shape == (336, 672, 3)
    assert (frame[:height, :width] == 200).all()
    assert (frame[:height, width:] == 100).all()
    assert frame[height:].max() > 200
    blank = compose_video_frame(left, right, "")
    assert (blank[height:] == 0).all()
    assert (blank[:height] == frame[:height]).all()
    long = compose_video_frame(left, right, "word " * 60)
    assert (long[height:] > 0).sum() > (frame[height:] > 0).sum()


def test_no_gl_is_one_clear_line():
    code = (
        "import mujoco\n"
        "from hv_sim.rendering import CameraRenderer\n"
        "m = mujoco.MjModel.from_xml_string('<mujoco/>')\n"
        "try: CameraRenderer(8, 8).render_qpos(m, [])\n"
        "except RuntimeError as e: print(type(e).__name__, e)\n"
    )
    env = {**os.environ, "MUJOCO_GL": "disable"}
    out = subprocess.run([sys.executable, "-c", code], env=env, capture_output=True, text=True, check=True).stdout
    assert out.startswith("GLError")
    assert "libosmesa6" in out
    assert out.count("\n") == 1


def test_mujoco_imported_first_still_renders_headless():
    code = (
        "import mujoco\n"
        "from hv_sim.rendering import CameraRenderer\n"
        "m = mujoco.MjModel.from_xml_string('<mujoco><worldbody><camera name=\"head\"/></worldbody></mujoco>')\n"
        "print(CameraRenderer(8, 8).render_qpos(m, []).shape)\n"
    )
    env = {k: v for k, v in os.environ.items() if k not in ("MUJOCO_GL", "PYOPENGL_PLATFORM", "DISPLAY")}
    out = subprocess.run([sys.executable, "-c", code], env=env, capture_output=True, text=True, check=True).stdout
    assert out.strip() == "(8, 8, 3)"


@pytest.mark.parametrize("name", ["height_px", "width_px", "max_scenes"])
def test_a_bad_size_is_named(name):
    with pytest.raises(ValueError, match=f"{name}: 0 is not valid"):
        CameraRenderer(**{name: 0})


def test_two_threads_draw_what_one_does(physics):
    alone = CameraRenderer(24, 32).render_batch(physics, [0])

    def draw(_: int) -> np.ndarray:
        renderer = CameraRenderer(24, 32)
        pictures = [renderer.render_batch(physics, [0]) for _ in range(20)]
        renderer.close()
        assert all(np.array_equal(picture, pictures[0]) for picture in pictures)
        return pictures[0]

    with ThreadPoolExecutor(2) as pool:
        for picture in pool.map(draw, range(4)):
            np.testing.assert_array_equal(picture, alone)
