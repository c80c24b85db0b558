"""Trains the closer look of a student (`hv_policy.belief.closer_look`), and nothing else of it.

It sees one thing at a time, whatever that is called, always in the same scale, and so learns from few frames.

    python training/student/train_closer.py --init CHECKPOINT --frames DIR --output DIR --seconds 1500
"""

from __future__ import annotations

import argparse
import shutil
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import torch
from torch import Tensor
from tqdm import tqdm
from train_perception import coded_pictures, decoded, load_perception, save, warmed_cosine

from hv_policy.belief import mirror
from hv_policy.belief.boxes import can_be_carried, first_box_hit
from hv_policy.belief.camera import pixel_rays
from hv_policy.belief.closer_look import FARTHEST_M, CloserLook
from hv_policy.belief.closer_look_loss import Things, closer_look_loss
from hv_policy.belief.places import OBJECT
from hv_policy.half_precision import in_half
from hv_policy.motor.proprioception import read_proprioception

WARMUP_STEPS, LEAST_SHARE = 200, 0.01
HELD_OUT_EVERY, TESTED = 25, 2048
"""Of files one in so many is kept aside, and so many of their frames are looked at now and then."""
GRID, LEAST_RAYS, FELL_WITHIN_M = 32, 2, 1.8
"""Rays along a side of a picture that tell what is in view: what so many meet. Frames of what fell count as such when
it is so near."""
LOOKS_A_PICTURE = 2


@dataclass
class Frames:
    """Frames in which something that can be carried is in view and near."""

    coded: list[bytes]
    state: Tensor  # (N, 223)
    things: Things
    fell: Tensor  # (N,) bool: the task's object lies, in view

    def of(
        self, rows: Tensor, looks: int = 1, altered: Callable[[Tensor], Tensor] | None = None
    ) -> tuple[Tensor, Tensor, Things]:
        """Pictures, `altered` or as they are, each so many times; their proprioception, and what there is in them."""
        pictures = torch.from_numpy(decoded([self.coded[i] for i in rows.tolist()])).permute(0, 3, 1, 2).float() / 255
        pictures = (altered(pictures) if altered else pictures).repeat_interleave(looks, 0)
        rows = rows.repeat_interleave(looks)
        return pictures, self.state[rows], self.things.rows(rows)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--init", type=Path, required=True, help="checkpoint whose head is trained")
    parser.add_argument("--anew", action="store_true", help="from scratch")
    parser.add_argument("--frames", type=Path, required=True, help="folder of files of pack_frames.py")
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--seconds", type=float, default=1500.0)
    parser.add_argument("--batch", type=int, default=96, help="pictures")
    parser.add_argument("--lr", type=float, default=1.5e-3)
    parser.add_argument("--fell-share", type=float, default=0.45, help="how often frames of what fell are drawn")
    parser.add_argument("--own", default="st_", help="what the names of files of the student acting begin with")
    parser.add_argument("--own-share", type=float, default=0.3, help="how often frames of those are drawn")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    torch.set_num_threads(args.threads)
    perception = load_perception(args.init)
    torch.manual_seed(args.seed)
    files = sorted(args.frames.glob("*.npz"))
    aside = [f for i, f in enumerate(files) if i % HELD_OUT_EVERY == HELD_OUT_EVERY // 2]
    kept = [f for f in files if f not in aside]
    frames, counts = read_frames(kept)
    test = read_frames(aside)[0] if aside else None
    is_own = torch.tensor([f.name.startswith(args.own) for f in kept]).repeat_interleave(torch.tensor(counts))
    share = drawn_share(frames.fell, is_own, args.fell_share, args.own_share)
    head = perception.closer = CloserLook() if args.anew else perception.closer
    optimizer = torch.optim.AdamW(head.parameters(), lr=args.lr, weight_decay=1e-2)
    args.output.mkdir(parents=True, exist_ok=True)
    start, step, recent, saved = time.monotonic(), 0, 0.0, time.monotonic()
    with tqdm(total=round(args.seconds), unit="s") as bar, (args.output / "curve_closer.csv").open("w") as curve:
        while (done := (time.monotonic() - start) / args.seconds) < 1:
            for group in optimizer.param_groups:
                group["lr"] = args.lr * warmed_cosine(step, WARMUP_STEPS, done, LEAST_SHARE)
            rows = torch.multinomial(share, args.batch, replacement=True)
            pictures, state, things = frames.of(rows, LOOKS_A_PICTURE, mirror.recoloured)
            with in_half("cpu"):
                loss, _ = closer_look_loss(head, pictures, read_proprioception(state), things)
            optimizer.zero_grad()
            loss.mean().backward()
            optimizer.step()
            step, recent = step + 1, recent + loss.detach().mean().item()
            if step % 300 == 0:
                figures = {"samples": step * args.batch * LOOKS_A_PICTURE, "loss": recent / 300}
                figures |= tested(head, test) if test else {}
                if step == 300:
                    curve.write(",".join(figures) + "\n")
                curve.write(",".join(f"{value:.4g}" for value in figures.values()) + "\n")
                curve.flush()
                bar.set_postfix(figures)
                recent = 0.0
            if time.monotonic() - saved > 240:
                save(perception, args.init, args.output)
                saved = time.monotonic()
            bar.update(round(done * args.seconds) - bar.n)
    save(perception, args.init, args.output)
    shutil.copy(args.init / "config.json", args.output)


def drawn_share(fell: Tensor, is_own: Tensor, fell_share: float, own_share: float) -> Tensor:
    """(N,) how often each frame is drawn."""
    share = torch.zeros(len(fell))
    for own, of_all in ((True, own_share), (False, 1 - own_share)):
        for lies, of_these in ((True, fell_share), (False, 1 - fell_share)):
            rows = (is_own == own) & (fell == lies)
            share[rows] = of_all * of_these / max(1, int(rows.sum()))
    return share


@torch.no_grad()
def tested(head: CloserLook, frames: Frames) -> dict[str, float]:
    """Loss and figures on frames that were kept aside, of what fell and of the rest, the same places each time."""
    head.eval()
    out: dict[str, float] = {}
    with torch.random.fork_rng():
        torch.manual_seed(0)
        for name, of_these in (("fell", frames.fell), ("rest", ~frames.fell)):
            rows = of_these.nonzero()[:, 0]
            if not len(rows):
                continue
            pictures, state, things = frames.of(rows[torch.randperm(len(rows))[: TESTED // 2]])
            loss, figures = closer_look_loss(head, pictures, read_proprioception(state), things)
            figures = {"loss": loss.mean()} | figures
            out |= {f"{name}_{key.removeprefix('closer_')}": float(value) for key, value in figures.items()}
    head.train()
    return out


def read_frames(files: list[Path]) -> tuple[Frames, list[int]]:
    """Those of files of `pack_frames.py`, and how many of each."""
    parts: list[Frames] = []
    rays = pixel_rays(GRID)
    for file in tqdm(files, unit="file"):
        with np.load(file) as held:
            names = ("state", "places", "rotation", "half_extents", "boxes")
            state, places, rotation, half, boxes = (torch.from_numpy(held[name]).float() for name in names)
            exists, pictures = torch.from_numpy(held["box_name"]) >= 0, coded_pictures(held)
        things = Things.of(boxes, exists, places[:, OBJECT], rotation, half)
        label = first_box_hit(read_proprioception(state), rays, things.boxes, exists)
        in_view = torch.nn.functional.one_hot(label + 1, exists.shape[1] + 1)[..., 1:].sum(1) >= LEAST_RAYS
        near = can_be_carried(boxes) & in_view & exists & (boxes[..., :2].norm(dim=-1) < FARTHEST_M)
        rows = near.any(1).nonzero()[:, 0]
        things = replace(things, near=near).rows(rows)
        fell = (things.fell >= 0) & things.near[torch.arange(len(rows)), things.fell]
        fell &= places[rows, OBJECT][:, :2].norm(dim=1) < FELL_WITHIN_M
        parts.append(Frames([pictures[i] for i in rows.tolist()], state[rows], things, fell))
    joined = Things(*(torch.cat([getattr(p.things, name) for p in parts]) for name in Things.__dataclass_fields__))
    coded = [one for p in parts for one in p.coded]
    frames = Frames(coded, torch.cat([p.state for p in parts]), joined, torch.cat([p.fell for p in parts]))
    return frames, [len(p.state) for p in parts]


if __name__ == "__main__":
    main()
