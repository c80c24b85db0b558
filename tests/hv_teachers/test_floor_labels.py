import mujoco
import numpy as np
import torch

from hv_policy.belief.floor_patch import patch_points, read_patches
from hv_sim.humanoid import ROBOT_NQ
from hv_sim.suites import load_suite
from hv_sim.world import RearrangeWorld
from hv_teachers.floor_labels import LOW_M, world_floor


def test_floor_is_taken_where_a_ray_from_above_meets_something():
    """Against MuJoCo: rays from 1.9 m straight down, the robot out of the way."""
    world = RearrangeWorld(load_suite("seen")[3:200:60], num_threads=1)
    world.reset(seeds=[1, 2, 3, 4])
    points = patch_points().double().numpy()
    rng = np.random.default_rng(0)
    right, total = 0, 0
    for env, scene in enumerate(world.scenes):
        [taken], [known] = read_patches([world_floor(world, env)])
        assert known
        data = mujoco.MjData(scene.model)
        data.qpos[:] = scene.initial_qpos
        for k, position in enumerate(world.state.object_pos_w[env, : scene.num_objects].tolist()):
            data.qpos[ROBOT_NQ + 7 * k : ROBOT_NQ + 7 * k + 3] = position
        data.qpos[2] += 50.0
        mujoco.mj_forward(scene.model, data)
        heading, root = world.heading, world.state.link_pos_w[env, 0].double().numpy()
        c, s = float(heading.cos[env]), float(heading.sin[env])
        for i in rng.choice(len(points), 400, replace=False):
            x, y = points[i]
            at = root[:2] + np.array([c * x - s * y, s * x + c * y])
            if not (np.abs(at) < np.array(scene.task.room.size_m) / 2 - 0.1).all():
                continue
            geom = np.zeros(1, dtype=np.int32)
            down = mujoco.mj_ray(
                scene.model, data, np.array([*at, 1.9]), np.array([0.0, 0.0, -1.0]), None, 1, -1, geom
            )
            total += 1
            right += bool(taken[i]) == (1.9 - down > 0.03)
    assert total > 400
    assert right / total > 0.95


def test_what_lies_on_furniture_or_is_carried_takes_no_floor():
    world = RearrangeWorld(load_suite("seen")[:1], num_threads=1)
    world.reset(seeds=[5])
    state, root = world.state, world.state.link_pos_w[0, 0]
    half = float(world.scenes[0].half_extents_m[0].max())
    ahead = torch.tensor([float(world.heading.cos[0]), float(world.heading.sin[0])])
    state.object_pos_w[0, 0] = torch.tensor([*(root[:2] + 0.3 * ahead), LOW_M + 2 * half + 0.1])
    [above], _ = read_patches([world_floor(world, 0)])
    state.object_pos_w[0, 0, 2] = half
    [below], _ = read_patches([world_floor(world, 0)])
    assert below.sum() > above.sum()
    there = (patch_points() - torch.tensor([0.3, 0.0])).norm(dim=-1).argmin()
    assert below[there]
    assert not above[there]
