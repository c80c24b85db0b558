"""Which tasks a stage practises on (Algorithm 1 of the paper), and which of them a batch of environments holds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import torch

from hv_sim.single_object import single_object_tasks
from hv_sim.task import Task, resolve_tasks

PARTS = ("whole", "single", "first")


def practice_tasks(names: str, part: str = "whole") -> list[Task]:
    """The tasks that a comma-separated list of suites, tasks or files stands for, cut as a stage wants them.

    Args:
        names: what `hv_sim.task.resolve_tasks` understands, separated by commas.
        part: `whole`: as they are; `single`: every sub-task a task of its own (Algorithm 1); `first`: the first
            sub-tasks only, from the start that the task gives.

    Raises:
        ValueError: `part` is unknown.
        hv_sim.task.TaskError: a name stands for nothing.
    """
    if part not in PARTS:
        raise ValueError(f"part: {part!r} is not valid; valid: {', '.join(PARTS)}")
    tasks = [task for name in names.split(",") for task in resolve_tasks(name.strip())]
    if part == "whole":
        return tasks
    if part == "first":
        return [replace(task, subtasks=task.subtasks[:1]) for task in tasks]
    return [single for task in tasks for single in single_object_tasks(task)]


def share_of_tasks(tasks: Sequence[Task], num_envs: int, seed: int, turn: int) -> list[Task]:
    """The tasks of `num_envs` environments: every task equally often; if there are more, a new share each turn.

    Args:
        tasks: to choose from.
        num_envs: how many are wanted.
        seed: of the order.
        turn: 0, 1, ...; after `len(tasks) / num_envs` turns every task has been practised.
    """
    at = turn * num_envs
    chosen: list[Task] = []
    while len(chosen) < num_envs:
        lap, place = divmod(at, len(tasks))
        order = torch.randperm(len(tasks), generator=torch.Generator().manual_seed(seed + 7919 * lap))
        taken = order[place : place + num_envs - len(chosen)].tolist()
        chosen += [tasks[i] for i in taken]
        at += len(taken)
    return chosen
