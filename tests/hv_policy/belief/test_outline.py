import math

import torch

from hv_policy.belief.outline import (
    compass_yaw_rad,
    half_extent_m,
    outline_of,
    turned_outline,
)


def columns(yaw: float, toppled: bool = False) -> torch.Tensor:
    """(1, 6) first two columns of a rotation about z; toppled: its x axis points up."""
    c, s = math.cos(yaw), math.sin(yaw)
    if toppled:
        return torch.tensor([[0.0, 0.0, 1.0, -s, c, 0.0]])
    return torch.tensor([[c, s, 0.0, -s, c, 0.0]])


def test_extents_along_the_sides_come_back_and_a_half_turn_changes_nothing():
    half = torch.tensor([[0.3, 0.1, 0.2]])
    for yaw in (0.0, 0.4, 2.0):
        outline = outline_of(columns(yaw), half)
        torch.testing.assert_close(half_extent_m(outline, torch.tensor([yaw])), half[:, 0])
        torch.testing.assert_close(half_extent_m(outline, torch.tensor([yaw + math.pi / 2])), half[:, 1])
        torch.testing.assert_close(outline_of(columns(yaw + math.pi), half), outline)
        torch.testing.assert_close(turned_outline(outline_of(columns(0.0), half), torch.tensor([yaw])), outline)


def test_what_lies_on_its_side_has_the_outline_of_what_is_level():
    half = torch.tensor([[0.3, 0.1, 0.2]])  # its x axis points up: the others span the outline
    outline = outline_of(columns(0.4, toppled=True), half)
    torch.testing.assert_close(half_extent_m(outline, torch.tensor([0.4 + math.pi / 2])), half[:, 1])
    torch.testing.assert_close(half_extent_m(outline, torch.tensor([0.4])), half[:, 2])


def test_a_compass_is_the_same_after_a_quarter_turn():
    compass = torch.tensor([[math.cos(4 * 0.3), math.sin(4 * 0.3)]])
    torch.testing.assert_close(compass_yaw_rad(compass), torch.tensor([0.3]))
    turned = torch.tensor([[math.cos(4 * (0.3 + math.pi / 2)), math.sin(4 * (0.3 + math.pi / 2))]])
    torch.testing.assert_close(turned, compass, atol=1e-5, rtol=0)
    torch.testing.assert_close(compass_yaw_rad(turned), torch.tensor([0.3]))
