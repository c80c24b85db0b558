"""The reference generator: what it plans, and that each robot's plan is its own."""

from dataclasses import fields

import pytest
import torch
from plain_ground import ground_model

from hv_policy.motor.gait import GaitConfig
from hv_policy.motor.intent import neutral_intent
from hv_policy.motor.proprioception import read_proprioception
from hv_policy.motor.reference import advance_reference, standing_pose, start_reference
from hv_sim.humanoid import standing_qpos
from hv_sim.mujoco_physics import MujocoPhysics
from hv_sim.observations import proprioception


@pytest.fixture(scope="module")
def standing():
    physics = MujocoPhysics([ground_model()] * 3, num_threads=1)
    physics.reset(range(3), [standing_qpos((0, 0), 0.5 * i) for i in range(3)])
    return read_proprioception(proprioception(physics.state()))


def test_standing_stays_standing(standing):
    intent, config = neutral_intent(3), GaitConfig()
    memory = start_reference(standing, intent, config)
    for _ in range(30):
        reference = advance_reference(memory, standing, intent, config)
    assert (reference.moving == 0).all()
    assert (reference.stance == 1).all()
    torch.testing.assert_close(reference.foot_target, standing.pos[:, [11, 14]], atol=0.02, rtol=0)


def test_walking_alternates_the_feet_and_never_crosses_them(standing):
    intent, config = neutral_intent(3), GaitConfig()
    intent[:, 0] = torch.tensor([0.3, 0.8, -0.3])
    intent[:, 1] = torch.tensor([0.0, 0.2, -0.3])
    memory = start_reference(standing, intent, config)
    swung, airborne = [], []
    for _ in range(90):
        reference = advance_reference(memory, standing, intent, config)
        swung.append(memory.swing.clone())
        airborne.append(reference.stance.sum(1))
        left, right = memory.foot_pos[:, 1], memory.foot_pos[:, 0]
        planned = torch.where((memory.swing == 1)[:, None], reference.foothold, left)
        other = torch.where((memory.swing == 1)[:, None], right, reference.foothold)
        # sideways in the reference's own heading: the left foot keeps to the left of the right one
        c, s = memory.yaw.cos(), memory.yaw.sin()
        apart = planned - other
        assert ((c * apart[:, 1] - s * apart[:, 0]) > 0.05).all()
    changes = (torch.stack(swung)[1:] != torch.stack(swung)[:-1]).sum(0)
    steps = 90 / 30 / config.step_duration_s
    assert ((changes - steps).abs() <= 1.5).all()
    assert (torch.stack(airborne) >= 1).all(), "both feet in the air"


def test_a_row_alone_is_the_row_among_others(standing):
    intent, config = neutral_intent(3), GaitConfig()
    intent[:, 0] = torch.tensor([0.0, 0.5, -0.2])
    memory = start_reference(standing, intent, config)
    alone = start_reference(
        type(standing)(*(getattr(standing, f.name)[1:2] for f in fields(standing))), intent[1:2], config
    )
    one = type(standing)(*(getattr(standing, f.name)[1:2] for f in fields(standing)))
    for _ in range(20):
        many = advance_reference(memory, standing, intent, config)
        single = advance_reference(alone, one, intent[1:2], config)
    assert torch.equal(many.joints[1:2], single.joints)
    picked = memory.select(torch.tensor([1]))
    torch.testing.assert_close(picked.anchor, alone.anchor, atol=1e-6, rtol=0)


def test_no_bending_while_stepping(standing):
    intent, config = neutral_intent(3), GaitConfig()
    intent[:, 0], intent[:, 3], intent[:, 4] = 0.6, 0.45, 1.2
    memory = start_reference(standing, intent, config)
    for _ in range(60):
        reference = advance_reference(memory, standing, intent, config)
    stepping = reference.moving > 0
    assert stepping.any()
    assert (memory.posture[stepping, 0] > config.walk_height_m - 0.06).all()


def test_standing_pose_is_balanced_and_reaches():
    height, pitch = torch.tensor([0.84, 0.6, 0.45]), torch.tensor([0.05, 0.8, 1.35])
    z = torch.tensor([0.95, 0.45, 0.2])
    hands = torch.stack([torch.stack([0.42 + 0 * z, s * (0.2 + 0 * z), z], -1) for s in (-1, 1)], 1)
    joints, lean = standing_pose(height, pitch, hands)
    physics = MujocoPhysics([ground_model()] * 3, num_threads=1)
    qpos = []
    for i in range(3):
        q = standing_qpos((0, 0), 0)
        q[2] = height[i]
        q[3], q[5] = torch.cos(lean[i] / 2), torch.sin(lean[i] / 2)
        q[7:] = joints[i].numpy()
        qpos.append(q)
    physics.reset(range(3), qpos)
    state = physics.state()
    assert (state.link_pos_w[:, [11, 14], 2] - 0.05).abs().max() < 0.01
    assert (state.link_pos_w[:, [5, 8]] - hands).norm(dim=-1).max() < 0.08
    com = read_proprioception(proprioception(state)).com[:, 0] - state.link_pos_w[:, [11, 14], 0].mean(1)
    assert ((com > -0.02) & (com < 0.10)).all(), "the centre of mass lies over the soles"
