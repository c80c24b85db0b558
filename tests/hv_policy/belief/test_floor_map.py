import math

import torch

from hv_policy.belief.floor_map import CELL_M, MOST_EVIDENCE, FloorMap, cells_of, points_to_look_at


def test_what_is_seen_lies_where_the_robot_looked():
    floor, pose = FloorMap(2), torch.tensor([1.0, 2.0, math.pi / 2])
    floor.see(1, pose, torch.tensor([[1.5, 0.0], [0.0, 1.0]]), torch.tensor([2.0, -2.0]))
    [taken, free] = cells_of(torch.tensor([[1.0, 3.5], [0.0, 2.0]]) + 1e-4)
    assert floor.evidence[1][tuple(taken)] > 0
    assert floor.evidence[1][tuple(free)] < 0
    assert (floor.evidence[1] != 0).sum() == 2
    assert (floor.evidence[0] == 0).all()


def test_evidence_adds_up_but_not_for_ever_and_can_be_taken_back():
    floor, pose, there = FloorMap(1), torch.zeros(3), torch.tensor([[1.05, 0.05]])
    cell = tuple(cells_of(there)[0])
    found = []
    for odds in [3.0] * 12 + [-3.0] * 12:
        floor.see(0, pose, there, torch.tensor([odds]))
        found.append(float(floor.evidence[0][cell]))
    assert found[0] < found[1] < MOST_EVIDENCE
    assert found[11] == MOST_EVIDENCE
    assert found[23] < 0


def test_where_the_robot_stands_is_free():
    floor = FloorMap(1)
    floor.evidence[:] = 4.0
    floor.stand(0, torch.tensor([0.53, -0.52]))
    free = (floor.evidence[0] < 0).nonzero() * CELL_M
    assert 9 <= len(free) <= 25
    assert floor.evidence[0][tuple(cells_of(torch.tensor([[0.53, -0.52]]))[0])] < 0


def test_points_that_are_looked_at_cover_the_cells_around():
    points = points_to_look_at()
    assert points.norm(dim=-1).max() < 4.5
    assert len(cells_of(points).unique(dim=0)) > 0.97 * len(points)
