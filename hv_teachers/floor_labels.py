"""Which floor around a robot is taken by walls, furniture and things that lie on it: a label of a recorded frame."""

from __future__ import annotations

import numpy as np

from hv_policy.belief.floor_patch import patch_points, write_patch
from hv_sim.world import RearrangeWorld

LOW_M = 0.3
"""A thing whose lowest point is below this height stands on the floor; others lie on furniture, or are carried."""
_POINTS_H = patch_points().double().numpy()


def world_floor(world: RearrangeWorld, env: int) -> str:
    """`hv_policy.belief.floor_patch` of environment `env` in its present state; what is beyond the walls is taken."""
    state = world.state
    rotation, position = state.link_rot_w[env, 0].double().numpy(), state.link_pos_w[env, 0].double().numpy()
    ahead = rotation[:2, 0] / max(float(np.hypot(*rotation[:2, 0])), 1e-9)
    left = np.array([-ahead[1], ahead[0]])
    return write_patch(taken_floor(world, env, position[:2] + _POINTS_H[:, :1] * ahead + _POINTS_H[:, 1:] * left))


def taken_floor(world: RearrangeWorld, env: int, points_w: np.ndarray) -> np.ndarray:
    """(P,) bool which points (P, 2) of the floor of environment `env` are taken now."""
    state, scene = world.state, world.scenes[env]
    taken = scene.occupancy.is_taken(points_w)
    for k, half in enumerate(scene.half_extents_m[: scene.num_objects]):
        turned = state.object_rot_w[env, k].double().numpy()
        middle = state.object_pos_w[env, k].double().numpy()
        if middle[2] - float(np.abs(turned[2]) @ half) > LOW_M:
            continue
        # the axis that stands most upright is left out: the thing's outline on the floor is the rectangle of the others
        level = [i for i in range(3) if i != int(np.abs(turned[2]).argmax())]
        apart = (points_w - middle[:2]) @ turned[:2, level]
        taken |= (np.abs(apart) < half[level]).all(-1)
    return taken
