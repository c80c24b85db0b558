"""The simulated user: decides when the next instruction is given (Algorithm 3 of the paper), latched and batched.

The paper states the rule for two objects and re-evaluates it every step. Here it holds for any number of sub-tasks,
must hold for several steps in a row, and never takes an instruction back.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields

import torch
from torch import Tensor


@dataclass(frozen=True)
class InstructorConfig:
    """Thresholds of Algorithm 3. `None` switches a distance or speed condition off (the paper's ablations).

    The values are ours: the paper names the thresholds but does not give them.

    Raises:
        ValueError: a threshold is negative or not finite.
    """

    max_object_speed_m_s: float | None = 0.15
    """The object has come to rest: its linear speed is below this."""
    max_object_goal_distance_m: float | None = 0.4
    """The object is where it should be: its distance to the goal is below this."""
    min_robot_object_distance_m: float | None = 0.8
    """The robot has let go and stepped back: horizontal distance between pelvis and object is above this."""
    min_steps: int = 45
    """More control steps than this have passed since the current instruction was given."""
    hold_steps: int = 10
    """All conditions have held for this many control steps in a row."""

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            optional = field.name.startswith(("max_", "min_robot"))
            if value is None and optional:
                continue
            if value is None or not math.isfinite(value) or value < 0:
                valid = "a number >= 0" + (" or null" if optional else "")
                raise ValueError(f"instructor.{field.name}: {value!r} is not valid; valid: {valid}")


class Instructor:
    """Holds, for every environment, which sub-task's instruction is in force.

    Args:
        num_subtasks: sub-tasks of each environment's task, (N,) positive integers; they may differ.
        config: thresholds (default: `InstructorConfig()`).
        device: where its tensors live.
    """

    def __init__(
        self,
        num_subtasks: Sequence[int] | Tensor,
        config: InstructorConfig | None = None,
        *,
        device: torch.device | str = "cpu",
    ) -> None:
        self.config = InstructorConfig() if config is None else config
        self.num_subtasks = torch.as_tensor(num_subtasks, dtype=torch.int64, device=device)
        if self.num_subtasks.ndim != 1 or not len(self.num_subtasks) or int(self.num_subtasks.min()) < 1:
            raise ValueError(
                f"num_subtasks: {num_subtasks!r} is not valid; valid: one integer >= 1 for each environment"
            )
        self._index: tuple[tuple[int, int], Tensor] | None = None
        self.num_finished = torch.zeros_like(self.num_subtasks)
        """(N,) sub-tasks finished so far; `num_subtasks` once all are."""
        self.steps_since_instruction = torch.zeros_like(self.num_subtasks)
        """(N,) control steps since the current instruction was given (Algorithm 3's p)."""
        self.steps_held = torch.zeros_like(self.num_subtasks)
        """(N,) control steps in a row for which every condition has held."""

    @property
    def subtask_index(self) -> Tensor:
        """(N,) index of the sub-task whose instruction is in force; the last one's stays when all are finished."""
        # both change in place only, and this is asked for a dozen times a step
        versions = self.num_finished._version, self.num_subtasks._version
        if self._index is None or self._index[0] != versions:
            self._index = versions, torch.minimum(self.num_finished, self.num_subtasks - 1)
        return self._index[1]

    @property
    def finished(self) -> Tensor:
        """(N,) bool: every sub-task of the environment is finished."""
        return self.num_finished >= self.num_subtasks

    def reset(self, ids: Sequence[int] | Tensor | None = None) -> None:
        """Gives the first instruction in environments `ids` (default: all)."""
        rows = slice(None) if ids is None else torch.as_tensor(ids, dtype=torch.int64, device=self.num_finished.device)
        for counter in (self.num_finished, self.steps_since_instruction, self.steps_held):
            counter[rows] = 0

    def update(
        self,
        object_speed_m_s: Tensor,
        object_goal_distance_m: Tensor,
        robot_object_distance_m: Tensor,
        active: Tensor | None = None,
    ) -> Tensor:
        """One control step of Algorithm 3.

        Args:
            object_speed_m_s: (N,) linear speed of the current sub-task's object.
            object_goal_distance_m: (N,) distance of that object from its goal.
            robot_object_distance_m: (N,) horizontal distance of the pelvis from that object.
            active: (N,) bool, environments whose time passes (default: all).

        Returns:
            (N,) bool: the environments whose current sub-task was finished in this step.
        """
        config = self.config
        running = ~self.finished if active is None else active & ~self.finished
        self.steps_since_instruction += running
        holds = running & (self.steps_since_instruction > config.min_steps)
        if config.max_object_speed_m_s is not None:
            holds &= object_speed_m_s < config.max_object_speed_m_s
        if config.max_object_goal_distance_m is not None:
            holds &= object_goal_distance_m < config.max_object_goal_distance_m
        if config.min_robot_object_distance_m is not None:
            holds &= robot_object_distance_m > config.min_robot_object_distance_m
        self.steps_held = torch.where(running, (self.steps_held + 1) * holds, self.steps_held)
        switched = holds & (self.steps_held >= config.hold_steps)
        if switched.any():
            self.num_finished += switched
            self.steps_since_instruction[switched] = 0
            self.steps_held[switched] = 0
        return switched
