from dataclasses import fields

import pytest
import torch

from hv_policy.belief import mirror
from hv_policy.belief.attitude import STANDS
from hv_policy.belief.camera import camera_position, pixel_rays, ray_directions
from hv_policy.belief.closer_look import (
    CELLS,
    FARTHEST_M,
    WIDE_M,
    Closer,
    CloserLook,
    look_closer,
    screen_through,
    view_axes,
)
from hv_policy.motor.proprioception import BodyState, read_proprioception
from hv_sim.observations import proprioception
from hv_sim.suites import load_suite
from hv_sim.world import RearrangeWorld

PLACES = torch.tensor([[1.2, 0.1, 0.2], [0.8, -0.3, 0.4]])


@pytest.fixture(scope="module")
def state() -> torch.Tensor:
    """(2, 223) of two robots that stand."""
    return proprioception(RearrangeWorld(load_suite("seen")[:2], num_threads=1).state)


@pytest.fixture(scope="module")
def body(state) -> BodyState:
    return read_proprioception(state)


def test_a_screen_stands_square_to_the_view_and_shows_what_is_behind_its_points(body):
    directions = ray_directions(body, pixel_rays(128))  # painted: which way each pixel looks
    pictures = directions.mT.unflatten(2, (128, 128))
    axes = view_axes(body, PLACES)
    screen = screen_through(pictures, body, PLACES, axes)
    torch.testing.assert_close(axes @ axes.mT, torch.eye(3).expand(2, 3, 3), atol=1e-5, rtol=0)
    assert (axes[:, 1, 2].abs() < 1e-6).all(), "left is level"
    assert (axes[:, 2, 2] > 0).all(), "up leads upward"
    for row, column in ((0, 0), (10, 30), (24, 24), (47, 5)):
        right, down = (((k + 0.5) / CELLS - 0.5) * WIDE_M for k in (column, row))
        point = PLACES - right * axes[:, 1] - down * axes[:, 2]
        shown = screen[:, 3, row, column] > 0
        looks = torch.nn.functional.normalize(point - camera_position(body), dim=1)
        found = screen[:, :3, row, column] + 0.5
        torch.testing.assert_close(found[shown], looks[shown], atol=0.02, rtol=0)
        torch.testing.assert_close(screen[:, 4, row, column], point[:, 2])
    assert (screen[:, 3] > 0).float().mean() > 0.5
    far = (PLACES - camera_position(body)).norm(dim=1)
    torch.testing.assert_close(screen[:, 5, 0, 0], far - 1.0)


def test_a_mirrored_screen_of_a_mirrored_picture_tells_the_mirrored_thing(state, body):
    torch.manual_seed(0)
    head, pictures, both = CloserLook().eval(), torch.rand(2, 3, 64, 64), torch.ones(2, dtype=torch.bool)
    here = read_proprioception(mirror.STATE.where(both, state))
    there = head(mirror.mirrored_pictures(pictures, both), here, mirror.POINT(PLACES), both)
    seen = head(pictures, body, PLACES)
    torch.testing.assert_close(there.at, mirror.POINT(seen.at), atol=1e-4, rtol=0)
    across = torch.tensor([1.0, -1.0, 1.0])  # of an outline and of faces what is left for right
    for name, flips in (("log_spread", 1.0), ("seen", 1.0), ("outline", across), ("attitude", across)):
        torch.testing.assert_close(getattr(there, name), flips * getattr(seen, name), atol=1e-3, rtol=1e-3)


class Finds(CloserLook):
    """Sees a thing at one place, whatever it looks at, if that is in reach."""

    def __init__(self, at: torch.Tensor) -> None:
        super().__init__()
        self.at = at

    def forward(self, pictures, body, at_h, mirrored=None):
        near = (self.at - at_h).norm(dim=1) < 0.5
        spread = torch.tensor([0.04, 0.02, 0.01]).log().expand(len(at_h), -1)
        shape = torch.tensor([0.4, 0.1, 0.5]).expand(len(at_h), -1), STANDS.expand(len(at_h), -1)
        return Closer(self.at.expand(len(at_h), -1), spread, torch.where(near, 3.0, -3.0), *shape)


def test_a_closer_look_tells_where_a_thing_is_only_where_it_found_it_and_was_wanted(body):
    pictures, at = torch.rand(2, 3, 64, 64), torch.tensor([1.1, 0.1, 0.25])
    looked = torch.stack([at + torch.tensor([0.1, 0.1, 0.0]), torch.tensor([1.1, -0.8, 0.2])])
    head, everyone = Finds(at), torch.ones(2, dtype=torch.bool)
    found = look_closer(head, pictures, body, looked, everyone)
    assert found.rows.tolist() == [0], "the second one looked elsewhere"
    torch.testing.assert_close(found.at_h, at[None])
    variance = (view_axes(body, at.repeat(2, 1))[0] * torch.tensor([[0.04], [0.02], [0.01]])).square().sum(0)
    variance[:2] = variance[:2].mean()
    torch.testing.assert_close(found.deviation_m[0], variance.sqrt())
    torch.testing.assert_close(found.outline, torch.tensor([[0.4, 0.1, 0.5]]))
    torch.testing.assert_close(found.attitude, STANDS[None])
    for place, wanted in ((looked, ~everyone), (looked - 5.0, everyone), (looked + FARTHEST_M, everyone)):
        none = look_closer(head, pictures, body, place, wanted)
        assert {len(getattr(none, f.name)) for f in fields(none)} == {0}
    far = look_closer(head, pictures, body, at + torch.tensor([[0.47, 0.0, 0.0], [0.2, 0.0, 0.0]]), everyone)
    assert far.rows.tolist() == [1], "what is farther away is another thing"
