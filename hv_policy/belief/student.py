"""The network that sees, believes and decides; and one that acts with it, step by step, in many environments."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import torch
from torch import Tensor, nn

from hv_policy.belief.belief import Belief, BeliefConfig
from hv_policy.belief.perception import (
    Perception,
    belief_features,
    measurement_loss,
    way_loss,
)
from hv_policy.belief.places import (
    FLAGS,
    GOAL,
    OBJECT,
    PICK,
    PLACE,
    WAYPOINT,
    squash,
    stretch,
    unsquash,
    unsquash_waypoint,
)  # fmt: skip
from hv_policy.belief.task_places import leg_is_done, view_of
from hv_policy.decision.memory import TaskMemory
from hv_policy.decision.network import DecisionConfig, DecisionNetwork, hand_anchors, sight
from hv_policy.decision.view import Phase
from hv_policy.decision.weights import load_decision
from hv_policy.motor.prior import MotorPrior, load_shipped_motor_prior
from hv_policy.motor.proprioception import BodyState, read_proprioception

DECISION = DecisionConfig(sees="places", geometry=0)
SHIPPED_DECISION = Path(__file__).resolve().parents[1] / "weights" / "decision.safetensors"
LEAST_BELIEF_SPREAD, MOST_BELIEF_SPREAD = 0.02, 1.5
UNKNOWN_SHARE = 0.15


class BeliefNetwork(nn.Module):
    """All weights of a student: perception, decisions (`DECISION`) and motor prior.

    Args:
        perception: see `Perception`.
        from_scratch: take the shipped decisions and motor prior; else they come with a checkpoint.
    """

    def __init__(self, perception: Perception, from_scratch: bool) -> None:
        super().__init__()
        self.perception = perception
        self.prior: MotorPrior = load_shipped_motor_prior()
        self.decision: DecisionNetwork = load_decision(SHIPPED_DECISION) if from_scratch else DecisionNetwork(DECISION)
        self.decision.requires_grad_(False)
        self.prior.requires_grad_(False)

    def loss(
        self, pictures: Tensor, state: Tensor, words: Tensor, is_word: Tensor, known: dict[str, Tensor]
    ) -> tuple[Tensor, dict[str, float]]:
        """(B,) how wrong the places and the way are that the network sees, and figures to watch (m).

        Args:
            pictures, state, words, is_word: see `Perception`.
            known: `places` (B, 21), `way` (B, 8), `memory` (B, 18): what was so.
        """
        seen = self.perception(pictures, state, words, is_word)
        places, way, memory = known["places"], known["way"], known["memory"]
        truth = squash(places)
        low, high = torch.tensor([LEAST_BELIEF_SPREAD, MOST_BELIEF_SPREAD]).log().tolist()
        log_spread = low + (high - low) * torch.rand(len(truth), 1, device=truth.device)
        unknown = torch.rand(len(truth), 1, device=truth.device) < UNKNOWN_SHARE
        log_spread = torch.where(unknown, torch.full_like(log_spread, 2.0), log_spread).expand_as(truth)
        believed = truth + torch.randn_like(truth) * log_spread.exp()
        features = belief_features(believed, log_spread, memory[:, 0].long(), memory[:, 1])
        predicted = self.perception.way(seen, state, features)
        seeing, going = measurement_loss(seen, places), way_loss(predicted, way)
        with torch.no_grad():
            error = (unsquash(seen.places) - places).abs()
            near = places[:, :2].norm(dim=-1) < 1.5
            figures = {
                "seeing_loss": seeing.mean().item(),
                "way_loss": going.mean().item(),
                "object_error_m": _median(error[:, OBJECT][:, :2]),
                "near_object_error_m": _median(error[near][:, OBJECT][:, :2]),
                "goal_error_m": _median(error[:, GOAL][:, :2]),
                "stand_error_m": _median(error[:, PICK]),
                "waypoint_error_m": _median((unsquash_waypoint(predicted[:, WAYPOINT]) - way[:, WAYPOINT]).abs()),
                "flags_wrong": ((predicted[:, FLAGS] > 0) != (way[:, FLAGS] > 0.5)).float().mean().item(),
            }
        return seeing + going, figures


@dataclass
class _Observed:
    """`hv_policy.decision.network.Observed` without what cannot be seen."""

    proprioception: Tensor
    object: Tensor
    goal: Tensor
    waypoint: Tensor
    half_extents: Tensor


@dataclass
class Following:
    """Everything that a student carries from one control step to the next, for N environments."""

    belief: Belief
    memory: TaskMemory
    prior: MotorPrior
    instructions: list[str]
    step: int = 0
    seen_way: Tensor = field(default_factory=lambda: torch.zeros(0))
    places_h: Tensor = field(default_factory=lambda: torch.zeros(0))
    intent: Tensor = field(default_factory=lambda: torch.zeros(0))

    @staticmethod
    def begin(network: BeliefNetwork, instructions: Sequence[str], config: BeliefConfig) -> Following:
        """Nothing has been seen yet."""
        n = len(instructions)
        prior = copy.copy(network.prior)  # shares the weights, has a memory of its own
        prior.reset()
        return Following(Belief(n, config), TaskMemory.of(n), prior, list(instructions))

    def copy(self) -> Following:
        """The same, from where another future may begin."""
        prior = copy.copy(self.prior)
        prior.memory = copy.deepcopy(self.prior.memory)
        prior._last_residual, prior._fresh = copy.deepcopy((self.prior._last_residual, self.prior._fresh))
        rest = (copy.deepcopy(self.belief), self.memory.clone(), prior, list(self.instructions))
        return Following(*rest, self.step, self.seen_way, self.places_h, self.intent)

    def hear(self, instructions: Sequence[str]) -> None:
        """Begins anew where the instruction is another one, and there alone."""
        changed = [i for i, (new, old) in enumerate(zip(instructions, self.instructions, strict=True)) if new != old]
        if changed:
            ids = torch.tensor(changed)
            self.belief.forget(ids)
            self.memory.reset(ids)
            self.instructions = list(instructions)

    def act(self, network: BeliefNetwork, pictures: Tensor, state: Tensor, words: Tensor, is_word: Tensor) -> Tensor:
        """(N, 28) servo targets in rad for this control step; see `Perception` for the arguments."""
        body = read_proprioception(state)
        phase = self.memory.phase
        self.belief.move(body, (phase >= Phase.LIFT) & (phase <= Phase.LOWER))
        seen = network.perception(pictures, state, words, is_word)
        places = unsquash(seen.places)
        self.belief.measure(places, seen.log_spread.exp() * stretch(places))
        places_h, log_spread = self.belief.now()
        features = belief_features(squash(places_h), log_spread, phase, self.memory.clock_s)
        way = self._way(network.perception.way(seen, state, features), places_h)
        intent = self._decide(network.decision, state, body, places_h, way)
        self.places_h, self.seen_way, self.intent = places_h, way, intent
        self.step += 1
        return self.prior(state, intent)

    def _way(self, said: Tensor, places_h: Tensor) -> Tensor:
        """(N, 8) the way as `hv_policy.belief.places` has it, of what the network said."""
        way = said.clone()
        way[:, FLAGS] = (said[:, FLAGS] > 0).to(said)
        to_place = (self.memory.phase >= Phase.LIFT) & (self.memory.phase <= Phase.LOWER)
        stand = torch.where(to_place[:, None], places_h[:, PLACE], places_h[:, PICK])
        at_stand = (way[:, FLAGS[0]] > 0.5) & (self.memory.phase <= Phase.LOWER)
        way[:, WAYPOINT] = torch.where(at_stand[:, None], stand, unsquash_waypoint(said[:, WAYPOINT]))
        return way

    def _decide(
        self, decision: DecisionNetwork, state: Tensor, body: BodyState, places_h: Tensor, way: Tensor
    ) -> Tensor:
        """(N, 14) intents; the memory moves on."""
        view = view_of(places_h, way, body, self.belief.pose)
        root = torch.zeros_like(places_h[:, :3])
        root[:, 2] = state[:, 0]
        nothing = torch.zeros_like(places_h[:, :12])
        observed = _Observed(
            proprioception=state,
            object=torch.cat([places_h[:, OBJECT] - root, nothing], 1),
            goal=torch.cat([places_h[:, GOAL] - root, nothing[:, :6]], 1),
            waypoint=torch.cat([way[:, WAYPOINT], -root[:, 2:]], 1),
            half_extents=nothing[:, :3],
        )
        sights = sight(observed, view, leg_is_done(way), self.memory.phase > Phase.LIFT)
        geometry = state.new_zeros(len(state), 600)
        before = self.memory.vector(view)
        phase = decision.phase_logits(sights, geometry, before).argmax(-1)
        lost = self.memory.advance(phase, view)
        if bool(lost.any()):
            self.belief.doubt(lost.nonzero()[:, 0])
        vector = self.memory.vector(view)
        action = decision(sights, hand_anchors(view, vector), geometry, vector)
        self.memory.tick()
        return decision.from_units(action)


def _median(values: Tensor) -> float:
    return float(values.median()) if values.numel() else float("nan")
