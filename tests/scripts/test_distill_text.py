"""Distillation on a little model of BERT's kind with random weights: what is learned is what it says."""

from pathlib import Path

import numpy as np
import pytest
import torch
from stock_commands import error_lines, run_command

from hv_policy.text_encoder import split_words
from hv_policy.word_features import load_word_features, save_word_features
from hv_scripts.distill_text import distil
from hv_scripts.household_sentences import THINGS, household_sentence


@pytest.fixture(scope="module")
def model(tmp_path_factory) -> Path:
    from transformers import BertConfig, BertModel

    folder = tmp_path_factory.mktemp("bert")
    words = sorted({w for i in range(300) for w in split_words(household_sentence(np.random.default_rng(i)))})
    letters = [f"##{c}" for c in "abcdefghijklmnopqrstuvwxyz"]
    pieces = ["[PAD]", "[UNK]", "[CLS]", "[SEP]", "[MASK]", *words, *letters, "日"]
    (folder / "vocab.txt").write_text("\n".join(pieces))
    torch.manual_seed(0)
    config = BertConfig(
        vocab_size=len(pieces), hidden_size=128, num_hidden_layers=1, num_attention_heads=2, intermediate_size=128
    )
    BertModel(config).save_pretrained(folder)
    return folder


def test_the_network_learns_what_the_model_says(model: Path, tmp_path: Path, capfd):
    torch.manual_seed(0)
    network = distil(model, sentences=1500, epochs=4, seed=0)
    lines = [line for line in capfd.readouterr().out.splitlines() if line.startswith("epoch")]
    explained = [float(line.split(": ")[1].split()[0]) for line in lines]
    assert len(explained) == 4
    assert explained[-1] > max(0.3, explained[0])
    assert not any(piece.startswith("[") or not piece.isascii() for piece in network.pieces)
    save_word_features(network, tmp_path / "w.safetensors")
    assert load_word_features(tmp_path / "w.safetensors").of(["box", "chair"]).shape == (2, 96)


def test_a_folder_without_a_model_is_refused(tmp_path: Path):
    done = run_command("hv-distill-text", "--model", tmp_path, "--output", tmp_path / "w.safetensors")
    assert done.returncode == 2
    [line] = error_lines(done.stdout)
    assert line == f"error: model: {tmp_path} has no vocab.txt; valid: a folder with all-MiniLM-L6-v2"
    assert not list(tmp_path.iterdir())


def test_sentences_are_many_and_about_things():
    rng = np.random.default_rng(0)
    texts = [household_sentence(rng) for _ in range(2000)]
    assert len(set(texts)) > 1950
    nouns = {word for thing in THINGS for word in thing.split()}
    assert np.mean([bool(nouns & set(split_words(text))) for text in texts]) > 0.85
    odd = [household_sentence(rng, ["zebra"]) for _ in range(200)]
    assert 60 < sum("zebra" in text for text in odd) < 190
