"""The ring of imitation samples, on disk and in memory, and a network that learns a known rule from it."""

import torch

from hv_policy.decision.memory import NUM_PHASES
from hv_policy.decision.network import DecisionConfig, DecisionNetwork
from hv_policy.decision.sight import ANCHOR_DIM, SIGHT_DIM
from hv_teachers.imitation import ImitationBuffer, Samples, SharedSamples, imitation_loss


def samples(num: int, seed: int) -> Samples:
    """A rule to be learned: the phase goes on when the second sight is positive; the hands go to one of two places."""
    generator = torch.Generator().manual_seed(seed)
    sights = torch.randn(num, SIGHT_DIM, generator=generator)
    anchors = torch.randn(num, ANCHOR_DIM, generator=generator).clamp(-1.4, 1.4)
    before, after = torch.randn(num, 18, generator=generator), torch.randn(num, 18, generator=generator)
    before[:, 0] = torch.randint(NUM_PHASES - 1, (num,), generator=generator).float()
    before[:, 1] = after[:, 1] = 1.0
    phase = before[:, 0].long() + (sights[:, 1] > 0)
    after[:, 0] = phase.float()
    places = anchors.view(num, 7, 2, 3)
    hands = torch.where((phase % 2 == 0)[:, None, None], places[:, 2], places[:, 5])
    action = torch.zeros(num, 14)
    action[:, 5:8], action[:, 8:11] = hands[:, 1] / 0.1, hands[:, 0] / 0.1
    action[:, 0] = phase.float() / 5
    return Samples(sights.half(), anchors.half(), torch.zeros(num, dtype=torch.int32), before, after, phase, action)


def test_learns_a_rule():
    torch.manual_seed(0)
    network = DecisionNetwork(DecisionConfig(hidden=(64,), phase_hidden=(32,), geometry=4))
    data = samples(6000, 0)
    network.set_normalization(data.sights.float())
    optimizer = torch.optim.Adam(network.parameters(), lr=3e-3)
    geometry = torch.zeros(1, 600)
    for _ in range(250):
        batch = data.at(torch.randint(len(data), (256,)))
        loss, _ = imitation_loss(network, batch, geometry[batch.shape.long()], 5.0)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
    test = samples(500, 1)
    with torch.no_grad():
        _, shown = imitation_loss(network, test, geometry[test.shape.long()], 5.0)
        said = network.from_units(
            network(test.sights.float(), test.anchors.float(), geometry.expand(500, -1), test.memory)
        )
    error = (said[:, 5:11] - 0.1 * test.action[:, 5:11]).abs()
    inside = (0.1 * test.action[:, 5:11]).abs() < 0.3
    assert shown["phase_wrong"] < 0.15
    assert error[inside].median() < 0.1


def test_ring_and_files(tmp_path):
    buffer = ImitationBuffer(tmp_path, capacity=25)
    shapes = torch.randn(3, 600)
    assert buffer.shape_rows(shapes[[0, 1, 0]]).tolist() == [0, 1, 0]
    for number in range(4):
        buffer.add(number, SharedSamples.alone(samples(10, number)))
    assert sorted(buffer.rounds) == [2, 3]
    assert len(list(tmp_path.iterdir())) == 4  # until a checkpoint no longer needs them
    state = buffer.state()
    buffer.forget_files()
    again = ImitationBuffer(tmp_path, capacity=25)
    again.restore(state)
    for name, value in buffer.all().here.tensors().items():
        assert torch.equal(value, getattr(again.all().here, name))
    assert again.shape_rows(shapes[[2, 1]]).tolist() == [2, 1]
    assert sorted(p.name for p in tmp_path.iterdir()) == ["round_00002.safetensors", "round_00003.safetensors"]


def test_processes_that_share_samples_draw_what_one_would(tmp_path):
    generator = torch.Generator().manual_seed(0)
    rounds = [samples(10, 0), samples(7, 1)]
    mine = [torch.randperm(len(r), generator=generator).sort().values % 3 == 0 for r in rounds]
    both = []
    for name, chosen in (("a", mine), ("b", [~m for m in mine])):
        buffer = ImitationBuffer(tmp_path / name, capacity=17)
        for number, (whole, here) in enumerate(zip(rounds, chosen, strict=True)):
            rows = here.nonzero()[:, 0]
            buffer.add(number, SharedSamples(whole.at(rows), rows, len(whole)))
        again = ImitationBuffer(tmp_path / name, capacity=17)
        again.restore(buffer.state())
        both.append(again.all())
    alone = SharedSamples.join([SharedSamples.alone(r) for r in rounds])
    drawn = torch.randint(len(alone), (50,), generator=generator)
    a, b = (shared.at(drawn) for shared in both)
    assert len(a) + len(b) == 50
    here = torch.cat(mine)[drawn]
    assert torch.equal(a.sights, alone.at(drawn).sights[here])
    assert torch.equal(b.action, alone.at(drawn).action[~here])
    assert [len(shared) for shared in both] == [17, 17]
