"""Which rooms the page offers: the hand-made ones and the benchmark's; only these can be asked for over the network."""

from __future__ import annotations

from typing import Any

from hv_sim.suites import load_suite
from hv_sim.task import Task, available_tasks, load_task

SUITES_ON_OFFER = ("unseen", "chain3", "chain5", "seen")


def rooms_on_offer(first: Task) -> dict[str, Task]:
    """Tasks by name: the one to begin with, the packaged ones, those of `SUITES_ON_OFFER`."""
    tasks = {first.name: first}
    for name in available_tasks():
        tasks.setdefault(name, load_task(name))
    for suite in SUITES_ON_OFFER:
        for task in load_suite(suite):
            tasks.setdefault(task.name, task)
    return tasks


def catalogue(tasks: dict[str, Task]) -> list[dict[str, Any]]:
    """What the page is told about them."""
    return [{"name": name, "room": task.room.kind} for name, task in tasks.items()]
