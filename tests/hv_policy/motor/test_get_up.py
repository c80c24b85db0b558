"""Getting up: who lies is noticed, who bends or squats is not, and left is right in a mirror."""

import math

import numpy as np
import torch
from plain_ground import play

from hv_policy.motor import embodiment as body
from hv_policy.motor.get_up import (
    LIES_STEPS,
    STANDING,
    STANDS_STEPS,
    GettingUp,
    GetUpNetwork,
    is_on_left_side,
    seen_lying,
    stands,
    targets_of,
)
from hv_policy.motor.intent import neutral_intent
from hv_policy.motor.prior import (
    MotorPrior,
    MotorPriorConfig,
    load_motor_prior,
    load_shipped_motor_prior,
    save_motor_prior,
)
from hv_policy.motor.proprioception import read_proprioception
from hv_policy.motor.symmetry import JOINTS, Reflection
from hv_sim.humanoid import standing_qpos
from hv_sim.mujoco_physics import MujocoPhysics
from hv_sim.observations import proprioception
from hv_teachers.get_up_practice import lying_poses
from hv_teachers.motor_scenes import compile_ground


def lying(turns: list[tuple[float, float, float, float]]) -> torch.Tensor:
    """(N, 223) of robots that hang in the air at .3 m, turned as these quaternions say."""
    physics = MujocoPhysics([compile_ground(np.random.default_rng(0), None, randomize=False)] * len(turns))
    poses = []
    for turn in turns:
        pose = standing_qpos((0.0, 0.0), 0.0)
        pose[2], pose[3:7] = 0.3, turn
        poses.append(pose)
    physics.reset(np.arange(len(turns)), poses)
    return proprioception(physics.state())


HALF = math.sqrt(0.5)
FACE_DOWN, FACE_UP, ON_THE_LEFT, ON_THE_RIGHT = (
    (HALF, 0.0, HALF, 0.0), (HALF, 0.0, -HALF, 0.0), (HALF, -HALF, 0.0, 0.0), (HALF, HALF, 0.0, 0.0),
)  # fmt: skip


def some_network() -> GetUpNetwork:
    torch.manual_seed(0)
    network = GetUpNetwork((16,))
    torch.nn.init.normal_(network.layers[-1].weight, std=0.1)
    return network.eval()


def test_the_pose_that_answers_are_counted_from_is_that_of_who_stands():
    assert torch.equal(STANDING, torch.tensor(standing_qpos((0, 0), 0.0)[7:], dtype=torch.float32))
    torch.testing.assert_close(targets_of(torch.zeros(1, 28))[0], STANDING)
    far = targets_of(torch.full((1, 28), 9.0))[0]
    torch.testing.assert_close(far, body.JOINT_HIGH + 0.3)


def test_who_lies_is_noticed_after_a_while_and_who_stands_is_let_go():
    getting_up = GettingUp(some_network())
    getting_up.reset(torch.tensor([2]))  # before it has seen any
    down = lying([FACE_DOWN, FACE_UP, ON_THE_LEFT])
    up = proprioception(play(MotorPrior(), lambda _: neutral_intent(3), 3, 30)[0].state())
    assert stands(read_proprioception(up)).all()
    assert not stands(read_proprioception(down)).any()
    for step in range(LIES_STEPS):
        rows, targets = getting_up(torch.cat([down[:2], up[:1]]))
        assert rows.tolist() == ([0, 1] if step == LIES_STEPS - 1 else []), step
    assert targets.shape == (2, 28)
    for step in range(STANDS_STEPS):
        assert getting_up.active.tolist() == [True, True, False], step
        getting_up(torch.cat([up[:1], down[1:2], up[:1]]))
    assert getting_up.active.tolist() == [False, True, False]
    getting_up.reset(torch.tensor([1]))
    assert not getting_up.active.any()


def test_who_squats_and_bends_does_not_lie():
    prior = MotorPrior()
    lowest = []

    def squat(step: int) -> torch.Tensor:
        intent = neutral_intent(3)
        intent[:, 3], intent[:, 4] = torch.tensor([0.42, 0.6, 0.84]), torch.tensor([1.4, 1.4, 1.2])
        intent[:, 5:11] = torch.tensor([0.5, 0.2, 0.1, 0.5, -0.2, 0.1])
        return intent

    prior.getting_up = GettingUp(some_network())
    call = GettingUp.__call__

    class Watched(GettingUp):
        def __call__(self, observed):
            lowest.append(self.active.any() if len(self.active) else torch.tensor(False))
            return call(self, observed)

    prior.getting_up = Watched(some_network())
    play(prior, squat, 3, 120)
    assert len(lowest) == 120
    assert not torch.stack(lowest).any()


def test_left_is_right_in_a_mirror():
    observed = lying([ON_THE_LEFT, ON_THE_RIGHT])
    state = read_proprioception(observed)
    assert is_on_left_side(state).tolist() == [True, False]
    reflect = Reflection().proprioception()
    one, other = GettingUp(some_network()), GettingUp(some_network())
    for _ in range(LIES_STEPS + 3):
        _, targets = one(observed)
        _, reflected = other(reflect(observed))
    torch.testing.assert_close(JOINTS(targets), reflected, atol=1e-5, rtol=1e-5)
    mirrored = seen_lying(observed, torch.zeros(2, 28), is_on_left_side(state))
    torch.testing.assert_close(mirrored[:, :223], torch.stack([reflect(observed[:1])[0], observed[1]]))


def test_a_prior_with_it_saves_and_loads_and_one_without_stays_as_it_was(tmp_path):
    prior = MotorPrior(MotorPriorConfig(hidden=(8,), get_up_hidden=(16, 8))).eval()
    torch.nn.init.normal_(prior.get_up.layers[-1].weight, std=0.1)
    save_motor_prior(prior, tmp_path / "p.safetensors")
    loaded = load_motor_prior(tmp_path / "p.safetensors")
    down = lying([FACE_DOWN, FACE_UP])
    for _ in range(LIES_STEPS + 1):
        targets, again = prior(down, neutral_intent(2)), loaded(down, neutral_intent(2))
    assert torch.equal(targets, again)
    assert loaded.getting_up.active.all()
    without = MotorPrior(MotorPriorConfig(hidden=(8,), get_up_hidden=()))
    assert without.getting_up is None
    assert not [name for name in without.state_dict() if name.startswith("get_up")]


def test_everybody_gets_up_and_stands():
    rng = np.random.default_rng(5)
    poses, speeds = lying_poses(rng, 24, 1)
    physics = MujocoPhysics([compile_ground(rng, None) for _ in poses], num_threads=1)
    physics.reset(np.arange(len(poses)), list(poses), list(speeds))
    prior = load_shipped_motor_prior()
    for _ in range(300):
        physics.step(prior(proprioception(physics.state()), neutral_intent(len(poses))))
    assert stands(read_proprioception(proprioception(physics.state()))).float().mean() > 0.9
    assert prior.getting_up.active.float().mean() < 0.1


def test_what_a_copy_does_leaves_the_other_alone():
    prior, down = load_shipped_motor_prior(), lying([FACE_DOWN, FACE_UP])
    for _ in range(LIES_STEPS):
        prior(down, neutral_intent(2))
    copied = prior.copied()
    assert copied.getting_up.active.all()
    copied.reset()
    assert prior.getting_up.active.all()
    assert copied.residual is prior.residual
