"""A student that acts while a teacher says, at every state that it comes to, what should have been done (DAgger).

The teacher is asked with the student's memory: what would it do here if it believed what the student believes about
the work, and saw where everything is? A student with no memory of phases would be asked with the teacher's own.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch
from lerobot.configs.policies import PreTrainedConfig
from torch import Tensor

from hv_policy.batch_invariant import atan2
from hv_policy.belief.acting import BeliefStudent
from hv_policy.belief.belief import BeliefConfig
from hv_policy.belief.places import turned
from hv_policy.belief.student import Following
from hv_policy.decision.memory import TaskMemory
from hv_policy.decision.view import Phase
from hv_policy.modeling_hv import HVPolicy
from hv_sim.rendering import StepCamera
from hv_sim.world import RearrangeWorld
from hv_teachers.knowledge import Knowledge
from hv_teachers.teacher import Teacher, TeacherSenses, load_shipped_teacher

_STRETCH_STEPS = 90


def load_student(folder: Path) -> HVPolicy:
    """An `hv` policy of the form `belief`.

    Raises:
        ValueError: the folder holds another policy, or none.
    """
    import lerobot_policy_hv  # noqa: F401  (makes the type known)

    try:
        config = PreTrainedConfig.from_pretrained(folder)
    except (OSError, ValueError, KeyError) as error:
        raise ValueError(f"policy: {folder} cannot be read ({' '.join(str(error).split())[:150]})") from error
    form = getattr(config, "form", None)
    if config.type != "hv" or form != "belief":
        raise ValueError(f"policy: {folder} is of type {config.type}, form {form}; valid: type hv, form belief")
    config.pretrained_path = folder
    config.device = "cpu"
    policy = HVPolicy.from_pretrained(folder, config=config)
    policy.eval()
    return policy


class CorrectedStudent:
    """A recorder's expert: the student does, the teacher says (`executed` and what a call returns).

    Args:
        num_envs: environments of the worlds it will be shown.
        folder: of the student's checkpoint (`pretrained_model`).
        beta: share of the time, in stretches of three seconds drawn from the episode's seed, in which the teacher acts.

    Raises:
        ValueError: it is none, or the package comes without teachers.
    """

    def __init__(self, num_envs: int, folder: str, beta: float = 0.0) -> None:
        student = load_student(Path(folder)).student
        assert isinstance(student, BeliefStudent)
        self.student = student
        self.teacher: Teacher = load_shipped_teacher()
        self.executed: Tensor | None = None
        """(N, 28) what is done."""
        self.knowledge: Knowledge | None = None
        self._beta = beta
        self._camera: StepCamera | None = None
        self._following: Following | None = None
        self._senses: TeacherSenses | None = None

    def reset(self, ids: Tensor | None = None) -> None:
        """Forgets everything."""
        self._following = self._senses = None

    def see_through(self, camera: StepCamera) -> None:
        """The camera that pictures of the environments come from."""
        self._camera = camera

    @torch.no_grad()
    def __call__(self, world: RearrangeWorld) -> tuple[Tensor, Tensor]:
        """The teacher's intents (N, 14) and servo targets (N, 28) in rad; what is done is `executed`."""
        instructions = world.instructions()
        if self._following is None or self._senses is None:
            self._following = Following.begin(self.student.network, instructions, BeliefConfig())
            self._senses = TeacherSenses(world.num_envs, True, 14)
        following, senses = self._following, self._senses
        following.hear(instructions)
        state = world.observe().proprioception
        before = following.memory.clone()
        assert self._camera is not None, "a student that sees needs see_through(camera)"
        # its odometry is up to date from here on
        decided = see_and_decide(self.student, following, world, self._camera, state)
        intent, targets = self._corrections(world, following, before, senses, state)
        if self._beta > 0:
            leads = teacher_leads(world.episode_seed, world.episode_step.tolist(), self._beta)
            decided = torch.where(leads[:, None], intent, decided)
            senses.memory.tick()
            following.memory = _moved(senses.memory, true_pose(world), following.belief.pose).where(
                leads, following.memory
            )
        self.executed = following.prior(state, decided)
        senses.lost = (following.memory.phase == Phase.APPROACH) & (before.phase >= Phase.LIFT)
        return intent, targets

    def _corrections(
        self, world: RearrangeWorld, following: Following, before: TaskMemory, senses: TeacherSenses, state: Tensor
    ) -> tuple[Tensor, Tensor]:
        """What the teacher would do now, with the memory that the student had `before` it decided, and its gait."""
        memory = _moved(before, following.belief.pose, true_pose(world))
        senses.memory = memory.clone()
        seen = senses.look(world)
        senses.memory = memory  # a new route does not change what the student remembers
        vector = memory.vector(seen.view)
        who = world.subtask_index.clamp(max=len(self.teacher.networks) - 1)
        decided = senses.decide(self.teacher.networks, who, seen)
        done, phase = world.navigator.leg_is_done, senses.memory.phase
        self.knowledge = Knowledge.of(seen.truth, done, vector, phase)
        intent = self.teacher.networks[0].from_units(decided.action)
        return intent, following.prior.copied()(state, intent)


def see_and_decide(
    student: BeliefStudent, following: Following, world: RearrangeWorld, camera: StepCamera, state: Tensor
) -> Tensor:
    """(N, 14) a student's intents in a world that it sees through a camera, from proprioceptions (N, 223)."""
    looks, size = following.looks, student.config.image_size
    pictures = torch.zeros(len(looks), 3, size, size)
    for row, env in enumerate(looks.tolist()):
        if not bool(world.done[env]):
            pictures[row] = torch.from_numpy(camera.picture(env)).permute(2, 0, 1).float() / 255
    words, is_word = student.reader.recall(following.instructions)
    return following.decide(student.network, pictures, state, words, is_word)


def teacher_leads(seeds: Sequence[int | None], steps: Sequence[int], beta: float) -> Tensor:
    """(N,) bool: the teacher acts in this stretch of the episode with that seed."""
    stretches = zip(seeds, steps, strict=True)
    drawn = [np.random.default_rng([seed or 0, step // _STRETCH_STEPS]).uniform() < beta for seed, step in stretches]
    return torch.tensor(drawn)


def true_pose(world: RearrangeWorld) -> Tensor:
    """(N, 3) x, y, yaw of the robots in the world."""
    heading = world.heading
    yaw = atan2(heading.sin, heading.cos)
    return torch.cat([world.state.link_pos_w[:, 0, :2], yaw[:, None]], -1)


def _moved(memory: TaskMemory, from_pose: Tensor, to_pose: Tensor) -> TaskMemory:
    """The memory with its one place in another frame, in which the robot's pose (N, 3) is another one."""
    moved, turn = memory.clone(), -from_pose[:, 2:]
    ahead = turned(memory.from_object_w[:, :2] - from_pose[:, :2], turn.cos(), turn.sin())
    xy = turned(ahead, to_pose[:, 2:].cos(), to_pose[:, 2:].sin()) + to_pose[:, :2]
    moved.from_object_w = torch.cat([xy, memory.from_object_w[:, 2:]], -1)
    return moved
