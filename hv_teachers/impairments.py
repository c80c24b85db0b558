"""What is taken from a policy that sees while it is evaluated: a modality (Table 5), or the right instruction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hv_sim.world import RearrangeWorld, pick_phrasing

MODALITIES = ("vision", "language", "proprioception")


@dataclass(frozen=True)
class Impairments:
    """See the module's docstring.

    Args:
        without: modalities in `MODALITIES` that are blanked: a black picture, no words, zeros.
        wrong_instruction: in each sub-task the robot is told the one after it (in the last one, the first). One that
            listens moves the object that it is told, and leaves the one that the sub-task is about.

    Raises:
        ValueError: a modality is unknown or named twice.
    """

    without: tuple[str, ...] = ()
    wrong_instruction: bool = False

    def __post_init__(self) -> None:
        for name in self.without:
            if name not in MODALITIES or self.without.count(name) > 1:
                raise ValueError(f"without: {name!r} is not valid; valid: each of {', '.join(MODALITIES)} once")

    def __bool__(self) -> bool:
        return bool(self.without) or self.wrong_instruction

    def told(self, world: RearrangeWorld) -> list[str]:
        """The instructions that the robot hears, one for each environment."""
        if "language" in self.without:
            return [""] * world.num_envs
        if not self.wrong_instruction:
            return world.instructions()
        told = []
        for task, index, seed in zip(world.tasks, world.subtask_index.tolist(), world.episode_seed, strict=True):
            other = (index + 1) % len(task.subtasks)
            told.append(pick_phrasing(task.subtasks[other].phrasings, seed or 0, other))
        return told

    def seen(self, observation: dict[str, Any]) -> dict[str, Any]:
        """`RearrangeEnv`'s observation without what is taken away."""
        pictures, joints = observation["pixels"], observation["agent_pos"]
        if "vision" in self.without:
            pictures = {name: np.zeros_like(picture) for name, picture in pictures.items()}
        if "proprioception" in self.without:
            joints = np.zeros_like(joints)
        return {**observation, "pixels": pictures, "agent_pos": joints}


NOTHING_TAKEN = Impairments()


def read_impairments(without: Sequence[str], wrong_instruction: bool) -> Impairments:
    """As a configuration names them; the order of modalities does not matter.

    Raises:
        ValueError: see `Impairments`.
    """
    return Impairments(tuple(sorted(without)), wrong_instruction)
