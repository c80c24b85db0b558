"""What is asked for though it is not there is never called like what is."""

import torch

from hv_policy.belief.absent_names import are_absent, noun_at
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
