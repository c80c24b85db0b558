import numpy as np

from hv_policy.belief.floor_map import CELL_M, CELLS, ORIGIN_M
from hv_policy.belief.stands import Stand, choose_stand, stand_distance_m
from hv_policy.belief.ways import Reach
from hv_sim.navigation import stand_distance_m as known_distance_m

YAWS = np.arange(4) * np.pi / 2
MIDDLES = ORIGIN_M + (np.arange(CELLS) + 0.5) * CELL_M


def floor_with(taken: np.ndarray) -> np.ndarray:
    return np.where(taken, 4.0, -4.0)


def along(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return x[:, None] & y[None]


def choose(evidence, robot, at, depth=0.3, width=0.3, hint=None, before=None, keeps=False, failed=()):
    depths, widths = np.broadcast_to(depth, 4), np.broadcast_to(width, 4)
    reach = Reach.of(evidence, np.array(robot), np.array(at)[:2], 0.3)
    stand = choose_stand(reach, np.array(at), YAWS, depths, widths, hint, before, keeps, failed)
    return stand.xy_yaw, stand.number


def test_distances_are_those_of_the_routes():
    for depth in (0.1, 0.3, 0.5):
        assert stand_distance_m(depth, False) == known_distance_m(depth, 0.7)
        assert stand_distance_m(depth, True) == known_distance_m(depth, 0.0)


def test_the_nearest_side_is_taken_facing_the_thing():
    stand, number = choose(floor_with(np.zeros((CELLS, CELLS), bool)), [-2.0, 0.2], [0.0, 0.0, 0.9])
    assert number == 0
    np.testing.assert_allclose(stand, [-0.35, 0.0, 0.0], atol=1e-9)


def test_a_side_at_a_wall_is_not_taken():
    wall = along((MIDDLES < -0.3) & (MIDDLES > -0.8), np.abs(MIDDLES) < 2)
    stand, number = choose(floor_with(wall), [-2.0, 0.2], [0.0, 0.0, 0.9])
    assert number in (1, 3)
    assert abs(stand[0]) < 0.01


def test_a_table_edge_keeps_the_robot_back():
    table = along(np.abs(MIDDLES) < 0.3, np.abs(MIDDLES) < 0.6)
    stand, number = choose(floor_with(table), [-2.0, 0.0], [-0.1, 0.0, 0.9])
    assert number == 0
    assert -0.63 < stand[0] < -0.44
    near = Stand(np.array([-0.45, 0.0, 0.0]), 0, 0.0)
    kept, _ = choose(floor_with(table), [-2.0, 0.0], [-0.1, 0.0, 0.9], before=near, keeps=True)
    np.testing.assert_allclose(kept[:2], [-0.45, 0.0], atol=1e-9)


def test_what_is_too_wide_that_way_is_taken_from_another_side_and_choices_are_kept():
    free = floor_with(np.zeros((CELLS, CELLS), bool))
    at = [0.0, 0.0, 0.9]
    assert choose(free, [-2.0, 0.2], at, width=np.array([0.7, 0.3, 0.7, 0.3]))[1] in (1, 3)
    assert choose(free, [-1.0, -0.9], at)[1] == 0
    assert choose(free, [-1.0, -0.9], at, before=Stand(np.array([0.0, -0.35, np.pi / 2]), 1, 0.0))[1] == 1
    assert choose(free, [-1.0, -0.9], at, hint=np.pi / 2)[1] == 1


def test_a_side_that_is_near_but_behind_a_barrier_is_not_taken():
    barrier = along((MIDDLES > -1.6) & (MIDDLES < -1.4), (MIDDLES > -4) & (MIDDLES < 0.6))
    pocket = along((MIDDLES > -1.6) & (MIDDLES < -0.2), (MIDDLES > 0.4) & (MIDDLES < 0.6))
    assert choose(floor_with(np.zeros((CELLS, CELLS), bool)), [-2.2, 0.0], [0.0, 0.0, 0.9])[1] == 0
    assert choose(floor_with(barrier | pocket), [-2.2, 0.0], [0.0, 0.0, 0.9])[1] != 0


def test_where_it_did_not_work_out_another_side_is_worth_a_detour():
    free, at = floor_with(np.zeros((CELLS, CELLS), bool)), [0.0, 0.0, 0.9]
    assert choose(free, [-2.0, 0.2], at)[1] == 0
    assert choose(free, [-2.0, 0.2], at, failed=[0.1])[1] == 3
    assert choose(free, [-2.0, 0.2], at, failed=[0.1, -np.pi / 2])[1] == 0  # the other one is a long way
    assert choose(free, [-2.0, 0.2], at, failed=[0.0, 0.1, -np.pi / 2])[1] == 1
