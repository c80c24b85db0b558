"""Where the object and its goal are, put together from all that pictures say of them, of the goal also by the piece of
furniture that it is said to be at.

What speaks for a place is kept on a map (`hv_policy.belief.spot_map`). A picture that speaks for another place than the
likeliest does not count, and what is believed goes where that is.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import torch
from torch import Tensor

from hv_policy.belief.belief import Belief
from hv_policy.belief.landmark_head import OFFSETS
from hv_policy.belief.perception import GOAL_QUERY, Measurement, Perception, Sight
from hv_policy.belief.places import GOAL, OBJECT, SPAN
from hv_policy.belief.refusals import GOES_WITH, IGNORED_M
from hv_policy.belief.spot_map import Detections, Likeliest, SpotMap
from hv_policy.motor.vectors import turned_xy
from hv_policy.rewording import Reworder

PIECE_DOUBT, OBJECT_HALF_M = 1.5, (0.1, 0.22)
"""By how much more a piece of furniture is off than is said; and what half of an object's width may be."""
AROUND_M = 0.6
"""Two places that are so near to each other are one."""
TOO_SURE = (1.0, 2.0)
"""Of goals that are in a picture with probability p, as the network says, about p squared were right in rooms never
seen; of objects, p."""
LIKELY, SURE = 0.5, 0.7
"""From the one share on it is believed to be at a place and no other, from the other on it is looked for no longer."""
ELSEWHERE_M = 3.0
"""How far away it is if it is not there."""
PLACES = (OBJECT, GOAL)
"""By the number of the query (`hv_policy.belief.perception`)."""


class Network(Protocol):
    """What is needed of a `hv_policy.belief.student.BeliefNetwork`."""

    @property
    def perception(self) -> Perception: ...

    @property
    def reworder(self) -> Reworder: ...


@dataclass
class Looked:
    """What n pictures say, heading frame; what turns out to be wrong is taken back."""

    sight: Sight
    seen: Measurement
    gaze_rad: Tensor  # (n,) how far the camera is turned to the left
    places: Tensor  # (n, 21) m
    spread: Tensor  # (n, 21) m
    elsewhere_m: Tensor  # (n, 2) least deviation of object and goal, for they may be elsewhere altogether


class Whereabouts:
    """Of N environments, in the frame of `Belief.pose`."""

    def __init__(self, num: int) -> None:
        self.maps = (SpotMap(num), SpotMap(num))
        self.mean = torch.zeros(num, 2)
        """(N, 2) how likely pictures say that object and goal are where they are likeliest."""
        self._names: dict[str, Tensor] = {}

    def copy(self) -> Whereabouts:
        """The same, from where another future may begin."""
        return copy.deepcopy(self)

    def forget(self, env: int, place: slice | None = None) -> None:
        """Nothing is known in environment `env` of a place, `OBJECT` or `GOAL`, or of both."""
        for known, spots in zip(PLACES, self.maps, strict=True):
            if place in (None, known):
                spots.forget(env)
                self.mean[env, PLACES.index(known)] = 0.0

    def reject(self, env: int, place: slice, xy: Tensor) -> None:
        """In environment `env` a place is not around `xy` (2,)."""
        self.maps[PLACES.index(place)].reject(env, xy)

    def begin_at(self, env: int, place: slice, xy: Tensor, deviation_m: float) -> None:
        """In environment `env` a place is known to be around `xy` (2,), give or take so much."""
        self.maps[PLACES.index(place)].begin_at(env, xy, deviation_m)

    def see(
        self,
        network: Network,
        belief: Belief,
        ids: Tensor,
        instructions: Sequence[str],
        counts: Tensor,
        worse: Tensor,
        looked: Looked,
    ) -> None:
        """Takes in what pictures of environments `ids` (n,) say.

        Args:
            network: finds things by their names.
            belief: changes where it is wrong about a place.
            ids: (n,).
            instructions: n of them.
            counts: (n, 2) bool whether object and goal are looked for.
            worse: (n, 2) by how much more than is said they are off.
            looked: what the pictures say; changes.
        """
        half = belief.places[ids, SPAN].norm(dim=-1).clamp(*OBJECT_HALF_M)
        beside, has_piece = self._beside_pieces(network, instructions, looked.sight, half)
        for query, place in enumerate(PLACES):
            there = 1 - looked.seen.pointing[:, query, 0].exp()
            found = Detections(looked.places[:, place][:, :2], looked.spread[:, place][:, :2].mean(1), there)
            found = Detections(*(torch.stack(pair, 1) for pair in zip(found.columns, beside.columns, strict=True)))
            found.deviation_m *= worse[:, query, None]
            found.seen = found.seen.pow(TOO_SURE[query])
            for row in counts[:, query].nonzero()[:, 0].tolist():
                env, of_row = int(ids[row]), found.of(row, 1 + (place == GOAL and has_piece[row]))
                spots = self.maps[query]
                spots.see(env, belief.pose[env], float(looked.gaze_rad[row]), of_row)
                self._agree(belief, env, query, spots.likeliest(env), of_row, row, looked)
        nowhere = looked.seen.pointing[:, GOAL_QUERY, 0]
        looked.seen.pointing[:, GOAL_QUERY, 0] = torch.minimum(nowhere, (1 - beside.seen).clamp(min=1e-6).log())

    def _agree(
        self, belief: Belief, env: int, query: int, best: Likeliest, said: Detections, row: int, looked: Looked
    ) -> None:
        """Environment `env`, whose look is a `row` of those, believes in the likeliest place."""
        place = PLACES[query]
        xy, pose = slice(place.start, place.start + 2), belief.pose[env]
        likely = best.share > LIKELY
        self.mean[env, query] = best.mean
        away = float((belief.places[env, xy] - best.xy).norm())
        if likely and away > AROUND_M + belief.deviation_m(env, place):
            belief.settle(env, place, best.xy, AROUND_M)
        here = torch.tensor(turned_xy(-float(pose[2]), *(best.xy - pose[:2]).tolist()))
        agrees = (said.xy - here).norm(dim=-1) < AROUND_M + 2 * said.deviation_m
        if likely and not bool(agrees[0]):
            for numbers in GOES_WITH[place.start]:
                looked.spread[row, numbers] = IGNORED_M
        if len(agrees) > 1 and (bool(agrees[1]) or not likely):
            deviation = said.deviation_m[1] * (1 + belief.config.unseen * (1 - said.seen[1]))
            share = 1 / (1 + (deviation / looked.spread[row, xy]).square())
            looked.places[row, xy] += share * (said.xy[1] - looked.places[row, xy])
            looked.spread[row, xy] *= (1 - share).clamp(min=1e-6).sqrt()
        looked.elsewhere_m[row, query] = ELSEWHERE_M * (1 - best.share) * (best.share < SURE)

    def _beside_pieces(
        self, network: Network, instructions: Sequence[str], sight: Sight, half_m: Tensor
    ) -> tuple[Detections, list[bool]]:
        """The goals of n instructions as far as they follow from pieces of furniture, and whether they do."""
        told = [network.reworder.goal(text) for text in instructions]
        chosen = [row for row, (relation, noun) in enumerate(told) if relation in OFFSETS and noun]
        nothing = torch.zeros(len(told))
        found = Detections(torch.zeros(len(told), 2), nothing + IGNORED_M, nothing.clone())
        if chosen:
            named = torch.stack([self._named(network.perception, f"the {told[row][1]}") for row in chosen])[:, None]
            rows = torch.tensor(chosen)
            piece = network.perception.find_pieces(sight.of(rows.to(named.device)), named)
            offsets = named.new_tensor([OFFSETS[told[row][0]] for row in chosen])[:, None]
            found.xy[rows] = piece.spot(offsets, half_m[rows, None].to(named))[:, 0].cpu()
            found.deviation_m[rows] = PIECE_DOUBT * piece.log_spread[:, 0].exp().cpu()
            found.seen[rows] = piece.seen[:, 0].sigmoid().cpu()
        return found, [row in chosen for row in range(len(told))]

    def _named(self, perception: Perception, name: str) -> Tensor:
        """(dim,) what is looked for to find a thing."""
        if name not in self._names:
            self._names[name] = perception.named(*perception.text([name]))[0]
        return self._names[name]
