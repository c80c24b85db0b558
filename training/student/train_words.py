"""Teaches a student to read sentences of any shape, from sentences alone: no picture is trained on.

A student that was trained on pictures finds things by sentences of the shapes that it was told ("put the vase on the
desk") and takes other shapes for something else. So its text encoder is trained until the network sees, with a sentence
of another shape, what it sees with a known one in the same picture. All else stays as it is. The other shapes are
those of `hv_policy.belief.other_tasks` and nonsense: any words before, between and behind what names a thing and a
spot. Some words are strangers that mean nearly the same.

    python training/student/train_words.py --init hv_policy/weights/student --frames DIR --output DIR --seconds 3000
"""

from __future__ import annotations

import argparse
import copy
import csv
import itertools
import math
import multiprocessing
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from hv_policy.belief.other_tasks import ALL_SHAPES, SHAPES, parts_of
from hv_policy.belief.perception import Measurement, Perception, Sight
from hv_policy.text_encoder import PAD, UNKNOWN

sys.path.insert(0, str(Path(__file__).parent))
from train_on_gpu import Phrases, load_perception, read_file, save

KNOWN_SHAPES = 14
"""The first shapes: a sentence of one of them is what the others shall be read like."""
NONSENSE_SHARE, STRANGER_SHARE, OWN_SHARE = 0.5, 0.25, 0.25
"""How often a sentence has nonsense around its names; a word is a stranger; and the picture's own instruction is read
instead."""
MEANING_NOISE = 0.6
"""How far a stranger's meaning is from the word's, as a share of its length."""
NONSENSE = 4000
LINKS = ("and", "which", "that", "is", "to", "it", ",", ";", "so", "there", "please", "now", "should", "be", "a", ".")
SPREAD_WEIGHT, POINTING_WEIGHT, OUTLINE_WEIGHT = 0.3, 0.3, 0.3


@dataclass
class Pictures:
    """What there is to see in N pictures, as the student sees it, and what is called how in them."""

    sight: Sight
    things: Tensor  # (N, T) rows of `Phrases`, -1: nothing there that has a name
    spots: Tensor  # (N, S), likewise
    own: Tensor  # (N,) the picture's own instruction


@torch.no_grad()
def look(perception: Perception, phrases: Phrases, folder: Path, most: int, seed: int) -> Pictures:
    """Some pictures of the files of `pack_frames.py` in a folder, looked at once and for all."""
    rng, parts = np.random.default_rng(seed), []
    files = sorted(folder.glob("*.npz"))
    with multiprocessing.get_context("fork").Pool(1) as pool:
        for file in files:
            held = read_file(file, pool)
            rows = rng.permutation(len(held["task"]))[: most // len(files)]
            names, texts = held["names"].tolist(), held["texts"].tolist()
            of_name = np.append(phrases.add([name or "nothing" for name in names]), -1)
            of_name[:-1][[not name for name in names]] = -1
            pictures = torch.from_numpy(held["pictures"][rows]).permute(0, 3, 1, 2).float() / 255
            state = torch.from_numpy(held["state"][rows]).float()
            looked = [perception.look(pictures[i : i + 64], state[i : i + 64]) for i in range(0, len(rows), 64)]
            sight = [torch.cat([getattr(s, name) for s in looked]).half() for name in ("tokens", "rays", "keys")]
            own = phrases.add(texts)[held["task"][rows]]
            named = (of_name[held["box_name"][rows]], of_name[held["spot_name"][rows]], own)
            parts.append((*sight, *(torch.from_numpy(x) for x in named)))
            print(f"{file.name}: {len(rows)} pictures, {len(phrases.row)} phrases", flush=True)
    tokens, rays, keys, things, spots, own = (torch.cat(x) for x in zip(*parts, strict=True))
    return Pictures(Sight(tokens, rays, keys, torch.zeros(len(tokens), 0)), things, spots, own)


class Sentences:
    """Makes sentences of phrases, as rows of them."""

    def __init__(self, phrases: Phrases, perception: Perception, seed: int) -> None:
        rng = np.random.default_rng(seed)
        whole = [p for p in perception.text.features.pieces if p.isalpha() and len(p) > 2]

        def nonsense() -> str:
            count = int(rng.choice([0, 1, 2, 3, 4, 5, 6], p=[0.15, 0.15, 0.2, 0.2, 0.12, 0.1, 0.08]))
            return " ".join(str(rng.choice(LINKS if rng.random() < 0.5 else whole)) for _ in range(count))

        self.nonsense = torch.from_numpy(phrases.add([nonsense() for _ in range(NONSENSE)]))
        self.shapes: list[tuple[list[int], list[str]]] = []
        for shape in ALL_SHAPES:
            texts, slots = parts_of(shape)
            self.shapes.append((phrases.add(texts).tolist(), slots))
        phrases.add([""])

    def of_shape(self, shape: int, filling: dict[str, int]) -> list[int]:
        texts, slots = self.shapes[shape]
        between = [filling[slot] for slot in slots]
        return [x for pair in itertools.zip_longest(texts, between) for x in pair if x is not None]

    def of_nonsense(self, filling: dict[str, int], generator: np.random.Generator) -> list[int]:
        first, second = ("thing", "spot") if generator.random() < 0.65 else ("spot", "thing")
        around = self.nonsense[generator.integers(0, NONSENSE, 3)].tolist()
        return [around[0], filling[first], around[1], filling[second], around[2]]


def read(phrases: Phrases, sentences: list[list[int]], strange: bool) -> tuple[Tensor, Tensor]:
    """Tokens and mask of sentences that consist of rows of phrases; `strange`: some words are strangers."""
    most = max(len(line) for line in sentences)
    empty = phrases.row[""]
    rows = torch.tensor([line + [empty] * (most - len(line)) for line in sentences])
    if not strange:
        return phrases.read_joined(rows)
    encoder, original = phrases.encoder, phrases.encoder.read

    def disturbed(numbers: Tensor, buckets: Tensor, meanings: Tensor) -> tuple[Tensor, Tensor]:
        stranger = (torch.rand(numbers.shape) < STRANGER_SHARE) & (numbers != PAD)
        spelled = torch.rand(numbers.shape) < 0.5
        noise = torch.randn_like(meanings)
        far = MEANING_NOISE * torch.rand(numbers.shape) * stranger
        noise = noise * (far * meanings.norm(dim=-1) / noise.norm(dim=-1))[..., None]
        others = buckets.flatten(0, 1)[torch.randperm(numbers.numel())].view_as(buckets)
        others = torch.where(spelled[..., None], others, torch.full_like(buckets, PAD))
        return original(
            numbers.masked_fill(stranger, UNKNOWN),
            torch.where(stranger[..., None], others, buckets),
            meanings + noise,
        )

    encoder.read = disturbed  # type: ignore[method-assign]
    try:
        return phrases.read_joined(rows)
    finally:
        encoder.read = original  # type: ignore[method-assign]


def draw(
    pictures: Pictures, made: Sentences, count: int, rng: np.random.Generator
) -> tuple[Tensor, list[list[int]], list[list[int]]]:
    """Pictures (count,), a sentence of a known shape for each, and one that means the same."""
    chosen, known, other = [], [], []
    while len(chosen) < count:
        i = int(rng.integers(len(pictures.own)))
        if rng.random() < OWN_SHARE:
            line = [int(pictures.own[i])]
            chosen, known, other = [*chosen, i], [*known, line], [*other, line]
            continue
        things, spots = (x[i][x[i] >= 0].tolist() for x in (pictures.things, pictures.spots))
        if not things or not spots:
            continue
        filling = {"thing": int(rng.choice(things)), "spot": int(rng.choice(spots)), "other": int(rng.choice(spots))}
        known.append(made.of_shape(int(rng.integers(KNOWN_SHAPES)), filling))
        if rng.random() < NONSENSE_SHARE:
            other.append(made.of_nonsense(filling, rng))
        else:
            shapes = len(SHAPES) if filling["other"] == filling["spot"] else len(ALL_SHAPES)
            other.append(made.of_shape(int(rng.integers(shapes)), filling))
        chosen.append(i)
    return torch.tensor(chosen), known, other


def difference(seen: Measurement, wanted: Measurement) -> Tensor:
    """() how differently two sentences make the network see."""
    places = F.smooth_l1_loss(seen.places, wanted.places, beta=0.3)
    spread = F.smooth_l1_loss(seen.log_spread, wanted.log_spread, beta=0.3)
    pointing = F.kl_div(seen.pointing, wanted.pointing, log_target=True, reduction="none").sum(-1).mean()
    outline = F.smooth_l1_loss(seen.outline, wanted.outline, beta=0.3)
    return places + SPREAD_WEIGHT * spread + POINTING_WEIGHT * pointing + OUTLINE_WEIGHT * outline


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--init", type=Path, required=True, help="checkpoint that it goes on from")
    parser.add_argument("--frames", type=Path, required=True, help="folder of files of pack_frames.py")
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--seconds", type=float, default=3000.0)
    parser.add_argument("--pictures", type=int, default=6000)
    parser.add_argument("--batch", type=int, default=64)
    parser.add_argument("--lr", type=float, default=5e-4)
    parser.add_argument("--report-s", type=float, default=30.0)
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    torch.manual_seed(args.seed)
    rng = np.random.default_rng(args.seed)
    args.output.mkdir(parents=True, exist_ok=True)
    teacher = load_perception(args.init).eval().requires_grad_(False)
    student = copy.deepcopy(teacher)
    trained = [p for name, p in student.text.named_parameters() if not name.startswith("features")]
    for parameter in trained:
        parameter.requires_grad_(True)
    phrases = Phrases(teacher.text)
    pictures = look(teacher, phrases, args.frames, args.pictures, args.seed)
    made = Sentences(phrases, teacher, args.seed)
    read_by_student = copy.copy(phrases)
    read_by_student.encoder = student.text
    optimizer = torch.optim.AdamW(trained, lr=args.lr, weight_decay=0.0)
    start = reported = time.monotonic()
    step, total, count = 0, 0.0, 0
    with (args.output / "words.csv").open("w") as file:
        curve = csv.writer(file)
        curve.writerow(["samples", "seconds", "lr", "difference", "difference_of_known", "difference_of_unread"])
        while (share := (time.monotonic() - start) / args.seconds) < 1:
            rate = args.lr * min(1.0, (step + 1) / 200) * (0.01 + 0.99 * 0.5 * (1 + math.cos(math.pi * share)))
            optimizer.param_groups[0]["lr"] = rate
            rows, known, other = draw(pictures, made, args.batch, rng)
            sight = Sight(*(getattr(pictures.sight, n)[rows].float() for n in ("tokens", "rays", "keys", "fine")))
            with torch.no_grad():
                wanted = teacher.judge(sight, *read(phrases, known, False))
            loss = difference(student.judge(sight, *read(read_by_student, other, True)), wanted)
            optimizer.zero_grad(set_to_none=True)
            loss.backward()
            torch.nn.utils.clip_grad_norm_(trained, 1.0)
            optimizer.step()
            step, total, count = step + 1, total + float(loss.detach()), count + 1
            if time.monotonic() - reported > args.report_s:
                with torch.no_grad():
                    same = difference(student.judge(sight, *read(read_by_student, known, False)), wanted)
                    unread = difference(teacher.judge(sight, *read(phrases, other, False)), wanted)
                seconds = time.monotonic() - start
                row = [step * args.batch, round(seconds), rate, total / count, float(same), float(unread)]
                curve.writerow([f"{value:.5g}" for value in row])
                file.flush()
                print(*(f"{value:.4g}" for value in row), flush=True)
                save(student, args.init, args.output)
                total, count, reported = 0.0, 0, time.monotonic()
    save(student, args.init, args.output)
    print("done", step * args.batch, flush=True)


if __name__ == "__main__":
    main()
