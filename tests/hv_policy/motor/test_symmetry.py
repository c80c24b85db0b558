"""A robot and its mirror image are moved like a robot and its mirror image."""

import mujoco
import numpy as np
import torch

from hv_policy.motor import embodiment as body
from hv_policy.motor.intent import neutral_intent
from hv_policy.motor.prior import FEATURE_DIM, FEATURES, MotorPrior
from hv_policy.motor.symmetry import JOINTS, Reflection
from hv_sim.humanoid import ROBOT_NQ
from hv_sim.mujoco_physics import MujocoPhysics
from hv_sim.observations import Heading, proprioception
from hv_teachers.motor_scenes import compile_ground


def states(num, seed=0):
    """Upright robots in random poses and motion, and each one's mirror image; proprioception (num, 223) of both."""
    model = compile_ground(np.random.default_rng(0), None, randomize=False)
    rng = np.random.default_rng(seed)
    perm, sign = body.MIRROR_JOINTS.numpy(), body.MIRROR_JOINT_SIGN.numpy()
    seen = []
    for mirrored in (False, True):
        rng = np.random.default_rng(seed)
        physics = MujocoPhysics([model] * num, num_threads=1)
        qpos, qvel = [], []
        for _ in range(num):
            joints, speed = rng.normal(0, 0.15, 28), rng.normal(0, 0.5, 28)
            yaw, pitch = rng.normal(0, 1), rng.normal(0.1, 0.1)
            lin, ang = rng.normal(0, 0.4, 3), rng.normal(0, 0.4, 3)
            if mirrored:
                joints, speed, yaw = joints[perm] * sign, speed[perm] * sign, -yaw
                lin, ang = lin * [1, -1, 1], ang * [-1, 1, -1]
            quat = np.zeros(4)
            mujoco.mju_mulQuat(
                quat,
                np.array([np.cos(yaw / 2), 0, 0, np.sin(yaw / 2)]),
                np.array([np.cos(pitch / 2), 0, np.sin(pitch / 2), 0]),
            )
            qpos.append(np.concatenate([[0, 0, 0.9], quat, joints]))
            qvel.append(np.concatenate([lin, ang, speed]))
            assert len(qpos[-1]) == ROBOT_NQ
        physics.reset(np.arange(num), qpos, qvel)
        state = physics.state()
        seen.append(proprioception(state, Heading.of(state)).float())
    return seen


def test_reflected_proprioception_is_that_of_the_reflected_robot():
    here, there = states(8)
    torch.testing.assert_close(Reflection().proprioception()(here), there, atol=1e-5, rtol=1e-5)


def test_reflections_undo_themselves():
    assert len(FEATURES) == FEATURE_DIM
    for reflection in (FEATURES, JOINTS, Reflection().intent()):
        values = torch.randn(3, len(reflection))
        torch.testing.assert_close(reflection(reflection(values)), values)


def test_the_controller_does_not_favour_a_side():
    torch.manual_seed(0)
    priors = [MotorPrior(), MotorPrior()]
    with torch.no_grad():
        priors[0].residual.layers[-1].weight.normal_(0, 0.05)
    priors[1].load_state_dict(priors[0].state_dict())
    intent = neutral_intent(8)
    intent[:, :3] = torch.tensor([[0.5, 0.2, -0.4]])
    intent[:, 5:8] = torch.tensor([0.35, 0.25, 0.9])
    mirror = Reflection().intent()
    for step in range(6):
        here, there = states(8, seed=step)
        targets = priors[0](here, intent)
        reflected = priors[1](there, mirror(intent))
        walking = (priors[0].memory.moving > 0) & (priors[1].memory.moving > 0)
        # standing, the foot that swung last is the same for lack of a reason
        assert walking.sum() >= 6 or step == 0
        assert (priors[0].memory.moving == priors[1].memory.moving).all()
        if step:
            assert (priors[0].memory.swing == 1 - priors[1].memory.swing)[walking].all()
            gap = (JOINTS(targets)[walking] - reflected[walking]).abs()
            assert gap.max() < 0.02, "states drawn at random are far from any pose: rounding grows in them"
            assert gap.mean() < 1e-3
