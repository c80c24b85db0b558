"""What a frame of a recording holds, of whatever plays in a world; and the frames of glances.

Needs nothing of LeRobot, so that frames can be made where it is not installed (`training/student/render_frames.py`).
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import torch
from torch import Tensor

from hv_policy.motor.proprioception import BodyState, read_proprioception
from hv_sim.looks import Look, LookRanges
from hv_sim.rendering import CameraRenderer
from hv_sim.task import Task
from hv_sim.world import RearrangeWorld
from hv_teachers.dataset_format import ACTION, FLOOR, HEAD_IMAGE, LANDMARKS, STATE
from hv_teachers.floor_labels import world_floor
from hv_teachers.glances import BEGINNING_SHARE, LYING_SHARE, VIEWS_PER_PLACE, glance_around, no_action
from hv_teachers.knowledge import Knowledge, no_knowledge
from hv_teachers.landmark_labels import world_landmarks


def attempt_seed(seed: int, task_name: str, repeat: int) -> int:
    """The environment's seed of one attempt."""
    return int(np.random.SeedSequence([seed, zlib.crc32(task_name.encode()), repeat]).generate_state(1)[0])


def draw_looks(ranges: LookRanges, seeds: Sequence[int], number: int = 0) -> list[Look] | None:
    """How each attempt looks; for glances, at place `number`."""
    if not ranges.vary:
        return None
    return [Look(ranges, np.random.default_rng([seed, 12, number])) for seed in seeds]


def vector_columns(
    world: RearrangeWorld, knowledge: Knowledge | None, intent: Tensor, joint_targets: Tensor
) -> dict[str, np.ndarray]:
    """`VECTOR_COLUMNS` of every environment, (N, size) float32 each, for its present state.

    Args:
        world: whose.
        knowledge: what whoever plays knew; None where that cannot be said: zeros, which are no labels to a student.
        intent: (N, 14).
        joint_targets: (N, 28) rad.
    """
    observation = world.observe()
    known = no_knowledge(world.num_envs) if knowledge is None else knowledge.columns()
    vectors = {
        STATE: observation.proprioception,
        ACTION: joint_targets,
        "privileged.object": observation.object,
        "privileged.goal": observation.goal,
        "privileged.waypoint": observation.waypoint,
        "privileged.half_extents": observation.half_extents,
        "privileged.intent": intent,
        "privileged.subtask_index": world.subtask_index[:, None],
        **known,
    }
    return {key: value.float().cpu().numpy() for key, value in vectors.items()}


def frame_row(
    world: RearrangeWorld, env: int, arrays: dict[str, np.ndarray], body: BodyState, number: int
) -> dict[str, Any]:
    """Environment `env`'s row of `arrays`, and its landmarks and floor for frame `number`."""
    texts = {LANDMARKS: world_landmarks(world, env, body, number), FLOOR: world_floor(world, env)}
    return {key: value[env].copy() for key, value in arrays.items()} | texts


def glance_frames(
    tasks: Sequence[Task],
    seeds: Sequence[int],
    glances: int,
    image_size_px: int,
    looks: LookRanges,
    beginning_share: float = BEGINNING_SHARE,
    lying_share: float = LYING_SHARE,
) -> Iterator[tuple[RearrangeWorld, list[dict[str, Any]]]]:
    """Of each glance (`hv_teachers.glances`) the world and every environment's frame, ready for
    `LeRobotDataset.add_frame`.

    Args:
        tasks: one for each environment.
        seeds: likewise.
        glances: how many.
        image_size_px: side of the pictures.
        looks: how different every place looks.
        beginning_share, lying_share: see `glance_around`.
    """
    renderer = CameraRenderer(image_size_px, image_size_px)
    try:
        glanced = glance_around(tasks, seeds, glances, beginning_share, lying_share)
        for number, (world, knowledge) in enumerate(glanced):
            arrays, instructions = vector_columns(world, knowledge, *no_action(world)), world.instructions()
            body = read_proprioception(torch.from_numpy(arrays[STATE]))
            if number % VIEWS_PER_PLACE == 0:
                drawn = draw_looks(looks, seeds, number)
            pictures = renderer.render_batch(world.physics, looks=drawn)
            yield (
                world,
                [
                    {HEAD_IMAGE: picture, **frame_row(world, env, arrays, body, number), "task": instructions[env]}
                    for env, picture in enumerate(pictures)
                ],
            )
    finally:
        renderer.close()
