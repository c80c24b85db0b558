"""Jobs for tests of engines: their processes are killed in the middle, as a machine's owner would do it."""

import os
import signal
from pathlib import Path

FACTOR = 0


def prepare(factor: int) -> None:
    global FACTOR
    FACTOR = factor


def multiply(job: tuple[int, str, int]) -> tuple[int, int]:
    """(number, number times the factor); dies `deaths` times first, and notes each in `folder`."""
    number, folder, deaths = job
    notes = Path(folder)
    if len(list(notes.glob(f"{number}_*"))) < deaths:
        (notes / f"{number}_{os.getpid()}").touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return number, number * FACTOR


def fail(job: int) -> None:
    raise ValueError(f"job {job}: nobody can do it")
