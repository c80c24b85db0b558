"""Trains what a student sees with, from frames that are all held in memory: a GPU's, or that of a machine without one.

The loss, the mirror and the other colours are those of `lerobot-train` (`hv_policy.belief.perception_loss`,
`hv_policy.belief.mirror`); words are looked up once, and pictures are decoded once. Needs torch, numpy, pillow, scipy
and safetensors, and nothing of LeRobot: 14,000 pictures a second on an H100, 110 on a core with bfloat16. Files of
`pack_frames.py` that come into the folder while it runs are taken in. Under torchrun each process holds its share.

    python training/student/train_perception.py --init hv_policy/weights/student --frames DIR --output DIR --seconds 400
"""

from __future__ import annotations

import argparse
import hashlib
import io
import json
import math
import multiprocessing
import os
import queue
import re
import threading
import time
import zlib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
import torch
import torch.distributed as dist
from PIL import Image
from safetensors.torch import load_file, save_file
from torch import Tensor

from hv_policy.belief import mirror
from hv_policy.belief.absent_names import are_absent, draw_names, noun_at
from hv_policy.belief.other_tasks import ALL_SHAPES, SLOTS, choose_tasks, parts_of
from hv_policy.belief.perception import Perception
from hv_policy.belief.perception_loss import (
    NAMELESS,
    OtherTask,
    Shown,
    Things,
    Truth,
    movable_loss,
    perception_loss,
    pieces_loss,
)
from hv_policy.belief.perception_size import PERCEPTIONS
from hv_policy.half_precision import in_half
from hv_policy.rewording import Lexicon, Reworder, load_rewording
from hv_policy.text_encoder import TextEncoder
from hv_policy.weight_decay import decay_groups
from hv_policy.word_features import FEATURE_DIM, MAX_PIECES
from hv_sim.object_kinds.made_up import NOUNS as MADE_UP_NOUNS

PREFIX = "network.perception."
SPOTS_A_PICTURE = 2
HELD_OUT, HELD_OUT_EVERY = "new", 25
"""Of files whose names begin so, one episode in so many is kept aside."""
LEAST_SHARE = 0.002


class Phrases:
    """Everything that a text encoder looks up, for each of many phrases, on the device."""

    def __init__(self, encoder: TextEncoder) -> None:
        self.encoder, self.device = encoder, encoder.position.device
        self.row: dict[str, int] = {}
        words = encoder.max_words
        self.numbers = torch.zeros(0, words, dtype=torch.long, device=self.device)
        self.buckets = torch.zeros(0, words, 16, dtype=torch.int16, device=self.device)
        self.meanings = torch.zeros(0, words, FEATURE_DIM, dtype=torch.float16, device=self.device)
        self.pieces = torch.zeros(0, MAX_PIECES, dtype=torch.long, device=self.device)
        self.owner = torch.zeros(0, MAX_PIECES, dtype=torch.long, device=self.device)
        self.length = torch.zeros(0, dtype=torch.long, device=self.device)
        self.piece_count = torch.zeros(0, dtype=torch.long, device=self.device)
        self.mirrored = torch.zeros(0, dtype=torch.long, device=self.device)
        self.renamed = torch.zeros(0, dtype=torch.long, device=self.device)
        self.nouns = torch.zeros(0, FEATURE_DIM, dtype=torch.float16, device=self.device)
        """(P, FEATURE_DIM) what the noun of each, if it is a name, means."""

    def add(self, phrases: Sequence[str]) -> np.ndarray:
        """(P,) int64 rows of phrases; those in the mirror are added too."""
        both = [text for phrase in phrases for text in (phrase, mirror.mirrored_text(phrase))]
        new = [text for text in dict.fromkeys(both) if text not in self.row]
        for text in new:
            self.row[text] = len(self.row)
        for start in range(0, len(new), 512):
            self._look_up(self.encoder.words_of(new[start : start + 512]))
        others = [self.row.get(mirror.mirrored_text(text), self.row[text]) for text in new]
        self.mirrored = torch.cat([self.mirrored, torch.tensor(others, dtype=torch.long, device=self.device)])
        self.renamed = torch.cat([self.renamed, torch.arange(len(self.renamed), len(self.row), device=self.device)])
        return np.array([self.row[phrase] for phrase in phrases], dtype=np.int64)

    def rename(self, others: Mapping[str, str]) -> None:
        """Phrases, and what may be said in the place of each (`renamed`)."""
        rows, said = self.add(list(others)), self.add(list(others.values()))
        self.renamed[torch.from_numpy(rows).to(self.device)] = torch.from_numpy(said).to(self.device)

    @torch.no_grad()
    def _look_up(self, lines: list[list[str]]) -> None:
        encoder, count = self.encoder, len(lines)
        numbers, buckets = encoder.tokenize(lines)
        pieces = torch.zeros(count, MAX_PIECES, dtype=torch.long)
        owner, is_piece = torch.zeros_like(pieces), torch.zeros(count, MAX_PIECES, dtype=torch.bool)
        for i, line in enumerate(lines):
            lists = encoder.features.pieces_of(line)
            flat = [(piece, word) for word, found in enumerate(lists) for piece in found][:MAX_PIECES]
            if flat:
                pieces[i, : len(flat)], owner[i, : len(flat)] = torch.tensor(flat).T
            is_piece[i, : len(flat)] = True
        pieces, owner, is_piece = (x.to(self.device) for x in (pieces, owner, is_piece))
        meanings = self._meanings(pieces, owner, is_piece).half()
        words = encoder.max_words - numbers.shape[1]
        numbers = torch.nn.functional.pad(numbers, (0, words))
        buckets = torch.nn.functional.pad(buckets, (0, 16 - buckets.shape[2], 0, words)).to(torch.int16)
        length = torch.tensor([0 if line == [""] else len(line) for line in lines], device=self.device)
        grown = {
            "numbers": numbers,
            "buckets": buckets,
            "meanings": meanings,
            "pieces": pieces,
            "owner": owner,
            "length": length,
            "piece_count": is_piece.sum(1),
            "nouns": meanings[torch.arange(count), torch.tensor([noun_at(line) for line in lines])],
        }
        for name, more in grown.items():
            setattr(self, name, torch.cat([getattr(self, name), more]))

    def _meanings(self, pieces: Tensor, owner: Tensor, is_piece: Tensor) -> Tensor:
        """(N, W, FEATURE_DIM) of sentences of pieces (N, P), which belong to the words `owner` (N, P)."""
        shown = is_piece.clone()
        shown[~is_piece.any(1), 0] = True
        read = self.encoder.features(pieces, shown).float() * is_piece[..., None]
        meanings = torch.zeros(len(pieces), self.encoder.max_words, FEATURE_DIM, device=self.device)
        meanings.scatter_add_(1, owner[..., None].expand(-1, -1, FEATURE_DIM), read)
        of_word = torch.zeros(meanings.shape[:2], device=self.device).scatter_add_(1, owner, is_piece.float())
        return meanings / of_word.clamp(min=1)[..., None]

    def read_joined(self, rows: Tensor) -> tuple[Tensor, Tensor]:
        """Tokens (N, L, dim) and (N, L) bool of sentences that consist of K phrases each, `rows` (N, K)."""
        ends, piece_ends = self.length[rows].cumsum(1), self.piece_count[rows].cumsum(1)
        starts, piece_starts = ends - self.length[rows], piece_ends - self.piece_count[rows]
        numbers = self._joined(self.numbers, rows, starts, self.length)
        buckets = torch.stack([self._joined(self.buckets[..., k], rows, starts, self.length) for k in range(16)], -1)
        pieces = self._joined(self.pieces, rows, piece_starts, self.piece_count)
        owner = self._joined(self.owner, rows, piece_starts, self.piece_count, starts)
        is_piece = torch.arange(MAX_PIECES, device=self.device) < piece_ends[:, -1:]
        longest, most = int(ends[:, -1].max()), int(piece_ends[:, -1].max())
        with torch.no_grad():
            meanings = self._meanings(pieces[:, :most], owner[:, :most], is_piece[:, :most])[:, :longest]
        return self.encoder.read(numbers[:, :longest], buckets[:, :longest].long(), meanings)

    def _joined(
        self, table: Tensor, rows: Tensor, starts: Tensor, counts: Tensor, add: Tensor | None = None
    ) -> Tensor:
        """(N, W) of a table (P, W): the first `counts` (P,) numbers of each of the phrases, one after the other, with
        `add` (N, K) added to those of each."""
        width = table.shape[1]
        out = torch.zeros(len(rows), width + 1, dtype=table.dtype, device=self.device)
        along = torch.arange(width, device=self.device)
        for k in range(rows.shape[1]):
            values = table[rows[:, k]]
            values = values if add is None else values + add[:, k : k + 1]
            at = torch.where(along < counts[rows[:, k], None], starts[:, k : k + 1] + along, width).clamp(max=width)
            out.scatter_(1, at, values)
        return out[:, :width]

    def read(self, rows: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Tokens (D, L, dim) and (D, L) bool of the D different phrases in `rows` (...), and their numbers (...)."""
        distinct, number = rows.unique(return_inverse=True)
        longest = int(self.length[distinct].max())
        looked_up = (x[distinct, :longest] for x in (self.numbers, self.buckets, self.meanings))
        numbers, buckets, meanings = looked_up
        return *self.encoder.read(numbers, buckets.long(), meanings.float()), number


class Strangers:
    """Calls things by a word that fits nothing: of what it has never seen perception is to know the colour, where that
    is said, and else at least that it is a thing.

    Args:
        lexicon: known words for colours and things.
        words: that take the place of a thing's name.
    """

    def __init__(self, lexicon: Lexicon, words: Sequence[str]) -> None:
        def any_of(known: Mapping[str, str]) -> str:
            return "|".join(re.escape(word) for word in sorted(known, key=len, reverse=True))

        adjectives = rf"(?:(?:{any_of(lexicon.sizes)}) )?(?:(?:{any_of(lexicon.colors)}) )?"
        things = any_of({**lexicon.things, **dict.fromkeys(MADE_UP_NOUNS, "")})
        self._thing = re.compile(rf"\bthe ({adjectives})(?:{things})\b")
        self._words = list(words)

    def of(self, phrase: str) -> str:
        """The phrase with a strange word for the first thing in it, the same one each time."""
        word = self._words[zlib.crc32(phrase.encode()) % len(self._words)]
        return self._thing.sub(rf"the \1{word}", phrase, count=1)


class Frames:
    """All frames, on the device.

    Args:
        phrases: reads their names.
        reword: says an instruction as the student reads it.
        strangers: what it is not to know by name.
        strange_share: how often things are called by such words.
        capacity: frames that there is room for from the start; more make it grow, which takes three times the room
            while it does.
        weights: how often frames are drawn, by the beginning of their file's name; 1 for all others.
    """

    def __init__(
        self,
        phrases: Phrases,
        reword: Callable[[str], str] = str,
        strangers: Strangers | None = None,
        strange_share: float = 0.0,
        capacity: int = 0,
        weights: Mapping[str, float] | None = None,
    ) -> None:
        self._weights = weights or {}
        self._reword, self._strangers, self._strange_share = reword, strangers, strange_share
        self.phrases, self.device = phrases, phrases.device
        self._capacity, self._count = capacity, 0
        self._room: dict[str, Tensor] = {}
        self.held: dict[str, Tensor] = {}
        self.number_of_nothing = int(phrases.add([NAMELESS])[0])
        self._nothing = torch.tensor(self.number_of_nothing, device=self.device)
        taken_apart = [parts_of(shape) for shape in ALL_SHAPES]
        more = [len(SLOTS) - len(slots) for _, slots in taken_apart]
        parts = phrases.add(
            [part for (texts, _), n in zip(taken_apart, more, strict=True) for part in texts + [""] * n]
        )
        self.shapes = torch.from_numpy(parts).view(-1, len(SLOTS) + 1).to(self.device)
        """(K, 4) phrases around the slots of each shape."""
        order = [[SLOTS.index(slot) for slot in slots] for _, slots in taken_apart]
        order = [slots + [len(SLOTS)] * n for slots, n in zip(order, more, strict=True)]
        self.slots = torch.tensor(order, device=self.device)
        """(K, 3) what fills them: a number of `SLOTS`, or 3 for nothing."""
        self._empty = torch.from_numpy(phrases.add([""])).to(self.device)

    def add(self, file: Path, held: dict[str, np.ndarray]) -> None:
        """Those of a file, as `read_file` returns them."""
        phrases, names = self.phrases, held.pop("names").tolist()
        told = [self._reword(text) for text in held.pop("texts").tolist()]
        of_text = phrases.add(told)
        of_name = np.append(phrases.add([name or NAMELESS for name in names]), self.number_of_nothing)
        if self._strangers is not None:
            phrases.rename({phrase: self._strangers.of(phrase) for phrase in told + names if phrase})
        named = np.append(np.array([bool(name) for name in names]), False)
        held["task"] = of_text[held["task"]]
        held["has_name"], held["exists"] = named[held["box_name"]], held["box_name"] >= 0
        held["spot_exists"] = held["spot_name"] >= 0
        held["box_name"], held["spot_name"] = of_name[held["box_name"]], of_name[held["spot_name"]]
        aside = (held.pop("episode") % HELD_OUT_EVERY == 0) & file.name.startswith(HELD_OUT)
        weight = next((w for start, w in self._weights.items() if file.name.startswith(start)), 1.0)
        held["aside"], held["weight"] = aside, np.where(aside, 0.0, weight)
        count = self._count + len(aside)
        for name, values in held.items():
            more = torch.from_numpy(np.ascontiguousarray(values)).to(self.device)
            if name not in self._room or len(self._room[name]) < count:
                rows = max(self._capacity, 2 * self._count, count)
                grown = torch.empty(rows, *more.shape[1:], dtype=more.dtype, device=self.device)
                if self._count:
                    grown[: self._count] = self.held[name]
                self._room[name] = grown
            self._room[name][self._count : count] = more
            self.held[name] = self._room[name][:count]
        self._count = count
        total = self.held["weight"].cumsum(0)
        self._share = total / total[-1]
        self.aside = self.held["aside"].nonzero()[:, 0]

    def __len__(self) -> int:
        return len(self._share)

    def draw(self, count: int) -> Tensor:
        """(count,) rows."""
        drawn = torch.rand(count, device=self.device, dtype=torch.double)
        return torch.searchsorted(self._share, drawn).clamp(max=len(self) - 1)

    def loss(
        self, perception: Perception, rows: Tensor, mirror_share: float = 0.0, with_things: bool = True
    ) -> tuple[Tensor, dict[str, Tensor]]:
        """`perception_loss` of rows (B,), some of them mirrored; in training all recoloured. Without things that are
        not the task's it takes half the time."""
        row, pictures, state, flip = self._shown(rows, mirror_share, perception.training)
        bits = 7 - torch.arange(8, device=self.device)
        taken = (row["floor"][..., None] >> bits & 1).flatten(1).bool()
        truth = Truth(
            mirror.PLACES.where(flip, row["places"].float()),
            mirror.ROTATION_6D.where(flip, row["rotation"].float()),
            row["half_extents"].float(),
            mirror.mirrored_floor(taken, flip),
            row["floor_known"],
        )
        named = self._naming(flip, perception.training)
        things = self._things(perception, row, state, named) if with_things else None
        words, is_word, number = self.phrases.read(named(row["task"]))
        return perception_loss(perception, pictures, state, words[number], is_word[number], truth, things)

    def heads_loss(
        self, perception: Perception, rows: Tensor, mirror_share: float = 0.0
    ) -> tuple[Tensor, dict[str, Tensor]]:
        """How wrong `Perception.find_pieces` and `find_movable` are in rows (B,), as in `perception_loss`; nothing else
        is learned."""
        row, pictures, state, flip = self._shown(rows, mirror_share, perception.training)
        with torch.no_grad():
            boxes = row["boxes"]
            shown = Shown.of(perception, state, boxes, row["exists"])
            has_name = row["has_name"] & shown.asked
            names = self._naming(flip, False)(row["box_name"].where(has_name, self._nothing))
            foreign, is_absent = self._foreign(names, has_name)
            tokens, is_word, number = self.phrases.read(torch.cat([names.flatten(), foreign]))
            sight, distinct = perception.look(pictures, state), perception.named(tokens, is_word)
            others = distinct[number[names.numel() :]].expand(len(names), -1, -1)
            named = torch.cat([distinct[number[: names.numel()]].view(*names.shape, -1), others], 1)
        asked = torch.cat([has_name, is_absent], 1)
        pieces, figures = pieces_loss(perception, sight, named, boxes, shown.in_view, asked)
        movable, more = movable_loss(perception, sight, shown.label, boxes)
        return pieces + movable, figures | more

    def _foreign(self, names: Tensor, has_name: Tensor) -> tuple[Tensor, Tensor]:
        """(K,) some of the names (B, T), and (B, K) bool whether nothing in a picture may be called so."""
        foreign = draw_names(names, has_name)
        return foreign, are_absent(self.phrases.nouns[foreign], self.phrases.nouns[names], has_name)

    def _shown(
        self, rows: Tensor, mirror_share: float, recolour: bool
    ) -> tuple[dict[str, Tensor], Tensor, Tensor, Tensor]:
        """What is held of rows (B,), their pictures and proprioception, and (B,) bool which of them are mirrored."""
        row = {name: values[rows] for name, values in self.held.items()}
        flip = torch.rand(len(rows), device=self.device) < mirror_share
        here = flip[:, None, None]
        pictures = mirror.mirrored_pictures(row["pictures"].permute(0, 3, 1, 2).float() / 255, flip)
        pictures = mirror.recoloured(pictures) if recolour else pictures
        state = mirror.STATE.where(flip, row["state"].float())
        boxes, spots = row["boxes"].float(), row["spots"].float()
        row["boxes"] = torch.where(here, mirror.BOX(boxes), boxes)
        row["spots"] = torch.where(here, mirror.POINT(spots), spots)
        return row, pictures, state, flip

    def _naming(self, flip: Tensor, may_be_strange: bool) -> Callable[[Tensor], Tensor]:
        """Numbers of phrases (B, ...) -> those of what is said: of others where a picture is mirrored (`flip` (B,)),
        and now and then strange ones."""
        strange = torch.rand(len(flip), device=self.device) < (self._strange_share if may_be_strange else 0.0)

        def named(rows_of_names: Tensor) -> Tensor:
            along = -1, *[1] * (rows_of_names.dim() - 1)
            said = torch.where(strange.view(along), self.phrases.renamed[rows_of_names], rows_of_names)
            return torch.where(flip.view(along), self.phrases.mirrored[said], said)

        return named

    def _things(
        self, perception: Perception, row: dict[str, Tensor], state: Tensor, named: Callable[[Tensor], Tensor]
    ) -> Things:
        """What else the pictures show."""
        boxes, spots = row["boxes"], row["spots"]
        shown = Shown.of(perception, state, boxes, row["exists"])
        has_name = row["has_name"] & shown.asked
        drawn = (torch.rand(spots.shape[:2], device=self.device) + row["spot_exists"]).topk(SPOTS_A_PICTURE, 1).indices
        of_things = named(row["box_name"].where(has_name, self._nothing))
        of_spots = named(row["spot_name"].gather(1, drawn))
        foreign, is_absent = self._foreign(of_things, has_name)
        tokens, is_word, number = self.phrases.read(torch.cat([of_things.flatten(), of_spots.flatten(), foreign]))
        which, of_spots, foreign = (
            part.view(shape)
            for part, shape in zip(
                number.split([of_things.numel(), of_spots.numel(), len(foreign)]),
                (of_things.shape, of_spots.shape, foreign.shape),
                strict=True,
            )
        )
        others = self._others(row, shown, named)
        return Things(
            shown,
            boxes,
            has_name,
            spots.gather(1, drawn[..., None].expand(-1, -1, 3)),
            row["spot_exists"].gather(1, drawn),
            tokens,
            is_word,
            which,
            of_spots,
            foreign,
            is_absent,
            others,
        )

    def _others(self, row: dict[str, Tensor], shown: Shown, named: Callable[[Tensor], Tensor]) -> OtherTask:
        """Other tasks in the pictures of a batch."""
        boxes, spots = row["boxes"], row["spots"]
        thing, spot, other, shape, possible = choose_tasks(
            row["has_name"], shown.in_view, boxes[..., 3:6], row["spot_exists"]
        )
        at = torch.arange(len(boxes), device=self.device)
        filling = [row["box_name"][at, thing], row["spot_name"][at, spot], row["spot_name"][at, other]]
        told = torch.cat([named(torch.stack(filling, 1)), self._empty.expand(len(at), 1)], 1)
        told, around = told.gather(1, self.slots[shape]), self.shapes[shape]
        sentence = torch.cat([torch.stack([around[:, :-1], told], 2).flatten(1), around[:, -1:]], 1)
        words, is_word = self.phrases.read_joined(sentence)
        return OtherTask(words, is_word, possible, boxes[at, thing], spots[at, spot])


def read_file(file: Path, pool: multiprocessing.pool.Pool) -> dict[str, np.ndarray]:
    """What a file of `pack_frames.py` holds, its pictures (N, S, S, 3) decoded."""
    with np.load(file) as opened:
        held = dict(opened)
    coded = coded_pictures(held)
    del held["sizes"]
    held["pictures"] = np.concatenate(pool.map(decoded, [coded[i : i + 256] for i in range(0, len(coded), 256)]))
    return held


def coded_pictures(held: Mapping[str, np.ndarray]) -> list[bytes]:
    """Those of a file of `pack_frames.py`, each by itself."""
    ends, raw = np.cumsum(held["sizes"], dtype=np.int64), held["pictures"].tobytes()
    return [raw[start:end] for start, end in zip([0, *ends[:-1]], ends, strict=True)]


def decoded(coded: Sequence[bytes]) -> np.ndarray:
    """(B, S, S, 3) uint8."""
    return np.stack([np.asarray(Image.open(io.BytesIO(one)).convert("RGB")) for one in coded])


def load_perception(folder: Path) -> Perception:
    """Of a checkpoint of `lerobot-train`."""
    config = json.loads((folder / "config.json").read_text())
    size = PERCEPTIONS[config["size"]]
    texts = config["vocabulary"], config["max_words"], config["word_dropout"]
    perception = Perception(size, config["image_size"], *texts)
    weights = load_file(folder / "model.safetensors")
    perception.load_state_dict({k.removeprefix(PREFIX): v for k, v in weights.items() if k.startswith(PREFIX)})
    return perception


def save(perception: Perception, init: Path, output: Path, learned_share: float = 1.0) -> None:
    """The checkpoint `init` with this perception in it, or `learned_share` of the way from the one to the other
    (Wortsman et al. 2022, "Robust fine-tuning of zero-shot models"), as `output/model.safetensors`."""
    weights = load_file(init / "model.safetensors")
    for name, value in perception.state_dict().items():
        before = weights[PREFIX + name]
        learned = value.detach().to("cpu", before.dtype)
        weights[PREFIX + name] = torch.lerp(before, learned, learned_share).contiguous()
    save_file(weights, output / "draft.tmp", metadata={"format": "pt"})
    (output / "draft.tmp").replace(output / "model.safetensors")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--init", type=Path, required=True, help="checkpoint that it goes on from")
    parser.add_argument("--frames", type=Path, required=True, help="folder of files of pack_frames.py")
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--seconds", type=float, default=400.0)
    parser.add_argument("--batch", type=int, default=1024)
    parser.add_argument("--lr", type=float, default=1.2e-3)
    parser.add_argument("--warmup", type=int, default=300, help="steps")
    parser.add_argument("--weight-decay", type=float, default=1e-2)
    parser.add_argument(
        "--weights", nargs="*", default=[], metavar="NAME=W", help="how often frames of files with such names are drawn"
    )
    parser.add_argument("--mirror-share", type=float, default=0.35, help="of the pictures")
    parser.add_argument("--word-dropout", type=float, help="share of words shown as unknown (the checkpoint's)")
    parser.add_argument("--strange-share", type=float, default=0.2, help="how often things have an unknown name")
    parser.add_argument("--things-every", type=int, default=1, help="one step in so many asks for other things too")
    parser.add_argument("--learned-share", type=float, default=1.0, help="how far weights go from what they were")
    parser.add_argument(
        "--only-heads", action="store_true", help="only where pieces of furniture are and what can be moved is learned"
    )
    parser.add_argument("--keep-faces", action="store_true", help="the head that tells faces (train_faces.py) stays")
    parser.add_argument("--report-s", type=float, default=10.0)
    parser.add_argument("--decoders", type=int, default=multiprocessing.cpu_count())
    parser.add_argument("--capacity", type=int, default=0, help="frames to make room for at once")
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    world, rank = int(os.environ.get("WORLD_SIZE", 1)), int(os.environ.get("RANK", 0))
    if world > 1:
        dist.init_process_group("gloo")
    torch.manual_seed(args.seed + rank)
    torch.set_float32_matmul_precision("high")
    torch.backends.cuda.allow_fp16_bf16_reduction_math_sdp(True)  # says cuda, counts for every device
    pool = multiprocessing.get_context("fork").Pool(args.decoders)
    device = "cuda" if torch.cuda.is_available() else "cpu"
    perception = load_perception(args.init).to(device).train()
    if args.word_dropout is not None:
        perception.text.word_dropout = args.word_dropout
    perception.faces.requires_grad_(not args.keep_faces)
    perception.closer.requires_grad_(False)  # learned alone, by train_closer.py
    if args.only_heads:
        perception.requires_grad_(False)
        for head in (perception.landmarks, perception.movable):
            head.requires_grad_(True)
    features = perception.text.features
    reworder = Reworder(load_rewording(), features)
    strangers = Strangers(reworder.lexicon, [piece for piece in features.pieces if piece.isalpha() and len(piece) > 3])
    phrases = Phrases(perception.text)
    frames = Frames(phrases, reworder.say, strangers, args.strange_share, args.capacity, _weights(args.weights))
    args.output.mkdir(parents=True, exist_ok=True)
    arrived: queue.Queue[tuple[Path, dict[str, np.ndarray]]] = queue.Queue()

    def watch() -> None:
        known: set[Path] = set()
        while True:
            for file in sorted(args.frames.glob("*.npz")):
                if file not in known and _holder(file, world) == rank:
                    known.add(file)
                    arrived.put((file, read_file(file, pool)))
            time.sleep(0.5)

    threading.Thread(target=watch, daemon=True).start()
    frames.add(*arrived.get())
    trained = [p for p in perception.parameters() if p.requires_grad]
    groups = decay_groups(perception, weight_decay=args.weight_decay)
    optimizer = torch.optim.AdamW(groups, lr=args.lr, fused=device == "cuda")
    start = reported = saved = time.monotonic()
    step = 0
    sums: dict[str, Tensor] = {}
    counts: dict[str, int] = {}
    curve = (args.output / ("curve.csv" if rank == 0 else f"curve_{rank}.csv")).open("w")
    while (share := _of_first((time.monotonic() - start) / args.seconds, world)) < 1:
        while not arrived.empty():
            frames.add(*arrived.get())
        rate = args.lr * warmed_cosine(step, args.warmup, share, LEAST_SHARE)
        for group in optimizer.param_groups:
            group["lr"] = rate
        with in_half(device):
            with_things = step % args.things_every == 0
            drawn = frames.draw(args.batch)
            if args.only_heads:
                loss, figures = frames.heads_loss(perception, drawn, args.mirror_share)
            else:
                loss, figures = frames.loss(perception, drawn, args.mirror_share, with_things)
        optimizer.zero_grad(set_to_none=True)
        loss.mean().backward()
        _average_gradients(trained, world)
        torch.nn.utils.clip_grad_norm_(trained, 5.0)
        optimizer.step()
        step += 1
        for name, value in {"loss": loss.detach().mean(), **figures}.items():
            sums[name] = sums.get(name, torch.zeros_like(value)) + value.nan_to_num()
            counts[name] = counts.get(name, 0) + 1
        if step % 25 == 0 and time.monotonic() - reported > args.report_s:
            row = {"samples": step * args.batch * world, "frames": len(frames), "lr": rate}
            row |= {name: float(total) / counts[name] for name, total in sums.items()}
            row |= {f"aside_{name}": value for name, value in _aside(frames, perception).items()}
            if curve.tell() == 0:
                curve.write(",".join(row) + "\n")
            curve.write(",".join(f"{value:.5g}" for value in row.values()) + "\n")
            curve.flush()
            print(" ".join(f"{name} {value:.4g}" for name, value in row.items()), flush=True)
            sums, counts, reported = {}, {}, time.monotonic()
        if rank == 0 and time.monotonic() - saved > 60:
            save(perception, args.init, args.output, args.learned_share)
            saved = time.monotonic()
    if rank == 0:
        save(perception, args.init, args.output, args.learned_share)
        (args.output / "done").write_text(f"{step * args.batch * world}\n")
        print("done", step * args.batch * world, flush=True)
    pool.terminate()


def warmed_cosine(step: int, warmup: int, done: float, least: float) -> float:
    """Share of the learning rate at a step: up in `warmup` steps, then down to `least` when all is `done` (0..1)."""
    return min(1.0, (step + 1) / warmup) * (least + (1 - least) * 0.5 * (1 + math.cos(math.pi * done)))


def _holder(file: Path, world: int) -> int:
    """Which of `world` processes holds a file: the same one whatever other files there are by now."""
    return hashlib.sha256(file.name.encode()).digest()[0] % world


def _weights(given: Sequence[str]) -> dict[str, float]:
    return {name: float(weight) for name, weight in (one.split("=") for one in given)}


def _of_first(value: float, world: int) -> float:
    """What the first of `world` processes says."""
    if world == 1:
        return value
    said = torch.tensor(value, dtype=torch.float64)
    dist.broadcast(said, 0)
    return float(said)


def _average_gradients(trained: Sequence[Tensor], world: int) -> None:
    """Over `world` processes."""
    if world == 1:
        return
    flat = torch.cat([torch.zeros(p.numel()) if p.grad is None else p.grad.flatten() for p in trained])
    dist.all_reduce(flat)
    for p, mean in zip(trained, (flat / world).split([p.numel() for p in trained]), strict=True):
        p.grad = mean.view_as(p)


@torch.no_grad()
def _aside(frames: Frames, perception: Perception) -> dict[str, float]:
    """Figures on frames that are kept aside; none if there are none."""
    if not len(frames.aside):
        return {}
    perception.eval()
    rows = frames.aside[torch.randperm(len(frames.aside), device=frames.device)[:2048]]
    loss, figures = frames.loss(perception, rows)
    perception.train()
    return {"loss": float(loss.mean()), **{name: float(value) for name, value in figures.items()}}


if __name__ == "__main__":
    main()
