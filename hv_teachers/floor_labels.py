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
    state, scene = world.state, world.scenes[env]
    rotation, position = state.link_rot_w[env, 0].double().numpy(), state.link_pos_w[env, 0].double().numpy()
    ahead = rotation[:2, 0] / max(float(np.hypot(*rotation[:2, 0])), 1e-9)
    left = np.array([-ahead[1], ahead[0]])
    points = position[:2] + _POINTS_H[:, :1] * ahead + _POINTS_H[:, 1:] * left
    taken = scene.occupancy.is_taken(points)
    for k, half in enumerate(scene.half_extents_m[: scene.num_objects]):
        turned = state.object_rot_w[env, k].double().numpy()
        middle = state.object_pos_w[env, k].double().numpy()
        if middle[2] - float(np.abs(turned[2]) @ half) > LOW_M:
            continue
        # the axis that stands most upright is left out: the thing's outline on the floor is the rectangle of the others
        level = [i for i in range(3) if i != int(np.abs(turned[2]).argmax())]
        apart = (points - middle[:2]) @ turned[:2, level]
        taken |= (np.abs(apart) < half[level]).all(-1)
    return write_patch(taken)
