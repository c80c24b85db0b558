"""Frames of recorded shards in one small file, for `train_on_gpu.py`: pictures as WebP, labels in half precision.

    python training/student/pack_frames.py OUT.npz STRIDE SHARD...        # shards of hv-record, every STRIDE-th frame
"""

from __future__ import annotations

import io
import json
import sys
import zlib
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
from PIL import Image

from hv_policy.belief.floor_patch import read_patches

THINGS, SPOTS = 20, 4
QUALITY = 80


def main() -> None:
    out, stride, shards = Path(sys.argv[1]), int(sys.argv[2]), [Path(s) for s in sys.argv[3:]]
    rows: dict[str, list[np.ndarray]] = {}
    pictures: list[bytes] = []
    texts: dict[str, int] = {}
    names: dict[str, int] = {"": 0}
    for shard in shards:
        tasks = pq.read_table(shard / "meta" / "tasks.parquet").to_pandas()
        text_of = dict(zip(tasks["task_index"], tasks["task"] if "task" in tasks.columns else tasks.index, strict=True))
        for file in sorted((shard / "data").rglob("*.parquet")):
            table = pq.read_table(file)
            column = {name: table[name].to_pylist()[::stride] for name in table.column_names}
            keep = [i for i, places in enumerate(column["privileged.places"]) if any(places)]
            column = {name: [values[i] for i in keep] for name, values in column.items()}
            pictures += [_webp(picture["bytes"]) for picture in column["observation.images.head"]]
            landmarks = [_padded(json.loads(text), names) for text in column["privileged.landmarks"]]
            taken, known = read_patches(column["privileged.floor"])
            found = {
                "state": _half(column["observation.state"]),
                "places": _half(column["privileged.places"]),
                "rotation": _half(column["privileged.object"])[:, 3:9],
                "half_extents": _half(column["privileged.half_extents"]),
                "floor": np.packbits(taken.numpy(), axis=1),
                "floor_known": known.numpy(),
                "task": np.array([texts.setdefault(text_of[i], len(texts)) for i in column["task_index"]], np.int32),
                "episode": np.array([zlib.crc32(f"{shard}/{i}".encode()) for i in column["episode_index"]], np.int64),
            }
            for k, name in enumerate(("boxes", "box_name", "spots", "spot_name")):
                found[name] = np.stack([row[k] for row in landmarks])
            for name, values in found.items():
                rows.setdefault(name, []).append(values)
    held = {name: np.concatenate(values) for name, values in rows.items()}
    held["sizes"] = np.array([len(picture) for picture in pictures], np.int32)
    held["pictures"] = np.frombuffer(b"".join(pictures), np.uint8)
    held["texts"], held["names"] = np.array(list(texts)), np.array(list(names))
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **held)
    draft = out.with_suffix(".tmp")
    draft.write_bytes(buffer.getvalue())
    draft.replace(out)
    print(out, len(pictures), "frames", round(out.stat().st_size / 2**20, 1), "MiB")


def _half(values: list[list[float]]) -> np.ndarray:
    return np.array(values, dtype=np.float16)


def _webp(png: bytes) -> bytes:
    out = io.BytesIO()
    Image.open(io.BytesIO(png)).convert("RGB").save(out, "WEBP", quality=QUALITY, method=2)
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
