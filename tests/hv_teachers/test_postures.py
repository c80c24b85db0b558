"""Bending to reach, against the body's forward kinematics in plain MuJoCo."""

import mujoco
import numpy as np
import pytest
import torch

from hv_policy.motor.reference import standing_pose
from hv_sim.humanoid import add_humanoid, configure_physics
from hv_teachers.postures import reach_posture


def test_the_lower_the_hands_the_deeper_the_bend():
    height, pitch = reach_posture(torch.linspace(0.05, 1.2, 40))
    assert (height.diff() >= 0).all()
    assert (pitch.diff() <= 0).all()


def test_far_hands_need_a_deeper_bend_than_near_ones():
    z = torch.full((2,), 0.75)
    height, pitch = reach_posture(z, torch.tensor([0.25, 0.55]))
    assert height[1] < height[0] - 0.03
    assert pitch[1] > pitch[0] + 0.1


@pytest.mark.parametrize(("z", "ahead"), [(0.14, 0.40), (0.14, 0.48), (0.45, 0.45), (0.75, 0.45), (0.95, 0.45)])
def test_the_hands_arrive_in_the_bent_pose(z, ahead):
    spec = mujoco.MjSpec()
    add_humanoid(spec)
    configure_physics(spec)
    model = spec.compile()
    data = mujoco.MjData(model)
    height, pitch = reach_posture(torch.tensor([z]), torch.tensor([ahead]))
    from hv_policy.motor.reference import feet_ahead

    to_feet = float(feet_ahead(height, pitch))
    hands = torch.tensor([[[ahead + to_feet, -0.2, z], [ahead + to_feet, 0.2, z]]])
    joints, lean = standing_pose(height, pitch, hands)
    data.qpos[2] = height[0]
    data.qpos[3:7] = [np.cos(lean[0] / 2), 0, np.sin(lean[0] / 2), 0]
    data.qpos[7:35] = joints[0].numpy()
    mujoco.mj_kinematics(model, data)
    for k, name in enumerate(("right_hand", "left_hand")):
        np.testing.assert_allclose(data.body(name).xpos, hands[0, k].numpy(), atol=0.02)
    foot = np.mean([data.body(f"{s}_foot").xpos for s in ("left", "right")], 0)
    assert abs(foot[0] - to_feet) < 0.02
