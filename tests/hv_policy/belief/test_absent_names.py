"""What is asked for though it is not there is never called like what is."""

import torch

from hv_policy.belief.absent_names import NAMES_ASKED, are_absent, draw_names, noun_at
from hv_policy.text_encoder import split_words
from hv_policy.word_features import load_word_features


def noun(name: str) -> torch.Tensor:
    words = split_words(name)
    return load_word_features().of(words)[noun_at(words)]


def test_the_noun_is_what_kind_of_thing_it_is():
    for name, kind in (
        ("the red box that is on the left side of the dresser", "box"),
        ("the wardrobe", "wardrobe"),
        ("the stack of books that is just in front of the sofa", "books"),
        ("that", "that"),
    ):
        words = split_words(name)
        assert words[noun_at(words)] == kind


def test_what_may_be_there_under_another_name_is_not_absent():
    asked = torch.stack([noun(name) for name in ("the boxes", "the fridge", "the sofa")])
    here = torch.stack([noun(name) for name in ("the red box", "the couch", "the toaster")])
    has_name = torch.tensor([[True, True, True], [False, True, True], [False, False, False]])
    absent = are_absent(asked, here.expand(3, -1, -1), has_name)
    assert absent.tolist() == [[False, True, False], [True, True, False], [True, True, True]]


def test_names_are_drawn_from_those_that_are_names():
    names = torch.arange(12).view(3, 4)
    has_name = names % 5 == 2
    drawn = draw_names(names, has_name)
    assert drawn.shape == (NAMES_ASKED,)
    assert set(drawn.tolist()) == {2, 7}
    assert set(draw_names(names, names < 0).tolist()) <= set(range(12)), "a batch without names is no error"
