"""Tasks with many sub-tasks, taken apart into tasks with one (Algorithm 1 of the paper)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hv_sim.navigation import RETREAT_M, plan_subtask
from hv_sim.scene import compile_scene
from hv_sim.task import RobotStart, Task, TaskError, check_task


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


def _is_valid(task: Task) -> bool:
    try:
        check_task(task)
    except TaskError:
        return False
    return True
