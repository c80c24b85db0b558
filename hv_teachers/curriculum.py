"""Which tasks a stage practises on (Algorithm 1 of the paper), and which of them a batch of environments holds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import torch

from hv_sim.navigation import RETREAT_M, plan_subtask
from hv_sim.scene import compile_scene
from hv_sim.task import RobotStart, Task, TaskError, check_task, resolve_tasks

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


def single_object_tasks(task: Task) -> list[Task]:
    """A task for each sub-task; all but the first begin as the one before ends: objects placed, the robot stepped back.

    Where the robot would not have room there, it begins where the whole task begins.
    """
    if len(task.subtasks) == 1:
        return [task]
    scene = compile_scene(task)
    singles = []
    objects = list(task.objects)
    robot = task.robot
    for i, subtask in enumerate(task.subtasks):
        single = replace(
            task, name=f"{task.name}.{i + 1}", objects=tuple(objects), subtasks=(subtask,), robot=task.robot
        )
        begun_behind = replace(single, robot=robot)
        singles.append(begun_behind if _is_valid(begun_behind) else single)
        here = np.array([o.position_m for o in objects], dtype=float)
        route = plan_subtask(scene, i, robot.position_m, here)
        x, y, yaw = (float(v) for v in route.place_stand_xy_yaw)
        behind = (x - RETREAT_M * np.cos(yaw), y - RETREAT_M * np.sin(yaw))
        robot = RobotStart((round(float(behind[0]), 3), round(float(behind[1]), 3)), round(yaw, 3))
        objects = [
            replace(o, position_m=subtask.goal_position_m, yaw_rad=subtask.goal_yaw_rad)
            if o.name == subtask.object
            else o
            for o in objects
        ]
    return singles


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


def _is_valid(task: Task) -> bool:
    try:
        check_task(task)
    except TaskError:
        return False
    return True
