"""The humanoid against the published table (written out here a second time), and in plain MuJoCo."""

import itertools
import math

import mujoco
import numpy as np
import pytest
from plain_ground import ground_model, random_state

from hv_sim.humanoid import (
    BODY_NAMES,
    CONTROL_HZ,
    JOINT_NAMES,
    JOINT_RANGE_RAD,
    KD,
    KP,
    NUM_BODIES,
    NUM_JOINTS,
    STANDING_HEIGHT_M,
    TORQUE_LIMIT,
    add_humanoid,
    configure_physics,
    standing_qpos,
)

# body: parent, offset from it for the left side (m), mass (kg); the right side has the opposite y
BODIES = {
    "torso": ("pelvis", (0, 0, 0.2362), 12.011),
    "head": ("torso", (0, 0, 0.2239), 3.882),
    "upper_arm": ("torso", (-0.0241, 0.1831, 0.2435), 1.499),
    "lower_arm": ("upper_arm", (0, 0, -0.2748), 1.0),
    "hand": ("lower_arm", (0, 0, -0.2589), 0.5),
    "thigh": ("pelvis", (0, 0.0849, 0), 4.502),
    "shin": ("thigh", (0, 0, -0.4215), 3.0),
    "foot": ("shin", (0, 0, -0.4099), 1.0),
}
# joint: range of the right side (deg), mirrored on the left?, kp, kd, torque limit
JOINTS = {
    "abdomen_x": ((-60, 60), False, 1000, 100, 200),
    "abdomen_y": ((-60, 90), False, 1000, 100, 200),
    "abdomen_z": ((-50, 50), False, 1000, 100, 200),
    "neck_x": ((-50, 50), False, 100, 10, 50),
    "neck_y": ((-40, 60), False, 100, 10, 50),
    "neck_z": ((-45, 45), False, 100, 10, 50),
    "shoulder_x": ((-180, 45), True, 400, 40, 100),
    "shoulder_y": ((-180, 60), False, 400, 40, 100),
    "shoulder_z": ((-90, 90), False, 400, 40, 100),
    "elbow": ((-160, 0), False, 300, 30, 70),
    "hip_x": ((-60, 15), True, 500, 50, 200),
    "hip_y": ((-140, 60), False, 500, 50, 200),
    "hip_z": ((-60, 35), True, 500, 50, 200),
    "knee": ((0, 160), False, 500, 50, 150),
    "ankle_x": ((-30, 30), False, 400, 40, 90),
    "ankle_y": ((-55, 55), False, 400, 40, 90),
    "ankle_z": ((-40, 40), False, 400, 40, 90),
}
ARM = ["shoulder_x", "shoulder_y", "shoulder_z", "elbow"]
LEG = ["hip_x", "hip_y", "hip_z", "knee", "ankle_x", "ankle_y", "ankle_z"]
ORDER = [
    *(f"{part}_{axis}" for part in ("abdomen", "neck") for axis in "xyz"),
    *(f"{side}_{name}" for limb in (ARM, LEG) for side in ("right", "left") for name in limb),
]
AXES = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1), "elbow": (0, 1, 0), "knee": (0, 1, 0)}


def without_side(name: str) -> str:
    return name.removeprefix("right_").removeprefix("left_")


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    return ground_model()


def forwarded(model: mujoco.MjModel, qpos: np.ndarray) -> mujoco.MjData:
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_forward(model, data)
    return data


def test_bodies_have_the_tables_parents_offsets_and_masses(model):
    assert model.body("pelvis").mass[0] == pytest.approx(9.996, abs=1e-6)
    for name in BODY_NAMES[1:]:
        parent, offset, mass = BODIES[without_side(name)]
        side = "right_" if name.startswith("right") else "left_" if name.startswith("left") else ""
        parent = parent if parent in ("pelvis", "torso") else side + parent
        expected = np.array(offset) * ([1, -1, 1] if side == "right_" else [1, 1, 1])
        body = model.body(name)
        assert model.body(int(body.parentid[0])).name == parent, name
        np.testing.assert_allclose(body.pos, expected, atol=6e-5, err_msg=name)  # the table has four decimals
        assert body.mass[0] == pytest.approx(mass, abs=1e-6), name
    assert len(BODY_NAMES) == NUM_BODIES == 15
    assert [model.body(1 + i).name for i in range(15)] == list(BODY_NAMES)
    assert model.body("pelvis").subtreemass[0] == pytest.approx(48.9, abs=0.05)


def test_joints_have_the_tables_order_ranges_and_servos(model):
    assert list(JOINT_NAMES) == ORDER
    assert NUM_JOINTS == 28
    assert model.nq == 35
    assert model.nv == 34
    assert model.nu == 28
    for i, name in enumerate(ORDER):
        (low, high), mirrored, kp, kd, limit = JOINTS[without_side(name)]
        if mirrored and name.startswith("left"):
            low, high = -high, -low
        joint, servo = model.joint(1 + i), model.actuator(i)
        assert joint.name == name
        assert joint.qposadr[0] == 7 + i
        assert joint.dofadr[0] == 6 + i
        assert joint.type[0] == mujoco.mjtJoint.mjJNT_HINGE
        assert joint.limited[0], name
        np.testing.assert_allclose(np.degrees(joint.range), [low, high], atol=1e-6, err_msg=name)
        np.testing.assert_array_equal(joint.axis, AXES[name.rsplit("_", 1)[-1]], err_msg=name)
        np.testing.assert_array_equal(joint.pos, [0, 0, 0])
        assert joint.armature[0] == pytest.approx(0.1)
        assert servo.trnid[0] == 1 + i
        assert servo.gainprm[0] == pytest.approx(kp), name
        np.testing.assert_allclose(servo.biasprm[:3], [0, -kp, -kd], err_msg=name)
        assert servo.forcelimited[0], name
        np.testing.assert_allclose(servo.forcerange, [-limit, limit], err_msg=name)
        np.testing.assert_allclose(np.degrees(JOINT_RANGE_RAD[i]), [low, high])
        assert (KP[i], KD[i], TORQUE_LIMIT[i]) == (kp, kd, limit)


def test_a_servo_pushes_with_kp_times_error_up_to_its_limit(model):
    data = forwarded(model, standing_qpos((0, 0), 0.0))
    data.qvel[6:] = 0.01
    for error in (0.01, 2.0):
        data.ctrl[:] = data.qpos[7:] + error
        mujoco.mj_forward(model, data)
        for i, name in enumerate(ORDER):
            _, _, kp, kd, limit = JOINTS[without_side(name)]
            assert data.actuator_force[i] == pytest.approx(np.clip(kp * error - kd * 0.01, -limit, limit)), name


def test_feet_are_the_tables_boxes_and_hands_its_spheres(model):
    for side in ("right", "left"):
        foot, hand = model.geom(f"{side}_foot"), model.geom(f"{side}_hand")
        assert foot.type[0] == mujoco.mjtGeom.mjGEOM_BOX
        np.testing.assert_allclose(foot.size, [0.0885, 0.045, 0.0275])
        np.testing.assert_allclose(foot.pos, [0.045, 0, -0.0225])
        assert hand.type[0] == mujoco.mjtGeom.mjGEOM_SPHERE
        assert hand.size[0] == pytest.approx(0.04)


def test_the_body_is_symmetric(model):
    for name in BODY_NAMES:
        other = name.replace("right", "left") if "right" in name else name.replace("left", "right")
        mirror = np.array([1, -1, 1])
        np.testing.assert_allclose(model.body(name).ipos, model.body(other).ipos * mirror, atol=1e-9)
        np.testing.assert_allclose(model.body(name).inertia, model.body(other).inertia, atol=1e-9)


def test_the_head_camera_sees_90_degrees_ahead_and_a_little_down(model):
    data = forwarded(model, standing_qpos((0.3, -0.2), 0.7))
    head, camera = data.body("head"), data.camera("head")
    rotation = head.xmat.reshape(3, 3)
    np.testing.assert_allclose(rotation.T @ (camera.xpos - head.xpos), [0.10, 0, 0.175], atol=1e-9)
    right, up, backward = (rotation.T @ camera.xmat.reshape(3, 3)).T
    tilt = math.radians(20)
    np.testing.assert_allclose(-backward, [math.cos(tilt), 0, -math.sin(tilt)], atol=1e-6)
    np.testing.assert_allclose(right, [0, -1, 0], atol=1e-6)
    assert up[2] > 0.9
    assert model.camera("head").fovy[0] == 90  # a square picture: 90 degrees across as well


def stand(model: mujoco.MjModel, qpos: np.ndarray, targets: np.ndarray, seconds: float) -> mujoco.MjData:
    data = forwarded(model, qpos)
    data.ctrl[:] = targets
    while data.time < seconds:
        mujoco.mj_step(model, data)
    return data


def test_stands_straight_for_three_seconds_under_pd_alone(model):
    start = standing_qpos((1.0, 2.0), 0.8)
    start[7:] = 0.0
    start[2] = 0.4215 + 0.4099 + 0.0225 + 0.0275  # straight legs, ankle height
    data = stand(model, start, start[7:], 3.0)
    np.testing.assert_allclose(data.qpos[:2], [1.0, 2.0], atol=0.03)
    assert data.qpos[2] == pytest.approx(start[2], abs=0.01)
    np.testing.assert_allclose(data.qpos[7:], start[7:], atol=0.05)
    assert np.abs(data.qvel).max() < 0.01


def test_stands_in_its_standing_pose_under_pd_and_the_static_torques(model):
    """Bent knees sag under PD alone; with the torques of statics added, the pose holds."""
    start = standing_qpos((0.0, 0.0), 0.0)
    data = forwarded(model, start)
    torque, weight = data.qfrc_bias.copy(), 48.891 * 9.81
    for side in ("right", "left"):
        foot, jacobian = data.body(f"{side}_foot"), np.zeros((3, model.nv))
        under = np.array([data.subtree_com[1][0], foot.xpos[1], 0.0])
        mujoco.mj_jac(model, data, jacobian, None, under, model.body(f"{side}_foot").id)
        torque -= jacobian.T @ [0, 0, weight / 2]
    np.testing.assert_allclose(torque[:6], 0, atol=1e-6)  # the soles bear the whole robot
    data = stand(model, start, start[7:] + torque[6:] / KP, 3.0)
    np.testing.assert_allclose(data.qpos[:3], start[:3], atol=0.01)
    np.testing.assert_allclose(data.qpos[7:], start[7:], atol=0.02)


def test_standing_qpos_puts_flat_soles_on_the_floor_and_faces_the_yaw(model):
    for yaw in (-2.0, 0.0, 1.2):
        data = forwarded(model, standing_qpos((0.4, -0.3), yaw))
        np.testing.assert_allclose(data.qpos[:2], [0.4, -0.3])
        assert data.qpos[2] == pytest.approx(STANDING_HEIGHT_M, abs=0.001)
        forward = data.body("pelvis").xmat.reshape(3, 3)[:, 0]
        np.testing.assert_allclose(forward, [math.cos(yaw), math.sin(yaw), 0], atol=1e-9)
        for side in ("right", "left"):
            foot = data.geom(f"{side}_foot")
            np.testing.assert_allclose(foot.xmat.reshape(3, 3)[:, 2], [0, 0, 1], atol=1e-9)
            assert foot.xpos[2] - 0.0275 == pytest.approx(0.0, abs=0.001)
        assert (data.qpos[7:] >= JOINT_RANGE_RAD[:, 0]).all()
        assert (data.qpos[7:] <= JOINT_RANGE_RAD[:, 1]).all()


def touching_bodies(model: mujoco.MjModel, data: mujoco.MjData) -> set[frozenset[str]]:
    bodies = model.geom_bodyid
    return {frozenset((model.body(bodies[c.geom1]).name, model.body(bodies[c.geom2]).name)) for c in data.contact}


def test_a_hand_pressed_into_a_thigh_touches_it(model):
    qpos = standing_qpos((0, 0), 0)
    qpos[2] += 1.0
    assert touching_bodies(model, forwarded(model, qpos)) == set()
    for side, turn in (("right", 1), ("left", -1)):
        into = qpos.copy()
        into[7 + ORDER.index(f"{side}_shoulder_x")] = 0.17 * turn
        into[7 + ORDER.index(f"{side}_elbow")] = -0.1
        assert frozenset((f"{side}_hand", f"{side}_thigh")) in touching_bodies(model, forwarded(model, into))


def test_limbs_that_overlap_touch_unless_their_pair_is_excluded(model):
    """Every pair of bodies, in random poses, by the distance of their geoms."""
    excluded = {frozenset((int(s) >> 16, int(s) & 0xFFFF)) for s in model.exclude_signature}
    geoms = [[g for g in range(model.ngeom) if model.geom_bodyid[g] == b] for b in range(1, 16)]
    rng, overlapping, quiet = np.random.default_rng(0), 0, set()
    for _ in range(100):
        data = forwarded(model, random_state(model, rng)[0])
        touching = touching_bodies(model, data)
        for a, b in itertools.combinations(range(1, 16), 2):
            welded, parent = model.body_weldid, lambda w: model.body_weldid[model.body_parentid[w]]
            first, second = int(welded[a]), int(welded[b])
            if first == second or parent(first) == second or parent(second) == first:
                continue  # MuJoCo never collides neighbours
            gap = min(
                mujoco.mj_geomDistance(model, data, g, h, 0.5, None) for g in geoms[a - 1] for h in geoms[b - 1]
            )
            names = frozenset((model.body(a).name, model.body(b).name))
            if frozenset((a, b)) in excluded:
                assert names not in touching
                quiet |= {names} if gap < 0 else set()
            elif abs(gap) > 1e-6:
                assert (names in touching) == (gap < 0), (sorted(names), gap)
                overlapping += gap < 0
    assert overlapping > 30
    assert len(quiet) >= 4, "the poses never tried the excluded pairs"


def test_the_excluded_pairs_are_few_and_symmetric(model):
    names = [
        frozenset(model.body(i).name for i in (int(s) >> 16, int(s) & 0xFFFF)) for s in model.exclude_signature
    ]
    swap = {frozenset(n.replace("right", "L").replace("left", "right").replace("L", "left") for n in p) for p in names}
    assert set(names) == swap
    assert len(names) == 11
    limbs = ("hand", "thigh", "shin", "foot")
    assert not any(all(n.endswith(limbs) for n in pair) for pair in names), "limbs must not pass through each other"


def test_contact_sensors_report_the_deepest_contact_with_the_static_world():
    model = ground_model(1)
    rng, fired, silent = np.random.default_rng(1), 0, 0
    for _ in range(100):
        qpos, _ = random_state(model, rng, tilt_rad=3.0)
        data = forwarded(model, qpos)
        robot = (model.geom_bodyid > 0) & (model.geom_bodyid < 16)
        qpos[2] -= (data.geom_xpos[robot, 2] - model.geom_rbound[robot]).min() + 0.05  # into the floor
        data = forwarded(model, qpos)
        for b, name in enumerate(BODY_NAMES, start=1):
            contacts = [
                c for c in data.contact if {int(model.geom_bodyid[c.geom1]), int(model.geom_bodyid[c.geom2])} == {0, b}
            ]
            reading = data.sensor(f"contact_{name}").data
            assert (reading[0] > 0) == bool(contacts), name
            if contacts:
                deepest = min(contacts, key=lambda c: c.dist)
                np.testing.assert_allclose(reading[1:4], deepest.pos, atol=1e-9)
                fired += 1
            silent += not contacts
    assert fired > 20
    assert silent > 20


def test_a_body_on_a_loose_object_does_not_touch_the_static_world():
    model = ground_model(1)
    data = mujoco.MjData(model)
    data.qpos[:] = model.qpos0
    data.qpos[:35] = standing_qpos((0, 0), 0)
    data.qpos[2] += 0.5
    mujoco.mj_kinematics(model, data)
    data.qpos[35:38] = data.body("right_hand").xpos - np.array([0, 0.13, 0])
    mujoco.mj_forward(model, data)
    assert frozenset(("right_hand", "box_0")) in touching_bodies(model, data)
    assert data.sensor("contact_right_hand").data[0] == 0


@pytest.mark.parametrize("hz", [120, 240])
def test_physics_options(hz):
    model = ground_model(physics_hz=hz)
    assert model.opt.timestep == pytest.approx(1 / hz)
    assert CONTROL_HZ == 30
    assert model.opt.cone == mujoco.mjtCone.mjCONE_PYRAMIDAL
    np.testing.assert_allclose(model.geom_solref[:, 0], 2 / hz)


@pytest.mark.parametrize("hz", [100, 0, -120])
def test_a_rate_that_the_control_rate_does_not_divide_is_refused(hz):
    spec = mujoco.MjSpec()
    add_humanoid(spec)
    with pytest.raises(ValueError, match=f"physics_hz: {hz} is not a positive multiple of 30"):
        configure_physics(spec, hz)
