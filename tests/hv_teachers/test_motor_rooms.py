"""The teachers' work in rooms, with a residual: with the motor prior's own it is what they do alone."""

import pytest
import torch

from hv_policy.motor.prior import FEATURE_DIM, MotorPriorConfig, load_shipped_motor_prior
from hv_sim.task import load_task
from hv_teachers.motor_critic import CRITIC_EXTRA
from hv_teachers.motor_env import MotorEnv, MotorEnvConfig
from hv_teachers.motor_practice import Practices
from hv_teachers.motor_rooms import MotorRooms, RoomsConfig
from hv_teachers.motor_training import MotorTraining, MotorTrainingConfig
from hv_teachers.sight_noise import SightNoiseConfig
from hv_teachers.teacher import load_shipped_teacher
from hv_teachers.teacher_env import TeacherEnv, TeacherEnvConfig

TASKS = [load_task("living_room_1"), load_task("living_room_2")]
EXACT = RoomsConfig(noise=SightNoiseConfig(), num_threads=1)


@pytest.fixture
def rooms() -> MotorRooms:
    return MotorRooms(load_shipped_motor_prior(), load_shipped_teacher().networks[0], TASKS, EXACT, seed=3)


def test_with_its_own_residual_the_prior_does_what_it_does_under_the_teachers(rooms):
    network = load_shipped_teacher().networks[0]
    alone = TeacherEnv(
        TASKS, TeacherEnvConfig(num_envs=2, num_threads=1), network.config, load_shipped_motor_prior(), 3
    )
    for _ in range(40):
        with torch.no_grad():
            rooms.step(rooms.prior.residual(rooms.features))
            seen = alone.look()
            alone.act(seen, alone.decide(network, seen).action)
    ours, theirs = rooms.env.world.state, alone.world.state
    assert float(theirs.link_lin_vel_w.norm(dim=-1).max()) > 0.3  # they walk
    torch.testing.assert_close(ours.link_pos_w, theirs.link_pos_w, atol=1e-3, rtol=0)


def test_what_is_seen_and_paid(rooms):
    assert rooms.features.shape == (2, FEATURE_DIM)
    assert rooms.critic_extra.shape == (2, len(CRITIC_EXTRA))
    reward, failed, timed_out, terms = rooms.step(torch.zeros(2, 28))
    assert not failed.any()
    assert not timed_out.any()
    torch.testing.assert_close(reward, torch.stack(list(terms.values())).sum(0))
    assert float(terms["load"].min()) > 0.2  # nobody has touched it
    assert set(terms) >= {"velocity", "hands", "placed", "dropped"}


def test_who_falls_begins_anew(rooms):
    before = rooms.env.episodes.clone()
    failed = torch.zeros(2, dtype=torch.bool)
    for _ in range(60):
        failed |= rooms.step(torch.tensor([[4.0], [0.0]]).expand(2, 28))[1]
    assert failed.tolist() == [True, False]
    assert int(rooms.env.episodes[0]) > int(before[0])
    assert int(rooms.env.episodes[1]) == int(before[1])


def test_parts_side_by_side_do_what_they_do_alone(rooms):
    def ground() -> MotorEnv:
        return MotorEnv(load_shipped_motor_prior(), MotorEnvConfig(num_envs=3, num_threads=1), 5)

    alone, both = ground(), Practices([ground(), rooms])
    assert both.num_envs == 5
    residual = 0.1 * torch.randn(5, 28, generator=torch.Generator().manual_seed(0))
    reward, failed, timed_out, terms = both.step(residual)
    own, *_ = alone.step(residual[:3])
    torch.testing.assert_close(reward[:3], own)
    assert terms["dropped"].shape == failed.shape == timed_out.shape == both.dropped.shape == (5,)
    torch.testing.assert_close(both.features[:3], alone.features)


def test_a_few_iterations_of_both():
    config = MotorTrainingConfig(
        steps_per_iteration=2,
        prior=MotorPriorConfig(hidden=(16,)),
        env=MotorEnvConfig(num_envs=4, num_threads=1),
        rooms=RoomsConfig(num_envs=2, tasks="living_room_1", num_threads=1),
    )
    row = MotorTraining(config).iterate()
    assert row["steps_per_s"] > 0
    assert "dropped" in row
