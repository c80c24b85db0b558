import math

import pytest
import torch

from hv_policy.belief.attitude import STANDS, attitude_of
from hv_policy.belief.camera import project
from hv_policy.belief.closer_look import FARTHEST_M, REACH_M, Closer, CloserLook, view_axes
from hv_policy.belief.closer_look_loss import Looked, Things, closer_look_loss, closer_loss, looks_to_learn
from hv_policy.belief.outline import half_extent_m, outline_of
from hv_policy.motor.proprioception import BodyState, read_proprioception
from hv_sim.observations import proprioception
from hv_sim.suites import load_suite
from hv_sim.world import RearrangeWorld

COUNT = 400
BOX = [1.2, 0.1, 0.2, 0.1, 0.15, 0.2, 0.3]
SOFA, FAR = [1.4, 0.9, 0.4, 0.9, 0.4, 0.4, 0.0], [4.0, 0.0, 0.2, 0.1, 0.1, 0.2, 0.0]
UPRIGHT_POSE = torch.tensor([[math.cos(0.3), math.sin(0.3), 0.0, -math.sin(0.3), math.cos(0.3), 0.0]])
FALLEN_POSE = torch.tensor([[1.0, 0.0, 0.0, 0.0, 0.0, 1.0]])
"""Turned by a quarter about its own x axis: its y axis is upward, its z axis across."""


@pytest.fixture(scope="module")
def body() -> BodyState:
    """Of robots that stand, all alike."""
    state = proprioception(RearrangeWorld(load_suite("seen")[:1], num_threads=1).state)
    return read_proprioception(state.expand(COUNT, -1))


def things_of(*boxes: list[float], near: list[bool], pose: torch.Tensor = UPRIGHT_POSE, count: int = COUNT) -> Things:
    """The first of them is the task's object."""
    rows = torch.tensor(boxes).expand(count, -1, -1)
    first = rows[:, 0]
    exists = torch.ones(rows.shape[:2], dtype=torch.bool)
    things = Things.of(rows, exists, first[:, :3], pose.expand(count, -1), first[:, 3:6])
    things.near = torch.tensor(near).expand(count, -1)
    return things


def test_what_stands_is_as_its_box_is_and_what_fell_as_it_lies():
    stands = things_of(BOX, SOFA, near=[True, False], count=1)
    half = torch.tensor([BOX[3:6]])
    assert stands.fell.tolist() == [-1]
    torch.testing.assert_close(stands.boxes, torch.tensor([[BOX, SOFA]]))
    torch.testing.assert_close(stands.outline[:, 0], outline_of(UPRIGHT_POSE, half), atol=1e-5, rtol=0)
    torch.testing.assert_close(stands.attitude[:, 0], attitude_of(UPRIGHT_POSE), atol=1e-5, rtol=0)
    fell = things_of(BOX, SOFA, near=[True, False], pose=FALLEN_POSE, count=1)
    assert fell.fell.tolist() == [0]
    torch.testing.assert_close(fell.boxes[0, 0], torch.tensor([*BOX[:3], 0.1, 0.2, 0.15, 0.0]), atol=1e-4, rtol=0)
    torch.testing.assert_close(fell.boxes[0, 1], torch.tensor(SOFA))
    wide = [float(half_extent_m(fell.outline[:, 0], torch.tensor([yaw]))) for yaw in (0.0, math.pi / 2)]
    assert wide == pytest.approx([0.1, 0.2], abs=1e-4)
    torch.testing.assert_close(fell.attitude[0, 0], torch.tensor([1.0, 0.0, 0.0]), atol=1e-5, rtol=0)


def test_places_that_are_looked_at_are_mostly_within_reach_of_a_thing_in_view_that_can_be_carried(body):
    torch.manual_seed(0)
    looked = looks_to_learn(body, things_of(BOX, SOFA, near=[True, False]))
    apart = (looked.place[:, :2] - torch.tensor(BOX[:2])).norm(dim=1)
    there = looked.is_there
    assert torch.equal(there, apart < REACH_M)
    assert 0.7 < there.float().mean() < 0.95
    assert (apart > 0.45).any(), "also elsewhere"
    torch.testing.assert_close(looked.at[there], torch.tensor(BOX[:3]).expand(int(there.sum()), -1))
    assert (looked.counts <= project(body, looked.place[:, None])[1][:, 0]).all()
    assert apart[there].max() > 0.25, "also those that are believed quite wrongly"
    assert not looks_to_learn(body, things_of(BOX, near=[False])).is_there.any(), "what is hidden is not there"
    assert FAR[0] > FARTHEST_M


def test_what_fell_is_looked_at_more_often_than_what_stands_beside_it(body):
    torch.manual_seed(0)
    beside = [1.2, -0.9, *BOX[2:]]
    shares = [
        (looks_to_learn(body, things_of(BOX, beside, near=[True, True], pose=pose)).at[:, 1] > 0).float().mean()
        for pose in (UPRIGHT_POSE, FALLEN_POSE)
    ]
    assert 0.35 < shares[0] < 0.65 < shares[1] < 0.95


def test_who_sees_it_right_is_least_wrong_and_where_nothing_is_only_that_counts(body):
    places = torch.tensor([[1.2, 0.1, 0.2], [0.8, -0.3, 0.4]])
    axes, both = view_axes(body.rows(torch.arange(2)), places), torch.ones(2, dtype=torch.bool)
    shape = torch.tensor([0.3, 0.1, 0.5]).expand(2, -1), STANDS.expand(2, -1)
    spread, sees = torch.full((2, 3), math.log(0.05)), torch.full((2,), 3.0)
    right = Closer(places, spread, sees, *shape)
    wrongs = (
        Closer(places + 0.1 * axes[:, 0], spread, sees, *shape),
        Closer(places, spread, sees, shape[0] + 0.2, shape[1]),
        Closer(places, spread, sees, shape[0], torch.tensor([0.0, 1.0, 1.0]).expand(2, -1)),
        Closer(places, spread, sees, shape[0], torch.tensor([0.0, 0.0, 0.2]).expand(2, -1)),
    )
    unseen = Closer(places, spread, -sees, *shape)
    truths = (Looked(places, places, *shape, *how) for how in ((both, both), (~both, both), (both, ~both)))
    truth, nothing, blind = truths
    best, apart = closer_loss(right, axes, truth)
    torch.testing.assert_close(apart, torch.zeros(2, 3))
    torch.testing.assert_close(closer_loss(wrongs[0], axes, truth)[1], torch.tensor([[0.1, 0.0, 0.0]]).repeat(2, 1))
    for wrong in (*wrongs, unseen):
        assert (closer_loss(wrong, axes, truth)[0] > best + 0.1).all()
        assert (closer_loss(wrong, axes, blind)[0] == 0).all()
    absent = [closer_loss(one, axes, nothing)[0] for one in (right, *wrongs, unseen)]
    assert all(torch.equal(one, absent[0]) for one in absent[:-1])
    assert (absent[-1] < absent[0]).all()


def test_it_is_learned_where_things_are_and_how_wide(body):
    torch.manual_seed(0)
    things = things_of(BOX, near=[True])
    head, pictures = CloserLook(), torch.rand(1, 3, 64, 64).expand(COUNT, -1, -1, -1)
    optimizer = torch.optim.Adam(head.parameters(), lr=2e-3)
    losses, widths = [], []
    for _ in range(25):
        loss, figures = closer_look_loss(head, pictures, body, things)
        optimizer.zero_grad()
        loss.mean().backward()
        optimizer.step()
        losses.append(float(loss.detach().mean()))
        widths.append(float(figures["closer_width_m"]))
    assert losses[-1] < losses[0] - 0.1
    assert widths[-1] < 0.7 * widths[0]
    assert float(figures["closer_missed"]) < 0.1
