"""What pictures say of a place is averaged over those that show it; the best place counts, and not a mean of places."""

import math

import pytest
import torch

from hv_policy.belief.spot_map import CELL_M, CELLS, DOUBT, MOST_WEIGHT, Detections, SpotMap

ORIGIN = torch.zeros(3)


def found(*rows: tuple[float, float, float, float]) -> Detections:
    table = torch.tensor(rows)
    return Detections(table[:, :2], table[:, 2], table[:, 3])


def test_looks_are_averaged_cell_by_cell():
    spots = SpotMap(2)
    said, weight = torch.zeros(CELLS, CELLS), torch.zeros(CELLS, CELLS)
    for pose, gaze, rows in (
        ((0.53, -0.31, 0.4), 0.217, [(2.0, 0.4, 0.3, 0.8), (1.0, 1.5, 1.2, 0.2)]),
        ((-0.2, 0.17, -1.1), -0.3, [(1.4, -0.4, 0.1, 0.9)]),
    ):
        spots.see(1, torch.tensor(pose), gaze, found(*rows))
        for i in range(CELLS):
            for j in range(CELLS):
                dx, dy = ((k + 0.5) * CELL_M - CELLS * CELL_M / 2 - pose[a] for a, k in enumerate((i, j)))
                c, s = math.cos(pose[2]), math.sin(pose[2])
                x, y = c * dx + s * dy, c * dy - s * dx
                away, turn = math.hypot(x, y), abs(math.remainder(math.atan2(y, x) - gaze, math.tau))
                shown = turn < math.radians(40.0) and 0.6 < away < 4.0
                mean = 0.0
                for at_x, at_y, deviation, seen in rows:
                    square = ((x - at_x) ** 2 + (y - at_y) ** 2) / min(max(deviation, 0.25), 1.0) ** 2
                    if square < 9:
                        mean += seen * math.exp(-square / 2) / max(1.0, deviation) ** 2 / len(rows)
                        shown = True
                said[i, j] += mean / (1 + away) ** 2
                weight[i, j] += shown / (1 + away) ** 2
    assert float(weight.max()) < MOST_WEIGHT
    torch.testing.assert_close(spots.said[1], said, atol=1e-5, rtol=1e-4)
    torch.testing.assert_close(spots.weight[1], weight, atol=1e-5, rtol=1e-4)
    assert float(spots.weight[0].sum()) == 0
    best = spots.likeliest(1)
    mean = said / (weight + DOUBT)
    assert best.mean == pytest.approx(float(mean.max()), abs=1e-5)
    at = divmod(int(mean.argmax()), CELLS)
    middle = torch.tensor([(k + 0.5) * CELL_M - CELLS * CELL_M / 2 for k in at])
    assert float((best.xy - middle).norm()) < 0.3


def test_at_first_nothing_is_likely_and_looks_that_agree_make_a_place_likely():
    spots = SpotMap(1)
    assert spots.likeliest(0).share < 0.05
    shares = []
    for _ in range(12):
        spots.see(0, ORIGIN, 0.0, found((2.0, 0.5, 0.4, 0.95)))
        shares.append(spots.likeliest(0).share)
    best = spots.likeliest(0)
    assert shares[0] < shares[3] < shares[-1]
    assert best.share > 0.9
    torch.testing.assert_close(best.xy, torch.tensor([2.0, 0.5]), atol=0.05, rtol=0)


def test_what_is_half_likely_does_not_become_certain_however_often_it_is_seen():
    spots = SpotMap(1)
    for _ in range(100):
        spots.see(0, ORIGIN, 0.0, found((2.0, 0.5, 0.4, 0.5)))
    assert spots.likeliest(0).mean == pytest.approx(0.5, abs=0.05)
    for _ in range(10):
        spots.see(0, ORIGIN, 0.0, found((2.0, -1.5, 0.4, 0.9)))  # seen now as something else
    torch.testing.assert_close(spots.likeliest(0).xy, torch.tensor([2.0, -1.5]), atol=0.25, rtol=0)


def test_near_looks_count_more_than_far_ones():
    spots = SpotMap(1)
    for _ in range(20):
        spots.see(0, ORIGIN, 0.0, found((3.0, 0.0, 0.4, 0.9)))
    near = torch.tensor([2.0, 0.0, 0.0])
    for _ in range(5):
        spots.see(0, near, 0.0, found((1.0, 0.0, 0.3, 0.1)))
    assert spots.likeliest(0).mean < 0.5


def test_what_should_be_in_the_picture_and_is_not_becomes_less_likely():
    spots = SpotMap(1)
    for _ in range(8):
        spots.see(0, ORIGIN, 0.0, found((2.0, 0.5, 0.4, 0.9)))
    before = spots.likeliest(0).mean
    turned = torch.tensor([0.0, 0.0, math.pi])
    spots.see(0, turned, 0.0, found((1.0, 0.0, 0.3, 0.0)))  # looks the other way, sees nothing
    assert spots.likeliest(0).mean == pytest.approx(before, abs=1e-3)
    for _ in range(12):
        spots.see(0, ORIGIN, 0.0, found((3.0, 0.0, 0.3, 0.0)))
    assert spots.likeliest(0).mean < 0.6 * before


def test_what_is_rejected_forgotten_and_known():
    spots = SpotMap(2)
    for _ in range(8):
        spots.see(0, ORIGIN, 0.0, found((2.0, 0.5, 0.4, 0.9)))
    spots.reject(0, torch.tensor([2.0, 0.5]))
    for _ in range(8):
        spots.see(0, ORIGIN, 0.0, found((2.0, 0.5, 0.2, 0.9)))
    assert spots.likeliest(0).mean < 0.2
    spots.forget(0)
    assert float(spots.said.sum()) == float(spots.weight.sum()) == 0
    spots.begin_at(0, torch.tensor([1.0, -2.0]), 0.3)
    best = spots.likeliest(0)
    torch.testing.assert_close(best.xy, torch.tensor([1.0, -2.0]), atol=0.05, rtol=0)
    assert best.share > 0.95
