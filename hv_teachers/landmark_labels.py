"""Names of things and spots of a room and where they are as seen from the robot: labels of a recorded frame."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import torch

from hv_policy.belief.camera import project
from hv_policy.motor.proprioception import BodyState
from hv_sim.landmarks import landmarks
from hv_sim.task import Task
from hv_sim.world import RearrangeWorld

NO_LANDMARKS = "[]"
_SPOTS_IN_VIEW, _SPOTS = 3, 4


def landmark_labels(
    task: Task,
    subtask: int,
    objects_w: Mapping[str, tuple[Sequence[float], float]],
    pose: tuple[float, float, float],
    body: BodyState,
    seed: tuple[int, int],
) -> str:
    """The things of a room and some of its spots (`hv_sim.landmarks`) as JSON.

    A list of [phrase, x, y, z, half extents 3, yaw] for things, phrase "" where no words fit it alone, and of
    [phrase, x, y, z] for spots, most of those in the picture; m and rad, heading frame with its origin on the floor.

    Args:
        task, subtask: what is being done.
        objects_w: name -> (x, y, z) and yaw of every object in the world.
        pose: x, y, yaw of the robot in the world.
        body: (1, ...) of the robot, for the pose of its camera.
        seed: decides which spots are named, and how everything is.
    """
    known = landmarks(task, subtask)
    poses = [objects_w[k.object] if k.object else (k.position_m, k.yaw_rad) for k in known]
    at = np.array([position for position, _ in poses]).reshape(-1, 3)
    x, y, yaw = pose
    dx, dy = at[:, 0] - x, at[:, 1] - y
    c, s = np.cos(yaw), np.sin(yaw)
    places = np.stack([c * dx + s * dy, c * dy - s * dx, at[:, 2]], -1)
    visible = project(body, torch.from_numpy(places).float()[None])[1][0].numpy()
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(known))
    spots = order[np.array([k.is_spot for k in known], bool)[order]]
    chosen = spots[visible[spots]][:_SPOTS_IN_VIEW].tolist()
    chosen += spots[~visible[spots]][: _SPOTS - len(chosen)].tolist()
    named: list[list[Any]] = []
    for k in (*[i for i, landmark in enumerate(known) if not landmark.is_spot], *chosen):
        phrases = known[k].phrases
        phrase = phrases[int(rng.integers(len(phrases)))] if phrases else ""
        box = [] if known[k].is_spot else [*known[k].half_extents_m, (poses[k][1] - yaw + np.pi) % (2 * np.pi) - np.pi]
        named.append([phrase, *(round(float(value), 3) for value in (*places[k], *box))])
    return json.dumps(named, separators=(",", ":"))


def world_landmarks(world: RearrangeWorld, env: int, body: BodyState, number: int) -> str:
    """`landmark_labels` of environment `env` in its present state.

    Args:
        world: whose.
        env: its number.
        body: (N, ...) of all robots.
        number: of the frame, so that every frame names others.
    """
    task, state = world.tasks[env], world.state
    rotation, position = state.link_rot_w[env, 0], state.link_pos_w[env, 0]
    pose = (float(position[0]), float(position[1]), float(torch.atan2(rotation[1, 0], rotation[0, 0])))
    objects = {}
    for k, o in enumerate(task.objects):
        turned = state.object_rot_w[env, k]
        objects[o.name] = state.object_pos_w[env, k].tolist(), float(torch.atan2(turned[1, 0], turned[0, 0]))
    one = body.rows(slice(env, env + 1))
    subtask = min(int(world.subtask_index[env]), len(task.subtasks) - 1)
    seed = (int(world.episode_seed[env] or 0), number)
    return landmark_labels(task, subtask, objects, pose, one, seed)
