import math

import pytest
import torch

from hv_policy.belief import mirror
from hv_policy.belief.camera import camera_position, pixel_rays, ray_directions
from hv_policy.belief.closer_look import (
    CELLS,
    FARTHEST_M,
    WIDE_M,
    CloserLook,
    Refined,
    Thing,
    closer_loss,
    look_closer,
    screen_through,
    view_axes,
)
from hv_policy.belief.outline import outline_of
from hv_policy.belief.places import GOAL, MIDDLE, OBJECT
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
    outline = seen.outline * torch.tensor([1.0, -1.0, 1.0])
    torch.testing.assert_close(there.outline, outline, atol=1e-3, rtol=1e-3)
    for name in ("log_spread", "half_height_m", "above_m", "upright", "seen"):
        torch.testing.assert_close(getattr(there, name), getattr(seen, name), atol=1e-3, rtol=1e-3)


def truth(at: torch.Tensor) -> Thing:
    six = torch.tensor([[1.0, 0.0, 0.0, 0.0, 1.0, 0.0]]).repeat(2, 1)
    half = torch.tensor([[0.1, 0.2, 0.3]]).repeat(2, 1)
    return Thing(at, six, half, torch.tensor([0.1, math.nan]), torch.ones(2, dtype=torch.bool))


def test_who_sees_it_right_is_least_wrong_and_of_what_nobody_knows_nothing_is_asked(body):
    head = CloserLook().eval()
    seen, axes, true = head(torch.rand(2, 3, 64, 64), body, PLACES), view_axes(body, PLACES), truth(PLACES)
    right = vars(seen) | {
        "at": PLACES,
        "outline": outline_of(true.rotation_6d, true.half_extents_m),
        "half_height_m": torch.full((2,), 0.3),
        "above_m": torch.tensor([0.1, 0.7]),
        "upright": torch.ones(2),
        "seen": torch.full((2,), 3.0),
    }
    best, apart = closer_loss(type(seen)(**right), axes, true)
    torch.testing.assert_close(apart, torch.zeros(2, 3))
    for name, other in right.items():
        if name == "log_spread":
            continue
        worse, apart = closer_loss(type(seen)(**right | {name: other - 0.5}), axes, true)
        assert worse[0] > best[0] + 1e-3, name
        assert bool(worse[1] > best[1] + 1e-3) == (name != "above_m"), name
    moved = PLACES + 0.1 * axes[:, 0]
    _, apart = closer_loss(type(seen)(**right | {"at": moved}), axes, true)
    torch.testing.assert_close(apart, torch.tensor([[0.1, 0.0, 0.0]]).repeat(2, 1), atol=1e-5, rtol=0)


class Finds(CloserLook):
    """Sees a thing at one place, whatever it looks at, if that is in reach."""

    def __init__(self, at: torch.Tensor) -> None:
        super().__init__()
        self.at = at

    def forward(self, pictures, body, at_h, mirrored=None):
        found = super().forward(pictures, body, at_h, mirrored)
        near = (self.at - at_h).norm(dim=1) < 0.5
        found.at, found.seen = self.at.expand(len(at_h), -1), torch.where(near, 3.0, -3.0)
        found.log_spread = torch.full((len(at_h), 3), math.log(0.02))
        return found


def before() -> Refined:
    flags = torch.zeros(2, dtype=torch.bool)
    return Refined(flags, torch.full((2, 21), 5.0), torch.full((2, 21), 0.4), torch.zeros(2, 3), torch.zeros(2, 1))


def test_a_closer_look_replaces_what_is_known_of_the_object_alone_and_only_where_it_found_it(body):
    pictures, at = torch.rand(2, 3, 64, 64), torch.tensor([1.1, 0.1, 0.25])
    looked = torch.stack([at + torch.tensor([0.1, 0.1, 0.0]), torch.tensor([1.1, -0.8, 0.2])])
    head, everyone = Finds(at), torch.ones(2, dtype=torch.bool)
    found = look_closer(head, pictures, body, looked, everyone, before())
    assert found.is_so.tolist() == [True, False], "the second one looked elsewhere"
    torch.testing.assert_close(found.places[0, OBJECT], at)
    torch.testing.assert_close(found.spread[0, OBJECT], torch.full((3,), 0.02), atol=1e-4, rtol=0)
    untouched = torch.ones(21, dtype=torch.bool)
    untouched[OBJECT] = untouched[MIDDLE.stop - 1] = False
    assert (found.places[0, untouched] == 5.0).all()
    assert (found.spread[0, untouched] == 0.4).all()
    assert untouched[GOAL].all()
    assert (found.places[1] == 5.0).all()
    for place, wanted in ((looked, ~everyone), (looked - 5.0, everyone), (looked + FARTHEST_M, everyone)):
        assert not look_closer(head, pictures, body, place, wanted, before()).is_so.any()
