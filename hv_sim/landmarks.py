"""What can be named in a room, and where it is: every object, piece of furniture and spot that some words fit alone.

A task is about two objects and two places. Whoever learns what words look like can learn from all the others, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

from hv_sim.furniture import FURNITURE_KINDS
from hv_sim.lexicon import (
    COLOR_WORDS,
    PLACE_WORDS,
    called,
    color_fits,
    furniture_nouns,
    looks,
    object_nouns,
    usable,
)
from hv_sim.places import BESIDE, BY_THE_MIDDLE, ON, Layout, Place, layout_at
from hv_sim.task import FurniturePlacement, Task

_SPOT_HEIGHT_M = 0.1
"""Above the floor or the top: about where the middle of what would stand there is."""


@dataclass(frozen=True)
class Landmark:
    """A thing or spot of a room, words that fit it alone, and where it is in the world.

    Attributes:
        phrases: each of them fits nothing else ("the red box", "the box that is on the dresser", "just behind the
            sofa"); a thing that is like another has none.
        is_spot: it is a place to put something, not a thing.
        position_m: the middle of a thing; for an object where it is at first, see `object`.
        half_extents_m: of a thing's box, along its own axes; zeros for a spot.
        yaw_rad: of that box.
        object: name of the object that it is, "" if it is none.
    """

    phrases: tuple[str, ...]
    is_spot: bool
    position_m: tuple[float, float, float]
    half_extents_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    yaw_rad: float = 0.0
    object: str = ""


@cache
def landmarks(task: Task, subtask: int) -> tuple[Landmark, ...]:
    """All landmarks of a task when sub-task number `subtask` begins, in words that seen instructions use."""
    layout = layout_at(task, subtask)
    found = []
    for name, (position, yaw) in layout.poses.items():
        half = tuple(layout.half_extents_m[name].tolist())
        found.append(Landmark(_object_phrases(layout, name), False, position, half, yaw, name))
    for piece in task.furniture:
        kind = FURNITURE_KINDS[piece.kind]
        nouns = [n for n in usable(furniture_nouns(piece.kind), False) if called(layout, n) == ([], [piece.name])]
        if kind.solid:
            depth, width, height = piece.size_m or kind.size_m
            half, at = (depth / 2, width / 2, height / 2), (*piece.position_m, height / 2)
            found.append(Landmark(tuple(f"the {n}" for n in nouns), False, at, half, piece.yaw_rad))
        if nouns:
            found += _spots(layout, piece, nouns, task.subtasks[subtask].object)
    found.append(Landmark(PLACE_WORDS["room_middle"][0], True, (0.0, 0.0, _SPOT_HEIGHT_M)))
    return tuple(found)


def _object_phrases(layout: Layout, name: str) -> tuple[str, ...]:
    kind, color, _ = looks(layout)[name]
    phrases = []
    for noun in usable(object_nouns(kind), False):
        objects, pieces = called(layout, noun)
        if pieces:
            continue
        if objects == [name]:
            phrases.append(f"the {noun}")
        word = COLOR_WORDS[color][0] if color in COLOR_WORDS else ""
        if word and [o for o in objects if color_fits(word, looks(layout)[o][1])] == [name]:
            phrases.append(f"the {word} {noun}")
        phrases += [f"the {noun} that is {where}" for where in _where(layout, name, objects)]
    return tuple(phrases)


def _where(layout: Layout, name: str, alike: Sequence[str]) -> list[str]:
    """Where an object is, in words that fit it and none of those that are called the same; at most two."""
    at, found = layout.poses[name][0], []
    for place in layout.places(name, at):
        piece = layout.furniture(place.landmark)
        near = place.relation in ON or layout.is_goal(place, name, at)
        if piece is None or not near or any(layout.contains(place, o, layout.poses[o][0]) for o in alike if o != name):
            continue
        nouns = [n for n in usable(furniture_nouns(piece.kind), False) if called(layout, n) == ([], [piece.name])]
        found += [PLACE_WORDS[place.relation][0][0].format(f"the {nouns[0]}")] if nouns else []
    return found[:2]


def _spots(layout: Layout, piece: FurniturePlacement, nouns: list[str], name: str) -> list[Landmark]:
    found = []
    for relation in (*ON, *BESIDE, *BY_THE_MIDDLE):
        spot = layout.spot_m(Place(relation, piece.name), name)
        if spot is not None:
            top = layout.surfaces[piece.name].height_m if relation in ON else 0.0
            phrases = tuple(w.format(f"the {n}") for w in PLACE_WORDS[relation][0] for n in nouns)
            found.append(Landmark(phrases, True, (*spot, top + _SPOT_HEIGHT_M)))
    return found
