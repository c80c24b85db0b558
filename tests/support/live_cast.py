"""Actors for tests of hv_live that load nothing: they stand still and note what they are told."""

import torch
from torch import Tensor


class SpyActor:
    knowledge = None

    def __init__(self, needs_goal: bool = False, sees: bool = False):
        self.needs_goal, self.sees = needs_goal, sees
        """What they mean to an `hv_live.actors.Actor`; who sees looks at every picture."""
        self.told: list[str] = []
        self.pictures: list = []
        self.resets = 0

    def reset(self) -> None:
        self.resets += 1

    def needs_picture(self, world) -> bool:
        return self.sees

    def act(self, world, picture) -> tuple[Tensor, Tensor]:
        self.told += world.instructions()
        self.pictures.append(picture)
        return torch.zeros(1, 14), torch.zeros(1, 28)


class SpyCast:
    """A reader and one that needs a goal."""

    warning = "The reader only stands there."
    missing = ("student",)

    def __init__(self, first: str = "reader"):
        self.first = first
        self.actors = {"reader": SpyActor(), "teacher": SpyActor(needs_goal=True)}

    @property
    def names(self) -> list[str]:
        return list(self.actors)

    def get(self, name: str) -> SpyActor:
        if name not in self.actors:
            raise ValueError(f"policy: {name!r} is not here; valid: {', '.join(self.actors)}")
        return self.actors[name]
