"""The first privileged controller: the scripted planner says what to do, the motor prior does it."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

import torch
from torch import Tensor

from hv_policy.decision.rising import Rising
from hv_policy.motor.prior import MotorPrior, load_shipped_motor_prior
from hv_sim.observations import proprioception
from hv_sim.rendering import StepCamera
from hv_sim.world import RearrangeWorld
from hv_teachers.corrected_student import CorrectedStudent
from hv_teachers.knowledge import Knowledge
from hv_teachers.planner import PlannerConfig, ScriptedPlanner
from hv_teachers.planner_memory import memory_of
from hv_teachers.routes import RouteViews, gave_up, replan_routes
from hv_teachers.teacher import TEACHER_FILES, Teacher, load_shipped_teacher


class _Does:
    """Does what it says, and needs no pictures."""

    executed: Tensor | None = None

    def see_through(self, camera: StepCamera) -> None:
        """It sees everything anyway."""


class PlannerExpert(_Does):
    """Plays any number of sub-tasks in every environment of a world: `intent, joint_targets = expert(world)`.

    It follows the world's own bookkeeping: a new episode or a new instruction starts the script anew, and an object
    that
    slipped away is fetched again along a new route.

    Args:
        num_envs: environments of the worlds it will be shown.
        prior: the controller below it (default: the shipped one).
        planner: speeds and distances of the script.
    """

    def __init__(self, num_envs: int, prior: MotorPrior | None = None, planner: PlannerConfig | None = None) -> None:
        self.prior = prior or load_shipped_motor_prior()
        self.planner = ScriptedPlanner(num_envs, planner)
        self.routes = RouteViews(num_envs)
        self.knowledge: Knowledge | None = None
        """What it knew when it was last asked."""
        self._rows = torch.arange(num_envs)
        self._gave_up = torch.zeros(num_envs, dtype=torch.bool)
        self._rising = Rising(num_envs)
        self._risen_from = self.planner.phase.clone()  # at the last step

    def reset(self, ids: Tensor | None = None) -> None:
        """Forgets environments `ids` (default: all); needed only between worlds, a new episode is noticed."""
        rows = self._rows if ids is None else torch.as_tensor(ids)
        self.planner.reset(rows)
        self._risen_from[rows] = self.planner.phase[rows]
        self._gave_up[rows] = False
        self._rising.reset(rows)
        self.prior.reset(None if ids is None else rows)
        self.routes.reset(rows)

    def __call__(self, world: RearrangeWorld) -> tuple[Tensor, Tensor]:
        """Intents (N, 14) and servo targets (N, 28) in rad for the world's present state."""
        begun = (world.episode_step == 0).nonzero()[:, 0]
        if len(begun):
            self.reset(begun if len(begun) < world.num_envs else None)
        # an object that slipped away, or was kicked before it was lifted, needs a new way to it
        kicked = self.routes.disturbed(world, self.planner.phase)
        in_vain = self.planner.lost | self._gave_up
        self.routes.spurn(in_vain.nonzero()[:, 0])
        replan_routes(world, ((in_vain | kicked) & ~world.done).nonzero()[:, 0], self.routes.spurned_rad)
        changed = self.routes.follow(world)
        self.planner.reset(changed[~self.planner.lost[changed]])  # a new sub-task, not one that is tried again
        heading = world.heading
        view = self.routes.view(world, heading)
        memory = memory_of(self.planner).vector(view)
        before = self.planner.phase
        decided = self.planner(view)
        self._rising.begin_where_given_up(self._risen_from, self.planner.phase)
        self._risen_from = self.planner.phase.clone()
        intent = self._rising(decided)
        self._gave_up = gave_up(before, self.planner.phase, self.planner.clock_s)
        self.knowledge = Knowledge.of(view, world.navigator.leg_is_done, memory, self.planner.phase)
        return intent, self.prior(proprioception(world.state, heading), intent)


class TeacherExpert(_Does):
    """The teachers as a recorder's expert: `intent, joint_targets = expert(world)`.

    Args:
        num_envs: environments of the worlds it will be shown.
        folder: of the teachers (`hv_teachers.teacher.Teacher.save`); None for those of the package.

    Raises:
        ValueError: there are none.
    """

    def __init__(self, num_envs: int, folder: str | None = None) -> None:
        self.teacher = load_shipped_teacher() if folder is None else Teacher.load(Path(folder))

    def reset(self, ids: Tensor | None = None) -> None:
        """Forgets environments `ids` (default: all)."""
        self.teacher.reset(ids)

    def __call__(self, world: RearrangeWorld) -> tuple[Tensor, Tensor]:
        """Intents (N, 14) and servo targets (N, 28) in rad for the world's present state."""
        return self.teacher.decide(world)

    @property
    def knowledge(self) -> Knowledge | None:
        """What it knew when it was last asked."""
        return self.teacher.knowledge


def expert_maker(policy: str, beta: float = 0.0) -> Callable[[int], PlannerExpert | TeacherExpert | CorrectedStudent]:
    """What builds an expert for a number of environments: `planner`, `teacher`, a folder of teachers, or one of a
    student, who then acts while the teacher says what should be done, and acts itself in a share `beta` of the time.

    Raises:
        ValueError: it is none of these, or its weights cannot be read.
    """
    if policy == "planner":
        return PlannerExpert
    if (Path(policy) / "config.json").is_file():
        student = partial(CorrectedStudent, folder=policy, beta=beta)
        student(1)
        return student
    if policy != "teacher" and not (Path(policy) / TEACHER_FILES[0]).is_file():
        raise ValueError(
            f"policy: {policy!r} is not known; valid: planner, teacher, a folder of teachers or of a student"
        )
    make = partial(TeacherExpert, folder=None if policy == "teacher" else policy)
    make(1)  # so that what is wrong is said before anything is begun
    return make
