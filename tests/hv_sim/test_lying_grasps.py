"""Hands press what is there: against MuJoCo's own rays, and where it hangs level."""

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hv_sim.lying_grasps import WIDTH_M, first_hit_m, press_points
from hv_sim.objects import OBJECT_KINDS, build_object
from hv_sim.parts import box

_TYPES = {"box": mujoco.mjtGeom.mjGEOM_BOX, "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER}


def _compiled(parts):
    spec = mujoco.MjSpec()
    for part in parts:
        if part.collides:
            spec.worldbody.add_geom(type=_TYPES[part.shape], size=part.size_m, pos=part.pos_m, quat=part.quat)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


@pytest.mark.parametrize("kind", ["plant", "stool", "dining_chair", "barrel", "lamp", "suitcase"])
def test_rays_hit_what_mujocos_rays_hit(kind):
    parts = build_object(kind).parts
    model, data = _compiled(parts)
    rng = np.random.default_rng(0)
    for direction in rng.normal(size=(6, 3)):
        direction /= np.linalg.norm(direction)
        origins = rng.uniform(-0.3, 0.3, (60, 3)) - 2.0 * direction
        ours = first_hit_m(parts, origins, direction)
        hit = np.zeros(1, np.int32)
        theirs = np.array([mujoco.mj_ray(model, data, o, direction, None, 1, -1, hit) for o in origins])
        np.testing.assert_allclose(ours, np.where(theirs < 0, np.inf, theirs), atol=1e-6)


@pytest.mark.parametrize("kind", sorted(OBJECT_KINDS))
def test_hands_press_faces_from_both_sides(kind):
    thing = build_object(kind)
    model, data = _compiled(thing.parts)
    hit = np.zeros(1, np.int32)
    found = 0
    for tilt in ([90, 0, 0], [0, 90, 0], [0, -90, 0], [180, 0, 0]):
        up_o = Rotation.from_euler("xyz", tilt, degrees=True).as_matrix()[2]
        level = np.cross(up_o, np.roll(np.abs(up_o).round(), 1))
        for ahead_o in (level, -level):
            points = press_points(thing.parts, thing.com_m, ahead_o, up_o, thing.half_extents_m)
            if points is None:
                continue
            found += 1
            (left, right), off = points
            assert off >= 0
            assert WIDTH_M[0] <= np.linalg.norm(left - right) <= WIDTH_M[1]
            np.testing.assert_allclose((left - right) @ np.stack([ahead_o, up_o], 1), 0.0, atol=1e-9)
            outward = (left - right) / np.linalg.norm(left - right)
            np.testing.assert_allclose(np.cross(up_o, ahead_o), outward, atol=1e-9)
            for point, out in ((left, outward), (right, -outward)):
                assert mujoco.mj_ray(model, data, point + 0.3 * out, -out, None, 1, -1, hit) == pytest.approx(0.3)
    assert found or kind in {"floor_lamp"}


def test_what_is_heavy_at_one_end_is_pressed_there():
    half, com = np.array([0.1, 0.1, 0.3]), np.array([0.0, 0.0, -0.2])
    parts = [box((0, 0, 0), (0.2, 0.2, 0.6), (1, 1, 1), collides=True)]
    ahead_o, up_o = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
    points, off = press_points(parts, com, ahead_o, up_o, half)
    assert off < 0.02
    assert points[:, 2] == pytest.approx(-0.17, abs=0.01)
    assert (points[:, 0] > 0.02).all()


def test_a_roller_is_not_pressed_where_it_curves_away():
    thing = build_object("barrel")
    half = thing.half_extents_m
    points, _ = press_points(thing.parts, thing.com_m, np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0]), half)
    assert (np.abs(points[:, 0]) < 0.4 * half[1]).all()


def test_nothing_to_press_is_none():
    wide = [box((0, 0, 0), (0.2, 0.8, 0.2), (1, 1, 1), collides=True)]
    half = np.array([0.1, 0.4, 0.1])
    assert press_points(wide, np.zeros(3), np.array([1.0, 0, 0]), np.array([0, 0, 1.0]), half) is None
