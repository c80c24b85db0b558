"""Rays and boxes against MuJoCo's own ray casting."""

import mujoco
import numpy as np
import torch

from hv_policy.belief.boxes import BOX_DIM, first_box_hit
from hv_policy.belief.camera import camera_position, pixel_rays, ray_directions
from hv_policy.motor.proprioception import read_proprioception
from hv_sim.observations import proprioception
from hv_sim.suites import load_suite
from hv_sim.world import RearrangeWorld


def test_the_nearest_box_is_the_one_that_mujoco_hits():
    world = RearrangeWorld(load_suite("seen")[:2], num_threads=1)
    body, rays = read_proprioception(proprioception(world.state)), pixel_rays(12)
    rng = np.random.default_rng(0)
    boxes = torch.zeros(2, 9, BOX_DIM)
    boxes[..., :2] = torch.from_numpy(rng.uniform((0.6, -2), (4, 2), (2, 9, 2)))
    boxes[..., 2] = torch.from_numpy(rng.uniform(0.1, 1.5, (2, 9)))
    boxes[..., 3:6] = torch.from_numpy(rng.uniform(0.05, 0.5, (2, 9, 3)))
    boxes[..., 6] = torch.from_numpy(rng.uniform(-3, 3, (2, 9)))
    exists = torch.ones(2, 9, dtype=torch.bool)
    exists[1, 4:] = False
    found = first_box_hit(body, rays, boxes, exists)
    origin, direction = camera_position(body).double().numpy(), ray_directions(body, rays).double().numpy()
    for env in range(2):
        spec = mujoco.MjSpec()
        for k in exists[env].nonzero()[:, 0].tolist():
            box = boxes[env, k].tolist()
            turn = [np.cos(box[6] / 2), 0, 0, np.sin(box[6] / 2)]
            spec.worldbody.add_geom(
                name=str(k), type=mujoco.mjtGeom.mjGEOM_BOX, pos=box[:3], size=box[3:6], quat=turn
            )
        model = spec.compile()
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        geom = np.zeros(1, np.int32)
        for ray in range(len(rays)):
            mujoco.mj_ray(model, data, origin[env], direction[env, ray], None, 1, -1, geom)
            expected = -1 if geom[0] < 0 else int(model.geom(int(geom[0])).name)
            assert int(found[env, ray]) == expected
    assert (found >= 0).float().mean() > 0.05
    assert (found < 0).any()
