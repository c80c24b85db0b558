import pytest
import torch

from hv_policy.belief.camera import project
from hv_policy.belief.closer_look import FARTHEST_M, REACH_M, CloserLook
from hv_policy.belief.closer_look_loss import closer_look_loss, looks_to_learn
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


def test_places_that_are_looked_at_are_mostly_within_reach_of_a_thing_in_view_that_can_be_carried(body):
    torch.manual_seed(0)
    boxes, in_view = torch.tensor([BOX, SOFA, FAR]).expand(COUNT, -1, -1), torch.ones(COUNT, 3, dtype=torch.bool)
    place, at, is_there, counts = looks_to_learn(body, boxes, in_view)
    apart = (place[:, :2] - torch.tensor(BOX[:2])).norm(dim=1)
    assert torch.equal(is_there, apart < REACH_M)
    assert 0.6 < is_there.float().mean() < 0.9
    assert 0.05 < (apart > 0.8).float().mean(), "somewhere else in the sofa"
    torch.testing.assert_close(at[is_there], torch.tensor(BOX[:3]).expand(int(is_there.sum()), -1))
    assert (counts <= project(body, place[:, None])[1][:, 0]).all()
    assert apart[is_there].max() > 0.25, "also those that are believed quite wrongly"
    assert not looks_to_learn(body, boxes, ~in_view)[2].any(), "what is hidden is not there"
    assert FAR[0] > FARTHEST_M
    assert not looks_to_learn(body, boxes[:, 1:], in_view[:, 1:])[2].any(), "furniture, and what is far away"


def test_it_is_learned_where_things_stand(body):
    torch.manual_seed(0)
    boxes, in_view = torch.tensor([BOX]).expand(COUNT, -1, -1), torch.ones(COUNT, 1, dtype=torch.bool)
    head, pictures = CloserLook(), torch.rand(1, 3, 64, 64).expand(COUNT, -1, -1, -1)
    optimizer = torch.optim.Adam(head.parameters(), lr=2e-3)
    losses = []
    for _ in range(25):
        loss, figures = closer_look_loss(head, pictures, body, boxes, in_view)
        optimizer.zero_grad()
        loss.mean().backward()
        optimizer.step()
        losses.append(float(loss.detach().mean()))
    assert losses[-1] < losses[0] - 0.1
    assert float(figures["closer_missed"]) < 0.1
