"""More words, and none of those that the unseen tasks keep for themselves."""

import pytest

from hv_policy.text_encoder import split_words
from hv_scripts.thesaurus import COLORS, FURNITURE, SIZES, THINGS
from hv_sim.furniture import FURNITURE_KINDS
from hv_sim.lexicon import COLOR_WORDS, SIZE_WORDS, furniture_nouns, object_nouns, usable
from hv_sim.objects import OBJECT_KINDS


def kept_and_known() -> tuple[set[str], set[str]]:
    kept, known = set(), set()
    for kinds, nouns in ((OBJECT_KINDS, object_nouns), (FURNITURE_KINDS, furniture_nouns)):
        for kind, spec in kinds.items():
            if getattr(spec, "held_out", False):
                kept |= set(nouns(kind))
            else:
                known |= set(usable(nouns(kind), unseen=False))
                kept |= set(usable(nouns(kind), unseen=True)) - set(usable(nouns(kind), unseen=False))
    return kept - known, known


def test_every_known_kind_has_more_words():
    assert set(THINGS) == {kind for kind, spec in OBJECT_KINDS.items() if not spec.held_out}
    assert set(FURNITURE) == set(FURNITURE_KINDS)
    assert (set(COLORS), set(SIZES)) == (set(COLOR_WORDS), set(SIZE_WORDS))
    assert min(len(words.split("|")) for words in (THINGS | FURNITURE | COLORS | SIZES).values()) >= 2


@pytest.mark.parametrize("table", [THINGS, FURNITURE])
def test_no_noun_of_the_unseen_tasks_nor_a_word_that_only_those_have(table):
    kept, known = kept_and_known()
    known_words = {word for noun in known for word in split_words(noun)}
    strange = {word for noun in kept for word in split_words(noun)} - known_words
    for phrase in "|".join(table.values()).split("|"):
        words = split_words(phrase)
        assert not strange & set(words), phrase
        for noun in kept:
            parts = split_words(noun)
            assert parts not in [words[i : i + len(parts)] for i in range(len(words))], (phrase, noun)


def test_no_adjective_of_the_unseen_tasks():
    for table, words in ((COLORS, COLOR_WORDS), (SIZES, SIZE_WORDS)):
        kept = {w for names in words.values() for w in set(usable(names, True)) - set(usable(names, False))}
        assert not kept & set("|".join(table.values()).split("|"))
