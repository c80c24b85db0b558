"""Glances rendered for `train_perception.py` while it trains: frames without end instead of a recording's.

What each process draws follows from the seed and its number. Needs numpy, torch, pillow, scipy, mujoco, gymnasium and
trimesh, and nothing of LeRobot; on a GPU's machine `MUJOCO_GL=egl` renders there.

    python training/student/render_frames.py --tasks FILE... --output DIR --seconds 500 --looks configs/looks.yaml
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import time
from pathlib import Path

import numpy as np
import torch
from pack_frames import Packer
from PIL import Image

from hv_sim.looks import NO_LOOKS, read_look_ranges
from hv_sim.suites import read_tasks, select_tasks
from hv_sim.task import Task
from hv_teachers.dataset_format import HEAD_IMAGE
from hv_teachers.frames import glance_frames
from hv_teachers.glances import BEGINNING_SHARE, LYING_SHARE


def render(worker: int, tasks: list[Task], args: argparse.Namespace, end: float) -> None:
    """Process `worker`: file after file until the time is over."""
    torch.set_num_threads(1)
    looks = read_look_ranges(args.looks) if args.looks else NO_LOOKS
    rng = np.random.default_rng([args.seed, worker])
    number = 0
    while time.time() < end and number != args.files:
        drawn = [tasks[i] for i in rng.choice(len(tasks), args.rooms, replace=False)]
        seeds = rng.integers(2**31, size=args.rooms).tolist()
        packer, name = Packer(), f"{args.name}{worker:02d}_{number:04d}"
        for _, rows in glance_frames(drawn, seeds, args.glances, args.image_size, looks, args.beginnings, args.lying):
            known = [i for i, row in enumerate(rows) if row["privileged.places"].any()]
            rows = [rows[i] for i in known]
            if not rows:
                continue
            columns = {key: [row[key] for row in rows] for key in rows[0]}
            pictures = [Image.fromarray(picture) for picture in columns[HEAD_IMAGE]]
            packer.add(columns, pictures, columns["task"], [f"{name}/{i}" for i in known])
        packer.save(args.output / f"{name}.npz")
        number += 1


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tasks", nargs="+", required=True, help="suites or files of tasks; a name twice counts twice")
    parser.add_argument("--output", type=Path, required=True, help="folder of --frames of train_perception.py")
    parser.add_argument("--name", default="fresh", help="what the files' names begin with")
    parser.add_argument("--looks", metavar="FILE", help="randomised lights, colours, textures, camera")
    parser.add_argument("--seconds", type=float, default=400.0)
    parser.add_argument("--files", type=int, default=-1, help="at most so many of each process")
    parser.add_argument("--rooms", type=int, default=6, help="in a file")
    parser.add_argument("--glances", type=int, default=36, help="of each room")
    parser.add_argument(
        "--beginnings", type=float, default=BEGINNING_SHARE, help="share of them from where a sub-task is told"
    )
    parser.add_argument("--lying", type=float, default=LYING_SHARE, help="share of the rest in which the object fell")
    parser.add_argument("--image-size", type=int, default=128)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    args.output.mkdir(parents=True, exist_ok=True)
    tasks: list[Task] = []
    for name in args.tasks:
        tasks += select_tasks(name) or read_tasks(name, check=False)
    end, context = time.time() + args.seconds, multiprocessing.get_context("fork")
    processes = [context.Process(target=render, args=(k, tasks, args, end)) for k in range(args.workers)]
    for process in processes:
        process.start()
    for process in processes:
        process.join()


if __name__ == "__main__":
    main()
