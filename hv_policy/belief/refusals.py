"""What turned out not to be meant: who has put something down where it should be, and hears the same instruction still,
has taken the wrong thing or brought it to the wrong place. A picture alone does not say so a second time either."""

from __future__ import annotations

import torch
from torch import Tensor

from hv_policy.belief.places import DEPTH, GOAL, MIDDLE, OBJECT, PICK, PICK_TURN, PLACE, PLACE_TURN, SPAN, to_frame
from hv_policy.decision.view import Phase

AGREE_M = 0.25
"""A thing so near to its goal was put down where it was meant to be put; farther away it was put down badly."""
AROUND_M = 0.45
"""So far around what was refused nothing is believed to be meant."""
SURE = 0.9
"""Goals that are seen in a smaller share of the pictures are refused before the thing is."""
_LATEST = 0.1
_IGNORED_M = 1e3
_GOES_WITH = {OBJECT.start: (OBJECT, SPAN, MIDDLE, PICK, PICK_TURN, DEPTH), GOAL.start: (GOAL, PLACE, PLACE_TURN)}


class Refusals:
    """Of N environments; all places in the frame of odometry."""

    def __init__(self, num: int) -> None:
        self.seen = torch.ones(num, 2)
        """(N, 2) in which share of the latest pictures the object, while it was walked to, and its goal were seen."""
        self._refused: list[list[tuple[slice, Tensor]]] = [[] for _ in range(num)]
        self._missed = [False] * num

    def forget(self, env: int) -> None:
        """Environment `env` has something else to do."""
        self._refused[env], self._missed[env] = [], False
        self.seen[env] = 1.0

    def see(self, ids: Tensor, in_view: Tensor, phase: Tensor) -> None:
        """Environments `ids` (n,) in phases (n,) saw the object and its goal with probabilities `in_view` (n, 2)."""
        counts = torch.stack([phase <= Phase.REACH, (phase >= Phase.CARRY) & (phase <= Phase.LOWER)], -1)
        self.seen[ids] += _LATEST * counts * (in_view - self.seen[ids])

    def refuse(self, env: int, places: Tensor) -> slice | None:
        """Decides which was wrong in environment `env`, `OBJECT` or `GOAL`; `None`: it did not get where it should.

        The first time it is the goal, which may be right and was seen badly, past the thing in the hands: it may be
        where it was. After that it is one of the two, and not where it was.

        Args:
            env: its number.
            places: (21,) what it believes.
        """
        if float((places[OBJECT] - places[GOAL]).norm()) > AGREE_M:
            return None
        if not self._missed[env]:
            self._missed[env] = True
            return GOAL
        so_far = [place for place, _ in self._refused[env]]
        goal_first = float(self.seen[env, 1]) < SURE and so_far.count(GOAL) <= so_far.count(OBJECT)
        place = GOAL if goal_first else OBJECT
        self._refused[env].append((place, places[place][:2].clone()))
        return place

    def applied(self, ids: Tensor, pose: Tensor, places_h: Tensor, spread: Tensor) -> Tensor:
        """(n, 21) deviations (n, 21) of the places that pictures of environments `ids` show, where what was refused
        tells nothing.

        Args:
            ids: (n,).
            pose: (n, 3) of the robots.
            places_h: (n, 21) heading frame.
            spread: (n, 21) m.
        """
        if not any(self._refused[env] for env in ids.tolist()):
            return spread
        seen, out = to_frame(places_h, pose), spread.clone()
        for row, env in enumerate(ids.tolist()):
            for place, at in self._refused[env]:
                if float((seen[row, place][:2] - at).norm()) < AROUND_M:
                    for numbers in _GOES_WITH[place.start]:
                        out[row, numbers] = _IGNORED_M
        return out
