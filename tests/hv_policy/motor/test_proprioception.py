"""What is read back from the 223 numbers, against MuJoCo."""

import mujoco
import numpy as np
import pytest
import torch
from plain_ground import ground_model, random_poses

from hv_policy.motor.proprioception import read_proprioception
from hv_sim.mujoco_physics import MujocoPhysics
from hv_sim.observations import proprioception


@pytest.fixture(scope="module")
def moving():
    model = ground_model()
    qpos = random_poses(8, seed=4)
    physics = MujocoPhysics([model] * 8, num_threads=1)
    physics.reset(range(8), list(qpos), list(np.random.default_rng(5).normal(0, 0.5, (8, 34))))
    return physics


def test_poses_and_velocities_come_back(moving):
    state = moving.state()
    read = read_proprioception(proprioception(state))
    yaw = torch.atan2(state.link_rot_w[:, 0, 1, 0], state.link_rot_w[:, 0, 0, 0])
    c, s, o = yaw.cos(), yaw.sin(), torch.zeros_like(yaw)
    to_heading = torch.stack([c, s, o, -s, c, o, o, o, o + 1], -1).view(-1, 1, 3, 3)
    origin = state.link_pos_w[:, :1] * torch.tensor([1.0, 1.0, 0.0])

    def turned(v):
        return (to_heading @ v[..., None])[..., 0]

    torch.testing.assert_close(read.pos, turned(state.link_pos_w - origin), atol=1e-5, rtol=0)
    torch.testing.assert_close(read.rot, to_heading @ state.link_rot_w, atol=1e-5, rtol=0)
    torch.testing.assert_close(read.lin_vel, turned(state.link_lin_vel_w), atol=1e-5, rtol=0)
    torch.testing.assert_close(read.ang_vel, turned(state.link_ang_vel_w), atol=1e-5, rtol=0)


def test_centre_of_mass_and_heading_rate(moving):
    state = moving.state()
    read = read_proprioception(proprioception(state))
    for env in range(8):
        model, data = moving.model(env), moving.data(env)
        mujoco.mj_forward(model, data)
        height = data.subtree_com[1, 2]
        assert read.com[env, 2].item() == pytest.approx(height, abs=2e-4)
        before = np.arctan2(data.body("pelvis").xmat[3], data.body("pelvis").xmat[0])
        mujoco.mj_integratePos(model, data.qpos, data.qvel, 1e-5)
        mujoco.mj_kinematics(model, data)
        after = np.arctan2(data.body("pelvis").xmat[3], data.body("pelvis").xmat[0])
        assert read.heading_rate[env].item() == pytest.approx((after - before) / 1e-5, abs=5e-3)


def test_another_width_is_refused():
    with pytest.raises(ValueError, match="proprioception: last dimension is 222; valid: 223"):
        read_proprioception(torch.zeros(1, 222))
