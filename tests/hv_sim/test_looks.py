"""Looks change what is drawn, within their ranges, and nothing else."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from hv_sim.looks import NO_LOOKS, Look, LookRanges, read_look_ranges
from hv_sim.rendering import CameraRenderer
from hv_sim.scene import compile_scene
from hv_sim.suites import load_suite

CONFIG = Path(__file__).parents[2] / "configs" / "looks.yaml"


@pytest.fixture(scope="module")
def scene():
    return compile_scene(load_suite("seen")[2])


def picture(scene, ranges: LookRanges | None, seed: int = 0) -> np.ndarray:
    renderer = CameraRenderer(64, 64)
    data = mujoco.MjData(scene.model)
    data.qpos[:] = scene.initial_qpos
    mujoco.mj_forward(scene.model, data)
    look = None if ranges is None else Look(ranges, np.random.default_rng(seed))
    try:
        return renderer.render(scene.model, data, "head", look)
    finally:
        renderer.close()


def test_the_packaged_ranges_change_the_picture_and_not_the_model(scene):
    before = scene.model.geom_rgba.copy(), scene.model.cam_pos.copy()
    plain, ranges = picture(scene, None), read_look_ranges(CONFIG)
    assert ranges.vary
    first, again, other = picture(scene, ranges), picture(scene, ranges), picture(scene, ranges, 1)
    np.testing.assert_array_equal(first, again)
    assert np.abs(first.astype(int) - plain).mean() > 4
    assert np.abs(first.astype(int) - other).mean() > 4
    np.testing.assert_array_equal(scene.model.geom_rgba, before[0])
    np.testing.assert_array_equal(scene.model.cam_pos, before[1])
    np.testing.assert_array_equal(picture(scene, None), plain)


def test_no_range_no_change(scene):
    assert not NO_LOOKS.vary
    np.testing.assert_array_equal(picture(scene, NO_LOOKS), picture(scene, None))


def test_light_alone_makes_it_brighter_or_darker_everywhere(scene):
    plain = picture(scene, None).astype(float).mean((0, 1))
    means = [picture(scene, LookRanges(light=0.3), seed).astype(float).mean((0, 1)) for seed in range(6)]
    for mean in means:
        assert np.ptp(mean / plain) < 0.12  # no tint
    assert min(m.mean() for m in means) < plain.mean() < max(m.mean() for m in means)


def altered(scene, ranges: LookRanges, seed: int = 3) -> tuple[mujoco.MjvScene, mujoco.MjvScene]:
    data = mujoco.MjData(scene.model)
    data.qpos[:] = scene.initial_qpos
    mujoco.mj_forward(scene.model, data)
    scenes = []
    for _ in range(2):
        made = mujoco.MjvScene(scene.model, 2000)
        camera = mujoco.MjvCamera()
        camera.type, camera.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, 0
        mujoco.mjv_updateScene(
            scene.model, data, mujoco.MjvOption(), None, camera, mujoco.mjtCatBit.mjCAT_ALL.value, made
        )
        scenes.append(made)
    Look(ranges, np.random.default_rng(seed)).alter(scenes[1], scene.model)
    return scenes[0], scenes[1]


def test_the_camera_moves_and_turns_as_far_as_it_should(scene):
    shifts, angles = [], []
    for seed in range(40):
        before, after = altered(scene, LookRanges(camera_m=0.02, camera_rad=0.05), seed)
        shifts.append(np.array(after.camera[0].pos) - before.camera[0].pos)
        forward, up = np.array(after.camera[0].forward), np.array(after.camera[0].up)
        np.testing.assert_allclose([np.linalg.norm(forward), np.linalg.norm(up)], 1, atol=1e-5)
        assert abs(forward @ up) < 1e-5
        angles.append(np.arccos(np.clip(forward @ np.array(before.camera[0].forward), -1, 1)))
    assert 0.015 < np.std(shifts) < 0.025
    assert 0.04 < np.mean(angles) < 0.09  # mean of two perpendicular deviations of .05: .063


def test_parts_of_one_colour_keep_one_colour_and_things_stay_near_theirs(scene):
    before, after = altered(scene, LookRanges(thing_tint=0.1, surface_blend=0.7))
    seen: dict[tuple, set] = {}
    walls, things = [], []
    for old, new in zip(before.geoms[: before.ngeom], after.geoms[: after.ngeom], strict=True):
        kind = (*np.round(old.rgba, 4).tolist(), int(old.type == mujoco.mjtGeom.mjGEOM_PLANE), old.matid)
        seen.setdefault(kind, set()).add(tuple(np.round(new.rgba, 4).tolist()))
        (walls if kind[4] else things).append(float(np.abs(np.array(new.rgba) - old.rgba).max()))
        assert old.matid == new.matid
    assert all(len(colors) == 1 for colors in seen.values())
    assert max(walls) > 0.1
    assert max(things) < 0.4


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("light: -1", "light -1 is not valid; valid: 0 to 0.5"),
        ("plain_share: 2", "plain_share 2 is not valid; valid: 0 to 1"),
        ("light: bright", "light 'bright' is not valid"),
        ("lights: 0.1", "holds lights; valid: light, light_tint"),
        ("- light", "holds list; valid"),
        ("a: [", "cannot be read"),
    ],
)
def test_what_is_wrong_with_a_file_is_said_in_one_line(tmp_path: Path, text: str, message: str):
    path = tmp_path / "looks.yaml"
    path.write_text(text)
    with pytest.raises(ValueError, match="looks: ") as error:
        read_look_ranges(path)
    assert message in str(error.value)
    assert "\n" not in str(error.value)
