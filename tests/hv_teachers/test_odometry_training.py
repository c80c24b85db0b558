import torch

from hv_policy.belief.odometry import rate_turn
from hv_sim.suites import load_suite
from hv_teachers.odometry_training import feel, train_odometry


def test_what_is_felt_is_what_happens_and_can_be_learned():
    tasks = load_suite("seen")[:32]
    felt = feel(tasks, seed=3, steps=400)
    assert felt.before.shape == felt.now.shape == (len(felt.turn_rad), 223)
    assert set(felt.env.tolist()) == set(range(32))
    assert felt.turn_rad.abs().max() < 0.35, "who starts anew has not turned"
    walking = (felt.env % 2 == 1).sum()
    assert 0.9 * 16 * (399 - 3) < walking < 16 * 399, "one pair less for each new start"
    assert (felt.turn_rad - rate_turn(felt.before, felt.now)).abs().median() < 0.005
    again = feel(tasks, seed=3, steps=5)
    torch.testing.assert_close(again.now[:32], felt.now[:32], atol=0, rtol=0)
    network, figures = train_odometry(felt, seed=0, steps=1000)
    assert figures["deg"] < 0.7 * figures["rate_deg"]
    assert not network.training
