import math

import pytest
import torch
from scipy.spatial.transform import Rotation

from hv_policy.belief.attitude import STANDS, attitude_of, face_yaw_rad, lies, turned_attitude

WALLS = torch.tensor([[1.0, 0.0]])


def six(rotation: Rotation) -> torch.Tensor:
    """(1, 6) first two columns."""
    return torch.tensor(rotation.as_matrix().T[:2].reshape(1, 6), dtype=torch.float32)


def about_z(yaw: float) -> Rotation:
    return Rotation.from_euler("z", yaw)


FALLS = [("x", 0.0), ("x", math.pi / 2), ("x", -math.pi / 2), ("y", math.pi / 2), ("y", math.pi)]


@pytest.mark.parametrize("yaw", [0.0, 0.3, -1.2, 2.9])
@pytest.mark.parametrize("fall", FALLS)
def test_faces_run_as_they_do_whichever_side_is_up(yaw, fall):
    attitude = attitude_of(six(about_z(yaw) * Rotation.from_euler(*fall)))
    expected = torch.tensor([[math.cos(4 * yaw), math.sin(4 * yaw), math.cos(fall[1])]])
    torch.testing.assert_close(attitude, expected, atol=1e-5, rtol=0)
    assert bool(lies(attitude)) == (fall[1] != 0)


def test_they_turn_with_the_frame():
    fallen = Rotation.from_euler("xz", [1.1, 0.2])  # leans: its faces are not certain
    turned = turned_attitude(attitude_of(six(fallen)), torch.tensor([0.7]))
    torch.testing.assert_close(turned, attitude_of(six(about_z(0.7) * fallen)), atol=1e-5, rtol=0)


def test_what_stands_is_turned_as_the_walls_are_unless_it_is_seen_not_to_be():
    def yaw_deg(yaw: float, size: float, upright: float) -> float:
        seen = torch.tensor([[size * math.cos(4 * yaw), size * math.sin(4 * yaw), upright]])
        return math.degrees(float(face_yaw_rad(seen, WALLS)))

    assert yaw_deg(0.1, 0.9, 1.0) == pytest.approx(0)  # as a picture errs
    assert yaw_deg(0.5, 0.5, 1.0) == pytest.approx(0)  # nor is it sure
    assert yaw_deg(0.5, 0.9, 1.0) == pytest.approx(math.degrees(0.5))
    assert yaw_deg(0.1, 0.5, 0.0) == pytest.approx(math.degrees(0.1))
    assert yaw_deg(0.5, 0.3, 0.0) == pytest.approx(0)
    assert not lies(STANDS[None])
