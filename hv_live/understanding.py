"""From a typed sentence to a sub-task: which object is meant, and where exactly it shall go."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import replace

from hv_live.goal_poses import goal_pose
from hv_policy.rewording import Reworder, load_rewording
from hv_sim.furniture import FURNITURE_KINDS
from hv_sim.grounding import ground
from hv_sim.lexicon import looks
from hv_sim.objects import OBJECT_KINDS
from hv_sim.places import Layout
from hv_sim.scene import Scene
from hv_sim.task import SubTask

MAX_SENTENCE = 200
"""Characters of an instruction."""


class NotUnderstoodError(ValueError):
    """A sentence that names no one object and no one free place of this room; the message is one line and says why."""


class NothingNamedError(NotUnderstoodError):
    """The words for the object, or for the place, are none that the grammar knows."""


def clean_sentence(text: str) -> str:
    """The sentence with single spaces.

    Raises:
        NotUnderstoodError: it is empty, too long, or holds something that is not to be printed.
    """
    sentence = " ".join(text.split())
    if not sentence:
        raise NotUnderstoodError("instruction: empty; valid: a sentence")
    if len(sentence) > MAX_SENTENCE:
        raise NotUnderstoodError(f"instruction: {len(sentence)} characters; valid: at most {MAX_SENTENCE}")
    if not sentence.isprintable():
        raise NotUnderstoodError("instruction: holds characters that cannot be printed")
    return sentence


def understand(sentence: str, scene: Scene, layout: Layout) -> SubTask:
    """The sub-task that a sentence asks for in a room as it now is, in its own words, or else in those that the student
    reads (`hv_policy.rewording`): "the dustbin" is the trash bin.

    Args:
        sentence: what was said.
        scene: the compiled room.
        layout: where everything is, the robot too (`layout.task.robot`).

    Raises:
        NotUnderstoodError: not exactly one object and one place with room for it are meant.
    """
    for subtask in scene.task.subtasks:
        if sentence in subtask.phrasings:
            return replace(subtask, instruction=sentence, paraphrases=())
    try:
        return _grounded(sentence, scene, layout)
    except NothingNamedError:
        known = _reworder().say(sentence)
        if known == sentence:
            raise
        return replace(_grounded(known, scene, layout), instruction=sentence)


@functools.cache
def _reworder() -> Reworder:
    return Reworder(load_rewording())


def _grounded(sentence: str, scene: Scene, layout: Layout) -> SubTask:
    meant = ground(sentence, layout)
    names = [described(layout, name) for name in sorted(meant.objects)]
    if not names:
        everything = _listed([described(layout, o.name) for o in layout.task.objects])
        raise NothingNamedError(f"no object of this room is named; here are {everything}")
    if len(names) > 1:
        raise NotUnderstoodError(f"which one: {_listed(names, 'or')}?")
    [name] = meant.objects
    goals = [g for g in meant.goals if g.landmark != name]
    if not goals:
        tops = [FURNITURE_KINDS[f.kind].noun for f in layout.task.furniture if f.name in layout.surfaces]
        such_as = f", such as on the {tops[0]}" if tops else ""
        raise NothingNamedError(f"no place of this room is named{such_as}")
    if len({(g.relation, g.landmark) for g in goals}) > 1 and len({g.landmark for g in goals}) > 1:
        where = _listed([g.landmark.replace("_", " ") for g in goals], "or")
        raise NotUnderstoodError(f"which place: {where}?")
    for place in goals:
        pose = goal_pose(scene, layout, name, place)
        if pose is not None:
            return SubTask(name, pose[0], pose[1], sentence)
    raise NotUnderstoodError(f"there is no free spot for {names[0]} there that the robot can reach")


def described(layout: Layout, name: str) -> str:
    """What to call an object: "the red box"."""
    kind, color, _ = looks(layout)[name]
    alike = sum(look[0] == kind for look in looks(layout).values())
    noun = OBJECT_KINDS[kind].noun
    return f"the {color} {noun}" if alike > 1 else f"the {noun}"


def _listed(words: Sequence[str], last: str = "and") -> str:
    return f"{', '.join(words[:-1])} {last} {words[-1]}" if len(words) > 1 else words[0]
