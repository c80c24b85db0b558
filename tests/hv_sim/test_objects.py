"""Objects against their own MuJoCo models: sizes, masses, and side faces that two hands can press."""

import mujoco
import numpy as np
import pytest

from hv_sim.lying_grasps import first_hit_m
from hv_sim.objects import GRASP_WIDTH_M, OBJECT_KINDS, build_object

KINDS = sorted(OBJECT_KINDS)


def _compile(built):
    """The colliding parts with their share of the mass, as MuJoCo sees them."""
    spec = mujoco.MjSpec()
    body = spec.worldbody.add_body(name="object")
    body.add_freejoint()
    total = sum(p.mass_share for p in built.parts)
    for part in built.parts:
        kind = mujoco.mjtGeom.mjGEOM_BOX if part.shape == "box" else mujoco.mjtGeom.mjGEOM_CYLINDER
        if part.collides:
            geom = body.add_geom(type=kind, size=list(part.size_m), pos=list(part.pos_m), quat=list(part.quat))
            geom.mass = built.mass_kg * part.mass_share / total
    return spec.compile()


@pytest.mark.parametrize("kind", KINDS)
def test_mass_properties_are_mujocos(kind):
    built = build_object(kind, mass_kg=3.0)
    model = _compile(built)
    assert model.body_mass[1] == pytest.approx(3.0)
    np.testing.assert_allclose(model.body_ipos[1], built.com_m, atol=1.1e-3)  # never exactly the centre, by design
    full = np.diag(model.body_inertia[1])
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, model.body_iquat[1])
    rotation = rotation.reshape(3, 3)
    np.testing.assert_allclose(rotation @ full @ rotation.T, np.diag(built.inertia), atol=1e-5)


@pytest.mark.parametrize("kind", KINDS)
def test_frame_is_the_centre_of_the_bounding_box(kind):
    built = build_object(kind)
    np.testing.assert_allclose(2 * built.half_extents_m, OBJECT_KINDS[kind].size_m, atol=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_hands_can_press_the_grasp_points(kind):
    """A ray along each hand's push meets a vertical face exactly at the grasp point, and 2 cm above and below it."""
    built = build_object(kind)
    model = _compile(built)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert built.grasps_o.shape == (4, 2, 3)
    assert built.grasp_ok.any()
    for i, (left, right) in enumerate(built.grasps_o):
        if not built.grasp_ok[i]:
            continue
        width = np.linalg.norm(left - right)
        assert GRASP_WIDTH_M[0] <= width <= GRASP_WIDTH_M[1]
        facing = np.array([np.cos(i * np.pi / 2), np.sin(i * np.pi / 2), 0.0])
        np.testing.assert_allclose(np.cross(facing, (left - right) / width), [0, 0, 1], atol=1e-9)
        for point, push in ((left, (right - left) / width), (right, (left - right) / width)):
            for height in (-0.02, 0.0, 0.02):
                start = point - 0.5 * push + [0, 0, height]
                geom = np.zeros(1, dtype=np.int32)
                distance = mujoco.mj_ray(model, data, start, push, None, 1, -1, geom)
                assert distance == pytest.approx(0.5, abs=1e-6), f"{kind} at {height:+g} m"


@pytest.mark.parametrize(("kind", "ahead_m"), [("crate", 0.055), ("pouf", 0.025), ("vase", 0.015)])
def test_hands_press_beyond_the_middle_where_there_is_room(kind, ahead_m):
    """Flat sides all the way, round ones as far as they hardly turn away."""
    built = build_object(kind)
    for i, grasp in enumerate(built.grasps_o):
        facing = np.array([np.cos(i * np.pi / 2), np.sin(i * np.pi / 2), 0.0])
        np.testing.assert_allclose(grasp @ facing, ahead_m, atol=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_what_rolls_is_the_same_from_all_sides(kind):
    built = build_object(kind)
    solid, half = [part for part in built.parts if part.collides], built.half_extents_m
    heights = np.linspace(-half[2], half[2], 19)[1:-1]
    seen = []
    for angle in np.arange(0.0, 2 * np.pi, 0.1):
        out = np.array([np.cos(angle), np.sin(angle), 0.0])
        seen.append(first_hit_m(solid, out + heights[:, None] * [0, 0, 1], -out))
    seen = np.nan_to_num(np.array(seen), posinf=2.0)
    assert built.rolls == (np.ptp(seen, 0).max() < 1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_sizes_and_colors_are_taken(kind):
    spec = OBJECT_KINDS[kind]
    size = tuple(0.95 * s for s in spec.size_m)
    built = build_object(kind, size, 1.0, "purple")
    np.testing.assert_allclose(2 * built.half_extents_m, size, atol=1e-9)
    assert built.mass_kg == 1.0
    assert {p.color for p in built.parts} != {p.color for p in build_object(kind, size, 1.0, "green").parts}


def test_what_cannot_be_carried_is_refused():
    with pytest.raises(ValueError, match="size_m"):
        build_object("box", (0.1, 0.3, 0.3))
    with pytest.raises(ValueError, match="size_m"):
        build_object("box", (0.3, 0.3, 1.3))
    with pytest.raises(ValueError, match="mass_kg"):
        build_object("box", mass_kg=40.0)


@pytest.mark.parametrize("kind", KINDS)
def test_it_stands_still(kind):
    """On a floor for two seconds: it neither slides by a centimetre nor tips."""
    built = build_object(kind)
    spec = mujoco.MjSpec()
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[5, 5, 1])
    body = spec.worldbody.add_body(name="object", pos=[0, 0, built.half_extents_m[2]])
    body.add_freejoint()
    body.explicitinertial = True
    body.mass, body.ipos, body.inertia = built.mass_kg, list(built.com_m), list(built.inertia)
    for part in built.parts:
        if part.collides:
            shape = mujoco.mjtGeom.mjGEOM_BOX if part.shape == "box" else mujoco.mjtGeom.mjGEOM_CYLINDER
            body.add_geom(type=shape, size=list(part.size_m), pos=list(part.pos_m), quat=list(part.quat))
    model = spec.compile()
    data = mujoco.MjData(model)
    while data.time < 2.0:
        mujoco.mj_step(model, data)
    np.testing.assert_allclose(data.qpos[:3], [0, 0, built.half_extents_m[2]], atol=0.01)
    assert data.body("object").xmat.reshape(3, 3)[2, 2] > 0.999


@pytest.mark.parametrize("kind", KINDS)
def test_it_can_be_named_and_painted(kind):
    spec = OBJECT_KINDS[kind]
    assert spec.category
    assert spec.noun
    assert spec.support in ("floor", "surface", "both")
    for color in spec.colors:
        assert build_object(kind, color=color).parts


def test_there_is_enough_to_choose_from():
    assert len(OBJECT_KINDS) >= 40
    assert len({spec.category for spec in OBJECT_KINDS.values()}) >= 18
    assert sum(spec.held_out for spec in OBJECT_KINDS.values()) >= 8
