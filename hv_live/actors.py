"""Who plays: the student, a teacher, the planner, or any LeRobot checkpoint, one robot at a time."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Protocol

import numpy as np
import torch
from torch import Tensor

from hv_policy.network_file import SHIPPED_STUDENT
from hv_sim.world import RearrangeWorld
from hv_teachers.evaluated_policies import load_evaluated_policy
from hv_teachers.expert import expert_maker
from hv_teachers.knowledge import Knowledge
from hv_teachers.teacher import TEACHER_FILES, WEIGHTS

HEAD_SIZE_PX = 128
"""Side of the picture that a policy sees, as in recorded datasets and in hv-eval."""


class Actor(Protocol):
    """What moves the robot of a world of one."""

    needs_goal: bool
    """It is told object and goal, not words: an instruction that cannot be grounded means nothing to it."""

    @property
    def knowledge(self) -> Knowledge | None:
        """What it knew when it last acted; None where that cannot be said."""

    def reset(self) -> None:
        """Forgets everything; an episode begins, or this one is taken over."""

    def needs_picture(self, world: RearrangeWorld) -> bool:
        """Whether it will look at the head camera's picture when it acts next."""

    def act(self, world: RearrangeWorld, picture: np.ndarray | None) -> tuple[Tensor, Tensor]:
        """Decides for the world's present state.

        Args:
            world: a world of one environment.
            picture: (HEAD_SIZE_PX, HEAD_SIZE_PX, 3) uint8 of the head camera; None only where it does not need
                one.

        Returns:
            Intent (1, 14), zeros where it has none, and servo targets (1, 28) in rad.
        """


class PrivilegedActor:
    """The planner or the teachers: they know the state."""

    needs_goal = True

    def __init__(self, name: str) -> None:
        self._expert = expert_maker(name)(1)

    @property
    def knowledge(self) -> Knowledge | None:
        return self._expert.knowledge

    def reset(self) -> None:
        self._expert.reset()

    def needs_picture(self, world: RearrangeWorld) -> bool:
        return False

    def act(self, world: RearrangeWorld, picture: np.ndarray | None) -> tuple[Tensor, Tensor]:
        with torch.no_grad():
            return self._expert(world)


class ReadingActor:
    """A LeRobot policy: it sees the head camera, feels its body and reads the instruction, through `select_action`."""

    needs_goal = False
    knowledge = None

    def __init__(self, folder: str) -> None:
        self._policy = load_evaluated_policy(folder)
        self._seen = np.zeros((HEAD_SIZE_PX, HEAD_SIZE_PX, 3), np.uint8)

    def reset(self) -> None:
        self._policy.reset(1)

    def needs_picture(self, world: RearrangeWorld) -> bool:
        return self._policy.needs_picture(world)

    def act(self, world: RearrangeWorld, picture: np.ndarray | None) -> tuple[Tensor, Tensor]:
        self._seen = self._seen if picture is None else picture
        feeling = world.observe().proprioception[0].numpy().astype(np.float32)
        targets = self._policy(world, {"pixels": {"head": self._seen}, "agent_pos": feeling})
        return torch.zeros(1, 14), targets


class Cast:
    """Those who can play here, by name, each loaded when it is first wanted.

    Args:
        policy: `student`, `teacher`, `planner`, or a folder (of teachers, or of a LeRobot policy), which then is one
            more to choose, under its own name.

    Raises:
        ValueError: there is no such policy.
    """

    def __init__(self, policy: str = "student") -> None:
        self.warning = ""
        """What to tell whoever asked for somebody who is not there."""
        makers: dict[str, Callable[[], Actor]] = {}
        if (SHIPPED_STUDENT / "config.json").is_file():
            makers["student"] = partial(ReadingActor, str(SHIPPED_STUDENT))
        if all((WEIGHTS / file).is_file() for file in TEACHER_FILES):
            makers["teacher"] = partial(PrivilegedActor, "teacher")
        makers["planner"] = partial(PrivilegedActor, "planner")
        if policy not in ("student", "teacher", "planner"):
            folder = Path(policy)
            if not folder.is_dir():
                raise ValueError(f"policy: {policy!r} is not known; valid: {', '.join(makers)}, or a folder")
            name = folder.resolve().name if folder.resolve().name not in makers else str(folder.resolve())
            kind = PrivilegedActor if (folder / TEACHER_FILES[0]).is_file() else ReadingActor
            makers = {name: partial(kind, policy), **makers}
            policy = name
        elif policy not in makers:
            instead = next(name for name in ("teacher", "planner") if name in makers)
            self.warning = f"The {policy}'s weights do not come with this package yet; the {instead} plays."
            policy = instead
        self.first = policy
        """Who plays at first."""
        self.names = list(makers)
        self.missing = [name for name in ("student", "teacher") if name not in makers]
        """Whose weights do not come with this package."""
        self._makers = makers
        self._loaded: dict[str, Actor] = {}
        self.get(self.first)  # what is wrong with it is said at once

    def get(self, name: str) -> Actor:
        """The actor of that name.

        Raises:
            ValueError: there is none, or its weights cannot be read.
        """
        if name not in self._makers:
            raise ValueError(f"policy: {name!r} is not here; valid: {', '.join(self.names)}")
        if name not in self._loaded:
            self._loaded[name] = self._makers[name]()
        return self._loaded[name]
