"""Kinds of things by their names, among them kinds without end that are made up."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import TypeVar

import numpy as np

Kind = TypeVar("Kind")


class Kinds(dict[str, Kind]):
    """Kinds by their names; those that are made up are found, too, but not listed.

    Args:
        known: the others.
        prefix, count: made-up ones are called by a prefix and a number of four digits below `count`.
        make: the made-up kind of a number, always the same.
    """

    def __init__(self, known: Mapping[str, Kind], prefix: str, count: int, make: Callable[[int], Kind]) -> None:
        super().__init__(known)
        self._pattern, self._prefix = re.compile(rf"{prefix}(\d{{4}})"), prefix
        self._count, self._make = count, make

    def made_up_name(self, number: int) -> str:
        """What made-up kind number `number` is called in a task."""
        return f"{self._prefix}{number:04d}"

    def draw_made_up(self, rng: np.random.Generator) -> str:
        """The name of one of the made-up kinds."""
        return self.made_up_name(int(rng.integers(self._count)))

    def made_up_number(self, name: object) -> int | None:
        """Which made-up kind a name names, None if none."""
        found = self._pattern.fullmatch(name) if isinstance(name, str) else None
        return int(found[1]) if found and int(found[1]) < self._count else None

    def __missing__(self, name: str) -> Kind:
        number = self.made_up_number(name)
        if number is None:
            raise KeyError(name)
        return self._make(number)

    def __contains__(self, name: object) -> bool:
        return super().__contains__(name) or self.made_up_number(name) is not None
