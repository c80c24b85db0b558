"""Word features: the same as a plain reading, near for words that mean the same, and they know what MiniLM knows."""

import numpy as np
import pytest
import torch

from hv_policy.text_encoder import TextEncoder, split_words
from hv_policy.word_features import (
    FEATURE_DIM,
    SHIPPED_WORD_FEATURES,
    WordFeatures,
    WordFeaturesConfig,
    load_word_features,
    save_word_features,
)
from hv_sim.furniture import FURNITURE_KINDS
from hv_sim.lexicon import furniture_nouns, object_nouns, usable
from hv_sim.objects import OBJECT_KINDS


@pytest.fixture(scope="module")
def features() -> WordFeatures:
    return load_word_features()


def noun(features: WordFeatures, text: str) -> np.ndarray:
    words = split_words(f"move the {text} over there.")
    return features.of(words)[2 : 2 + len(split_words(text))].mean(0).numpy()


def test_the_file_is_small():
    assert SHIPPED_WORD_FEATURES.stat().st_size < 6e6


def test_words_are_split_as_wordpiece_does(features: WordFeatures):
    from tokenizers import Tokenizer
    from tokenizers.models import WordPiece

    peer = Tokenizer(WordPiece({p: i for i, p in enumerate(features.pieces)}, unk_token=features.pieces[0]))
    for word in ("armchair", "nightstand", "jerry", "unbelievably", "kettle", "xylophonist", "bookshelves"):
        assert features.pieces_of([word])[0] == peer.encode(word).ids


def test_a_word_has_the_mean_of_its_pieces(features: WordFeatures):
    words = split_words("Put the couch beside the humidifier.")
    lists = features.pieces_of(words)
    flat = [n for numbers in lists for n in numbers]
    read = features(torch.tensor([flat]), torch.ones(1, len(flat), dtype=torch.bool))[0]
    start, rows = 0, []
    for numbers in lists:
        rows.append(read[start : start + len(numbers)].mean(0))
        start += len(numbers)
    torch.testing.assert_close(features.of(words), torch.stack(rows), atol=1e-5, rtol=1e-4)
    assert max(len(numbers) for numbers in lists) > 1


def test_words_of_the_unseen_tasks_are_nearest_to_their_kind(features: WordFeatures):
    kinds = [(k, usable(object_nouns(k), False), object_nouns(k)) for k in OBJECT_KINDS]
    kinds += [(k, usable(furniture_nouns(k), False), furniture_nouns(k)) for k in FURNITURE_KINDS]
    known = [(kind, word) for kind, words, _ in kinds for word in words]
    new = [(kind, words[-1]) for kind, _, words in kinds if len(words) > 1]
    a, b = (np.stack([noun(features, word) for _, word in x]) for x in (known, new))
    a, b = a - a.mean(0), b - a.mean(0)
    near = (b / np.linalg.norm(b, axis=1, keepdims=True)) @ (a / np.linalg.norm(a, axis=1, keepdims=True)).T
    right = [kind in {known[j][0] for j in np.argsort(-row)[:3]} for (kind, _), row in zip(new, near, strict=True)]
    assert len(new) > 100
    assert np.mean(right) > 0.7  # all-MiniLM-L6-v2 itself: .84; by chance .05


@pytest.mark.parametrize(
    ("word", "like", "unlike"),
    [("settee", "couch", "crate"), ("fridge", "refrigerator", "cushion"), ("grey", "gray", "seven"),
     ("onto", "on", "behind"), ("Rubbish", "trash", "lamp")],
)  # fmt: skip
def test_close_words(features: WordFeatures, word: str, like: str, unlike: str):
    one, near, far = (noun(features, text) for text in (word, like, unlike))

    def cosine(x: np.ndarray, y: np.ndarray) -> float:
        return float(x @ y / np.linalg.norm(x) / np.linalg.norm(y))

    assert cosine(one, near) > cosine(one, far) + 0.1


def test_order_matters(features: WordFeatures):
    forth = features.of(split_words("from the left to the right"))
    back = features.of(split_words("from the right to the left"))
    assert (forth[2] - back[5]).abs().max() > 0.1


@pytest.mark.parametrize("words", [[""], ["💩"], ["x" * 5000], ["word"] * 500, ["日本"]])
def test_any_words_can_be_read(features: WordFeatures, words: list[str]):
    read = features.of(words)
    assert read.shape == (len(words), FEATURE_DIM)
    assert read.isfinite().all()


def test_a_file_says_what_it_is(tmp_path):
    network = WordFeatures(WordFeaturesConfig(3, layers=1), ["a", "b", "##c"])
    save_word_features(network, tmp_path / "w.safetensors")
    again = load_word_features(tmp_path / "w.safetensors")
    assert again.pieces == ["a", "b", "##c"]
    assert again.pieces_of(["bc"]) == [[1, 2]]
    assert not any(p.requires_grad for p in again.parameters())
    (tmp_path / "bad.safetensors").write_bytes(b"no")
    with pytest.raises(ValueError, match="cannot be read"):
        load_word_features(tmp_path / "bad.safetensors")


def test_an_instruction_in_new_words_is_read_like_one_in_known_words():
    torch.manual_seed(0)
    encoder = TextEncoder(["move", "the", "sofa", "crate"], 16, 32, 4, 2, 0.0).eval()
    known = [encoder.tokenize([["sofa"]])[0].item(), encoder.tokenize([["couch"]])[0].item()]
    assert known == [4, 1]  # "couch" is unknown by itself
    assert not any(name.startswith("features.") for name, p in encoder.named_parameters() if p.requires_grad)
