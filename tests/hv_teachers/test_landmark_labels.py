import json

import numpy as np
import torch

from hv_policy.motor.proprioception import read_proprioception
from hv_sim.landmarks import landmarks
from hv_sim.observations import proprioception
from hv_sim.suites import load_suite
from hv_sim.world import RearrangeWorld
from hv_teachers.landmark_labels import world_landmarks

TASKS = load_suite("seen")[40:42]


def test_they_are_where_mujoco_has_them():
    world = RearrangeWorld(TASKS, num_threads=1)
    world.reset(seeds=[1, 2])
    for _ in range(20):
        world.step(torch.zeros(2, 28))
    body = read_proprioception(proprioception(world.state))
    for env, task in enumerate(TASKS):
        known = {p: k for k in landmarks(task, 0) for p in k.phrases}
        data = world.physics.data(env)
        forward = data.xmat[1].reshape(3, 3)[:, 0]
        yaw = np.arctan2(forward[1], forward[0])
        named = [n for number in range(12) for n in json.loads(world_landmarks(world, env, body, number))]
        assert len({n[0] for n in named}) > 10
        objects = 0
        for phrase, x, y, z, *box in named:
            if not phrase:
                continue  # a thing that no words fit alone
            landmark = known[phrase]
            assert landmark.is_spot == (not box)
            expected, turn = np.array(landmark.position_m), landmark.yaw_rad
            if landmark.object:
                k = [o.name for o in task.objects].index(landmark.object)
                expected = world.state.object_pos_w[env, k].numpy()
                axis = world.state.object_rot_w[env, k, :, 0].numpy()
                turn = np.arctan2(axis[1], axis[0])
                objects += 1
            at = [np.cos(yaw) * x - np.sin(yaw) * y, np.sin(yaw) * x + np.cos(yaw) * y]
            np.testing.assert_allclose([at[0] + data.xpos[1, 0], at[1] + data.xpos[1, 1], z], expected, atol=5e-3)
            if box:
                np.testing.assert_allclose(box[:3], landmark.half_extents_m, atol=1e-3)
                assert abs((box[3] + yaw - turn + np.pi) % (2 * np.pi) - np.pi) < 5e-3
        assert objects


def test_same_frame_same_names_other_frame_others():
    world = RearrangeWorld(TASKS, num_threads=1)
    world.reset(seeds=[1, 2])
    body = read_proprioception(proprioception(world.state))
    assert world_landmarks(world, 1, body, 3) == world_landmarks(world, 1, body, 3)
    assert world_landmarks(world, 1, body, 3) != world_landmarks(world, 1, body, 4)
    alone = RearrangeWorld(TASKS[1:], num_threads=1)
    alone.reset(seeds=[2])
    own = read_proprioception(proprioception(alone.state))
    assert world_landmarks(alone, 0, own, 3) == world_landmarks(world, 1, body, 3)
