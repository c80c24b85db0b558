"""Errors of what a teacher sees, as a student makes them that sees through a camera: slow, and larger far away.

Each number that a picture has to tell is wrong by a sum of a constant and three slow waves, drawn from the episode's
seed: the same episode has the same errors in whatever company it is played.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch
from torch import Tensor

from hv_policy.decision.view import TaskView
from hv_policy.motor.embodiment import CONTROL_DT_S
from hv_sim.observations import Heading, Observation

_OBJECT, _GOAL, _GRASP = slice(0, 3), slice(3, 6), slice(6, 12)
_PICK, _PLACE, _WAYPOINT, _DEPTH = slice(12, 15), slice(15, 18), slice(18, 20), 20
_CHANNELS, _WAVES = 21, 3
_LOWEST_HZ, _HIGHEST_HZ = 0.03, 0.8
_HELD_M = 0.3
_WAYPOINT_M = 0.8


@dataclass(frozen=True)
class SightNoiseConfig:
    """Deviation of the errors of places: `near_m`, and `per_m` more for each metre of distance. The error of an
    episode is between none and twice that.

    Raises:
        ValueError: a field is negative.
    """

    near_m: float = 0.0
    per_m: float = 0.0

    def __post_init__(self) -> None:
        for name in ("near_m", "per_m"):
            if getattr(self, name) < 0:
                raise ValueError(f"env.noise.{name}: {getattr(self, name)} is not valid; valid: a number >= 0")


class SightNoise:
    """Keeps the waves of every environment; they are drawn anew when an environment's episode has another seed."""

    def __init__(self, num_envs: int, config: SightNoiseConfig) -> None:
        self.config = config
        self._seeds: list[int | None] = [None] * num_envs
        self._constant = torch.zeros(num_envs, _CHANNELS)
        self._amplitude, self._frequency, self._phase = (torch.zeros(num_envs, _CHANNELS, _WAVES) for _ in range(3))

    def errors(self, seeds: Sequence[int | None], step: Tensor) -> Tensor:
        """(N, 21) errors of unit deviation on average, for episodes of these seeds at control step `step` (N,)."""
        for i, seed in enumerate(seeds):
            if seed != self._seeds[i]:
                self._draw(i, seed or 0)
                self._seeds[i] = seed
        time = step[:, None, None] * CONTROL_DT_S
        waves = self._amplitude * torch.sin(2 * torch.pi * self._frequency * time + self._phase)
        return self._constant + waves.sum(-1)

    def _draw(self, env: int, seed: int) -> None:
        rng = np.random.default_rng([seed, 7])
        size = (_CHANNELS, _WAVES)
        scale = rng.uniform(0.0, 2.0)
        self._constant[env] = torch.from_numpy(scale * 0.7 * rng.standard_normal(_CHANNELS))
        self._amplitude[env] = torch.from_numpy(scale * 0.7 * np.sqrt(2 / _WAVES) * np.abs(rng.standard_normal(size)))
        self._frequency[env] = torch.from_numpy(_LOWEST_HZ * (_HIGHEST_HZ / _LOWEST_HZ) ** rng.uniform(0.0, 1.0, size))
        self._phase[env] = torch.from_numpy(rng.uniform(0, 2 * np.pi, size))

    def __call__(
        self,
        seeds: Sequence[int | None],
        step: Tensor,
        view: TaskView,
        observation: Observation,
        heading: Heading,
    ) -> tuple[TaskView, Observation]:
        """View and observation as they would be seen with errors; what is given stays as it is."""
        error = self.errors(seeds, step)
        near, per_m = self.config.near_m, self.config.per_m

        def spread(place: Tensor) -> Tensor:
            return near + per_m * (place[:, :2] - view.root_xy).norm(dim=-1, keepdim=True)

        held = (view.object_pos - view.hands.mean(1)).norm(dim=-1, keepdim=True) < _HELD_M
        at_object = torch.where(held, torch.full_like(view.depth_m[:, None], near), spread(view.object_pos))
        object_error = error[:, _OBJECT] * at_object * error.new_tensor([1.0, 1.0, 0.7])
        goal_error = error[:, _GOAL] * spread(view.goal_pos) * error.new_tensor([1.0, 1.0, 0.5])
        grasp_error = object_error[:, None] + error[:, _GRASP].unflatten(-1, (2, 3)) * 0.5 * at_object[:, None]
        waypoint_error = error[:, _WAYPOINT] * (near + per_m * _WAYPOINT_M)

        def stand(pose: Tensor, e: Tensor) -> Tensor:
            away = spread(pose)
            return pose + torch.cat([e[:, :2] * away, e[:, 2:] * (2.0 * away).clamp(max=0.3)], -1)

        seen = replace(
            view,
            object_pos=view.object_pos + object_error,
            goal_pos=view.goal_pos + goal_error,
            grasp=view.grasp + grasp_error,
            pick_stand=stand(view.pick_stand, error[:, _PICK]),
            place_stand=stand(view.place_stand, error[:, _PLACE]),
            waypoint=view.waypoint + waypoint_error,
            depth_m=view.depth_m * (1.0 + 2.0 * near * error[:, _DEPTH]).clamp(min=0.5),
        )

        def moved(numbers: Tensor, error_w: Tensor) -> Tensor:
            change = torch.zeros_like(numbers)
            change[:, :3] = heading.rotate(error_w)
            return numbers + change

        flat = torch.cat([waypoint_error, torch.zeros_like(waypoint_error[:, :1])], -1)
        return seen, replace(
            observation,
            object=moved(observation.object, object_error),
            goal=moved(observation.goal, goal_error),
            waypoint=moved(observation.waypoint, flat),
        )
