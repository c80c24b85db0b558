"""The batched world: determinism, the instructor's inputs, the end of an episode, records."""

import copy

import mujoco
import numpy as np
import pytest
import torch

from hv_sim.humanoid import BODY_NAMES, ROBOT_NQ
from hv_sim.instructor import InstructorConfig
from hv_sim.scene import compile_scene
from hv_sim.suites import load_suite
from hv_sim.task import Task, load_task
from hv_sim.world import START_JITTER_M, START_JITTER_RAD, RearrangeWorld, jittered_start

EAGER = InstructorConfig(min_robot_object_distance_m=0.0, min_steps=2, hold_steps=2)
"""Moves on as soon as the object rests at its goal."""


@pytest.fixture(scope="module")
def tasks() -> list[Task]:
    return [load_task(f"living_room_{i}") for i in (1, 2, 3)]


def standing_targets(world: RearrangeWorld) -> torch.Tensor:
    return torch.tensor(np.stack([s.initial_qpos[7:ROBOT_NQ] for s in world.scenes]), dtype=torch.float32)


def noisy_run(world: RearrangeWorld, env: int, seed: int, num_steps: int = 12) -> list[np.ndarray]:
    """Proprioception, object, goal and waypoint of one environment, driven by noise that depends on the seed only."""
    noise = 0.3 * torch.randn(num_steps, 28, generator=torch.Generator().manual_seed(seed))
    targets = standing_targets(world)
    history = []
    for t in range(num_steps):
        moved = targets.clone()
        moved[env] += noise[t]
        world.step(moved)
        seen = world.observe()
        history.append(torch.cat([seen.proprioception, seen.object, seen.goal, seen.waypoint], 1)[env].numpy().copy())
    return history


def place_at_goal(world: RearrangeWorld, env: int, subtask: int) -> None:
    """Puts the object of a sub-task where it belongs, at rest, and everything else where it is."""
    data = world.physics.data(env)
    qpos = data.qpos.copy()
    k = int(world.scenes[env].subtask_object[subtask])
    start = ROBOT_NQ + 7 * k
    qpos[start : start + 3] = world.scenes[env].goal_pos_w[subtask]
    quat = np.zeros(4)
    mujoco.mju_mat2Quat(quat, np.asarray(world.scenes[env].goal_rot_w[subtask], dtype=float).ravel())
    qpos[start + 3 : start + 7] = quat
    world.physics.reset([env], [qpos])


def test_same_seed_and_task_give_the_same_bits_whatever_the_company(tasks):
    alone = RearrangeWorld([tasks[1]], num_threads=1)
    alone.reset(seeds=[7])
    expected = noisy_run(alone, 0, seed=5)
    crowd = RearrangeWorld([tasks[0], tasks[2], tasks[1], tasks[1]], num_threads=2)
    crowd.reset(seeds=[1, 2, 3, 7])
    np.testing.assert_array_equal(noisy_run(crowd, 3, seed=5), expected)


def test_a_reset_in_the_middle_is_a_fresh_start(tasks):
    world = RearrangeWorld(tasks[:2], num_threads=1)
    world.reset(seeds=[0, 4])
    expected = noisy_run(world, 1, seed=9)
    noisy_run(world, 0, seed=3)
    world.reset([1], seeds=[4])
    np.testing.assert_array_equal(noisy_run(world, 1, seed=9), expected)


def test_another_seed_is_another_start(tasks):
    scene = compile_scene(tasks[0])
    starts = np.stack([jittered_start(scene, seed) for seed in range(200)])
    shift = starts[:, :2] - scene.initial_qpos[:2]
    assert (np.abs(shift) <= START_JITTER_M).all()
    assert np.abs(shift).max() > 0.9 * START_JITTER_M
    np.testing.assert_array_equal(starts[:, 7:], np.tile(scene.initial_qpos[7:], (200, 1)))
    np.testing.assert_allclose(np.linalg.norm(starts[:, 3:7], axis=1), 1)
    dot = np.abs(starts[:, 3:7] @ scene.initial_qpos[3:7]).clip(0, 1)
    angle = 2 * np.arccos(dot)
    assert angle.max() <= START_JITTER_RAD + 1e-6
    assert angle.max() > 0.9 * START_JITTER_RAD


def test_the_robot_is_turned_about_the_vertical(tasks):
    scene = compile_scene(tasks[0])
    before, after = np.zeros(9), np.zeros(9)
    mujoco.mju_quat2Mat(before, scene.initial_qpos[3:7])
    mujoco.mju_quat2Mat(after, jittered_start(scene, 3)[3:7])
    turn = after.reshape(3, 3) @ before.reshape(3, 3).T
    np.testing.assert_allclose(turn[2], [0, 0, 1], atol=1e-9)
    assert turn[0, 0] < 1 - 1e-9


def test_distances_and_current_object_against_plain_mujoco(tasks):
    world = RearrangeWorld(tasks, num_threads=1)
    world.reset(seeds=[1, 2, 3])
    distances = world.object_goal_distances_m()
    for env, task in enumerate(tasks):
        data = world.physics.data(env)
        for s in range(len(task.subtasks)):
            k = int(world.scenes[env].subtask_object[s])
            position = data.xpos[1 + len(BODY_NAMES) + k]
            expected = np.linalg.norm(position - world.scenes[env].goal_pos_w[s])
            assert float(distances[env, s]) == pytest.approx(expected, abs=1e-5)
    assert world.instructions() == [task.subtasks[0].instruction for task in tasks]


def test_the_next_instruction_comes_when_the_object_rests_at_its_goal(tasks):
    world = RearrangeWorld(tasks[:2], instructor=EAGER, num_threads=1)
    waypoint = world.navigator.current_waypoint.clone()
    place_at_goal(world, 1, 0)
    for _ in range(15):
        world.step(standing_targets(world))
        if world.subtask_index[1] == 1:
            break
    assert world.subtask_index.tolist() == [0, 1]
    assert world.instructions() == [tasks[0].subtasks[0].instruction, tasks[1].subtasks[1].instruction]
    assert world.object_index[1] == world.scenes[1].subtask_object[1]
    assert not torch.equal(world.navigator.current_waypoint[1], waypoint[1]), "the route was not planned anew"
    assert world.progress()[1] >= 1.0
    assert world.progress()[0] < 1.0


def test_an_episode_ends_when_all_is_done_and_then_stands_still(tasks):
    world = RearrangeWorld(tasks[:2], instructor=EAGER, num_threads=1)
    for subtask in range(len(tasks[0].subtasks)):
        place_at_goal(world, 0, subtask)
        for _ in range(20):
            world.step(standing_targets(world))
    assert world.done.tolist() == [True, False]
    assert world.finished.tolist() == [True, False]
    frozen, steps = copy.deepcopy(world.state.link_pos_w[0]), int(world.episode_step[0])
    moving = world.state.link_pos_w[1].clone()
    for _ in range(5):
        world.step(standing_targets(world) + 0.3)
    assert torch.equal(world.state.link_pos_w[0], frozen)
    assert not torch.equal(world.state.link_pos_w[1], moving)
    assert int(world.episode_step[0]) == steps
    assert world.progress()[0] == len(tasks[0].subtasks)
    assert world.metrics()["n_episodes"] == 2
    first = world.records([0])[0]
    assert all(first.succeeded(0.4))
    assert first.num_finished == 2


def test_time_runs_out(tasks):
    world = RearrangeWorld(tasks[:1], max_episode_steps=3, num_threads=1)
    for expected in (False, False, True, True):
        world.step(standing_targets(world))
        assert bool(world.done[0]) == expected
    assert not world.finished[0]
    assert world.records()[0].num_steps == 3


def test_a_limp_robot_falls_and_the_fall_is_remembered_until_the_reset(tasks):
    world = RearrangeWorld(tasks[:1], num_threads=1)
    for _ in range(90):
        world.step(torch.zeros(1, 28) + torch.tensor([1.0 if i in (17, 24) else 0.0 for i in range(28)]))
    assert world.fallen[0]
    assert world.records()[0].fallen
    world.reset()
    assert not world.fallen[0]


def test_bps_and_size_belong_to_the_current_object(tasks):
    world = RearrangeWorld(tasks, num_threads=1)
    seen = world.observe()
    for env, scene in enumerate(world.scenes):
        k = int(scene.subtask_object[0])
        np.testing.assert_allclose(seen.bps[env], scene.bps[k], atol=1e-6)
        np.testing.assert_allclose(seen.half_extents[env], scene.half_extents_m[k], atol=1e-6)


def test_wrong_shapes_are_named(tasks):
    world = RearrangeWorld(tasks[:1], num_threads=1)
    with pytest.raises(ValueError, match=r"joint_targets: shape \(1, 14\)"):
        world.step(torch.zeros(1, 14))
    with pytest.raises(ValueError, match="seeds: 2 given for 1"):
        world.reset([0], seeds=[1, 2])
    with pytest.raises(ValueError, match="tasks: empty"):
        RearrangeWorld([])
    with pytest.raises(ValueError, match="max_episode_steps: 0"):
        RearrangeWorld(tasks[:1], max_episode_steps=0)


@pytest.mark.slow
def test_256_different_tasks_run_in_one_batch():
    tasks = load_suite("seen")[:256]
    world = RearrangeWorld(tasks)
    assert world.num_envs == len({t.name for t in world.tasks}) == 256
    world.reset(seeds=range(256))
    standing = torch.tensor(np.stack([s.initial_qpos[7:ROBOT_NQ] for s in world.scenes]), dtype=torch.float32)
    for _ in range(3):
        world.step(standing)
    lone = RearrangeWorld([tasks[200]])
    lone.reset(seeds=[200])
    for _ in range(3):
        lone.step(standing[200:201])
    np.testing.assert_array_equal(world.physics.data(200).qpos, lone.physics.data(0).qpos)
