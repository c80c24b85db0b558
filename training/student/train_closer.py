"""Trains the closer look of a student (`hv_policy.belief.closer_look`), and nothing else of it.

It sees one thing at a time, whatever that is called, always in the same scale, and so learns from few frames: half an
hour on a core. In `lerobot-train` and `train_perception.py` it goes on learning with the rest.

    python training/student/train_closer.py --init CHECKPOINT --frames DIR --output DIR --seconds 1500
"""

from __future__ import annotations

import argparse
import shutil
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from torch import Tensor
from tqdm import tqdm
from train_perception import coded_pictures, decoded, load_perception, save, warmed_cosine

from hv_policy.belief import mirror
from hv_policy.belief.attitude import attitude_of, lies
from hv_policy.belief.boxes import can_be_carried, first_box_hit
from hv_policy.belief.camera import pixel_rays
from hv_policy.belief.closer_look import FARTHEST_M, CloserLook
from hv_policy.belief.closer_look_loss import closer_look_loss
from hv_policy.half_precision import in_half
from hv_policy.motor.proprioception import read_proprioception

WARMUP_STEPS, LEAST_SHARE = 200, 0.01
HELD_OUT_EVERY, TESTED = 40, 2048
"""Of files one in so many is kept aside, and so many of their frames are looked at now and then."""
GRID, LEAST_RAYS = 32, 2
"""Rays along a side of a picture that tell what is in view: what so many meet."""
LOOKS_A_PICTURE = 3


@dataclass
class Frames:
    """Frames in which something that can be carried is in view and near."""

    coded: list[bytes]
    state: Tensor  # (N, 223)
    boxes: Tensor  # (N, T, 7) of things
    in_view: Tensor  # (N, T) bool
    lying: Tensor  # (N,) bool: the task's object lies

    def of(
        self, rows: Tensor, looks: int = 1, altered: Callable[[Tensor], Tensor] | None = None
    ) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """Pictures, `altered` or as they are, each so many times; and their proprioception, boxes, and which of these
        are in view."""
        pictures = torch.from_numpy(decoded([self.coded[i] for i in rows.tolist()])).permute(0, 3, 1, 2).float() / 255
        pictures = (altered(pictures) if altered else pictures).repeat_interleave(looks, 0)
        rows = rows.repeat_interleave(looks)
        return pictures, self.state[rows], self.boxes[rows], self.in_view[rows]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--init", type=Path, required=True, help="checkpoint whose head is trained")
    parser.add_argument("--anew", action="store_true", help="from scratch")
    parser.add_argument("--frames", type=Path, required=True, help="folder of files of pack_frames.py")
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--seconds", type=float, default=1500.0)
    parser.add_argument("--batch", type=int, default=96, help="pictures")
    parser.add_argument("--lr", type=float, default=2e-3)
    parser.add_argument("--lying-share", type=float, default=0.15, help="how often frames of things that lie are drawn")
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    perception = load_perception(args.init)
    torch.manual_seed(args.seed)
    files = sorted(args.frames.glob("*.npz"))
    train, test = (
        read_frames([f for i, f in enumerate(files) if (i % HELD_OUT_EVERY == HELD_OUT_EVERY // 2) == aside])
        for aside in (False, True)
    )
    share = torch.where(
        train.lying, args.lying_share / train.lying.sum().clamp(min=1), (1 - args.lying_share) / (~train.lying).sum()
    )
    head = perception.closer = CloserLook() if args.anew else perception.closer
    optimizer = torch.optim.AdamW(head.parameters(), lr=args.lr, weight_decay=1e-2)
    args.output.mkdir(parents=True, exist_ok=True)
    start, step, recent, saved = time.monotonic(), 0, 0.0, time.monotonic()
    with tqdm(total=round(args.seconds), unit="s") as bar, (args.output / "curve_closer.csv").open("w") as curve:
        while (done := (time.monotonic() - start) / args.seconds) < 1:
            for group in optimizer.param_groups:
                group["lr"] = args.lr * warmed_cosine(step, WARMUP_STEPS, done, LEAST_SHARE)
            rows = torch.multinomial(share, args.batch, replacement=True)
            pictures, state, *known = train.of(rows, LOOKS_A_PICTURE, mirror.recoloured)
            with in_half("cpu"):
                loss, _ = closer_look_loss(head, pictures, read_proprioception(state), *known)
            optimizer.zero_grad()
            loss.mean().backward()
            optimizer.step()
            step, recent = step + 1, recent + loss.mean().item()
            if step % 300 == 0:
                figures = {"samples": step * args.batch * LOOKS_A_PICTURE, "loss": recent / 300} | tested(head, test)
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


@torch.no_grad()
def tested(head: CloserLook, frames: Frames) -> dict[str, float]:
    """Loss and figures on frames that were kept aside, the same places each time."""
    if not frames.coded:
        return {}
    head.eval()
    with torch.random.fork_rng():
        torch.manual_seed(0)
        pictures, state, *known = frames.of(torch.arange(min(TESTED, len(frames.coded))))
        loss, figures = closer_look_loss(head, pictures, read_proprioception(state), *known)
    head.train()
    return {"test_loss": float(loss.mean())} | {name: float(value) for name, value in figures.items()}


def read_frames(files: list[Path]) -> Frames:
    """Those of files of `pack_frames.py`."""
    coded: list[bytes] = []
    parts: list[tuple[Tensor, ...]] = []
    rays = pixel_rays(GRID)
    for file in tqdm(files, unit="file"):
        with np.load(file) as held:
            names = ("state", "places", "rotation", "boxes")
            state, places, rotation, boxes = (torch.from_numpy(held[name]).float() for name in names)
            exists, pictures = torch.from_numpy(held["box_name"]) >= 0, coded_pictures(held)
        label = first_box_hit(read_proprioception(state), rays, boxes, exists)
        in_view = torch.nn.functional.one_hot(label + 1, exists.shape[1] + 1)[..., 1:].sum(1) >= LEAST_RAYS
        is_near = can_be_carried(boxes) & in_view & (boxes[..., :2].norm(dim=-1) < FARTHEST_M)
        rows = is_near.any(1).nonzero()[:, 0]
        coded += [pictures[i] for i in rows.tolist()]
        lying = lies(attitude_of(rotation)) & places.any(1)
        parts.append(tuple(value[rows] for value in (state, boxes, in_view, lying)))
    return Frames(coded, *(torch.cat(values) for values in zip(*parts, strict=True)))


if __name__ == "__main__":
    main()
