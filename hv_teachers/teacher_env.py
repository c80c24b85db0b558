"""Where teachers practise: a batched world with the planner beside it to say what it would do, and the rewards.

One control step is `look`, `decide` (or `label`), `act`; environments whose episode is over begin a new one by
themselves. While an earlier teacher plays the first sub-tasks of an episode (Stage 3) `learning` is false there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import torch
from torch import Tensor

from hv_policy.decision.memory import TaskMemory
from hv_policy.decision.network import DecisionConfig, DecisionNetwork
from hv_policy.decision.sight import hand_anchors
from hv_policy.decision.view import Phase
from hv_policy.motor.embodiment import CONTROL_DT_S
from hv_policy.motor.prior import MotorPrior
from hv_sim.instructor import InstructorConfig
from hv_sim.metrics import SUCCESS_THRESHOLDS_M
from hv_sim.physics_backends import check_backend
from hv_sim.task import Task
from hv_sim.world import STEPS_PER_SUBTASK, RearrangeWorld
from hv_teachers.planner import ScriptedPlanner
from hv_teachers.planner_memory import lend_memory, memory_of
from hv_teachers.rewards import (
    RetreatRewardConfig,
    TaskRewardConfig,
    read_world,
    retreat_rewards,
    surface_points,
    task_rewards,
)
from hv_teachers.sight_noise import SightNoiseConfig
from hv_teachers.style import StyleHistory, style_frame
from hv_teachers.teacher import Decision, Sight, TeacherSenses

REWARDS = ("rearrange", "retreat")


@dataclass(frozen=True)
class TeacherEnvConfig:
    """What an episode is.

    Raises:
        ValueError: a field is not valid.
    """

    num_envs: int = 256
    steps_per_subtask: int = STEPS_PER_SUBTASK
    reward: str = "rearrange"
    """`rearrange` (Tables 6 and 7) or `retreat` (Algorithm 2)."""
    task_reward: TaskRewardConfig = field(default_factory=TaskRewardConfig)
    retreat_reward: RetreatRewardConfig = field(default_factory=RetreatRewardConfig)
    instructor: InstructorConfig = field(default_factory=InstructorConfig)
    """Algorithm 3; `null` for a threshold is an ablation of the paper."""
    end_when_placed: bool = False
    """An episode ends as soon as the planner, asked for a label, would let go: Stage 1 (and HumanVLA) ends there."""
    end_when_fallen: bool = True
    num_threads: int = 0
    physics: str = "cpu"
    """`cpu` or `warp`, see `hv_sim.physics_backends`."""
    noise: SightNoiseConfig = field(default_factory=SightNoiseConfig)
    """Errors of what the networks see; the planner, who labels it, sees things as they are."""

    def __post_init__(self) -> None:
        if self.reward not in REWARDS:
            raise ValueError(f"env.reward: {self.reward!r} is not valid; valid: {', '.join(REWARDS)}")
        check_backend(self.physics, "env.physics")
        for name in ("num_envs", "steps_per_subtask"):
            if getattr(self, name) < 1:
                raise ValueError(f"env.{name}: {getattr(self, name)} is not valid; valid: an integer >= 1")


@dataclass
class Label:
    """What the planner would do, one row per environment."""

    memory_before: Tensor  # (N, 18)
    phase: Tensor  # (N,) int64
    memory: Tensor  # (N, 18) or (N, A): after the phase changed
    anchors: Tensor  # (N, 42) of that memory
    action: Tensor  # (N, A) in the network's units
    lost: Tensor  # (N,) bool
    remembered: TaskMemory  # the planner's, after the phase changed


@dataclass
class Outcome:
    """What came of one control step, one row per environment."""

    terms: dict[str, Tensor]  # weighted rewards, (N,) each
    style_windows: Tensor  # (N, 1310), ending with this step
    failed: Tensor  # (N,) bool: fell
    timed_out: Tensor  # (N,) bool: over for another reason; the value goes on
    accepted: Tensor  # (N,) int64 sub-tasks that the instructor accepted in this step


class TeacherEnv:
    """See the module's docstring.

    Args:
        tasks: one per environment; they may differ in number of sub-tasks.
        config: of the episodes.
        teacher: of the networks that will act.
        prior: the controller below; never trained here.
        seed: of the episodes.
        first: the teacher that plays the first sub-task of an episode (Stage 3's teacher 1).
        number: of the first of these environments, where they are a share of more (`hv_teachers.ranks`).
        total: how many those are (default: just these); an environment's number and `total` decide its seeds.
    """

    def __init__(
        self,
        tasks: Sequence[Task],
        config: TeacherEnvConfig,
        teacher: DecisionConfig,
        prior: MotorPrior,
        seed: int,
        first: DecisionNetwork | None = None,
        *,
        number: int = 0,
        total: int | None = None,
    ) -> None:
        self.config, self.teacher, self.prior, self.seed, self.first = config, teacher, prior, seed, first
        most = max(len(task.subtasks) for task in tasks)
        self.world = RearrangeWorld(
            tasks,
            instructor=config.instructor,
            max_episode_steps=config.steps_per_subtask * most,
            num_threads=config.num_threads,
            physics=config.physics,
        )
        self.num_envs = self.world.num_envs
        self._number, self._total = number, total or self.num_envs
        self.max_steps = config.steps_per_subtask * self.world.instructor.num_subtasks
        self._rows = torch.arange(self.num_envs)
        self.units = DecisionNetwork(DecisionConfig(action=teacher.action, memory="none", hidden=(1,), geometry=0))
        self.planner = ScriptedPlanner(self.num_envs)
        self.senses = TeacherSenses(self.num_envs, teacher.memory == "phase", teacher.num_actions, config.noise)
        self.history = StyleHistory(self.num_envs)
        self.episodes = torch.zeros(self.num_envs, dtype=torch.long)
        """(N,) episodes begun so far."""
        self.start_height = torch.zeros(self.num_envs)
        self._height_of = torch.full((self.num_envs,), -1)
        # (N, 200, 3), the coordinates of each axis side by side: so the rewards read them
        self._points = torch.zeros(self.num_envs, 3, 200).mT
        self._points_of = torch.full((self.num_envs,), -1)
        self._seen: Sight | None = None
        self._placed = torch.zeros(self.num_envs, dtype=torch.bool)  # the planner would let go now
        self.ended: dict[str, float] = {}
        """Sums over the episodes that ended in the last step."""
        self.begin(self._rows)

    @property
    def learning(self) -> Tensor:
        """(N,) bool: it is the learner's turn."""
        if self.first is None:
            return torch.ones(self.num_envs, dtype=torch.bool)
        return self.world.subtask_index >= 1

    def begin(self, ids: Tensor) -> None:
        """New episodes in environments `ids` (n,)."""
        if not len(ids):
            return
        seeds = [self.seed + self._number + int(i) + self._total * int(self.episodes[i]) for i in ids]
        self.world.reset(ids, seeds=seeds)
        self.episodes[ids] += 1
        self.senses.reset(ids)
        self.planner.reset(ids)
        self.prior.reset(ids if len(ids) < self.num_envs else None)
        self.history.reset(ids)
        self._height_of[ids] = -1

    def look(self) -> Sight:
        """What is to be seen now; routes are planned anew where that is needed. Looking twice is looking once."""
        if self._seen is not None:
            return self._seen
        seen = self._seen = self.senses.look(self.world)
        index = self.world.subtask_index
        new = index != self._height_of
        height = self.world.state.object_pos_w[self._rows, self.world.object_index, 2]
        self.start_height = torch.where(new, height, self.start_height)
        self._height_of = index.clone()
        other = (self.world.object_index != self._points_of).nonzero()[:, 0]
        if len(other):
            geometry = seen.geometry[other].unflatten(-1, (-1, 3))
            self._points[other] = surface_points(geometry, seen.half_extents[other])
            self._points_of[other] = self.world.object_index[other]
        if not self.senses.remembers_phase:
            self.planner.reset((new | self.senses.lost).nonzero()[:, 0])
        return seen

    def forget_sight(self) -> None:
        """The world was changed from outside: what was seen of it is no longer so."""
        self._seen = None

    def label(self, seen: Sight) -> Label:
        """What the planner would do here: with the network's memory if it has a phase, else with its own.

        For networks that give joint targets the motor prior is run as well, on the planner's intents.
        """
        memory = self.senses.memory
        before = memory.vector(seen.view)
        if self.senses.remembers_phase:
            lend_memory(memory, self.planner)
        intent = self.planner(seen.truth)
        after = memory_of(self.planner)
        after.clock_s = after.clock_s - CONTROL_DT_S  # the planner's step has passed already
        vector = after.vector(seen.view)
        if self.senses.remembers_phase:
            anchors, inputs = hand_anchors(seen.view, vector), vector
        else:
            anchors, inputs = self.senses.inputs(seen)
        action = intent if self.teacher.action == "intent" else self.prior(seen.proprioception, intent)
        lost = self.planner.lost.clone()
        self._placed = after.phase >= Phase.RELEASE
        return Label(before, after.phase, inputs, anchors, self.units.to_units(action), lost, after)

    def follow(self, label: Label, chosen: Tensor, decision: Decision) -> Tensor:
        """(N, A) actions: the planner's where `chosen` (N,) is true, with its memory, else those decided."""
        if self.senses.remembers_phase:
            self.senses.memory = label.remembered.clone().where(chosen, self.senses.memory)
            self.senses.lost = torch.where(chosen, label.lost, self.senses.lost)
        return torch.where(chosen[:, None], label.action, decision.action)

    def decide(self, network: DecisionNetwork, seen: Sight) -> Decision:
        """Lets the network decide, and the first teacher where it is its turn; the memory moves on."""
        if self.first is None:
            return self.senses.decide([network], torch.zeros_like(self._rows), seen)
        return self.senses.decide([self.first, network], self.learning.long(), seen)

    def act(self, seen: Sight, action: Tensor) -> Outcome:
        """One control step with actions (N, A) in the network's units; episodes that are over begin anew."""
        targets = self.units.from_units(action)
        if self.teacher.action != "joints":
            targets = self.prior(seen.proprioception, self.senses.steadied(targets))
        outcome = self.move(action, targets)
        self.renew(outcome)
        return outcome

    def move(self, action: Tensor, targets: Tensor) -> Outcome:
        """As `act`, with joint targets (N, 28) that follow from the actions; episodes that are over stay so until
        `renew`."""
        world = self.world
        before = world.num_finished.clone()
        index = world.object_index
        world.step(targets)
        self._seen = None
        self.senses.acted(action)
        frame = style_frame(world.state, world.state.object_pos_w[self._rows, index], world.heading)
        windows = self.history.add(frame)
        terms = self._rewards()
        accepted = world.num_finished - before
        fell = world.fallen if self.config.end_when_fallen else torch.zeros_like(world.fallen)
        over = world.finished | (world.episode_step >= self.max_steps)
        if self.config.end_when_placed:
            over = over | self._placed
            self._placed = torch.zeros_like(self._placed)
        broken = ~torch.isfinite(world.state.link_pos_w[:, 0, 2])
        failed = fell | broken
        return Outcome(terms, windows, failed, over & ~failed, accepted)

    def renew(self, outcome: Outcome) -> None:
        """Begins new episodes where they are over; `ended` says how they went."""
        over = outcome.failed | outcome.timed_out
        self.ended = self._report(over)
        self.begin(over.nonzero()[:, 0])

    def _rewards(self) -> dict[str, Tensor]:
        x = read_world(self.world, self._points, self.start_height)
        if self.config.reward == "retreat":
            return retreat_rewards(x, self.config.retreat_reward)
        return task_rewards(x, self.config.task_reward)

    def _report(self, over: Tensor) -> dict[str, float]:
        """Sums over the episodes that end now."""
        if not over.any():
            return {}
        ids = over.nonzero()[:, 0]
        records = self.world.records(ids)
        return {
            "episodes": float(len(ids)),
            "fallen": float(sum(r.fallen for r in records)),
            "accepted": float(sum(r.num_finished for r in records)),
            "subtasks": float(sum(len(r.distances_m) for r in records)),
            "successes": float(sum(sum(r.succeeded(SUCCESS_THRESHOLDS_M[0])) for r in records)),
            "all_successes": float(sum(all(r.succeeded(SUCCESS_THRESHOLDS_M[0])) for r in records)),
            "distance": float(sum(sum(r.distances_m) for r in records)),
        }
