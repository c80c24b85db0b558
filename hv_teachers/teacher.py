"""The privileged teachers: networks that say what to do, switched by the instructor; the motor prior does it.

Teacher 1 plays the first sub-task of an episode, teacher 2 all later ones, however many there are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import torch
from torch import Tensor

from hv_policy.decision.memory import TaskMemory
from hv_policy.decision.network import DecisionNetwork
from hv_policy.decision.rising import Rising
from hv_policy.decision.sight import hand_anchors, sight
from hv_policy.decision.view import TaskView, to_heading
from hv_policy.decision.weights import load_decision, save_decision
from hv_policy.motor import embodiment as body
from hv_policy.motor.prior import MotorPrior, load_shipped_motor_prior
from hv_sim.world import RearrangeWorld
from hv_teachers.knowledge import Knowledge
from hv_teachers.routes import RouteViews, gave_up, replan_routes
from hv_teachers.sight_noise import SightNoise, SightNoiseConfig

WEIGHTS = Path(__file__).resolve().parent / "weights"
TEACHER_FILES = ("teacher_1.safetensors", "teacher_2.safetensors")


@dataclass
class Sight:
    """What a teacher sees at one step, one row per environment."""

    proprioception: Tensor  # (N, 223)
    view: TaskView
    truth: TaskView
    """As `view`, without the errors that it may have."""
    sights: Tensor  # (N, SIGHT_DIM)
    geometry: Tensor  # (N, 600)
    half_extents: Tensor  # (N, 3)


@dataclass
class Decision:
    """What the networks say, and what they were shown to say it."""

    anchors: Tensor  # (N, 42)
    memory: Tensor  # (N, 18) or (N, A): what went into the action's network
    action: Tensor  # (N, A) in the network's units


class TeacherSenses:
    """Routes, memory and sight of every environment of a world.

    Args:
        num_envs: environments.
        remembers_phase: the network has `memory: phase`.
        num_actions: width of an action, to remember the last one.
        noise: errors of what is seen.
    """

    def __init__(
        self, num_envs: int, remembers_phase: bool, num_actions: int, noise: SightNoiseConfig | None = None
    ) -> None:
        self.noise = SightNoise(num_envs, noise) if noise and (noise.near_m or noise.per_m) else None
        self.num_envs, self.remembers_phase = num_envs, remembers_phase
        self.routes = RouteViews(num_envs)
        self.memory = TaskMemory.of(num_envs)
        self.last_action = torch.zeros(num_envs, num_actions)
        """(N, A) in the network's units."""
        self.lost = torch.zeros(num_envs, dtype=torch.bool)
        """(N,) the object slipped away at the last step: a new route to it is needed."""
        self.gave_up = torch.zeros(num_envs, dtype=torch.bool)
        """(N,) it could not be reached: it is tried from another side."""
        self.rising = Rising(num_envs)
        self._risen_from = torch.zeros(num_envs, dtype=torch.long)  # (N,) phase at the last step

    def reset(self, ids: Tensor) -> None:
        """Forgets environments `ids` (n,)."""
        self.routes.reset(ids)
        self.rising.reset(ids)
        self._risen_from[ids] = 0
        self.gave_up[ids] = False
        self.memory.reset(ids)
        self.last_action[ids] = 0.0
        self.lost[ids] = False

    def look(self, world: RearrangeWorld) -> Sight:
        """Plans new routes where they are needed, starts anew where a sub-task began, and says what is to be seen."""
        needs = self._needs_route(world)
        self.routes.spurn((self.lost | self.gave_up).nonzero()[:, 0])
        replan_routes(world, (needs & ~world.done).nonzero()[:, 0], self.routes.spurned_rad)
        changed = self.routes.follow(world)
        again = self.lost[changed]
        self.memory.reset(changed[~again])  # a new sub-task, not one that is tried again
        self.last_action[changed] = 0.0
        heading = world.heading
        view = truth = self.routes.view(world, heading)
        observation = world.observe()
        if self.noise is not None:
            view, observation = self.noise(world.episode_seed, world.episode_step, view, observation, heading)
        navigator = world.navigator
        seen = sight(observation, view, navigator.leg_is_done, navigator.picked_up)
        geometry = observation.bps.flatten(1)
        return Sight(observation.proprioception, view, truth, seen, geometry, observation.half_extents)

    def decide(self, networks: Sequence[DecisionNetwork], who: Tensor, seen: Sight) -> Decision:
        """Lets network `who` (N,) of `networks` decide in each environment, and moves the memory on."""
        phase = self.memory.phase
        if self.remembers_phase:
            before = self.memory.vector(seen.view)
            phase = phase.clone()
            for rows, network in _shares(networks, who):
                logits = network.phase_logits(seen.sights[rows], seen.geometry[rows], before[rows])
                phase[rows] = logits.argmax(-1)
        before = self.memory.phase
        self.lost = self.memory.advance(phase, seen.view)
        self.gave_up = gave_up(before, phase, self.memory.clock_s) & self.remembers_phase
        anchors, memory = self.inputs(seen)
        action = torch.zeros_like(self.last_action)
        for rows, network in _shares(networks, who):
            action[rows] = network(seen.sights[rows], anchors[rows], seen.geometry[rows], memory[rows])
        return Decision(anchors, memory, action)

    def inputs(self, seen: Sight) -> tuple[Tensor, Tensor]:
        """(N, 42) anchors and (N, M) memory for the action's network, from the memory as it now is."""
        vector = self.memory.vector(seen.view) if self.remembers_phase else _present(seen.view)
        anchors = hand_anchors(seen.view, vector)
        return anchors, vector if self.remembers_phase else self.last_action

    def steadied(self, intent: Tensor) -> Tensor:
        """(N, 14) the intent, but who gave up what it was bent for stands up first; once a control step."""
        if not self.remembers_phase:
            return intent
        self.rising.begin_where_given_up(self._risen_from, self.memory.phase)
        self._risen_from = self.memory.phase.clone()
        return self.rising(intent)

    def acted(self, action: Tensor) -> None:
        """(N, A), in the network's units, was done; a control step passes."""
        self.last_action = action
        self.memory.tick()

    def _needs_route(self, world: RearrangeWorld) -> Tensor:
        if self.remembers_phase:
            kicked = self.routes.disturbed(world, self.memory.phase)
            return self.lost | self.gave_up | kicked
        # without a phase: it was moved, lies still, far from the hands and from where it should be
        state, rows = world.state, torch.arange(world.num_envs)
        position = state.object_pos_w[rows, world.object_index]
        hands = state.link_pos_w[:, body.HANDS].mean(1)
        resting = state.object_lin_vel_w[rows, world.object_index].norm(dim=-1) < 0.1
        missed = (position - world.goal_pos_w[rows, world.subtask_index]).norm(dim=-1) > 0.3
        self.lost = world.navigator.picked_up & resting & missed & ((position - hands).norm(dim=-1) > 0.45)
        return self.lost


class Teacher:
    """One object that plays whole episodes: `joint_targets = teacher(world)`, the controller that hv-eval wants.

    Args:
        networks: teacher 1, teacher 2, ...; the last one plays all further sub-tasks.
        prior: the controller below (default: the shipped one); unused by networks that give joint targets.

    Raises:
        ValueError: there is no network, or they differ in action or memory.
    """

    def __init__(self, networks: Sequence[DecisionNetwork], prior: MotorPrior | None = None) -> None:
        kinds = {(n.config.action, n.config.memory) for n in networks}
        if len(kinds) != 1:
            raise ValueError(
                f"networks: {len(networks)} of kinds {sorted(kinds)} are not valid; valid: all of one kind"
            )
        self.networks = list(networks)
        self.config = self.networks[0].config
        self.prior = (prior or load_shipped_motor_prior()) if self.config.action == "intent" else None
        self._senses: TeacherSenses | None = None
        self.knowledge: Knowledge | None = None
        """What it knew when it was last asked; None for networks that remember no phase."""

    def reset(self, ids: Tensor | None = None) -> None:
        """Forgets environments `ids` (default: all); needed only between worlds, a new episode is noticed."""
        if ids is None or self._senses is None:
            self._senses = None
        else:
            self._senses.reset(torch.as_tensor(ids))
        if self.prior is not None:
            self.prior.reset(None if ids is None else torch.as_tensor(ids))

    @property
    def phase(self) -> Tensor | None:
        """(N,) what each environment is doing, a `Phase`, where the networks remember it."""
        known = self._senses is not None and self._senses.remembers_phase
        return self._senses.memory.phase if known and self._senses is not None else None

    @torch.no_grad()
    def decide(self, world: RearrangeWorld) -> tuple[Tensor, Tensor]:
        """Intents (N, 14), zeros for networks that give none, and servo targets (N, 28) in rad: a recorder's expert."""
        n = world.num_envs
        if self._senses is None or self._senses.num_envs != n:
            self._senses = TeacherSenses(n, self.config.memory == "phase", self.config.num_actions)
            if self.prior is not None:
                self.prior.reset()
        begun = (world.episode_step == 0).nonzero()[:, 0]
        if len(begun):
            self._senses.reset(begun)
            if self.prior is not None:
                self.prior.reset(begun if len(begun) < n else None)
        seen = self._senses.look(world)
        who = world.subtask_index.clamp(max=len(self.networks) - 1)
        memory = self._senses.memory.vector(seen.view)
        action = self._senses.decide(self.networks, who, seen).action
        if self._senses.remembers_phase:
            done, phase = world.navigator.leg_is_done, self._senses.memory.phase
            self.knowledge = Knowledge.of(seen.truth, done, memory, phase)
        decided = self.networks[0].from_units(action)
        if self.prior is None:
            self._senses.acted(action)
            return torch.zeros(n, 14), decided
        intent = self._senses.steadied(decided)
        self._senses.acted(action)
        return intent, self.prior(seen.proprioception, intent)

    def __call__(self, world: RearrangeWorld) -> Tensor:
        """Servo targets (N, 28) in rad for the world's present state."""
        return self.decide(world)[1]

    def save(self, folder: Path, metadata: dict[str, str] | None = None) -> None:
        """Writes `teacher_1.safetensors` and, if there are two, `teacher_2.safetensors`.

        Raises:
            ValueError: there are more than two.
        """
        if len(self.networks) > len(TEACHER_FILES):
            raise ValueError(f"networks: {len(self.networks)}; valid: at most {len(TEACHER_FILES)}")
        for network, name in zip(self.networks, TEACHER_FILES, strict=False):
            save_decision(network, Path(folder) / name, metadata)

    @staticmethod
    def load(folder: Path, prior: MotorPrior | None = None) -> Teacher:
        """Reads what `save` wrote; without a second file teacher 1 plays everything.

        Raises:
            ValueError: the first file is missing or one cannot be read.
        """
        paths = [Path(folder) / name for name in TEACHER_FILES]
        if not paths[0].is_file():
            raise ValueError(f"{paths[0]}: there is no such file; valid: a folder with {' and '.join(TEACHER_FILES)}")
        return Teacher([load_decision(path) for path in paths if path.is_file()], prior)


def load_shipped_teacher(prior: MotorPrior | None = None) -> Teacher:
    """The two teachers that come with the package.

    Raises:
        ValueError: this package comes without them.
    """
    missing = [name for name in TEACHER_FILES if not (WEIGHTS / name).is_file()]
    if missing:
        raise ValueError(f"teacher: {', '.join(missing)} not in {WEIGHTS}; valid: a folder that hv-train-teacher made")
    return Teacher.load(WEIGHTS, prior)


def _shares(networks: Sequence[DecisionNetwork], who: Tensor) -> list[tuple[Tensor | slice, DecisionNetwork]]:
    """The rows that each network decides in."""
    if len(networks) == 1:
        return [(slice(None), networks[0])]
    shares = [((who == k).nonzero()[:, 0], network) for k, network in enumerate(networks)]
    return [(rows, network) for rows, network in shares if len(rows)]


def _present(view: TaskView) -> Tensor:
    """(N, 18) a memory's numbers for networks that have none: everything is as it is now."""
    hands = to_heading(view, view.hands)
    obj = to_heading(view, view.object_pos[:, None])
    zero = torch.zeros(len(hands), 2)
    return torch.cat([zero, hands.flatten(1), (hands - obj).flatten(1), obj[:, 0], view.object_pos[:, 2:]], -1)
