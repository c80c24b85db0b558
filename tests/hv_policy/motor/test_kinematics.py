"""Arms and legs against MuJoCo's own forward kinematics and Jacobians."""

import mujoco
import numpy as np
import pytest
import torch
from plain_ground import ground_model, random_poses

from hv_policy.motor import embodiment as body
from hv_policy.motor.kinematics import (
    arm_forward_kinematics,
    arm_inverse_kinematics,
    hip_positions,
    leg_axes_at,
    leg_inverse_kinematics,
    shoulder_positions,
)
from hv_policy.motor.reference import preferred_arm_angles
from hv_policy.motor.vectors import about_y, about_z, hinge_angles, hinges_xyz, product


@pytest.fixture(scope="module")
def model():
    return ground_model()


def posed(model, qpos):
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    return data


def tensor(values):
    return torch.tensor(np.array(values), dtype=torch.float32)


def link(data, name):
    return tensor(data.body(name).xpos)[None], tensor(data.body(name).xmat.reshape(3, 3))[None]


def test_hinge_angles_invert_the_matrix():
    for angles in np.random.default_rng(0).uniform(-1.5, 1.5, (200, 3)):
        np.testing.assert_allclose(hinge_angles(hinges_xyz(*angles)), angles, atol=1e-9)


def test_arms_match_mujoco(model):
    for qpos in random_poses(20, seed=1):
        data = posed(model, qpos)
        torso = link(data, "torso")
        shoulder = shoulder_positions(*torso)
        angles = tensor(qpos[7:])[6:14].view(1, 2, 4)
        hand, jacobian, elbow, elbow_jacobian = arm_forward_kinematics(shoulder, torso[1], angles)
        for s, side in enumerate(("right", "left")):
            np.testing.assert_allclose(shoulder[0, s], data.body(f"{side}_upper_arm").xpos, atol=1e-5)
            columns = [6 + j for j in body.ARM_JOINTS[s]]
            for name, point, mine in (("hand", hand, jacobian), ("lower_arm", elbow, elbow_jacobian)):
                np.testing.assert_allclose(point[0, s], data.body(f"{side}_{name}").xpos, atol=1e-5)
                expected = np.zeros((3, model.nv))
                # the point moves with the bodies above it, not with the joint that sits on it
                parent = model.body(f"{side}_upper_arm" if name == "lower_arm" else f"{side}_hand").id
                mujoco.mj_jac(model, data, expected, None, data.body(f"{side}_{name}").xpos, parent)
                np.testing.assert_allclose(mine[0, s], expected[:, columns], atol=1e-5)


def test_arms_reach_what_they_can_and_keep_to_their_limits():
    torso_rot = torch.eye(3)[None].expand(60, 3, 3)
    shoulder = shoulder_positions(torch.zeros(60, 3), torso_rot)
    rng = np.random.default_rng(0)
    radius, azimuth, elevation = rng.uniform(0.3, 0.48, 60), rng.uniform(-0.3, 0.6, 60), rng.uniform(-1.4, -0.1, 60)
    offset = np.stack([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)], -1)
    left = tensor(offset * radius[:, None])
    target = shoulder + torch.stack([left * torch.tensor([1.0, -1.0, 1.0]), left], 1)
    start = preferred_arm_angles(torch.zeros(60))
    angles = arm_inverse_kinematics(shoulder, torso_rot, target, start, start, iterations=40)
    error = (arm_forward_kinematics(shoulder, torso_rot, angles)[0] - target).norm(dim=-1)
    assert error.median() < 0.005
    assert (error < 0.03).float().mean() > 0.95
    for s in range(2):
        assert (angles[:, s] >= body.JOINT_LOW[body.ARM_JOINTS[s]] - 1e-6).all()
        assert (angles[:, s] <= body.JOINT_HIGH[body.ARM_JOINTS[s]] + 1e-6).all()
    # a mirrored target is reached by the mirrored arm, elbows out on both sides
    elbow = arm_forward_kinematics(shoulder, torso_rot, angles)[2]
    torch.testing.assert_close(elbow[:, 0] * torch.tensor([1.0, -1.0, 1.0]), elbow[:, 1], atol=2e-3, rtol=0)
    # the bent arms' elbows point away from the body
    assert (elbow[:, 1, 1] > shoulder[:, 1, 1])[torch.tensor(radius < 0.42)].float().mean() > 0.8


@pytest.mark.parametrize(("heights", "tolerance"), [((0.75, 0.84), 0.004), ((0.42, 0.75), 0.04)])
def test_legs_put_the_soles_where_they_should_be(model, heights, tolerance):
    rng = np.random.default_rng(2)
    for _ in range(20):
        yaw, height = rng.uniform(-0.2, 0.2), rng.uniform(*heights)
        pitch = rng.uniform(0, 0.15 if height > 0.75 else 0.5)
        rotation = tensor(product(about_z(yaw), about_y(pitch))).mT[None]
        pelvis = tensor([[0, 0, height]])
        feet = tensor([[[rng.uniform(-0.1, 0.05), -0.1, 0.05], [rng.uniform(-0.05, 0.1), 0.1, 0.09]]])
        foot_yaw = tensor([[0.1, -0.05]])
        angles = leg_inverse_kinematics(hip_positions(pelvis, rotation), feet, rotation, foot_yaw)
        qpos = np.zeros(35)
        qpos[:3] = pelvis[0].numpy()
        mujoco.mju_mat2Quat(qpos[3:7], rotation[0].numpy().astype(float).ravel())
        qpos[21:] = angles.flatten().numpy()
        data = posed(model, qpos)
        for s, side in enumerate(("right", "left")):
            foot = data.body(f"{side}_foot")
            np.testing.assert_allclose(foot.xpos, feet[0, s], atol=tolerance)
            assert foot.xmat.reshape(3, 3)[2, 2] > 0.99


def test_leg_axes_are_mujocos(model):
    for qpos in random_poses(20, seed=3):
        data = posed(model, qpos)
        rotations = torch.stack([link(data, name)[1] for name in body.BODY_NAMES], 1)
        for s in range(2):
            expected = data.xaxis[[1 + j for j in body.LEG_JOINTS[s]]]
            np.testing.assert_allclose(leg_axes_at(rotations.numpy(), 0, s), expected, atol=1e-4)
