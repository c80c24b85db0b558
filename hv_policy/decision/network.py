"""The teacher as a network: section 3's observations, the route and its memory in; the next phase and an intent out.

Two small networks. The first says which phase of the work is next, the second what to do in it. Both have one linear
output layer for each phase, because what is to be done differs from phase to phase more than anything within one.

Where the hands shall go is said as a mixture of places that matter (where they are, where the object should be held,
where they would have to be for it to stand at its goal, ...) and a small correction: a squeeze needs a centimetre, and
a network that regresses coordinates of a room gives three.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import torch
from torch import Tensor, nn

from hv_policy.batch_invariant import BatchInvariantLinear
from hv_policy.decision.memory import NUM_PHASES, VECTOR_DIM
from hv_policy.decision.sight import ANCHOR_DIM, ANCHORS, OBSERVATION_DIM, SIGHT_DIM
from hv_policy.motor import embodiment as body
from hv_policy.motor.intent import (
    GAZE,
    HEIGHT,
    INTENT_HIGH,
    INTENT_LOW,
    LEFT_HAND,
    PITCH,
    RIGHT_HAND,
    SQUEEZE,
    neutral_intent,
)

MEMORIES = ("phase", "intent", "none")
SEES = ("all", "places")
ACTIONS = ("intent", "joints")

_UNSEEN_ANCHORS = [ANCHORS.index("grasp"), ANCHORS.index("chest")]  # without the route
_CLOCK_UNITS_S = (0.4, 1.0, 2.0, 5.0)
_MEMORY_FEATURES = NUM_PHASES + len(_CLOCK_UNITS_S) + VECTOR_DIM - 2
GEOMETRY_DIM = 600
# of section 3's observations: how object and goal are turned, how the object moves, and its size
_SHAPES = [*range(226, 238), *range(241, 247), *range(250, 253)]

# spread of an intent: units of the network's output, of the exploration noise and of the imitation loss
INTENT_UNITS = torch.tensor([0.5, 0.4, 0.8, 0.15, 0.4, *[0.1] * 6, 1.0, 0.5, 0.5])
JOINT_UNIT_RAD = 0.4
_HAND_ORDER = torch.tensor([3, 4, 5, 0, 1, 2])  # right, left -> left, right as in an intent


@dataclass(frozen=True)
class DecisionConfig:
    """What the network is.

    Raises:
        ValueError: `memory`, `action` or `sees` is unknown.
    """

    memory: str = "phase"
    """`phase`: `TaskMemory`, in the input, moved on by the network; `intent`: its own last output; `none`."""
    action: str = "intent"
    """`intent`: the motor prior turns it into joint targets; `joints`: 28 targets directly (the paper's form)."""
    route: bool = True
    """Sees stands, grasp and depth (below); without it, only what section 3 lists."""
    sees: str = "all"
    """`places`: not how object and goal are turned, how the object moves and how large it is; where to stand and where
    to hold it say as much, and can be seen in a picture."""
    geometry: int = 32
    """Width of the basis point set's embedding; 0 leaves the geometry out."""
    phase_hidden: tuple[int, ...] = (256, 128)
    hidden: tuple[int, ...] = (512, 256)

    def __post_init__(self) -> None:
        for name, valid in (("memory", MEMORIES), ("action", ACTIONS), ("sees", SEES)):
            if getattr(self, name) not in valid:
                raise ValueError(f"teacher.{name}: {getattr(self, name)!r} is not valid; valid: {', '.join(valid)}")

    @property
    def num_actions(self) -> int:
        return 14 if self.action == "intent" else body.KP.shape[0]

    @property
    def num_heads(self) -> int:
        return NUM_PHASES if self.memory == "phase" else 1


class DecisionNetwork(nn.Module):
    """See the module's docstring. Inputs are raw; normalisation is part of it (`set_normalization`)."""

    def __init__(self, config: DecisionConfig | None = None) -> None:
        super().__init__()
        self.config = config or DecisionConfig()
        c = self.config
        self.register_buffer("mean", torch.zeros(SIGHT_DIM))
        self.register_buffer("std", torch.ones(SIGHT_DIM))
        self.register_buffer("normalized", torch.zeros((), dtype=torch.bool))
        self.geometry = BatchInvariantLinear(GEOMETRY_DIM, c.geometry) if c.geometry else None
        memory = {"phase": _MEMORY_FEATURES, "intent": c.num_actions, "none": 0}[c.memory]
        inputs = SIGHT_DIM + c.geometry + memory
        if c.memory == "phase":
            self.phase_geometry = BatchInvariantLinear(GEOMETRY_DIM, c.geometry) if c.geometry else None
            self.phase_trunk = _trunk(inputs, c.phase_hidden)
            self.phase_head = BatchInvariantLinear(c.phase_hidden[-1], NUM_PHASES * NUM_PHASES)
        self.trunk = _trunk(inputs + ANCHOR_DIM, c.hidden)
        outputs = 5 + len(ANCHORS) + 6 + 1 + 2 if c.action == "intent" else c.num_actions
        self.head = BatchInvariantLinear(c.hidden[-1], c.num_heads * outputs)
        nn.init.zeros_(self.head.bias)
        self.head.weight.data.mul_(0.1)
        self.register_buffer("_low", torch.tensor(INTENT_LOW), persistent=False)
        self.register_buffer("_high", torch.tensor(INTENT_HIGH), persistent=False)
        self.register_buffer("_units", INTENT_UNITS.clone(), persistent=False)
        self.register_buffer("_rest", neutral_intent(1)[0], persistent=False)
        visible = torch.ones(SIGHT_DIM).index_fill(0, torch.tensor(_SHAPES), 0.0)
        self.register_buffer("_visible", visible, persistent=False)
        known = torch.ones(len(ANCHORS)).index_fill(0, torch.tensor(_UNSEEN_ANCHORS), 0.0)
        self.register_buffer("_known_anchors", known.repeat_interleave(6), persistent=False)
        self.register_buffer("_one_hot", torch.eye(NUM_PHASES), persistent=False)
        self.register_buffer("_clock_units_s", torch.tensor(_CLOCK_UNITS_S), persistent=False)

    def set_normalization(self, sights: Tensor) -> None:
        """Takes mean and spread of (B, SIGHT_DIM) inputs; done once, so that what was learned stays true."""
        self.set_moments(sights.mean(0), sights.std(0))

    def set_moments(self, mean: Tensor, std: Tensor) -> None:
        """As `set_normalization`, from the inputs' mean and standard deviation, (SIGHT_DIM,) each."""
        self.mean.copy_(mean)
        self.std.copy_(std.clamp(min=0.02))
        self.normalized.fill_(True)

    def phase_logits(self, sights: Tensor, geometry: Tensor, memory: Tensor) -> Tensor:
        """(N, 11) logits of the next phase.

        Args:
            sights: (N, SIGHT_DIM), see `sight`.
            geometry: (N, 600) basis point sets.
            memory: (N, 18) as it is before the phase changes.
        """
        seen = self._inputs(sights, memory)
        if self.phase_geometry is not None:
            seen = torch.cat([seen, self.phase_geometry(geometry)], -1)
        hidden = self.phase_trunk(seen)
        logits = self.phase_head(hidden).unflatten(-1, (NUM_PHASES, NUM_PHASES))
        return _of_phase(logits, memory[:, 0])

    def forward(self, sights: Tensor, anchors: Tensor, geometry: Tensor, memory: Tensor) -> Tensor:
        """(N, A) actions in units (`to_units`): intents of 14, or 28 joint targets.

        Args:
            sights: (N, SIGHT_DIM).
            anchors: (N, 42), `hand_anchors` of that memory.
            geometry: (N, 600).
            memory: (N, 18) after the phase changed; (N, A) the last action in units for `memory: intent`.
        """
        shown = anchors if self.config.route else anchors * self._known_anchors
        seen = [self._inputs(sights, memory), shown.clamp(-1.5, 1.5)]
        if self.geometry is not None:
            seen.append(self.geometry(geometry))
        hidden = self.trunk(torch.cat(seen, -1))
        out = self.head(hidden).unflatten(-1, (self.config.num_heads, -1))
        out = _of_phase(out, memory[:, 0]) if self.config.memory == "phase" else out[:, 0]
        if self.config.action == "joints":
            return out
        velocity, posture, share, correction, squeeze, gaze = out.split([3, 2, len(ANCHORS), 6, 1, 2], -1)
        if not self.config.route:
            share = share.index_fill(-1, torch.tensor(_UNSEEN_ANCHORS, device=share.device), -1e4)
        places = anchors.unflatten(-1, (len(ANCHORS), 6))
        hands = (share.softmax(-1)[..., None] * places).sum(1) + 0.1 * correction
        hands = hands[:, _HAND_ORDER.to(hands.device)]
        rest = self._rest
        units = self._units
        return torch.cat(
            [
                velocity,
                posture + rest[HEIGHT : PITCH + 1] / units[HEIGHT : PITCH + 1],
                hands / units[LEFT_HAND.start : RIGHT_HAND.stop],
                torch.sigmoid(squeeze) / units[SQUEEZE],
                gaze + rest[GAZE] / units[GAZE],
            ],
            -1,
        )

    def to_units(self, action: Tensor) -> Tensor:
        """Intents (N, 14) in the units of `hv_sim.control.INTENT_NAMES`, or joint targets (N, 28) -> the network's."""
        if self.config.action == "joints":
            return action / JOINT_UNIT_RAD
        return action / self._units

    def from_units(self, action: Tensor) -> Tensor:
        """The inverse of `to_units`, kept within what an intent or a servo can be."""
        if self.config.action == "joints":
            low, high = body.JOINT_LOW.to(action), body.JOINT_HIGH.to(action)
            return (action * JOINT_UNIT_RAD).clamp(low - 0.5, high + 0.5)
        return (action * self._units).clamp(self._low, self._high)

    def _inputs(self, sights: Tensor, memory: Tensor) -> Tensor:
        c = self.config
        seen = ((sights - self.mean) / self.std).clamp(-6.0, 6.0)
        if not c.route:
            seen = torch.cat([seen[:, :OBSERVATION_DIM], torch.zeros_like(seen[:, OBSERVATION_DIM:])], -1)
        if c.sees == "places":
            seen = seen * self._visible
        parts = [seen]
        if c.memory == "phase":
            times = torch.tanh(memory[:, 1:2] / self._clock_units_s)
            parts += [self._one_hot[memory[:, 0].long()], 2.0 * times - 1.0, memory[:, 2:]]
        elif c.memory == "intent":
            parts.append(memory)
        return torch.cat(parts, -1)


def _trunk(inputs: int, hidden: tuple[int, ...]) -> nn.Sequential:
    layers: list[nn.Module] = []
    for i, o in itertools.pairwise([inputs, *hidden]):
        layers += [BatchInvariantLinear(i, o), nn.ELU()]
    return nn.Sequential(*layers)


def _of_phase(outputs: Tensor, phase: Tensor) -> Tensor:
    """(N, 11, A) outputs of every phase's layer -> (N, A) those of the phase (N,)."""
    index = phase.long()[:, None, None].expand(-1, 1, outputs.shape[-1])
    return outputs.gather(1, index)[:, 0]
