import pytest
import torch

from hv_policy.belief.camera import project
from hv_policy.belief.closer_look import FARTHEST_M, REACH_M, CloserLook
from hv_policy.belief.closer_look_loss import closer_look_loss, looks_to_learn, things_of
from hv_policy.belief.places import MIDDLE, OBJECT, PLACES_DIM
from hv_policy.motor.proprioception import BodyState, read_proprioception
from hv_sim.observations import proprioception
from hv_sim.suites import load_suite
from hv_sim.world import RearrangeWorld

COUNT = 400
BOX = [1.2, 0.1, 0.2, 0.1, 0.15, 0.2, 0.3]
SOFA, FAR = [1.4, 0.9, 0.4, 0.9, 0.4, 0.4, 0.0], [4.0, 0.0, 0.2, 0.1, 0.1, 0.2, 0.0]


@pytest.fixture(scope="module")
def body() -> BodyState:
    """Of robots that stand, all alike."""
    state = proprioception(RearrangeWorld(load_suite("seen")[:1], num_threads=1).state)
    return read_proprioception(state.expand(COUNT, -1))


def things(boxes: list[list[float]], of: int):
    """Those with boxes, the task's object being number `of`, fallen to its side."""
    known = torch.tensor(boxes).expand(COUNT, -1, -1)
    places = torch.zeros(COUNT, PLACES_DIM)
    places[:, OBJECT], places[:, MIDDLE.stop - 1] = known[:, of, :3], 0.07
    fallen = torch.tensor([0.0, 1.0, 0.0, 0.0, 0.0, 1.0]).expand(COUNT, -1)
    return things_of(known, places, fallen, torch.tensor([0.3, 0.1, 0.2]).expand(COUNT, -1))


def test_of_the_tasks_object_it_is_known_how_it_lies_and_where_it_is_held_and_furniture_is_not_carried():
    known, is_object = things([BOX, SOFA], of=0)
    assert is_object[0].tolist() == [True, False]
    assert known.is_there[0].tolist() == [True, False]
    assert known.rotation_6d[0, 0].tolist() == [0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
    torch.testing.assert_close(known.half_extents_m[0], torch.tensor([[0.3, 0.1, 0.2], [0.9, 0.4, 0.4]]))
    assert known.above_m[0, 0] == pytest.approx(0.07)
    assert known.above_m[0, 1].isnan()


def test_places_that_are_looked_at_are_mostly_within_reach_of_a_thing_in_view(body):
    torch.manual_seed(0)
    known, is_object = things([BOX, SOFA, FAR], of=0)
    in_view = torch.ones(COUNT, 3, dtype=torch.bool)
    place, there, counts = looks_to_learn(body, known, in_view, is_object)
    apart = (place[:, :2] - torch.tensor(BOX[:2])).norm(dim=1)
    assert torch.equal(there.is_there, apart < REACH_M)
    assert 0.75 < there.is_there.float().mean() < 0.95
    torch.testing.assert_close(there.at_h[there.is_there][0], torch.tensor(BOX[:3]))
    assert (counts <= project(body, place[:, None])[1][:, 0]).all()
    assert apart[there.is_there].max() > 0.25, "also those that are believed quite wrongly"
    _, there, _ = looks_to_learn(body, known, ~in_view, is_object)
    assert not there.is_there.any(), "what is hidden is not there"
    alone, own = things([FAR, SOFA], of=0)
    assert FAR[0] > FARTHEST_M
    assert not looks_to_learn(body, alone, in_view[:, :2], own)[1].is_there.any()


def test_it_is_learned_where_things_stand(body):
    torch.manual_seed(0)
    known, is_object = things([BOX], of=0)
    in_view, pictures = torch.ones(COUNT, 1, dtype=torch.bool), torch.rand(1, 3, 64, 64).expand(COUNT, -1, -1, -1)
    head = CloserLook()
    optimizer = torch.optim.Adam(head.parameters(), lr=2e-3)
    found = []
    for _ in range(25):
        loss, figures = closer_look_loss(head, pictures, body, known, in_view, is_object)
        optimizer.zero_grad()
        loss.mean().backward()
        optimizer.step()
        found.append({name: float(value) for name, value in figures.items()} | {"loss": float(loss.detach().mean())})
    assert found[-1]["loss"] < found[0]["loss"] - 0.5
    assert found[-1]["closer_held_m"] < found[0]["closer_held_m"]
