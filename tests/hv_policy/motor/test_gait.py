"""The compiled gait by itself; how it walks is tested with the reference, how it answers with the motor prior."""

import mujoco
import numpy as np
import torch
from plain_ground import ground_model, random_poses

from hv_policy.motor import embodiment as body
from hv_policy.motor.gait import GaitConfig, gait_of, loaded_com_at


def test_the_configuration_is_the_same_for_compiled_code():
    config = GaitConfig(sway_m=0.02)
    compiled = gait_of(config)
    assert compiled.sway_m == 0.02
    assert compiled.max_acceleration == config.max_acceleration
    assert gait_of(GaitConfig(sway_m=0.02)) is compiled


def test_the_centre_of_mass_is_mujocos_and_a_load_pulls_it_to_the_hands():
    model = ground_model()
    for qpos in random_poses(10, seed=4):
        data = mujoco.MjData(model)
        data.qpos[:] = qpos
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        ids = [model.body(name).id for name in body.BODY_NAMES]
        pos = torch.tensor(data.xpos[ids], dtype=torch.float32)[None].numpy()
        rot = torch.tensor(data.xmat[ids].reshape(-1, 3, 3), dtype=torch.float32)[None].numpy()
        alone = data.subtree_com[ids[0]]
        np.testing.assert_allclose(loaded_com_at(pos, rot, 0, 0.0), alone, atol=2e-3)
        load = 6.0 * body.GRAVITY
        whole = (body.TOTAL_MASS_KG * alone + 6.0 * pos[0, body.HANDS].mean(0)) / (body.TOTAL_MASS_KG + 6.0)
        np.testing.assert_allclose(loaded_com_at(pos, rot, 0, load), whole, atol=2e-3)
