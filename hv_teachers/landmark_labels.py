"""Names of things and spots of a room and where they are as seen from the robot: labels of a recorded frame."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence

import numpy as np
import torch

from hv_policy.belief.camera import project
from hv_policy.motor.proprioception import BodyState
from hv_sim.landmarks import landmarks
from hv_sim.task import Task
from hv_sim.world import RearrangeWorld

NO_LANDMARKS = "[]"
_THINGS_IN_VIEW, _IN_VIEW, _IN_ALL = 4, 6, 8


def landmark_labels(
    task: Task,
    subtask: int,
    objects_w: Mapping[str, Sequence[float]],
    pose: tuple[float, float, float],
    body: BodyState,
    seed: tuple[int, int],
) -> str:
    """Some landmarks (`hv_sim.landmarks`) as a JSON list of [phrase, is a spot, x, y, z], in m.

    Heading frame, its origin on the floor. Mostly those in the picture, things before spots, none of them twice.

    Args:
        task, subtask: what is being done.
        objects_w: name -> (x, y, z) of every object in the world, m.
        pose: x, y, yaw of the robot in the world.
        body: (1, ...) of the robot, for the pose of its camera.
        seed: decides which are named, and how.
    """
    known = landmarks(task, subtask)
    at = np.array([objects_w[k.object] if k.object else k.position_m for k in known]).reshape(-1, 3)
    x, y, yaw = pose
    dx, dy = at[:, 0] - x, at[:, 1] - y
    c, s = np.cos(yaw), np.sin(yaw)
    places = np.stack([c * dx + s * dy, c * dy - s * dx, at[:, 2]], -1)
    visible = project(body, torch.from_numpy(places).float()[None])[1][0].numpy()
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(known))
    spot = np.array([k.is_spot for k in known], bool)[order]
    seen = visible[order]
    chosen = order[seen & ~spot][:_THINGS_IN_VIEW].tolist()
    chosen += order[seen & spot][: _IN_VIEW - len(chosen)].tolist()
    chosen += order[~seen][: _IN_ALL - len(chosen)].tolist()
    named = []
    for k in chosen:
        phrase = known[k].phrases[int(rng.integers(len(known[k].phrases)))]
        named.append([phrase, int(known[k].is_spot), *places[k].round(3).tolist()])
    return json.dumps(named)


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
    objects = {o.name: state.object_pos_w[env, k].tolist() for k, o in enumerate(task.objects)}
    one = BodyState(*(x[env : env + 1] for x in (body.pos, body.rot, body.lin_vel, body.ang_vel)))
    subtask = min(int(world.subtask_index[env]), len(task.subtasks) - 1)
    seed = (int(world.episode_seed[env] or 0), number)
    return landmark_labels(task, subtask, objects, pose, one, seed)
