"""LeRobot puts an episode's pictures into its table row by row, 4 ms each; here all rows at once: the same table."""

from collections.abc import Iterator
from contextlib import contextmanager

from datasets import Dataset
from datasets.table import embed_table_storage
from lerobot.datasets import dataset_writer, io_utils


def embed_whole(dataset: Dataset) -> Dataset:
    """As `lerobot.datasets.io_utils.embed_images`: files of pictures are read into the table."""
    embedded = dataset.with_format("arrow").map(embed_table_storage, batched=True, batch_size=None)
    return embedded.with_format(**dataset.format)


@contextmanager
def pictures_embedded_whole() -> Iterator[None]:
    """Within, LeRobot's writer of datasets, and its tool that joins them, embed with `embed_whole`."""
    theirs = io_utils.embed_images
    dataset_writer.embed_images = io_utils.embed_images = embed_whole
    try:
        yield
    finally:
        dataset_writer.embed_images = io_utils.embed_images = theirs
