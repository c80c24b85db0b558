import math

import numpy as np
import torch

from hv_policy.belief.compass import compass
from hv_policy.belief.outline import compass_yaw_rad
from hv_policy.motor.proprioception import read_proprioception
from hv_sim.rendering import CameraRenderer
from hv_sim.suites import load_suite
from hv_sim.world import RearrangeWorld
from hv_teachers.glances import glance_around


def test_walls_of_rooms_are_found_from_anywhere():
    """Rooms are built along the axes of the world: there the walls run at minus the robot's yaw."""
    renderer, wrong = CameraRenderer(128, 128), []
    try:
        for world, _ in glance_around(load_suite("unseen")[:60:15], [1, 2, 3, 4], 9):
            wrong += _errors(world, np.stack(renderer.render_batch(world.physics)))
    finally:
        renderer.close()
    assert np.median(wrong) < math.radians(3)
    assert np.quantile(wrong, 0.8) < math.radians(8)


def _errors(world: RearrangeWorld, images: np.ndarray) -> list[float]:
    pictures = torch.from_numpy(images).permute(0, 3, 1, 2).float() / 255
    found = compass_yaw_rad(compass(pictures, read_proprioception(world.observe().proprioception)))
    yaw = torch.atan2(world.heading.sin, world.heading.cos)
    error = torch.remainder(found + yaw + math.pi / 4, math.pi / 2) - math.pi / 4
    return error.abs().tolist()


def test_a_picture_of_nothing_points_nowhere():
    world = RearrangeWorld(load_suite("seen")[:1], num_threads=1)
    body = read_proprioception(world.observe().proprioception)
    assert compass(torch.full((1, 3, 128, 128), 0.5), body).norm() == 0
