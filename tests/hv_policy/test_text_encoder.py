import subprocess
import sys

import pytest
import torch

from hv_policy.text_encoder import TextEncoder, build_vocabulary, split_words, trigram_buckets

TEXTS = ["Carry the red box from the left to the right.", "Put the vase on the shelf."]


def make_encoder(texts: list[str] = TEXTS, **changes) -> TextEncoder:
    torch.manual_seed(0)
    settings = {"max_words": 16, "dim": 32, "heads": 4, "layers": 2, "word_dropout": 0.0} | changes
    return TextEncoder(build_vocabulary(texts, 100), **settings).eval()


def test_splits_words_numbers_and_punctuation():
    assert split_words("Don't move the 2.5 kg Box, please!") == [
        "don't", "move", "the", "2.5", "kg", "box", ",", "please", "!",
    ]  # fmt: skip
    assert split_words("Schließ die Tür") == ["schließ", "die", "tür"]


def test_vocabulary_keeps_the_most_frequent_words_whatever_the_order():
    assert build_vocabulary(TEXTS, 3) == build_vocabulary(TEXTS[::-1], 3)
    assert "the" in build_vocabulary(TEXTS, 1)
    assert build_vocabulary(TEXTS, 100) == sorted(build_vocabulary(TEXTS, 100))


def test_trigrams_are_the_same_in_another_process():
    code = "from hv_policy.text_encoder import trigram_buckets; print(trigram_buckets('bookshelf'))"
    other = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert other.stdout.strip() == str(trigram_buckets("bookshelf"))


def test_a_sentence_and_its_reverse_differ_word_by_word():
    encoder = make_encoder()
    forth, back = "from the left to the right", "from the right to the left"
    tokens, is_word = encoder([forth, back])
    assert is_word.all()
    left, right = tokens[0, 2], tokens[1, 5]  # the word "left" in both
    assert not torch.allclose(left, right, atol=1e-2)
    assert not torch.allclose(tokens[0].mean(0), tokens[1].mean(0), atol=1e-3)


def test_padding_changes_nothing():
    encoder, texts = make_encoder(), [*TEXTS, "the extraordinarily long one"]
    together, is_word = encoder(texts)
    for row, text in enumerate(texts):
        alone, _ = encoder([text])
        assert is_word[row].sum() == alone.shape[1]
        torch.testing.assert_close(together[row, : alone.shape[1]], alone[0], atol=1e-5, rtol=1e-5)


def test_an_unknown_word_is_near_a_known_one_of_like_spelling():
    encoder = make_encoder(["shelf", "vase", "box"])

    def embedding(word: str) -> torch.Tensor:  # before the transformer: only what the spelling gives
        return encoder.trigram(encoder.tokenize([[word]])[1]).mean(2)[0, 0]

    similar = torch.cosine_similarity(embedding("bookshelf"), embedding("bookshelves"), dim=0)
    other = torch.cosine_similarity(embedding("bookshelf"), embedding("carpet"), dim=0)
    assert similar > other + 0.3


def test_two_unknown_words_differ():
    tokens, _ = make_encoder()(["take the lamp", "take the sofa"])
    assert not torch.allclose(tokens[0], tokens[1], atol=1e-2)


@pytest.mark.parametrize("text", ["", "   ", "word " * 500, "x" * 5000, "\U0001f4a9 \x00"])
def test_any_text_can_be_read(text: str):
    tokens, is_word = make_encoder()([text])
    assert tokens.shape[1] <= 16
    assert is_word.any()
    assert torch.isfinite(tokens).all()


def test_word_dropout_only_while_training():
    encoder = make_encoder(word_dropout=0.9)
    first, _ = encoder(TEXTS[:1])
    second, _ = encoder(TEXTS[:1])
    torch.testing.assert_close(first, second, atol=0, rtol=0)
    encoder.train()
    assert not torch.allclose(encoder(TEXTS[:1])[0], encoder(TEXTS[:1])[0])
