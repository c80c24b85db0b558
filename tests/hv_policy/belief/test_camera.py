"""The camera's geometry against MuJoCo's own camera on the real humanoid."""

import mujoco
import numpy as np
import torch

from hv_policy.belief.camera import PLANES_M, camera_position, pixel_rays, project, ray_features
from hv_policy.motor.proprioception import read_proprioception
from hv_sim.observations import proprioception
from hv_sim.suites import load_suite
from hv_sim.world import RearrangeWorld


def looking_robot():
    """A robot in a room that has moved its head, MuJoCo's data of it, and its proprioception."""
    world = RearrangeWorld(load_suite("seen")[:1], num_threads=1)
    rng = np.random.default_rng(0)
    for _ in range(25):
        world.step(torch.from_numpy(rng.uniform(-0.4, 0.4, (1, 28))).float())
    return world.physics.model(0), world.physics.data(0), proprioception(world.state)


def test_camera_stands_and_looks_where_mujocos_does():
    model, data, state = looking_robot()
    mujoco.mj_camlight(model, data)
    camera = model.camera("head").id
    rotation, position = data.cam_xmat[camera].reshape(3, 3), data.cam_xpos[camera]
    pelvis = data.xpos[1]
    forward = data.xmat[1].reshape(3, 3)[:, 0]
    yaw = np.arctan2(forward[1], forward[0])
    to_heading = np.array([[np.cos(yaw), np.sin(yaw), 0], [-np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
    body = read_proprioception(state)
    expected = to_heading @ (position - [pelvis[0], pelvis[1], 0.0])
    np.testing.assert_allclose(camera_position(body)[0].numpy(), expected, atol=1e-4)

    grid = 4
    features = ray_features(body, pixel_rays(grid))[0].numpy()
    for row in range(grid):
        for column in range(grid):
            x, y = (column + 0.5) / grid * 2 - 1, 1 - (row + 0.5) / grid * 2
            ray = to_heading @ rotation @ (np.array([x, y, -1.0]) / np.linalg.norm([x, y, -1.0]))
            said = features[row * grid + column]
            np.testing.assert_allclose(said[:3], ray, atol=1e-4)
            for plane, (u, v, hits) in zip(PLANES_M, said[4:].reshape(-1, 3), strict=True):
                reach = (expected[2] - plane) / -ray[2] if ray[2] < -0.01 else -1.0
                assert bool(hits) == (0 < reach < 20)
                if hits:
                    point = expected[:2] + ray[:2] * reach
                    np.testing.assert_allclose(0.5 * np.sinh([u, v]), point, atol=1e-2, rtol=1e-3)


def test_a_point_is_where_its_ray_is():
    _, _, state = looking_robot()
    body, grid = read_proprioception(state), 6
    rays = pixel_rays(grid)
    direction = ray_features(body, rays)[:, :, :3]
    points = camera_position(body)[:, None] + 1.7 * direction
    at, visible = project(body, points)
    assert visible.all()
    cells = (torch.arange(grid) + 0.5) / grid * 2 - 1
    down, right = torch.meshgrid(cells, cells, indexing="ij")
    torch.testing.assert_close(at[0], torch.stack([right, down], -1).flatten(0, 1), atol=1e-4, rtol=1e-4)
    behind = camera_position(body)[:, None] - 1.7 * direction
    assert not project(body, behind)[1].any()
