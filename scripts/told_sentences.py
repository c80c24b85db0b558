"""Sentences in which somebody asks for a thing to be moved, with what each word is about: rewording learns of them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hv_policy.text_encoder import split_words

Marked = list[tuple[str, str, str]]
"""Words, the tag of each (`hv_policy.rewording.TAGS`), and the relation that it is a part of the words for, or ""."""

MOVES = (
    *("move", "bring", "carry", "take", "put", "place", "set", "get", "transport", "deliver", "haul", "lug", "lay"),
    *("stand", "position", "drop off", "park", "return", "store", "stow", "rest", "send", "drag", "stick", "pop"),
)
_PICKS = ("pick up", "lift", "take", "go and get", "go to", "walk to", "find", "look for", "get hold of", "hold")
SHAPES = (
    *("{move} {thing} {goal}", "{move} {thing} {goal}"),
    *("{move} {thing} {goal}", "{pick} {thing} and {move} it {goal}"),
    *("{pick} {thing}, then {move} it {goal}",),
    *("{pick} {thing}; it goes {goal}", "{pick} {thing} so that it is {goal}"),
    *("{thing} goes {goal}", "{thing} belongs {goal}", "{thing} has to go {goal}", "{thing} should go {goal}"),
    *("{thing} must be {goal}", "{thing} is to be put {goal}"),
    *("{thing} ought to stand {goal}", "{thing} comes {goal}"),
    *("{thing} wants to be {goal}", "{thing} has its place {goal}"),
    *("{thing} looks best {goal}", "{thing} fits {goal}"),
    *("{thing} would be better {goal}", "{thing} can go {goal}", "{thing} will have to stand {goal}"),
    *("i want {thing} {goal}", "i would like {thing} {goal}", "we want {thing} {goal}", "i need {thing} {goal}"),
    *("i would love {thing} {goal}", "i prefer {thing} {goal}", "i expect to see {thing} {goal} soon"),
    *("my wish is that {thing} is {goal}", "can {thing} be {goal}", "is it possible to have {thing} {goal}"),
    *("would it be possible to get {thing} {goal}",),
    *("it is time that {thing} was {goal}", "see that {thing} gets {goal}"),
    *("see to it that {thing} is {goal}", "take care that {thing} stands {goal}", "what about {thing} {goal}"),
    *("what about putting {thing} {goal}", "why not put {thing} {goal}", "try {thing} {goal}", "have {thing} {goal}"),
    *("what i want is {thing} {goal}", "the plan is to have {thing} {goal}", "the job: {thing} {goal}"),
    *("we agreed that {thing} stands {goal}", "somebody wants {thing} {goal}", "mother wants {thing} to be {goal}"),
    *("{goal} put {thing}", "{goal} is the place of {thing}"),
    *("{goal} is where {thing} belongs", "{goal} i want {thing}"),
    *("{goal} there is room for {thing}", "{goal} you can put {thing}"),
    *("{goal} goes {thing}", "{goal} stands {thing}"),
    *("the place of {thing} is {goal}", "the proper spot for {thing} is {goal}", "the best place of {thing}: {goal}"),
    *("the home of {thing} is {goal}",),
    *("there is a free spot {goal}; {move} {thing} there", "a place {goal} is free for {thing}"),
    *("put {goal} {thing}", "place {goal} {thing}", "{move} {thing} over, it should stand {goal}"),
    *("we lack {thing} {goal}", "what is missing {goal} is {thing}", "what should be {goal} is {thing}"),
    *("{goal} we could use {thing}, so {move} it there", "people look for {thing} {goal}, so {move} it there"),
    *("do you see {thing}? {move} it {goal}", "you see {thing}? it goes {goal}", "see {thing}? i want that {goal}"),
    *("there is {thing} in this room; {move} it {goal}",),
    *("{thing} is next; {move} it {goal}", "{thing}: {move} it {goal}"),
    *("{thing} first: {move} it {goal}", "{thing}, please, {goal}"),
    *("{thing}. {goal}", "{thing} {goal}", "{goal}: {thing}"),
    *("{thing} is not where it belongs, {move} it {goal}", "{thing} stands badly, it would be better {goal}"),
    *("{thing} is misplaced; its place is {goal}",),
    *("someone moved {thing}; {move} it back {goal}", "now {thing}, {goal}"),
    # beside something else that is not meant
    *("{move} {thing}, not {decoy}, {goal}",),
    *("{thing} and not {decoy} goes {goal}", "{thing}, not {decoy}, belongs {goal}"),
    *("not {decoy} but {thing} should go {goal}",),
    *("{decoy} can stay; {move} {thing} {goal}", "{move} {thing} {goal}, not {decoy}"),
    *("do not touch {decoy}; {move} {thing} {goal}", "you have moved {decoy}, now {move} {thing} {goal}"),
    *("{thing} is next to {decoy}; {move} it {goal}", "i mean {thing}, not {decoy}; it goes {goal}"),
    # where it is now, too
    *("take {thing} from {source} and {move} it {goal}",),
    *("{move} {thing} from {source} {goal}", "{move} {thing} {source} {goal}"),
    *("take {thing} that is {source} and {move} it {goal}", "{thing}, the one {source}, goes {goal}"),
    *("{move} {thing} that stands {source} {goal}",),
    *("{move} {thing} you see {source} {goal}", "{thing} {source} belongs {goal}"),
    *("there is {thing} {source}; {move} it {goal}", "do you see {thing} {source}? {move} it {goal}"),
    *("you will find {thing} {source}. {move} it {goal}", "look {source}: there is {thing}. {move} it {goal}"),
    *("{source} you see {thing}, which goes {goal}", "{source} there is {thing}; it should go {goal}"),
    *("what stands {source} is {thing}; it goes {goal}", "{thing} is {source} now; it has to stand {goal}"),
    *("{thing} is still {source}, but it belongs {goal}",),
    *("somebody has put {thing} {source}, but its place is {goal}",),
    *("{thing} must not stay {source}, put it {goal}", "not {source} but {goal} is the place of {thing}"),
    *("put {thing} {goal}, not {source}",),
    *("{thing} should stand {goal} and not {source}", "i want {thing} {goal}, not {source}"),
    *("{thing} {goal} rather than {source}",),
    *("have {thing} {goal} rather than {source}", "{thing} {goal} and no longer {source}"),
    *("i want {thing} {goal} in place of {source}", "{move} {thing} {goal} in lieu of {source}"),
    *("we want {thing} {goal} and not {source}", "{goal} rather than {source} is where {thing} goes"),
    *("you'll see {thing} {source}; {move} it {goal}", "should there be {thing} {source}, {move} it {goal}"),
    *("rather than {source}, put {thing} {goal}", "{thing} is wrong {source}: {move} it {goal}"),
    *("i do not like {thing} {source}; {move} it {goal}", "{thing} must leave {source}; {move} it {goal}"),
    *("you can't let {thing} stay {source}: {move} it {goal}", "never keep {thing} {source}, {goal} is right"),
    *("{pick} {thing} {source} and {move} it {goal}", "{pick} {thing}, now {source}, and {move} it {goal}"),
    *("{pick} {thing}, it is {source}, then {move} it {goal}",),
    *("{pick} {thing} that somebody left {source}; it goes {goal}",),
    *("when there is {thing} {source}, {move} it {goal}", "as soon as you see {thing} {source}, {move} it {goal}"),
    *("{thing} was {source} all day. now {move} it {goal}",),
    *("{thing} ({source}) goes {goal}", "from {source}, {move} {thing} {goal}"),
)  # fmt: skip
"""How it may be asked for. None of them is a shape of the unseen tasks (`hv_sim.instructions.UNSEEN_SHAPES`)."""
_BEFORE = (
    *("", "", "", "", "", "", "please", "now", "next,", "then", "okay,", "could you", "can you", "would you please"),
    *("robot,", "i want you to", "i'd like you to", "you should", "first", "kindly", "will you", "hey,", "and now"),
    *("listen:", "one more thing:", "your next task:", "be so kind and", "i ask you to", "do me a favour and"),
    *("when you are done,", "if you can,", "your turn:", "thanks. now", "good. next"),
)
_AFTER = (
    *("", "", "", "", "", "", "please", "now", "for me", "right away", "thanks", "thank you", "at once", "for now"),
    *("before you go on", "and come back", "carefully", "when you have time", "and let go of it", "as always"),
    *("it is in the way here", "somebody may fall over it", "we have guests tonight", "that is all for now"),
)
_RELATED = {
    "on": ("on {}", "onto {}", "upon {}", "on the top of {}", "up on {}", "atop {}", "on the surface of {}"),
    "on_left": (
        *("on the left side of {}", "onto the left side of {}", "on the left of {}", "on the left end of {}"),
        *("at the left end of {}", "on the left half of {}", "to the left end of {}", "on the left part of {}"),
        *("on the left-hand side of {}", "onto the left-hand side of {}"),
        *("on the leftmost part of {}", "at the left edge of {}", "on the left corner of {}", "on {}, on the left"),
    ),
    "on_right": (
        *("on the right side of {}", "onto the right side of {}", "on the right of {}", "on the right end of {}"),
        *("at the right end of {}", "on the right half of {}", "to the right end of {}", "on the right part of {}"),
        *("on the right-hand side of {}", "onto the right-hand side of {}"),
        *("on the rightmost part of {}", "at the right edge of {}"),
        *("on the right corner of {}", "on {}, on the right"),
    ),
    "on_middle": (
        *("on the middle of {}", "onto the middle of {}", "on the middle part of {}", "in the middle of {}"),
        *("on the center of {}", "on the central part of {}"),
        *("midway along {}", "half-way along {}", "on {}, in the middle"),
    ),
    "left_of": (
        *("just to the left of {}", "directly to the left of {}"),
        *("to the left of {}", "left of {}", "close on the left of {}"),
        *("to the spot just to the left of {}", "to the left-hand side of {}"),
        *("beside {}, on its left", "right by {}, left of it"),
        *("a foot to the left of {}", "a step to the left of {}"),
        *("next to {}, to the left", "to the place left of {}"),
        *("a hand's width left of {}", "closely left of {}"),
        *("to a place to the left of {}", "on the left next to {}"),
    ),
    "right_of": (
        *("just to the right of {}", "directly to the right of {}"),
        *("to the right of {}", "right of {}", "close on the right of {}"),
        *("to the spot just to the right of {}", "to the right-hand side of {}"),
        *("beside {}, on its right", "close by {}, right of it"),
        *("a foot to the right of {}", "a step to the right of {}"),
        *("next to {}, to the right", "to the place right of {}"),
        *("a hand's width right of {}", "closely right of {}"),
        *("to a place to the right of {}", "on the right next to {}"),
    ),
    "in_front_of": (
        *("just in front of {}", "directly in front of {}", "in front of {}", "right before {}", "close before {}"),
        *("to the spot just in front of {}", "to the front of {}", "a foot in front of {}", "a step in front of {}"),
        *("to a place in front of {}", "closely in front of {}"),
        *("at the front of {}", "shortly before {}", "before {}"),
    ),
    "front_middle": (
        *("just in front of the middle of {}",),
        *("directly in front of the middle of {}", "in front of the middle of {}"),
        *("to the spot just in front of the middle of {}", "before the middle of {}", "centrally in front of {}"),
        *("to a place in front of the middle of {}", "in front of the center of {}", "close before the middle of {}"),
    ),
    "behind": (
        *("just behind {}", "directly behind {}", "behind {}"),
        *("at the back of {}", "close behind {}", "right behind {}"),
        *("to the spot just behind {}", "to the back of {}"),
        *("a foot behind {}", "a step behind {}", "at the rear of {}"),
        *("to a place behind {}", "closely behind {}", "shortly behind {}", "in back of {}"),
    ),
    "back_middle": (
        *("just behind the middle of {}", "directly behind the middle of {}", "behind the middle of {}"),
        *("to the spot just behind the middle of {}", "close behind the middle of {}", "centrally behind {}"),
        *("to a place behind the middle of {}", "behind the center of {}", "at the back of the middle of {}"),
    ),
    "floor": (
        *("on the floor", "onto the floor", "to the floor", "on the ground", "onto the ground", "down on the floor"),
        *("on the carpet", "on the bare floor", "somewhere on the floor", "on the tiles"),
    ),
    "room_middle": (
        *("exactly in the middle of the room", "in the very middle of the room", "to the very middle of the room"),
        *("in the middle of the room", "to the middle of the room"),
        *("in the center of the room", "into the middle of the room"),
        *("right in the middle of the room", "to the room's middle"),
        *("half-way between the walls", "in the middle of this room"),
        *("to the exact middle of the room", "at the center of the room"),
        *("in the middle of the hall", "in the middle of the kitchen"),
    ),
    "your_left": ("on your left", "at your left", "on your left side", "to the left of you", "left of yourself"),
    "your_right": ("on your right", "at your right", "on your right side", "to the right of you", "right of yourself"),
}  # fmt: skip
"""Relation -> how it may be said; none as the unseen tasks say it."""
_STRAY = 0.12
"""So often a word that says nothing stands between others that are not marked."""
_DETERMINERS = ("the", "the", "the", "the", "the", "the", "this", "that", "my", "our", "your", "a", "a", "")
_OTHER_ADJECTIVES = (
    *("old", "new", "nice", "heavy", "light", "empty", "full", "other", "usual", "square", "round", "plain", "dusty"),
    *("second", "only", "single", "first", "last", "broken"),
    *("beautiful", "expensive", "clean", "dirty", "wet", "warm"),
)


@dataclass(frozen=True)
class Words:
    """What sentences are filled with."""

    things: Sequence[str]
    landmarks: Sequence[str]
    colors: Sequence[str]
    sizes: Sequence[str]
    any_words: Sequence[str]
    """Words of all kinds, which now and then take the place of a noun, or of a verb."""


def told_sentence(rng: np.random.Generator, words: Words) -> Marked:
    """One sentence, its words marked."""
    shape = _one(rng, SHAPES)
    text = " ".join(part for part in (_one(rng, _BEFORE), shape, _one(rng, _AFTER)) if part)
    marked: Marked = []
    for piece in re.split(r"({\w+})", text + _one(rng, (".", ".", ".", "", "!", "?"))):
        marked += _filled(rng, piece, words)
        if rng.random() < _STRAY and not (marked and marked[-1][1]):
            marked.append((_one(rng, words.any_words), "", ""))
    return marked


def _filled(rng: np.random.Generator, piece: str, words: Words) -> Marked:
    if piece == "{move}":
        return _plain(_one(rng, words.any_words if rng.random() < 0.35 else MOVES))
    if piece == "{pick}":
        return _plain(_one(rng, words.any_words if rng.random() < 0.15 else _PICKS))
    if piece == "{thing}":
        aside = rng.random() < 0.06
        marked = _noun_phrase(rng, words, "thing", words.things)
        side = _one(rng, ("your_left", "your_right"))
        where = _plain(_one(rng, ("that is", "which is", "standing"))) + _place(rng, words, "source", side)
        return marked + where * aside
    if piece == "{decoy}":
        return [(word, "", "") for word, _, _ in _noun_phrase(rng, words, "thing", words.things)]
    if piece == "{goal}":
        return _place(rng, words, "goal", _relation(rng, goal=True))
    if piece == "{source}":
        return _place(rng, words, "source", _relation(rng, goal=False))
    return _plain(piece)


def _relation(rng: np.random.Generator, goal: bool) -> str:
    names = [name for name in _RELATED if goal <= (not name.startswith("your_"))]
    return _one(rng, names)


def _place(rng: np.random.Generator, words: Words, theme: str, relation: str) -> Marked:
    phrase = _one(rng, _RELATED[relation])
    marked: Marked = []
    for piece in re.split(r"({})", phrase):
        if piece == "{}":
            pool = words.landmarks if rng.random() < 0.75 else words.things
            marked += _noun_phrase(rng, words, theme, pool)
        else:
            marked += [(word, f"{theme}_relation", relation) for word in split_words(piece)]
    return marked


def _noun_phrase(rng: np.random.Generator, words: Words, theme: str, pool: Sequence[str]) -> Marked:
    adjectives: Marked = []
    if rng.random() < (0.45 if theme == "thing" else 0.2):
        adjectives += [(word, f"{theme}_color", "") for word in split_words(_one(rng, words.colors))]
    if rng.random() < 0.15:
        adjectives = [(word, f"{theme}_size", "") for word in split_words(_one(rng, words.sizes))] + adjectives
    if rng.random() < 0.08:
        adjectives = [(_one(rng, _OTHER_ADJECTIVES), "", ""), *adjectives]
    noun = _one(rng, pool)
    if rng.random() < 0.3:
        noun = " ".join(_one(rng, words.any_words) for _ in range(int(rng.choice([1, 1, 2]))))
    return [*_plain(_one(rng, _DETERMINERS)), *adjectives, *((word, f"{theme}_noun", "") for word in split_words(noun))]


def _plain(text: str) -> Marked:
    return [(word, "", "") for word in split_words(text)]


def _one(rng: np.random.Generator, options: Sequence[str]) -> str:
    return options[int(rng.integers(len(options)))]
