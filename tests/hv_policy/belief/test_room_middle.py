"""The middle of rooms whose walls are known, however they stand in the map, and none of rooms that are half seen."""

import math

import pytest
import torch

from hv_policy.belief.floor_map import CELL_M, CELLS, ORIGIN_M
from hv_policy.belief.room_middle import room_middle

CENTERS = torch.stack(
    torch.meshgrid(*2 * [(torch.arange(CELLS) + 0.5) * CELL_M + ORIGIN_M], indexing="ij"), -1
)


def a_room(yaw: float, middle: tuple[float, float], size: tuple[float, float]) -> tuple[torch.Tensor, torch.Tensor]:
    """(X, Y) whether a cell lies inside, and (X, Y, 2) where in the room's own frame."""
    c, s = math.cos(yaw), math.sin(yaw)
    away = CENTERS - torch.tensor(middle)
    own = torch.stack([c * away[..., 0] + s * away[..., 1], c * away[..., 1] - s * away[..., 0]], -1)
    return (own.abs() < torch.tensor(size) / 2).all(-1), own


def compass_of(yaw: float) -> torch.Tensor:
    return torch.tensor([math.cos(4 * yaw), math.sin(4 * yaw)])


@pytest.mark.parametrize("yaw", [0.0, 0.3, -0.7, 1.2])
def test_it_is_half_way_between_the_walls(yaw):
    inside, own = a_room(yaw, (1.3, -0.8), (5.2, 6.1))
    evidence = torch.where(inside, -3.0, 2.0)
    wardrobe = inside & (own[..., 0] > 2.0) & (own[..., 1].abs() < 1.0)
    evidence[wardrobe] = 3.0
    evidence[~inside & (own.abs() > torch.tensor([3.2, 3.7])).any(-1)] = 0.0  # nobody sees through walls
    evidence[5, 7] = -3.0  # a mistake
    found = room_middle(evidence, compass_of(yaw))
    assert found is not None
    torch.testing.assert_close(found, torch.tensor([1.3, -0.8]), atol=0.1, rtol=0)


def test_a_room_that_is_half_seen_has_none_yet():
    inside, own = a_room(0.2, (0.0, 0.0), (5.0, 5.0))
    evidence = torch.where(inside, -3.0, 2.0)
    evidence[own[..., 0] > 1.0] = 0.0
    assert room_middle(evidence, compass_of(0.2)) is None
    assert room_middle(torch.zeros(CELLS, CELLS), compass_of(0.0)) is None
