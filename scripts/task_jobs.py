"""Draws and verifies many tasks at once, in processes; results come in order, whatever their number.

Progress is shown on a terminal only.
"""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

from tqdm import tqdm

from hv_sim.suites import SUITE_SIZES
from hv_sim.task import Task, TaskError, check_task
from hv_sim.task_generator import draw_task, single_tasks
from hv_teachers.task_verification import Verdict, verify_task


def verify_all(tasks: list[Task], ambiguity: bool, workers: int = 0, title: str = "verify") -> list[Verdict]:
    """A verdict on each task."""
    return _in_processes(partial(verify_task, ambiguity=ambiguity), tasks, workers, title)


def generate_suite(name: str, workers: int = 0, seen: list[Task] | None = None) -> list[Task]:
    """A suite as it is in the package; `seen`, if it was drawn already, spares drawing it again for `single`."""
    if name == "single":
        whole = generate_suite("seen", workers) if seen is None else seen
        return list(tqdm(single_tasks(whole), desc=name, unit="task", total=SUITE_SIZES[name], disable=None))
    return _in_processes(partial(_draw, name), range(SUITE_SIZES[name]), workers, name)


def generate_practice(count: int, verified: bool, workers: int = 0) -> list[Task]:
    """`count` tasks to learn in, in rooms that no suite has; verified, or good enough to look at."""
    return _in_processes(partial(_draw if verified else draw_task, "practice"), range(count), workers, "practice")


def is_solvable(task: Task) -> bool:
    """Whether a candidate passes every check; one for `seen` also in its parts, which become the suite `single`."""
    if not verify_task(task).solvable:
        return False
    if not task.name.startswith("seen"):
        return True
    for single in single_tasks([task]):
        try:
            check_task(single)
        except TaskError:
            return False
        if not verify_task(single).solvable:
            return False
    return True


def _draw(suite: str, index: int) -> Task:
    return draw_task(suite, index, is_solvable)


def _one_thread() -> None:
    import torch

    torch.set_num_threads(1)


def _in_processes(job: Callable[[Any], Any], items: Iterable[Any], workers: int, title: str) -> list[Any]:
    work = list(items)
    number = min(workers or os.cpu_count() or 1, len(work))
    if number <= 1:
        return [job(item) for item in tqdm(work, desc=title, unit="task", disable=None)]
    with multiprocessing.get_context("spawn").Pool(number, initializer=_one_thread) as pool:
        return list(tqdm(pool.imap(job, work, chunksize=2), desc=title, unit="task", total=len(work), disable=None))
