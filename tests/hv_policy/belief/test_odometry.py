import torch

from hv_policy.belief.belief import Belief
from hv_policy.belief.odometry import Odometry, load_odometry, rate_turn, save_odometry
from hv_policy.motor.proprioception import read_proprioception
from hv_sim.observations import Heading
from hv_sim.suites import load_suite
from hv_sim.world import RearrangeWorld
from hv_teachers.teacher import load_shipped_teacher


def test_keeps_count_of_a_real_walk_and_adding_up_rates_does_not():
    """The teacher plays for 20 s; what was counted is compared with where the robots are."""
    world = RearrangeWorld(load_suite("unseen")[:4], num_threads=1)
    world.reset(seeds=[3, 4, 5, 6])
    teacher, odometry = load_shipped_teacher(), load_odometry()
    counted, by_rates = Belief(4), Belief(4)
    start, heading = world.state.link_pos_w[:, 0, :2].clone(), Heading.of(world.state)
    yaw = torch.atan2(heading.sin, heading.cos)
    held, before = torch.zeros(4, dtype=torch.bool), None
    with torch.no_grad():
        for step in range(600):
            state = world.observe().proprioception.clone()
            for belief, turns in ((counted, odometry), (by_rates, rate_turn)):
                turn = torch.zeros(4) if before is None else turns(before, state)
                belief.move(read_proprioception(state), turn, held)
            before = state
            if step < 599:
                world.step(teacher(world))
    there = world.state.link_pos_w[:, 0, :2] - start
    c, s = yaw.cos(), yaw.sin()
    truth = torch.stack([c * there[:, 0] + s * there[:, 1], c * there[:, 1] - s * there[:, 0]], -1)
    now = torch.atan2(world.heading.sin, world.heading.cos) - yaw
    wrong, wrong_by_rates = ((b.pose[:, 2] - now).sin().abs().mean() for b in (counted, by_rates))
    assert wrong < 0.05
    assert wrong < 0.5 * wrong_by_rates
    assert (counted.pose[:, :2] - truth).norm(dim=-1).max() < 0.25


def test_who_stands_still_does_not_turn():
    world = RearrangeWorld(load_suite("seen")[:1], num_threads=1)
    state = world.observe().proprioception
    assert load_odometry()(state, state).abs().max() < 0.01


def test_a_file_brings_back_the_same_network(tmp_path):
    torch.manual_seed(0)
    odometry, felt = Odometry(), torch.randn(3, 223)
    save_odometry(odometry, tmp_path / "o.safetensors")
    torch.testing.assert_close(load_odometry(tmp_path / "o.safetensors")(felt, felt + 0.1), odometry(felt, felt + 0.1))
