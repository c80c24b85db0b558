"""Frames of recorded shards in one small file, for `train_perception.py`: pictures as WebP, labels in half precision.

    python training/student/pack_frames.py OUT.npz STRIDE SHARD...        # shards of hv-record, every STRIDE-th frame
    python training/student/pack_frames.py OUT.npz STRIDE SHARD... --only fallen      # or others: to be weighted apart
"""

from __future__ import annotations

import argparse
import io
import json
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from PIL import Image

from hv_policy.belief.attitude import attitude_of, lies
from hv_policy.belief.floor_patch import read_patches
from hv_policy.decision.view import Phase

THINGS, SPOTS = 20, 4
QUALITY = 80


class Packer:
    """Takes frames, and makes of them what `train_perception.py` reads."""

    def __init__(self) -> None:
        self._rows: dict[str, list[np.ndarray]] = {}
        self._pictures: list[bytes] = []
        self._texts: dict[str, int] = {}
        self._names: dict[str, int] = {"": 0}

    def add(
        self,
        columns: Mapping[str, Sequence[Any]],
        pictures: Sequence[Image.Image],
        texts: Sequence[str],
        episodes: Sequence[str],
    ) -> None:
        """Frames, by the names of their columns, with the instruction and the episode of each."""
        self._pictures += [_webp(picture) for picture in pictures]
        landmarks = [_padded(json.loads(text), self._names) for text in columns["privileged.landmarks"]]
        taken, known = read_patches(list(columns["privileged.floor"]))
        found = {
            "state": _half(columns["observation.state"]),
            "places": _half(columns["privileged.places"]),
            "rotation": _half(columns["privileged.object"])[:, 3:9],
            "half_extents": _half(columns["privileged.half_extents"]),
            "floor": np.packbits(taken.numpy(), axis=1),
            "floor_known": known.numpy(),
            "task": np.array([self._texts.setdefault(text, len(self._texts)) for text in texts], np.int32),
            "episode": np.array([zlib.crc32(episode.encode()) for episode in episodes], np.int64),
        }
        for k, name in enumerate(("boxes", "box_name", "spots", "spot_name")):
            found[name] = np.stack([row[k] for row in landmarks])
        for name, values in found.items():
            self._rows.setdefault(name, []).append(values)

    def __len__(self) -> int:
        return len(self._pictures)

    def save(self, out: Path) -> None:
        """Writes the file, all of it or nothing."""
        held = {name: np.concatenate(values) for name, values in self._rows.items()}
        held["sizes"] = np.array([len(picture) for picture in self._pictures], np.int32)
        held["pictures"] = np.frombuffer(b"".join(self._pictures), np.uint8)
        held["texts"], held["names"] = np.array(list(self._texts)), np.array(list(self._names))
        buffer = io.BytesIO()
        np.savez_compressed(buffer, **held)
        draft = out.with_suffix(".tmp")
        draft.write_bytes(buffer.getvalue())
        draft.replace(out)


def main() -> None:
    import pyarrow.parquet as pq

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path, help="the file")
    parser.add_argument("stride", type=int, help="frames from one that is taken to the next")
    parser.add_argument("shards", type=Path, nargs="+", help="of hv-record")
    parser.add_argument("--only", choices=("fallen", "others"), help="frames whose object has fallen over, or not")
    args = parser.parse_args()
    packer = Packer()
    for shard in args.shards:
        tasks = pq.read_table(shard / "meta" / "tasks.parquet").to_pandas()
        text_of = dict(zip(tasks["task_index"], tasks["task"] if "task" in tasks.columns else tasks.index, strict=True))
        for file in sorted((shard / "data").rglob("*.parquet")):
            table = pq.read_table(file)
            column = {name: table[name].to_pylist()[:: args.stride] for name in table.column_names}
            keep = [i for i, places in enumerate(column["privileged.places"]) if any(places)]
            if args.only:
                fallen = _fallen(column["privileged.object"], column["privileged.phase"])
                keep = [i for i in keep if fallen[i] == (args.only == "fallen")]
            column = {name: [values[i] for i in keep] for name, values in column.items()}
            pictures = [Image.open(io.BytesIO(p["bytes"])).convert("RGB") for p in column["observation.images.head"]]
            episodes = [f"{shard}/{i}" for i in column["episode_index"]]
            packer.add(column, pictures, [text_of[i] for i in column["task_index"]], episodes)
    packer.save(args.out)
    print(args.out, len(packer), "frames", round(args.out.stat().st_size / 2**20, 1), "MiB")


def _fallen(objects: Sequence[Sequence[float]], phases: Sequence[float]) -> list[bool]:
    """Of each frame, whether its object lies on its side, and nobody holds it."""
    lying = lies(attitude_of(torch.tensor(objects)[:, 3:9]))
    return (lying & (torch.tensor(phases).flatten() <= Phase.REACH)).tolist()


def _half(values: Sequence[Sequence[float]]) -> np.ndarray:
    return np.array(values, dtype=np.float16)


def _webp(picture: Image.Image) -> bytes:
    out = io.BytesIO()
    picture.save(out, "WEBP", quality=QUALITY, method=2)
    return out.getvalue()


def _padded(row: list[list], names: dict[str, int]) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Boxes (THINGS, 7) and spots (SPOTS, 3) and the numbers of their names, -1 for none."""
    found = []
    for count, size in ((THINGS, 7), (SPOTS, 3)):
        entries = [entry for entry in row if len(entry) == 1 + size][:count]
        values, numbers = np.zeros((count, size), np.float16), np.full(count, -1, np.int32)
        for i, entry in enumerate(entries):
            values[i], numbers[i] = entry[1:], names.setdefault(entry[0], len(names))
        found += [values, numbers]
    return found[0], found[1], found[2], found[3]


if __name__ == "__main__":
    main()
