import math

import pytest
import torch

from hv_policy.belief.floor_map import (
    CELL_M,
    LOOK_WEIGHT,
    MOST_EVIDENCE,
    FloorMap,
    cells_of,
    points_to_look_at,
)


def test_what_is_seen_lies_where_the_robot_looked():
    floor, pose = FloorMap(2), torch.tensor([1.0, 2.0, math.pi / 2])
    floor.see(1, pose, torch.tensor([[1.55, -0.05], [0.05, 1.05]]), torch.tensor([2.0, -2.0]))
    [taken, free] = cells_of(torch.tensor([[1.05, 3.55], [-0.05, 2.05]]))
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


def test_points_that_are_looked_at_cover_the_cells_around_in_two_turns():
    first, second = (points_to_look_at(turn) for turn in (0, 1))
    both = torch.cat([first, second]).unique(dim=0)
    assert both.norm(dim=-1).max() < 4.5
    assert len(cells_of(both).unique(dim=0)) > 0.97 * len(both)
    near = both[both.norm(dim=-1) < 1.7]
    assert all((points[:, None] == near).all(-1).any(0).all() for points in (first, second))
    assert len(first) + len(second) - len(both) == pytest.approx(torch.pi * 1.8**2 / CELL_M**2, rel=0.1)
    floor = FloorMap(2)
    floor.see(1, torch.zeros(3), first[:5], torch.ones(5))
    assert torch.equal(floor.points_to_look_at(0), first)
    assert torch.equal(floor.points_to_look_at(1), second)


def test_a_cell_gains_the_mean_of_what_is_seen_in_it():
    """Against a dictionary of lists."""
    torch.manual_seed(1)
    floor, pose = FloorMap(1), torch.tensor([0.4, -1.3, 2.1])
    points, logits = 6 * torch.rand(400, 2) - 3, 4 * torch.randn(400)
    floor.see(0, pose, points, logits)
    cos, sin = torch.cos(pose[2]), torch.sin(pose[2])
    turn = torch.stack([torch.stack([cos, sin]), torch.stack([-sin, cos])])
    there = points @ turn + pose[:2]
    told: dict[tuple[int, int], list[float]] = {}
    for cell, odds in zip(cells_of(there).tolist(), logits.tolist(), strict=True):
        told.setdefault(tuple(cell), []).append(LOOK_WEIGHT * min(max(odds, -3.0), 3.0))
    assert len(told) < 400
    wanted = torch.zeros_like(floor.evidence[0])
    for cell, values in told.items():
        wanted[cell] = sum(values) / len(values)
    torch.testing.assert_close(floor.evidence[0], wanted)
