"""What the page draws as a map, and what it says beside it: the room once, what moves and is going on ten times a
second."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch

from hv_live.simulation import Simulation
from hv_live.understanding import described
from hv_sim.furniture import FURNITURE_KINDS
from hv_sim.objects import OBJECT_KINDS
from hv_sim.parts import COLORS
from hv_sim.places import layout_at
from hv_sim.task import Task

MOST_SHOWN = 30
"""Instructions of the past that are shown."""


def room_message(live: Simulation) -> dict[str, Any]:
    """The room as it stands: metres in the world frame, whose origin is the middle of the floor; yaw in rad."""
    task, scene = live.task, live.world.whole_scene
    furniture = []
    for piece in task.furniture:
        kind = FURNITURE_KINDS[piece.kind]
        depth, width, height = piece.size_m or kind.size_m
        furniture.append(
            {
                "label": kind.noun,
                "x": piece.position_m[0],
                "y": piece.position_m[1],
                "yaw": piece.yaw_rad,
                "depth": depth,
                "width": width,
                "height": height,
                "flat": not kind.solid,
            }
        )
    layout = layout_at(task, 0)
    objects = [
        {
            "label": described(layout, placed.name),
            "half": [float(h) for h in scene.half_extents_m[k, :2]],
            "color": _css(placed.color or OBJECT_KINDS[placed.kind].color),
        }
        for k, placed in enumerate(task.objects)
    ]
    return {
        "type": "room",
        "task": task.name,
        "title": room_title(task),
        "size": list(task.room.size_m),
        "furniture": furniture,
        "objects": objects,
        "suggestions": [live.task_instruction(i) for i in range(len(task.subtasks))],
    }


def state_message(live: Simulation) -> dict[str, Any]:
    """What is so now."""
    world = live.world
    x, y, yaw = world.robot_xy_yaw()
    state = world.state
    yaws = torch.atan2(state.object_rot_w[0, :, 1, 0], state.object_rot_w[0, :, 0, 0]).tolist()
    goal = None
    if world.goal_known:
        goal = {
            "object": int(world.object_index[0]),
            "x": round(float(world.goal_pos_w[0, -1, 0]), 3),
            "y": round(float(world.goal_pos_w[0, -1, 1]), 3),
        }
    return {
        "type": "state",
        "time_s": round(live.time_s, 2),
        "step": int(world.episode_step[0]),
        "policy": live.policy,
        "instruction": live.instruction,
        "told": live.last_told,
        "stage": live.stage,
        "progress": _rounded(live.progress),
        "distance_m": _rounded(live.distance_m),
        "fallen": live.fallen,
        "instructor": live.instructor,
        "recording": live.recorder.num_frames if live.recorder is not None else None,
        "robot": [round(x, 3), round(y, 3), round(yaw, 3)],
        "objects": [
            [round(px, 3), round(py, 3), round(yaws[k], 3)]
            for k, (px, py, _) in enumerate(state.object_pos_w[0].tolist())
        ],
        "goal": goal,
        "said": [
            {
                "text": said.text,
                "by": said.by,
                "status": said.status,
                "seconds": round(((said.ended_step or int(world.episode_step[0])) - said.begun_step) / 30.0, 1),
            }
            for said in live.said[-MOST_SHOWN:]
        ],
    }


def room_title(task: Task) -> str:
    """ "Kitchen, unseen_005"."""
    return f"{task.room.kind.replace('_', ' ').capitalize()}, {task.name}"


def _rounded(value: float | None) -> float | None:
    return None if value is None or not np.isfinite(value) else round(value, 3)


def _css(color: str) -> str:
    r, g, b = (round(255 * c) for c in COLORS[color])
    return f"rgb({r} {g} {b})"
