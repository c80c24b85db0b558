"""Reads an instruction and says which objects of a scene it may mean, and which goals: the opposite of writing one.

It knows the words (`hv_sim.lexicon`) but not the sentences: noun phrases are found one after another, those behind a
preposition are places, the other one is what shall be moved. A place is where the object is now if it follows a word
such as "from", else where it shall go.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Iterable
from dataclasses import dataclass

from hv_sim.furniture import FURNITURE_KINDS
from hv_sim.furniture_kinds.made_up import NOUNS as MADE_UP_PIECES
from hv_sim.lexicon import (
    COLOR_WORDS,
    EVERYDAY_WORDS,
    MOTION_WORDS,
    PLACE_WORDS,
    SIZE_WORDS,
    called,
    color_fits,
    furniture_nouns,
    looks,
    object_nouns,
    size_word,
)
from hv_sim.object_kinds.made_up import NOUNS as MADE_UP_NOUNS
from hv_sim.objects import OBJECT_KINDS
from hv_sim.places import WITHOUT_LANDMARK, Layout, Place

_SOURCE = re.compile(r"\b(from|that is|the one|instead of|which is)$")
_INTRODUCED = re.compile(r"\b(there is|you see|you find|leave)$")


@dataclass(frozen=True)
class Grounding:
    """What an instruction may mean in a scene."""

    objects: frozenset[str]
    """Objects that it may ask to be moved."""
    goals: tuple[Place, ...]
    """Places where it may ask them to be brought."""


def ground(sentence: str, layout: Layout) -> Grounding:
    """The objects and goals that a sentence may mean, none where it cannot be read."""
    places, theme, sources = _read(sentence.lower())
    if theme is None:
        return Grounding(frozenset(), ())
    objects = _described(layout, theme)
    for source in sources:
        where = _places(layout, source)
        objects = [o for o in objects if any(layout.contains(p, o, layout.poses[o][0]) for p in where)]
    goals = {place for mention in places for place in _places(layout, mention)}
    return Grounding(frozenset(objects), tuple(sorted(goals, key=lambda p: (p.relation, p.landmark))))


def fits(sentence: str, layout: Layout, name: str, goal_position_m: tuple[float, float, float]) -> bool:
    """Whether a sentence can only mean that object and one place, and the goal is where that sends it."""
    meant = ground(sentence, layout)
    return (
        meant.objects == {name}
        and len(meant.goals) == 1
        and meant.goals[0].landmark != name
        and layout.is_goal(meant.goals[0], name, goal_position_m)
    )


@dataclass(frozen=True)
class _Mention:
    """A noun phrase; with a preposition before it, or a phrase such as "on the floor", it is a place."""

    place: str  # "" for a thing itself
    adjectives: tuple[str, ...]
    noun: str  # "" for a place without a landmark
    before: str  # what was written between the last mention and this one

    @property
    def relation(self) -> str:
        return _relations()[self.place]

    @property
    def is_source(self) -> bool:
        return self.place.startswith("from") or bool(_SOURCE.search(self.before))


def _mentions(text: str) -> list[_Mention]:
    found, at = [], 0
    for match in _phrases().finditer(text):
        adjectives = re.findall(_adjectives(), match["adjectives"] or "")
        place = (match["whole"] or match["relation"] or "").strip()
        before = text[at : match.start()].rstrip(" ,;:.?")
        found.append(_Mention(place, tuple(adjectives), match["noun"] or "", before))
        at = match.end()
    return found


def _read(text: str) -> tuple[list[_Mention], _Mention | None, list[_Mention]]:
    """Goals, what shall be moved, and where that is now."""
    goals: list[_Mention] = []
    sources: list[_Mention] = []
    theme: _Mention | None = None
    introduced = False
    for mention in _mentions(text):
        if not mention.place:
            if theme is not None:
                return [], None, []
            theme = mention
            introduced = bool(_INTRODUCED.search(mention.before))
        elif mention.relation.startswith("your_"):
            sources.append(mention)
        elif introduced or mention.is_source:
            sources.append(mention)
            introduced = False
        else:
            goals.append(mention)
    return goals, theme, sources


def _described(layout: Layout, mention: _Mention) -> list[str]:
    """The objects that a noun and adjectives may mean."""
    everything = looks(layout)
    sizes = [_sizes()[a] for a in mention.adjectives if a in _sizes()]
    colors = [a for a in mention.adjectives if a not in _sizes()]
    found = [o for o in called(layout, mention.noun)[0] if all(color_fits(c, everything[o][1]) for c in colors)]
    if not sizes:
        return found
    return [o for o in found if size_word(everything[o], [everything[other] for other in found if other != o]) in sizes]


def _places(layout: Layout, mention: _Mention) -> list[Place]:
    if not mention.noun:
        return [Place(mention.relation)]
    pieces = called(layout, mention.noun)[1] if not mention.adjectives else []
    return [Place(mention.relation, name) for name in (*pieces, *_described(layout, mention))]


@functools.cache
def _sizes() -> dict[str, str]:
    return {word: size for size, words in SIZE_WORDS.items() for word in words}


@functools.cache
def _relations() -> dict[str, str]:
    """How a place begins, without its landmark, or a whole place that has none -> relation."""
    found = {"from": "on"}
    for vocabulary in (PLACE_WORDS, MOTION_WORDS):
        for relation, (seen, unseen) in vocabulary.items():
            found |= {phrase.replace("{}", "").strip(): relation for phrase in (*seen, *unseen)}
    for relation, phrases in EVERYDAY_WORDS.items():
        found |= {phrase.replace("{}", "").strip(): relation for phrase in phrases}
    for phrase in [p for p in found if p.startswith("on the ")]:  # "from the floor", "from the left side of"
        whole = found[phrase] in WITHOUT_LANDMARK
        found[phrase.replace("on", "from", 1) if whole else phrase.removeprefix("on ")] = found[phrase]
    return found


@functools.cache
def _adjectives() -> str:
    words = {w for words in (*COLOR_WORDS.values(), *SIZE_WORDS.values()) for w in words}
    return _any_of(words)


@functools.cache
def _phrases() -> re.Pattern[str]:
    nouns = {n.lower() for k in OBJECT_KINDS for n in object_nouns(k)} | {*MADE_UP_NOUNS, *MADE_UP_PIECES}
    nouns |= {n.lower() for k in FURNITURE_KINDS for n in furniture_nouns(k)}
    alone = {phrase for phrase, relation in _relations().items() if relation in WITHOUT_LANDMARK}
    before = _relations().keys() - alone
    landmark = rf"(?:the|an?) (?P<adjectives>(?:(?:{_adjectives()}) )*)(?P<noun>{_any_of(nouns)})"
    return re.compile(rf"\b(?:(?P<whole>{_any_of(alone)})|(?P<relation>(?:{_any_of(before)}) )?{landmark})\b")


def _any_of(words: Iterable[str]) -> str:
    """A pattern for the longest of these words that fits."""
    return "|".join(sorted(map(re.escape, words), key=len, reverse=True))
