"""Sentences with what each word is about."""

import re

import numpy as np

from hv_policy.rewording import RELATIONS, TAGS
from hv_policy.text_encoder import split_words
from hv_scripts import told_sentences
from hv_scripts.told_sentences import SHAPES, Words, told_sentence
from hv_sim.instructions import LATER_UNSEEN_SHAPES, UNSEEN_SHAPES
from hv_sim.lexicon import MOTION_WORDS, PLACE_WORDS

KEPT = "shift relocate transfer depositing setting grab fetch mind nice hoping ends".split()
WORDS = Words(["gadget"], ["shelfy"], ["mauvish"], ["biggish"], ["whatever"])


def test_every_word_is_about_something_and_comes_from_where_it_says():
    rng, seen = np.random.default_rng(0), set()
    for _ in range(3000):
        line = told_sentence(rng, WORDS)
        assert [w for w, _, _ in line] == split_words(" ".join(w for w, _, _ in line))
        for word, tag, relation in line:
            assert tag in TAGS
            assert (relation in RELATIONS) == tag.endswith("_relation")
            seen.add(tag)
            if word in ("gadget", "shelfy"):
                assert not tag or tag.endswith("_noun")  # what is not meant is not marked
            if word in ("mauvish", "biggish"):
                assert not tag or tag.endswith(("_color", "_size"))
        tags = [tag for _, tag, _ in line]
        assert "thing_noun" in tags
        assert "goal_relation" in tags
    assert seen == set(TAGS)


def test_the_same_seed_tells_the_same():
    told = [[told_sentence(np.random.default_rng(seed), WORDS) for seed in range(5)] for _ in range(2)]
    assert told[0] == told[1]


def test_shapes_and_places_of_the_unseen_tasks_are_kept_for_them():
    def words(text: str) -> str:
        return " ".join(re.findall(r"[a-z']+", text.lower()))

    told = [words(re.sub(r"{(thing|goal|source)}", lambda m: m[1].upper(), shape)) for shape in SHAPES]
    assert not [line for line in told if set(line.split()) & set(KEPT)]
    for shape in UNSEEN_SHAPES + LATER_UNSEEN_SHAPES:
        filled = re.sub(r"{(at|to)}", "GOAL", re.sub(r"{[oa]}", "THING", shape), flags=re.IGNORECASE)
        assert words(filled.replace("{where}", "SOURCE")) not in told
    said = {phrase for phrases in told_sentences._RELATED.values() for phrase in phrases}
    for table in (PLACE_WORDS, MOTION_WORDS):
        for seen, unseen in table.values():
            assert not said & (set(unseen) - set(seen))
