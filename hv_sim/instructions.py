"""Says in English what a sub-task asks for, in many ways, each of which fits one object and one goal in its scene."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from hv_sim.grounding import fits
from hv_sim.lexicon import (
    COLOR_WORDS,
    MOTION_WORDS,
    PLACE_WORDS,
    SIZE_WORDS,
    alike_in_color,
    called,
    furniture_nouns,
    looks,
    object_nouns,
    size_word,
    usable,
)
from hv_sim.objects import OBJECT_KINDS
from hv_sim.places import ON, Layout, Place

SEEN_SHAPES = (
    "{move} {o} {to}.",
    "{move} {o} {to}.",
    "{put} {o} {at}.",
    "{put} {o} {at}.",
    "please {move} {o} {to}.",
    "please {put} {o} {at}.",
    "could you {move} {o} {to}?",
    "could you {put} {o} {at}, please?",
    "can you {put} {o} {at} for me?",
    "pick up {o} and {put} it {at}.",
    "lift {o} and {move} it {to}.",
    "take {o} from {where} and {put} it {at}.",
    "take {o} that is {where} and {put} it {at}.",
    "{o} goes {at}.",
    "{o} belongs {at}.",
    "i want {o} {at}.",
    "i would like {o} {at}, please.",
    "there is {a} {where}; {move} it {to}.",
    "do you see {o} {where}? {put} it {at}.",
    "go and get {o}, then {put} it {at}.",
    "{o}, the one {where}, belongs {at}.",
    "first lift {o}, then {move} it {to}.",
)
LATER_SEEN_SHAPES = ("now {move} {o} {to}.", "next, {put} {o} {at}.", "then {move} {o} {to}, please.")
UNSEEN_SHAPES = (
    "{At} is where {o} should be.",
    "the right place for {o} is {at}.",
    "would you mind {leaving} {o} {at}?",
    "make sure that {o} ends up {at}.",
    "grab {o} and leave it {at}.",
    "it would be nice to have {o} {at}.",
    "{o} is in the wrong place; it should be {at}.",
    "{o} needs to be {shifted} {to}.",
    "let's have {o} {at} instead of {where}.",
    "time to {shift} {o} {to}.",
    "i need you to {shift} {o} {to}.",
    "we need {o} {at}, so {shift} it there.",
    "fetch {o}, which is {where} at the moment, and {shift} it {to}.",
    "if you find {a} {where}, {shift} it {to}.",
    "don't leave {o} {where}; it should be {at}.",
    "how about {leaving} {o} {at}?",
    "i was hoping to have {o} {at}.",
)
LATER_UNSEEN_SHAPES = ("after that, {shift} {o} {to}.", "{o} is next: leave it {at}.")

_VERBS: dict[str, tuple[str, ...]] = {
    "move": ("move", "bring", "carry", "take"),
    "put": ("put", "place", "set"),
    "shift": ("shift", "relocate", "transfer"),
    "shifted": ("shifted", "relocated", "transferred"),
    "leaving": ("leaving", "depositing", "setting down"),
}
_ONTO: dict[str, tuple[str, ...]] = {
    "move": ("move", "put"),
    "shift": ("shift", "transfer"),
    "shifted": ("shifted", "transferred"),
}
"""The verbs that go with "onto"."""
_WITHOUT_ASIDE = ("i want {o}", "i would like {o}", "have {o} {at}", "we need {o}", "where {o} should", "leaving} {o}")
"""Shapes in which "that is on your left" would be taken for the place."""
_ON_THE_FLOOR_ANYWAY = ("chair", "stool", "pouf", "table", "barrel", "bin")
"""Categories of things of which nobody says that they are on the floor."""
_ATTEMPTS = 400


@dataclass(frozen=True)
class _Scene:
    layout: Layout
    unseen: bool
    rng: np.random.Generator

    def one_of(self, words: tuple[str, ...]) -> str:
        return str(self.rng.choice(list(words)))


def write_instructions(
    layout: Layout, name: str, goal_position_m: tuple[float, float, float], goal: Place, rng: np.random.Generator, *,
    unseen: bool, count: int = 6, later: bool = False,
) -> list[str]:  # fmt: skip
    """Different ways to ask for an object to be brought to a goal.

    Args:
        layout: where everything is before it is done.
        name: the object.
        goal_position_m: where its centre shall be.
        goal: the place that the goal is called by.
        rng: chooses.
        unseen: with the words and shapes that are kept for the unseen tasks.
        count: how many.
        later: another sub-task came before it.

    Returns:
        `count` sentences, or fewer where the scene does not allow as many that are unambiguous.
    """
    scene = _Scene(layout, unseen, rng)
    shapes: tuple[str, ...] = UNSEEN_SHAPES if unseen else SEEN_SHAPES
    if later:
        shapes += LATER_UNSEEN_SHAPES if unseen else LATER_SEEN_SHAPES
    sentences: list[str] = []
    left = list(rng.permutation(len(shapes)))
    for _ in range(_ATTEMPTS):
        if len(sentences) == count:
            break
        if not left:
            left = list(rng.permutation(len(shapes)))
        sentence = _write(scene, shapes[left.pop()], name, goal)
        if sentence and sentence not in sentences and fits(sentence, layout, name, goal_position_m):
            sentences.append(sentence)
    return sentences


def _write(scene: _Scene, shape: str, name: str, goal: Place) -> str:
    """A sentence of the shape, or "" where there is none."""
    there = _place(scene, goal, PLACE_WORDS)
    toward = _place(scene, goal, MOTION_WORDS)
    source = _source(scene, name)
    told_where = "{where}" in shape
    described = _object(scene, name, told_where, may_point=not any(part in shape for part in _WITHOUT_ASIDE))
    if not (there and toward and described) or (told_where and not source):
        return ""
    article = "an" if described[0] in "aeiou" else "a"
    words = {
        "o": f"the {described}", "a": f"{article} {described}", "at": there, "At": there, "to": toward, "where": source,
    }  # fmt: skip
    fitting = _VERBS | (_ONTO if "onto " in toward else {})
    words |= {slot: scene.one_of(verbs) for slot, verbs in fitting.items()}
    sentence = shape
    for slot in re.findall(r"{(\w+)}", shape):
        word = words[slot]
        if slot == "where" and "from {where}" in shape:
            word = _from(word)
            if not word:
                return ""
        sentence = sentence.replace("{" + slot + "}", word, 1)
    return re.sub(r"(^|[.?] )([a-z])", lambda m: m[1] + m[2].upper(), sentence).replace(" i ", " I ")


def _object(scene: _Scene, name: str, told_where: bool, may_point: bool) -> str:
    """An object with as many adjectives as it takes, now and then one more, and no article."""
    everything = looks(scene.layout)
    kind, color, _ = look = everything[name]
    noun = scene.one_of(usable(object_nouns(kind), scene.unseen))
    alike = [everything[o] for o in called(scene.layout, noun)[0] if o != name]
    words = []
    same_color = [other for other in alike if alike_in_color(other[1], color)]
    if (alike and not told_where) or scene.rng.random() < 0.45:
        adjective = scene.one_of(usable(COLOR_WORDS[color], scene.unseen))
        wooden = color in ("oak", "walnut") and "wooden" in noun
        if not wooden and not any(part in noun for part in adjective.split()):
            words.append(adjective)
    if same_color and words:
        alike = same_color
    size = size_word(look, alike)
    if size and (not words or same_color):
        words.insert(0, scene.one_of(usable(SIZE_WORDS[size], scene.unseen)))
    side = [p for p in scene.layout.places(name, scene.layout.poses[name][0]) if p.relation.startswith("your_")]
    aside = ""
    if alike and side and may_point and not told_where and scene.rng.random() < 0.5:
        words = words[:1] if scene.rng.random() < 0.5 else []
        aside = " that is " + scene.one_of(PLACE_WORDS[side[0].relation][scene.unseen])
    return " ".join([*words, noun]) + aside


def _source(scene: _Scene, name: str) -> str:
    """Where the object now is, as a place."""
    unsaid = {"your_left", "your_right"}
    if OBJECT_KINDS[looks(scene.layout)[name][0]].category in _ON_THE_FLOOR_ANYWAY:
        unsaid.add("floor")
    at = scene.layout.poses[name][0]
    options = [p for p in scene.layout.places(name, at) if p.relation not in unsaid]
    # the words for what is beside something say that it is close by
    options = [p for p in options if p.relation in (*ON, "floor") or scene.layout.is_goal(p, name, at)]
    said = [text for p in options if (text := _place(scene, p, PLACE_WORDS))]
    return said[int(scene.rng.integers(min(3, len(said))))] if said else ""


def _from(place: str) -> str:
    """ "from the dresser" for "on the dresser"; other places keep their preposition."""
    for start in ("on top of the ", "on the "):
        if place.startswith(start) and " of " not in place[len(start) :]:
            return "the " + place[len(start) :]
    return place.removeprefix("on ") if place.startswith(("on the left side", "on the right side")) else ""


def _place(scene: _Scene, place: Place, vocabulary: dict[str, tuple[tuple[str, ...], tuple[str, ...]]]) -> str:
    """A place in words, or "" where its landmark cannot be named without doubt."""
    if place.relation not in vocabulary:
        return ""
    phrase = scene.one_of(vocabulary[place.relation][scene.unseen])
    if not place.landmark:
        return phrase
    piece = scene.layout.furniture(place.landmark)
    if piece is not None:
        noun = scene.one_of(usable(furniture_nouns(piece.kind), scene.unseen))
        objects, pieces = called(scene.layout, noun)
        return phrase.format(f"the {noun}") if pieces == [place.landmark] and not objects else ""
    kind, color, _ = looks(scene.layout)[place.landmark]
    noun = scene.one_of(usable(object_nouns(kind), scene.unseen))
    objects, pieces = called(scene.layout, noun)
    adjective = f"{usable(COLOR_WORDS[color], scene.unseen)[0]} " if scene.rng.random() < 0.3 else ""
    return phrase.format(f"the {adjective}{noun}") if objects == [place.landmark] and not pieces else ""
