import numpy as np

from hv_policy.belief.floor_map import CELL_M, CELLS, ORIGIN_M
from hv_policy.belief.ways import LOOKAHEAD_M, Window, place_to_look_from, room_here, step_back, way_to, way_to_stand
from hv_sim.paths import OccupancyGrid, path_length_m, plan_path

MIDDLES = ORIGIN_M + (np.arange(CELLS) + 0.5) * CELL_M


def room_with_a_wall() -> np.ndarray:
    """A free room of 8 x 8 m, and a wall across it at x = 1 that is open from y = 1.2 on."""
    x, y = np.meshgrid(MIDDLES, MIDDLES, indexing="ij")
    taken = (np.maximum(np.abs(x), np.abs(y)) > 4) | ((np.abs(x - 1) < 0.1) & (y < 1.2))
    return np.where(taken, 4.0, -4.0)


def test_a_way_leads_round_a_wall_and_is_as_long_as_a_star_says():
    evidence, start, goal = room_with_a_wall(), np.array([0.0, -1.0]), np.array([2.0, -1.0])
    way = way_to(evidence, start, goal)
    grid = OccupancyGrid(np.array([ORIGIN_M, ORIGIN_M]), CELL_M, evidence > 0)
    known = plan_path(grid.inflated(0.3), start, goal, grid.clearance_m())
    length = path_length_m(way.points)
    assert abs(length - path_length_m(np.vstack([start, known]))) < 0.15 * length
    np.testing.assert_allclose(way.points[[0, -1]], [start, goal])
    assert Window.around(evidence, way.points).room(way.points).min() > 0.2


def test_the_waypoint_lies_ahead_and_is_walked_to_straight():
    evidence = room_with_a_wall()
    way = way_to(evidence, np.array([0.0, -1.0]), np.array([2.0, -1.0]))
    window = Window.around(evidence, way.points)
    xy = way.points[0]
    for _ in range(200):
        waypoint, is_last = way.waypoint(xy)
        assert np.linalg.norm(waypoint - xy) < LOOKAHEAD_M + 0.1
        assert window.room(xy + np.linspace(0, 1, 20)[:, None] * (waypoint - xy)).min() > 0.1
        if is_last and np.linalg.norm(waypoint - xy) < 0.05:
            break
        xy = xy + 0.05 * (waypoint - xy) / np.linalg.norm(waypoint - xy)
    np.testing.assert_allclose(xy, [2.0, -1.0], atol=0.06)


def test_a_stand_is_reached_from_straight_behind_and_then_not_left_again():
    evidence, stand = room_with_a_wall(), np.array([0.4, -1.0, 0.0])  # facing the wall
    way = way_to_stand(evidence, np.array([-1.0, 1.5]), stand, np.array([0.85, -1.0]))
    before = step_back(Window.around(evidence, stand[None, :2]), stand)
    assert before[0] < 0.3
    assert np.abs(way.points[-3:, 1] + 1.0).max() < 1e-6
    onward = way_to_stand(evidence, np.array([0.3, -0.98]), stand, None)
    assert path_length_m(onward.points) < 0.15


def test_what_is_to_be_picked_up_is_not_walked_over():
    evidence = np.full((CELLS, CELLS), -4.0)
    thing, stand = np.array([1.0, 0.0]), np.array([1.55, 0.0, np.pi])  # beyond the thing, looking back at it
    way = way_to_stand(evidence, np.array([-1.0, 0.0]), stand, thing)
    assert np.linalg.norm(way.points - thing, axis=1).min() > 0.4
    straight = way_to_stand(evidence, np.array([-1.0, 0.0]), stand, None)
    assert np.linalg.norm(straight.points - thing, axis=1).min() < 0.1


def test_floor_that_was_never_seen_is_walked_round_where_that_is_no_detour():
    seen = np.full((CELLS, CELLS), -4.0)
    half, start, goal = seen.copy(), np.array([0.0, 0.0]), np.array([2.0, 0.0])
    half[(np.abs(MIDDLES - 1) < 0.5)[:, None] & (MIDDLES < 0.3)[None]] = 0.0  # unseen, to the right of the way
    assert way_to(half, start, goal).points[:, 1].max() > 0.15
    assert np.abs(way_to(seen, start, goal).points[:, 1]).max() < 0.11


def test_who_looks_elsewhere_goes_where_the_way_is_open_and_it_has_not_been():
    evidence, here = room_with_a_wall(), np.array([0.3, -1.0])  # a wall is ahead
    first = place_to_look_from(evidence, here, 1.5, [])
    assert abs(np.linalg.norm(first - here) - 1.5) < 1e-6
    assert first[0] < 0.3
    second = place_to_look_from(evidence, first, 1.5, [here])
    assert np.linalg.norm(second - here) > 1.5


def test_room_at_a_wall_and_the_direction_away_from_it():
    clearance, away = room_here(room_with_a_wall(), np.array([0.4, -1.0]))
    assert abs(clearance - 0.5) < 0.11
    assert away[0] < -0.9
