"""Trains how a student sees which way the faces of things run (`hv_policy.belief.faces_head`), and nothing else of it.

The head looks at the surroundings of one place, each time turned otherwise, and so learns from far fewer frames than
all the rest: a quarter of an hour on a core. In `lerobot-train` and `train_perception.py` it goes on learning with it.

    python training/student/train_faces.py --init CHECKPOINT --frames DIR --output DIR --seconds 900
"""

from __future__ import annotations

import argparse
import shutil
import time
from pathlib import Path

import numpy as np
import torch
from torch import Tensor
from tqdm import tqdm
from train_perception import coded_pictures, decoded, load_perception, save, warmed_cosine

from hv_policy.belief import mirror
from hv_policy.belief.attitude import attitude_of, lies
from hv_policy.belief.camera import project
from hv_policy.belief.faces_head import FARTHEST_M, FacesHead, faces_loss
from hv_policy.belief.places import OBJECT
from hv_policy.half_precision import in_half
from hv_policy.motor.proprioception import read_proprioception

WARMUP_STEPS, LEAST_SHARE = 100, 0.02
NEAR_M, FAR_SHARE, HEIGHT_M = 0.03, 0.03, 0.04
"""By how much a place is believed wrongly: so far, so much more for each metre of distance, and so much too high."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--init", type=Path, required=True, help="checkpoint whose head is trained anew")
    parser.add_argument("--frames", type=Path, required=True, help="folder of files of pack_frames.py")
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--seconds", type=float, default=900.0)
    parser.add_argument("--batch", type=int, default=128)
    parser.add_argument("--lr", type=float, default=2e-3)
    parser.add_argument("--lying-share", type=float, default=0.5, help="how often frames of things that lie are drawn")
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    perception = load_perception(args.init)
    torch.manual_seed(args.seed)
    coded, state, at, rotation = read_frames(sorted(args.frames.glob("*.npz")))
    lying = lies(attitude_of(rotation))
    share = torch.where(lying, args.lying_share / lying.sum(), (1 - args.lying_share) / (~lying).sum())
    head = perception.faces = FacesHead()
    optimizer = torch.optim.AdamW(head.parameters(), lr=args.lr, weight_decay=1e-2)
    args.output.mkdir(parents=True, exist_ok=True)
    start, step, recent = time.monotonic(), 0, 0.0
    with tqdm(total=round(args.seconds), unit="s") as bar, (args.output / "curve_faces.csv").open("w") as curve:
        curve.write("samples,faces_loss\n")
        while (done := (time.monotonic() - start) / args.seconds) < 1:
            for group in optimizer.param_groups:
                group["lr"] = args.lr * warmed_cosine(step, WARMUP_STEPS, done, LEAST_SHARE)
            rows = torch.multinomial(share, args.batch, replacement=True)
            pictures = torch.from_numpy(decoded([coded[i] for i in rows.tolist()])).permute(0, 3, 1, 2).float() / 255
            pictures = mirror.recoloured(pictures)
            body = read_proprioception(state[rows])
            with in_half("cpu"):
                loss = faces_loss(head, pictures, body, _misplaced(at[rows]), at[rows], rotation[rows]).mean()
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            step, recent = step + 1, recent + loss.item()
            if step % 200 == 0:
                curve.write(f"{step * args.batch},{recent / 200:.5g}\n")
                curve.flush()
                bar.set_postfix(samples=step * args.batch, loss=recent / 200)
                recent = 0.0
            bar.update(round(done * args.seconds) - bar.n)
    save(perception, args.init, args.output)
    shutil.copy(args.init / "config.json", args.output)


def read_frames(files: list[Path]) -> tuple[list[bytes], Tensor, Tensor, Tensor]:
    """Of N frames in which the object is in view and near enough: pictures as they are packed, proprioception (N, 223),
    where the object is (N, 3), heading frame, m, and how it is turned (N, 6)."""
    coded: list[bytes] = []
    found: list[tuple[Tensor, Tensor, Tensor]] = []
    for file in tqdm(files, unit="file"):
        with np.load(file) as held:
            state, places = (torch.from_numpy(held[name]).float() for name in ("state", "places"))
            at, rotation = places[:, OBJECT], torch.from_numpy(held["rotation"]).float()
            pictures = coded_pictures(held)
        _, visible = project(read_proprioception(state), at[:, None])
        rows = (visible[:, 0] & (at[:, :2].norm(dim=1) < FARTHEST_M) & places.any(1)).nonzero()[:, 0]
        coded += [pictures[i] for i in rows.tolist()]
        found.append((state[rows], at[rows], rotation[rows]))
    state, at, rotation = (torch.cat(parts) for parts in zip(*found, strict=True))
    return coded, state, at, rotation


def _misplaced(at_h: Tensor) -> Tensor:
    """(B, 3) places as a student believes them."""
    far = NEAR_M + FAR_SHARE * at_h[:, :2].norm(dim=1, keepdim=True)
    wrong = torch.cat([far, far, torch.full_like(far, HEIGHT_M)], 1)
    return at_h + wrong * torch.randn_like(at_h)


if __name__ == "__main__":
    main()
