"""The policy's own copy of the body's numbers, against the simulated body."""

import numpy as np
import pytest
from plain_ground import ground_model

from hv_policy.motor import embodiment as body
from hv_sim import humanoid


@pytest.fixture(scope="module")
def model():
    return ground_model()


def test_names_gains_and_limits(model):
    assert body.BODY_NAMES == humanoid.BODY_NAMES
    np.testing.assert_allclose(body.KP, humanoid.KP)
    np.testing.assert_allclose(humanoid.KD / humanoid.KP, body.DAMPING_TIME_S)
    np.testing.assert_allclose(body.TORQUE_LIMIT, humanoid.TORQUE_LIMIT)
    np.testing.assert_allclose(np.stack([body.JOINT_LOW, body.JOINT_HIGH], 1), humanoid.JOINT_RANGE_RAD, atol=1e-6)
    for side, joints in zip(("right", "left"), body.ARM_JOINTS, strict=True):
        assert [humanoid.JOINT_NAMES[j] for j in joints] == [
            f"{side}_{n}" for n in ("shoulder_x", "shoulder_y", "shoulder_z", "elbow")
        ]
    for side, joints in zip(("right", "left"), body.LEG_JOINTS, strict=True):
        parts = ("hip_x", "hip_y", "hip_z", "knee", "ankle_x", "ankle_y", "ankle_z")
        assert [humanoid.JOINT_NAMES[j] for j in joints] == [f"{side}_{n}" for n in parts]


def test_masses_and_offsets(model):
    np.testing.assert_allclose(model.body_mass[1:16], body.BODY_MASS_KG, rtol=1e-4)
    np.testing.assert_allclose(model.body_ipos[1:16], body.BODY_COM_M, atol=2e-4)
    assert model.body_subtreemass[1] == pytest.approx(body.TOTAL_MASS_KG, abs=1e-3)
    position = {name: model.body(name).pos for name in body.BODY_NAMES}
    np.testing.assert_allclose(position["torso"], body.TORSO_OFFSET_M)
    np.testing.assert_allclose(position["left_upper_arm"], body.SHOULDER_OFFSET_M)
    np.testing.assert_allclose(position["right_upper_arm"], np.array(body.SHOULDER_OFFSET_M) * [1, -1, 1])
    np.testing.assert_allclose(position["left_lower_arm"], [0, 0, -body.UPPER_ARM_M])
    np.testing.assert_allclose(position["left_hand"], [0, 0, -body.FOREARM_M])
    np.testing.assert_allclose(position["left_thigh"], [0, body.HIP_WIDTH_M, 0])
    np.testing.assert_allclose(position["left_shin"], [0, 0, -body.THIGH_M])
    np.testing.assert_allclose(position["left_foot"], [0, 0, -body.SHIN_M])
    assert model.geom("left_hand").size[0] == body.HAND_RADIUS_M


def test_mirroring_is_an_involution_that_swaps_sides():
    joints = body.MIRROR_JOINTS
    np.testing.assert_array_equal(joints[joints], np.arange(28))
    np.testing.assert_array_equal(body.MIRROR_JOINT_SIGN[joints], body.MIRROR_JOINT_SIGN)
    low, high = body.JOINT_LOW, body.JOINT_HIGH
    mirrored = np.sort(np.stack([low, high], 1)[joints] * body.MIRROR_JOINT_SIGN.numpy()[:, None], axis=1)
    np.testing.assert_allclose(mirrored, np.stack([low, high], 1), atol=1e-6)
