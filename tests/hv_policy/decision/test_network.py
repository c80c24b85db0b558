"""The teacher's network: what its outputs mean, what it may see, and its file."""

import pytest
import torch
from safetensors.torch import save_file

from hv_policy.decision.memory import NUM_PHASES, VECTOR_DIM
from hv_policy.decision.network import DecisionConfig, DecisionNetwork
from hv_policy.decision.sight import ANCHOR_DIM, ANCHORS, OBSERVATION_DIM, SIGHT_DIM
from hv_policy.decision.weights import load_decision, save_decision
from hv_policy.motor.intent import GAZE, HEIGHT, LEFT_HAND, RIGHT_HAND, SQUEEZE, neutral_intent
from hv_sim.control import INTENT_HIGH, INTENT_LOW

SMALL = {"hidden": (16,), "phase_hidden": (8,), "geometry": 4}


def inputs(num, memory_dim=VECTOR_DIM, seed=0):
    generator = torch.Generator().manual_seed(seed)
    sights, anchors, geometry, memory = (
        torch.randn(num, d, generator=generator) for d in (SIGHT_DIM, ANCHOR_DIM, 600, memory_dim)
    )
    memory[:, 0] = torch.randint(NUM_PHASES, (num,), generator=generator).float()
    return sights, anchors, geometry, memory


def test_hands_are_a_mixture_of_places_and_a_correction():
    network = DecisionNetwork(DecisionConfig(**SMALL))
    sights, anchors, geometry, memory = inputs(6)
    with torch.no_grad():
        network.head.weight.zero_()
        bias = network.head.bias.view(NUM_PHASES, -1)
        bias.zero_()
        for phase in range(NUM_PHASES):
            bias[phase, 5 + phase % len(ANCHORS)] = 50.0  # each phase swears by one place
            bias[phase, 5 + len(ANCHORS) : 5 + len(ANCHORS) + 3] = 0.5  # and moves the right hand 5 cm along each axis
        intent = network.from_units(network(sights, anchors, geometry, memory))
    low, high = torch.tensor(INTENT_LOW), torch.tensor(INTENT_HIGH)
    for i in range(6):
        place = anchors[i].view(len(ANCHORS), 2, 3)[int(memory[i, 0]) % len(ANCHORS)]
        right, left = place[0] + 0.05, place[1]
        torch.testing.assert_close(
            intent[i, RIGHT_HAND], right.clamp(low[RIGHT_HAND], high[RIGHT_HAND]), atol=1e-5, rtol=0
        )
        torch.testing.assert_close(intent[i, LEFT_HAND], left.clamp(low[LEFT_HAND], high[LEFT_HAND]), atol=1e-5, rtol=0)
    rest = neutral_intent(6)
    torch.testing.assert_close(intent[:, HEIGHT], rest[:, HEIGHT])
    torch.testing.assert_close(intent[:, GAZE], rest[:, GAZE])
    torch.testing.assert_close(intent[:, SQUEEZE], torch.full((6,), 0.5))


def test_each_phase_has_its_own_last_layer():
    network = DecisionNetwork(DecisionConfig(**SMALL)).eval()
    sights, anchors, geometry, memory = inputs(4)
    memory[:, 0] = 3.0
    with torch.no_grad():
        before = network(sights, anchors, geometry, memory), network.phase_logits(sights, geometry, memory)
        outputs = network.head.weight.shape[0] // NUM_PHASES
        keep = torch.arange(NUM_PHASES).repeat_interleave(outputs) == 3
        network.head.weight[~keep] += 1.0
        network.phase_head.weight[torch.arange(NUM_PHASES).repeat_interleave(NUM_PHASES) != 3] += 1.0
        after = network(sights, anchors, geometry, memory), network.phase_logits(sights, geometry, memory)
    torch.testing.assert_close(before, after)


@pytest.mark.parametrize("action", ["intent", "joints"])
def test_without_the_route_only_section_3_is_seen(action):
    config = DecisionConfig(route=False, memory="none", action=action, **SMALL)
    network = DecisionNetwork(config)
    torch.nn.init.normal_(network.head.weight)
    sights, anchors, geometry, memory = inputs(5)
    other = sights.clone()
    other[:, OBSERVATION_DIM:] += 3.0
    with torch.no_grad():
        torch.testing.assert_close(
            network(sights, anchors, geometry, memory), network(other, anchors, geometry, memory)
        )
        moved = anchors.clone().unflatten(-1, (len(ANCHORS), 6))
        for name in ("grasp", "chest"):  # both follow from the route
            moved[:, ANCHORS.index(name)] += 0.2
        torch.testing.assert_close(
            network(sights, anchors, geometry, memory), network(sights, moved.flatten(1), geometry, memory)
        )
        other[:, 0] += 1.0
        assert not torch.allclose(network(sights, anchors, geometry, memory), network(other, anchors, geometry, memory))


@pytest.mark.parametrize("memory", ["phase", "intent", "none"])
@pytest.mark.parametrize("action", ["intent", "joints"])
def test_units_and_file(tmp_path, memory, action):
    network = DecisionNetwork(DecisionConfig(memory=memory, action=action, **SMALL)).eval()
    network.set_normalization(torch.randn(50, SIGHT_DIM))
    width = VECTOR_DIM if memory != "intent" else network.config.num_actions
    given = inputs(3, width)
    with torch.no_grad():
        said = network(*given)
    assert said.shape == (3, 14 if action == "intent" else 28)
    inside = network.from_units(said)
    torch.testing.assert_close(network.from_units(network.to_units(inside)), inside)
    save_decision(network, tmp_path / "t.safetensors", {"samples": "7"})
    again = load_decision(tmp_path / "t.safetensors")
    assert again.config == network.config
    with torch.no_grad():
        assert torch.equal(again(*given), said)
    assert not list(tmp_path.glob("*.tmp"))


def test_bad_files_and_fields(tmp_path):
    with pytest.raises(ValueError, match=r"teacher\.memory: 'gru' is not valid; valid: phase, intent, none"):
        DecisionConfig(memory="gru")
    (tmp_path / "a.safetensors").write_bytes(b"nothing")
    with pytest.raises(ValueError, match="cannot be read"):
        load_decision(tmp_path / "a.safetensors")
    save_file({"x": torch.zeros(1)}, tmp_path / "b.safetensors", metadata={"format": "other"})
    with pytest.raises(ValueError, match="format is 'other'; valid: 'hv_teacher/1'"):
        load_decision(tmp_path / "b.safetensors")
    header = {"format": "hv_teacher/1", "config": '{"depth": 3}'}
    save_file({"x": torch.zeros(1)}, tmp_path / "c.safetensors", metadata=header)
    with pytest.raises(ValueError, match="its configuration is of another version"):
        load_decision(tmp_path / "c.safetensors")
    header = {"format": "hv_teacher/1", "config": "{}"}
    save_file({"x": torch.zeros(1)}, tmp_path / "d.safetensors", metadata=header)
    with pytest.raises(ValueError, match="do not fit the configuration"):
        load_decision(tmp_path / "d.safetensors")
