"""Virtual model control, against J^T f with MuJoCo's Jacobians and against the robot's weight."""

import mujoco
import numpy as np
import pytest
import torch
from plain_ground import ground_model

from hv_policy.motor import embodiment as body
from hv_policy.motor.balance import BalanceConfig, arm_torques, estimate_load, leg_torques, measured_arm_angles
from hv_policy.motor.gait import GaitConfig
from hv_policy.motor.intent import neutral_intent
from hv_policy.motor.proprioception import read_proprioception
from hv_policy.motor.reference import advance_reference, standing_pose, start_reference
from hv_sim.humanoid import standing_qpos
from hv_sim.mujoco_physics import MujocoPhysics
from hv_sim.observations import proprioception


@pytest.fixture(scope="module")
def standing():
    physics = MujocoPhysics([ground_model()], num_threads=1)
    physics.reset([0], [standing_qpos((0, 0), 0.0)])
    data = physics.data(0)
    mujoco.mj_forward(physics.model(0), data)
    return physics.model(0), data, read_proprioception(proprioception(physics.state()))


def test_standing_legs_bear_the_weight(standing):
    model, data, state = standing
    intent = neutral_intent(1)
    intent[:, 3] = state.pos[0, 0, 2]
    memory = start_reference(state, intent, GaitConfig())
    reference = advance_reference(memory, state, intent, GaitConfig())
    reference.pelvis_pos = state.pos[:, 0].clone()
    reference.pelvis_rot = state.rot[:, 0].clone()
    config = BalanceConfig()
    torques = leg_torques(state, reference, torch.zeros(1), config)[0].double().numpy()
    # the force f on each sole for which these torques are -J^T f, least squares over the leg's joints
    lift = 0.0
    for s, side in enumerate(("right", "left")):
        jacp, jacr = np.zeros((3, model.nv)), np.zeros((3, model.nv))
        foot = model.body(f"{side}_foot").id
        mujoco.mj_jac(model, data, jacp, jacr, data.xpos[foot], foot)
        jacobian = np.vstack([jacp, jacr])[:, [6 + j for j in body.LEG_JOINTS[s]]]
        wrench = np.linalg.lstsq(-jacobian.T, torques[s], rcond=None)[0]
        np.testing.assert_allclose(-jacobian.T @ wrench, torques[s], atol=0.05)
        lift += wrench[2]
    assert lift == pytest.approx((body.TOTAL_MASS_KG - config.grounded_mass_kg) * 9.81, rel=1e-3)


def test_arms_bear_their_own_weight_and_squeeze(standing):
    model, data, state = standing
    resting = arm_torques(state, torch.zeros(1), torch.zeros(1), BalanceConfig())[0].double().numpy()
    gravity = mujoco.MjData(model)
    gravity.qpos[:] = data.qpos
    mujoco.mj_forward(model, gravity)
    for s in range(2):
        np.testing.assert_allclose(resting[s], gravity.qfrc_bias[[6 + j for j in body.ARM_JOINTS[s]]], atol=0.05)
    squeezing = arm_torques(state, torch.ones(1), torch.zeros(1), BalanceConfig())[0].double().numpy() - resting
    between = data.body("left_hand").xpos - data.body("right_hand").xpos
    for s, (side, sign) in enumerate((("right", 1), ("left", -1))):
        jacobian = np.zeros((3, model.nv))
        hand = model.body(f"{side}_hand").id
        mujoco.mj_jac(model, data, jacobian, None, data.xpos[hand], hand)
        force = sign * BalanceConfig().squeeze_force * between / np.linalg.norm(between)
        expected = jacobian[:, [6 + j for j in body.ARM_JOINTS[s]]].T @ force
        np.testing.assert_allclose(squeezing[s], expected, atol=0.05)


def test_arm_angles_are_read_from_the_links(standing):
    _, data, state = standing
    expected = torch.tensor(data.qpos[7:][6:14], dtype=torch.float32).view(1, 2, 4)
    torch.testing.assert_close(measured_arm_angles(state, expected + 0.3), expected, atol=1e-4, rtol=0)


def test_the_load_is_found_from_the_servos():
    # hands before the chest; a hanging arm could not feel a weight
    hands = torch.tensor([[[0.36, -0.18, 1.0], [0.36, 0.18, 1.0]]])
    joints, _ = standing_pose(torch.tensor([0.84]), torch.tensor([0.0]), hands)
    qpos = standing_qpos((0, 0), 0.0)
    qpos[7:] = joints[0].numpy()
    physics = MujocoPhysics([ground_model()], num_threads=1)
    physics.reset([0], [qpos])
    state = read_proprioception(proprioception(physics.state()))
    config = BalanceConfig()
    memory = start_reference(state, neutral_intent(1), GaitConfig())
    memory.squeeze[:] = 1.0
    angles = measured_arm_angles(state, memory.arm_angles)
    memory.arm_angles = angles.clone()
    # servos that hold 40 N between the hands besides the arms, standing still
    held = arm_torques(state, torch.zeros(1), torch.full((1,), 40.0), config)
    kp = torch.stack([body.KP[j] for j in body.ARM_JOINTS])
    memory.arm_targets = angles + held / kp
    for _ in range(60):
        load = estimate_load(state, memory, config)
    assert load.item() == pytest.approx(40.0, rel=0.1)
    memory.squeeze[:] = 0.0
    for _ in range(60):
        load = estimate_load(state, memory, config)
    assert load.item() < 0.1
