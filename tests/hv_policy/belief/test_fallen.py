import math

import pytest
import torch

from hv_policy.belief.attitude import FACES, UPRIGHT, attitude_of
from hv_policy.belief.fallen import as_it_lies, measured_standing
from hv_policy.belief.outline import half_extent_m, outline_of

HALF_M = torch.tensor([[0.09, 0.17, 0.25]])


def turned(yaw_rad: float, roll_rad: float, about: int) -> torch.Tensor:
    """(1, 6) first two columns of a rotation: fallen by `roll_rad` about its own axis `about`, then turned."""
    c, s = math.cos(roll_rad), math.sin(roll_rad)
    fall = torch.eye(3)
    i, j = [k for k in range(3) if k != about]
    fall[i, i], fall[i, j], fall[j, i], fall[j, j] = c, -s, s, c
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)
    rotation = torch.tensor([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ fall
    return rotation[:, :2].T.reshape(1, 6)


@pytest.mark.parametrize("height_m", [0.25, 0.9])
def test_what_stands_is_as_high_as_its_middle_is_or_as_where_it_is_held(height_m):
    pose = turned(0.4, 0.0, 0)
    outline, attitude = outline_of(pose, HALF_M), attitude_of(pose)
    found = measured_standing(outline, attitude[:, FACES], torch.tensor([height_m]), torch.tensor([0.205]))
    torch.testing.assert_close(found, HALF_M, atol=1e-4, rtol=0)


@pytest.mark.parametrize(("roll_rad", "about", "upward"), [(0.0, 0, 2), (math.pi / 2, 0, 1), (-math.pi / 2, 1, 0)])
@pytest.mark.parametrize("yaw_rad", [0.2, 1.9])
def test_a_thing_that_fell_is_as_large_as_before(roll_rad, about, upward, yaw_rad):
    pose = turned(yaw_rad, roll_rad, about)
    truth, attitude = outline_of(pose, HALF_M), attitude_of(pose)
    blurred = truth + torch.tensor([[0.06, 0.02, -0.06]])
    height_m = HALF_M[:, upward]
    outline, found, height = as_it_lies(HALF_M, blurred, attitude, height_m + 0.015)
    yaws = torch.tensor([yaw_rad, yaw_rad + math.pi / 2])
    sides = [half_extent_m(x.expand(2, -1), yaws) for x in (outline, truth, blurred)]
    assert (sides[0] - sides[1]).abs().max() < 0.5 * (sides[2] - sides[1]).abs().max()
    assert (height - height_m).abs() < 0.01
    assert (float(found[0, UPRIGHT]) > 0.6) == (upward == 2)


def test_what_fits_no_way_to_lie_is_believed_as_it_is_seen():
    pose = turned(0.7, 0.0, 0)
    outline, attitude, height_m = outline_of(pose, 2 * HALF_M), attitude_of(pose), torch.tensor([0.4])
    found = as_it_lies(HALF_M, outline, attitude, height_m)
    for seen, before in zip(found, (outline, attitude, height_m), strict=True):
        torch.testing.assert_close(seen, before)
