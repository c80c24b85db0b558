import math

import torch

from hv_policy.belief.attitude import STANDS, lies
from hv_policy.belief.belief import UNKNOWN, Belief, BeliefConfig
from hv_policy.belief.places import GOAL, GROUPS, OBJECT, PLACES_DIM
from hv_policy.motor import embodiment
from hv_policy.motor.proprioception import read_proprioception
from hv_sim.observations import proprioception
from hv_sim.suites import load_suite
from hv_sim.world import RearrangeWorld

NOTHING_HELD = torch.zeros(1, dtype=torch.bool)
NO_TURN = torch.zeros(1)


def standing_body():
    world = RearrangeWorld(load_suite("seen")[:1], num_threads=1)
    return read_proprioception(proprioception(world.state))


def test_what_stands_still_stays_where_it_is_while_the_robot_walks_and_turns():
    body, belief = standing_body(), Belief(1)
    body.lin_vel[:] = 0
    body.ang_vel[:] = 0
    belief.move(body, NO_TURN, NOTHING_HELD)
    places = torch.zeros(1, PLACES_DIM)
    places[0, :3] = torch.tensor([2.0, 1.0, 0.7])
    places[0, 14] = 1.0
    belief.measure(torch.tensor([0]), places, torch.full_like(places, 0.01))
    body.lin_vel[:, embodiment.PELVIS, 0] = 0.6
    for _ in range(31):
        belief.move(body, NO_TURN, NOTHING_HELD)
    seen = belief.now()
    torch.testing.assert_close(seen[0, :3], torch.tensor([1.4, 1.0, 0.7]), atol=0.02, rtol=0)
    body.lin_vel[:] = 0
    for _ in range(31):
        belief.move(body, torch.full((1,), math.pi / 60), NOTHING_HELD)
    seen = belief.now()
    torch.testing.assert_close(seen[0, :3], torch.tensor([1.0, -1.4, 0.7]), atol=0.1, rtol=0)
    torch.testing.assert_close(seen[0, 14:16], torch.tensor([0.0, -1.0]), atol=0.1, rtol=0)


def test_the_filter_weighs_as_kalmans_equations_say():
    config = BeliefConfig(correlation=1.0, looks=1e9)
    belief, mean, variance = Belief(1, config), 0.0, UNKNOWN
    generator = torch.Generator().manual_seed(0)
    for spread in (0.5, 0.1, 0.3):
        measured = torch.randn(1, PLACES_DIM, generator=generator)
        belief.measure(torch.tensor([0]), measured, torch.full((1, PLACES_DIM), spread))
        gain = variance / (variance + spread**2)
        mean, variance = mean + gain * (float(measured[0, 2]) - mean), (1 - gain) * variance
        assert abs(float(belief.places[0, 2]) - mean) < 1e-4
        torch.testing.assert_close(belief.variance[0], torch.full((len(GROUPS),), variance), atol=1e-5, rtol=1e-3)


def test_a_hundred_pictures_of_an_empty_wall_are_two():
    belief, one = Belief(1, BeliefConfig(looks=2.0)), torch.tensor([0])
    wall, sight = torch.full((1, PLACES_DIM), 1.5), torch.full((1, PLACES_DIM), 0.05)
    nowhere, there = torch.zeros(1, PLACES_DIM), torch.full((1, PLACES_DIM), 3.0)
    for _ in range(100):
        belief.measure(one, nowhere, wall)
    assert float(belief.variance.min()) >= 1.5**2 / 2 - 1e-4
    belief.measure(one, there, sight)
    assert float((belief.places - there).abs().max()) < 0.1  # one sight of it outweighs them all
    for _ in range(20):
        belief.measure(one, nowhere, wall)
    assert float((belief.places - there).abs().max()) < 0.2  # and is not forgotten
    assert float(belief.variance.max()) < 0.1**2


def test_what_is_carried_goes_where_the_hands_go():
    body, belief = standing_body(), Belief(1)
    body.lin_vel[:] = 0
    body.ang_vel[:] = 0
    holds = ~NOTHING_HELD
    belief.move(body, NO_TURN, holds)
    places = torch.zeros(1, PLACES_DIM)
    places[0, OBJECT] = torch.tensor([0.4, 0.0, 0.9])
    belief.measure(torch.tensor([0]), places, torch.full_like(places, 0.01))
    body.pos[:, embodiment.HANDS, 2] += 0.3
    belief.move(body, NO_TURN, holds)
    torch.testing.assert_close(belief.now()[0, OBJECT], torch.tensor([0.4, 0.0, 1.2]), atol=1e-3, rtol=0)
    body.lin_vel[:, embodiment.PELVIS, 0] = 0.5
    for _ in range(20):
        belief.move(body, NO_TURN, holds)
    torch.testing.assert_close(belief.now()[0, OBJECT], torch.tensor([0.4, 0.0, 1.2]), atol=1e-3, rtol=0)


def test_forgetting_and_doubting_concern_the_environments_named():
    belief = Belief(3)
    belief.measure(torch.arange(3), torch.zeros(3, PLACES_DIM), torch.full((3, PLACES_DIM), 0.01))
    belief.forget(torch.tensor([0]))
    belief.doubt(torch.tensor([1]), belief.config.doubt)
    assert (belief.variance[0] == UNKNOWN).all()
    assert belief.variance[1, 0] > 0.4
    assert belief.variance[1, 2] < 0.01  # the goal is where it was
    assert (belief.variance[2] < 0.01).all()
    belief.forget(torch.tensor([2]), GOAL)
    assert (belief.variance[2, [2, 3]] == UNKNOWN).all()
    assert belief.variance[2, 0] < 0.01  # the object is where it was
    belief.forget(torch.tensor([1]), OBJECT)
    assert (belief.variance[1, [0, 1]] == UNKNOWN).all()
    assert belief.variance[1, 2] < 0.01


def test_outline_and_walls_stay_where_they_are_while_the_robot_turns():
    belief, one, stands = Belief(1, BeliefConfig()), torch.tensor([0]), STANDS[None]
    wide_ahead, along_the_walls = torch.tensor([[0.9, 0.0, 0.1]]), torch.tensor([[1.0, 0.0]])
    belief.measure_shape(one, wide_ahead, stands, torch.ones(1))
    belief.measure_compass(one, along_the_walls)
    belief.pose[0, 2] = math.pi / 2
    belief.measure_shape(one, torch.tensor([[0.1, 0.0, 0.9]]), stands, torch.ones(1))  # the same from another side
    torch.testing.assert_close(belief.outline, wide_ahead, atol=1e-5, rtol=0)
    belief.measure_compass(one, along_the_walls)
    torch.testing.assert_close(belief.compass, along_the_walls, atol=1e-5, rtol=0)
    belief.forget(one)
    assert belief.shape_weight[0] == 0
    belief.measure_shape(one, wide_ahead, stands, torch.ones(1))  # another thing, at once
    torch.testing.assert_close(belief.outline, torch.tensor([[0.1, 0.0, 0.9]]), atol=1e-5, rtol=0)


def test_what_fell_over_is_seen_anew_and_what_is_asked_for_next_is_believed_to_stand():
    belief, both = Belief(2), torch.tensor([0, 1])
    lying, square = torch.tensor([[0.0, 1.0, 0.1]]).repeat(2, 1), torch.tensor([[0.5, 0.0, 0.5]]).repeat(2, 1)
    assert not lies(belief.attitude).any()
    belief.pose[1, 2] = math.pi / 8
    belief.measure_shape(both, square, STANDS.repeat(2, 1), 5 * torch.ones(2))
    belief.doubt(both, 0.3)
    belief.measure_shape(both, square, lying, torch.ones(2))
    assert lies(belief.attitude).all()
    expected = torch.tensor([[0.0, 1.0, 0.1], [-1.0, 0.0, 0.1]])  # the second robot is turned by half of 45 degrees
    torch.testing.assert_close(belief.attitude, expected, atol=1e-5, rtol=0)
    belief.forget(torch.tensor([0]))
    assert lies(belief.attitude).tolist() == [False, True]


def test_walls_that_seem_to_turn_are_drift_of_odometry():
    belief, one = Belief(1), torch.tensor([0])
    walls = torch.tensor([[math.cos(0.8), math.sin(0.8)]])
    for _ in range(10):
        belief.measure_compass(one, walls)
    belief.pose[0, 2] = math.pi / 2 + 0.1  # it turned by a quarter, and counted too much
    for _ in range(60):
        belief.measure_compass(one, walls)
    assert abs(float(belief.pose[0, 2]) - math.pi / 2) < 0.005
    torch.testing.assert_close(belief.compass, walls)
    belief.pose[0, 2] += 0.1
    belief.measure_compass(one, 0.1 * walls)  # edges that do not agree tell nothing
    assert abs(float(belief.pose[0, 2]) - math.pi / 2 - 0.1) < 0.005
