"""hv-train-rewording: teaches the student to say an instruction again in words that its perception knows, from text."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor
from tqdm import tqdm

from hv_policy.half_precision import in_half
from hv_policy.rewording import RELATIONS, SHIPPED_REWORDING, TAGS, Lexicon, Rewording, RewordingConfig, save_rewording
from hv_policy.text_encoder import build_vocabulary
from hv_policy.word_features import FEATURE_DIM, WordFeatures, load_word_features
from hv_scripts.thesaurus import COLORS, FURNITURE, SIZES, THINGS
from hv_scripts.told_sentences import Marked, Words, told_sentence
from hv_sim.furniture import FURNITURE_KINDS
from hv_sim.lexicon import COLOR_WORDS, SIZE_WORDS, furniture_nouns, object_nouns, usable
from hv_sim.objects import OBJECT_KINDS

_BATCH, _LONGEST = 256, 48
_FREQUENT = 160
_FORGOTTEN = 0.4
"""So many of the frequent words are shown as any other, so that what they mean counts too."""
_NOISE = 0.3
"""Added to what words mean, whose variance is about 1: other words than these will be said."""
_NOT_COUNTED = -100


def lexicon() -> Lexicon:
    """The words of the seen tasks, and the thesaurus', each with the one that seen tasks use first."""
    things: dict[str, str] = {}
    landmarks: dict[str, str] = {}
    known = [kind for kind, spec in OBJECT_KINDS.items() if not spec.held_out]
    for name, nouns, more, kinds in (
        (things, object_nouns, THINGS, known),
        (landmarks, furniture_nouns, FURNITURE, list(FURNITURE_KINDS)),
    ):
        for kind in kinds:
            seen = usable(nouns(kind), unseen=False)
            name.update({word: word for word in seen if word not in name})
        for kind in kinds:
            first = usable(nouns(kind), unseen=False)[0]
            name.update({word: first for word in more[kind].split("|") if word not in name})
    colors = {word: word for names in COLOR_WORDS.values() for word in usable(names, unseen=False)}
    colors |= {w: COLOR_WORDS[color][0] for color, more in COLORS.items() for w in more.split("|") if w not in colors}
    sizes = {word: names[0] for names in SIZE_WORDS.values() for word in usable(names, unseen=False)}
    sizes |= {w: SIZE_WORDS[size][0] for size, more in SIZES.items() for w in more.split("|") if w not in sizes}
    return Lexicon(things, landmarks, colors, sizes)


def main(arguments: list[str] | None = None) -> int:
    """Entry point of `hv-train-rewording`."""
    parser = argparse.ArgumentParser(prog="hv-train-rewording", description=__doc__)
    parser.add_argument("--output", type=Path, default=SHIPPED_REWORDING, help="file of the weights (safetensors)")
    parser.add_argument("--sentences", type=int, default=100_000)
    parser.add_argument("--epochs", type=int, default=5)
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args(arguments)
    if args.sentences < 1000 or args.epochs < 1:
        parser.error("--sentences, --epochs: valid: at least 1000, 1")
    network, wrong = train(args.sentences, args.epochs, args.seed)
    save_rewording(network, args.output)
    print(f"written: {args.output}; of words in sentences kept aside {100 * wrong:.2f} % are marked wrongly")
    return 0


def train(sentences: int, epochs: int, seed: int) -> tuple[Rewording, float]:
    """The network, and how many of the words of sentences that were kept aside it marks wrongly."""
    torch.manual_seed(seed)
    rng, features = np.random.default_rng(seed), load_word_features()
    known = lexicon()
    whole = [piece for piece in features.pieces if piece.isalpha() and len(piece) > 2]
    words = Words(*(list(x) for x in (known.things, known.landmarks, known.colors, known.sizes)), whole)
    told = [told_sentence(rng, words) for _ in tqdm(range(sentences), "sentences", disable=None)]
    plain = [" ".join(word for word, tag, _ in line if not tag or tag.endswith("relation")) for line in told]
    counted = build_vocabulary(plain[:20_000], _FREQUENT)
    network = Rewording(RewordingConfig(len(counted)), replace(known, frequent=tuple(counted)))
    held = _tables(network, features, told)
    aside, rest = sentences // 50, sentences - sentences // 50
    steps = epochs * rest // _BATCH
    optimizer = torch.optim.AdamW(network.parameters(), lr=1e-3, weight_decay=0.01)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, 1.5e-3, steps, pct_start=0.1)
    network.train()
    for _ in tqdm(range(steps), "steps", disable=None):
        rows = aside + torch.randint(rest, (_BATCH,))
        with in_half("cpu"):
            loss = _loss(network, {k: v[rows] for k, v in held.items()})
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        schedule.step()
    network.eval()
    network.look_up(features)
    return network, _wrong(network, {k: v[:aside] for k, v in held.items()})


def _tables(network: Rewording, features: WordFeatures, told: list[Marked]) -> dict[str, Tensor]:
    count = len(told)
    names = list(RELATIONS)
    meaning = torch.zeros(count, _LONGEST, FEATURE_DIM, dtype=torch.float16)
    number = torch.zeros(count, _LONGEST, dtype=torch.long)
    tag, relation = (torch.full((count, _LONGEST), _NOT_COUNTED) for _ in range(2))
    for i, line in enumerate(tqdm(told, "words", disable=None)):
        line = line[:_LONGEST]
        words = [word for word, _, _ in line]
        meaning[i, : len(line)] = features.of(words).half()
        number[i, : len(line)] = torch.tensor(network.number(words))
        tag[i, : len(line)] = torch.tensor([TAGS.index(t) for _, t, _ in line])
        relation[i, : len(line)] = torch.tensor([names.index(r) if r else _NOT_COUNTED for _, _, r in line])
    return {"meaning": meaning, "number": number, "tag": tag, "relation": relation}


def _loss(network: Rewording, row: dict[str, Tensor]) -> Tensor:
    is_word = row["tag"] != _NOT_COUNTED
    longest = int(is_word.sum(1).max())
    row, is_word = {k: v[:, :longest] for k, v in row.items()}, is_word[:, :longest]
    number = row["number"].masked_fill(torch.rand(is_word.shape) < _FORGOTTEN, 0)
    meaning = row["meaning"].float()
    tags, relations = network(meaning + _NOISE * torch.randn_like(meaning), number, is_word)
    marked = F.cross_entropy(tags.transpose(1, 2), row["tag"], ignore_index=_NOT_COUNTED)
    return marked + F.cross_entropy(relations.transpose(1, 2), row["relation"], ignore_index=_NOT_COUNTED)


@torch.no_grad()
def _wrong(network: Rewording, held: dict[str, Tensor]) -> float:
    is_word = held["tag"] != _NOT_COUNTED
    tags, _ = network(held["meaning"].float(), held["number"], is_word)
    return float(((tags.argmax(-1) != held["tag"]) & is_word).sum() / is_word.sum())


if __name__ == "__main__":
    raise SystemExit(main())
