from pathlib import Path

import numpy as np
import PIL.Image
from datasets import Dataset, Features, Image, Value
from lerobot.datasets.io_utils import embed_images

from hv_teachers.picture_embedding import embed_whole


def test_the_table_is_the_one_that_lerobot_makes(tmp_path: Path):
    rng = np.random.default_rng(0)
    paths = []
    for i in range(7):
        paths.append(str(tmp_path / f"{i}.png"))
        PIL.Image.fromarray(rng.integers(0, 256, (8, 8, 3), dtype=np.uint8)).save(paths[-1])
    features = Features({"picture": Image(), "number": Value("float32")})
    dataset = Dataset.from_dict({"picture": paths, "number": rng.random(7).tolist()}, features=features)
    ours, theirs = embed_whole(dataset), embed_images(dataset)
    assert ours.format == theirs.format
    assert ours.features == theirs.features
    ours, theirs = ours.with_format("arrow")[:], theirs.with_format("arrow")[:]
    assert ours.combine_chunks().equals(theirs.combine_chunks())
    assert all(row["bytes"] for row in ours["picture"].to_pylist())
