"""What cannot be carried is no object, whatever it is called."""

import torch

from hv_policy.belief.perception import GOAL_QUERY, OBJECT_QUERY, Perception
from hv_policy.belief.perception_size import PerceptionSize
from hv_sim.observations import proprioception
from hv_sim.suites import load_suite
from hv_sim.world import RearrangeWorld


@torch.no_grad()
def test_the_object_is_pointed_at_where_something_can_be_carried(monkeypatch):
    torch.manual_seed(0)
    perception = Perception(PerceptionSize(), 64, ["box"], 16, 0.0).eval()
    state = proprioception(RearrangeWorld(load_suite("seen")[:1], num_threads=1).state)
    picture, (words, is_word) = torch.rand(1, 3, 64, 64), perception.text(["put the box on the sofa."])
    sight = perception.look(picture, state)
    parts = sight.tokens.shape[1]
    pointing = []
    for movable in (torch.full((1, parts), 30.0), torch.where(torch.arange(parts) < 10, 0.0, -30.0)[None]):
        monkeypatch.setattr(perception, "find_movable", lambda sight, movable=movable: movable)
        pointing.append(perception.judge(sight, words, is_word).pointing.exp())
    everywhere, somewhere = pointing
    torch.testing.assert_close(everywhere[:, GOAL_QUERY], somewhere[:, GOAL_QUERY])
    before, after = everywhere[0, OBJECT_QUERY], somewhere[0, OBJECT_QUERY]
    assert float(after[11:].sum()) < 1e-6
    share = before[1:11] * 0.5  # as likely as not that it can be carried
    expected = torch.cat([before[:1], share]) / (before[0] + share.sum())
    torch.testing.assert_close(after[:11], expected, atol=1e-5, rtol=1e-4)
