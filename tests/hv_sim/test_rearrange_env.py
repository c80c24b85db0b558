"""The gymnasium environment: gymnasium's own check, determinism, the end of an episode, pictures."""

import warnings

import gymnasium as gym
import numpy as np
import pytest
import torch
from gymnasium.utils.env_checker import check_env

import hv_sim
from hv_sim.control import INTENT_LOW
from hv_sim.humanoid import JOINT_RANGE_RAD, ROBOT_NQ
from hv_sim.instructor import InstructorConfig
from hv_sim.rearrange_env import RearrangeEnv
from hv_sim.task import TaskError
from hv_sim.world import RearrangeWorld

SMALL = {"observation_height": 32, "observation_width": 40}


@pytest.fixture
def env():
    made = RearrangeEnv("living_room_1", max_episode_steps=8, **SMALL)
    yield made
    made.close()


def stand(env: RearrangeEnv) -> np.ndarray:
    return env.world.scenes[0].initial_qpos[7:ROBOT_NQ].astype(np.float32)


def test_gymnasiums_own_check_passes():
    made = gym.make(hv_sim.ENV_ID, task="living_room_2", **SMALL)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # proprioception has no bounds, and joint limits are not symmetric
        check_env(made.unwrapped)
    made.close()


def test_spaces(env):
    assert env.observation_space["pixels"]["head"].shape == (32, 40, 3)
    assert env.observation_space["agent_pos"].shape == (223,)
    np.testing.assert_allclose(env.action_space.low, JOINT_RANGE_RAD[:, 0], rtol=1e-6)
    np.testing.assert_allclose(env.action_space.high, JOINT_RANGE_RAD[:, 1], rtol=1e-6)
    assert env.metadata["render_fps"] == 30


def test_an_episode_is_the_worlds_episode(env):
    """Same seed and task: gymnasium, and a world with company, see the same."""
    world = RearrangeWorld([env.world.tasks[0]] * 3, num_threads=1)
    world.reset(seeds=[5, 6, 11])
    observation, _ = env.reset(seed=11)
    np.testing.assert_array_equal(observation["agent_pos"], world.observe().proprioception[2])
    for _ in range(4):
        action = stand(env) + 0.1
        observation, *_ = env.step(action)
        world.step(torch.from_numpy(action).expand(3, -1))
    np.testing.assert_array_equal(observation["agent_pos"], world.observe().proprioception[2])


def test_info_says_is_success_in_plain_bools_all_the_time(env):
    _, info = env.reset(seed=0)
    assert info["is_success"] is False
    for _ in range(10):
        *_, info = env.step(stand(env))
        assert info["is_success"] is False
        assert info["subtask_index"] == 0


def test_after_the_end_it_stands_still(env):
    env.reset(seed=0)
    ends = []
    for _ in range(8):
        observation, reward, terminated, truncated, _ = env.step(stand(env))
        ends.append((terminated, truncated))
    assert ends == [(False, False)] * 7 + [(False, True)]
    for _ in range(3):
        again, reward, terminated, truncated, _ = env.step(stand(env) + 0.5)
        np.testing.assert_array_equal(again["agent_pos"], observation["agent_pos"])
        np.testing.assert_array_equal(again["pixels"]["head"], observation["pixels"]["head"])
        assert (reward, terminated, truncated) == (0.0, False, True)
    env.reset(seed=1)
    assert env.step(stand(env))[2:4] == (False, False)


def test_success_the_changing_instruction_and_the_reward():
    """Objects are put at their goals by hand: the instruction changes, then the episode ends in success."""
    eager = InstructorConfig(min_robot_object_distance_m=0.0, min_steps=2, hold_steps=2)
    env = RearrangeEnv("living_room_1", instructor=eager, **SMALL)
    env.reset(seed=0)
    scene, physics = env.world.scenes[0], env.world.physics
    texts, rewards, ended = [], [], False
    for subtask in range(2):
        qpos = physics.data(0).qpos.copy()
        start = ROBOT_NQ + 7 * int(scene.subtask_object[subtask])
        qpos[start : start + 3] = scene.goal_pos_w[subtask]
        physics.reset([0], [qpos])
        for _ in range(20):
            texts.append(env.task_description)
            _, reward, terminated, truncated, info = env.step(stand(env))
            rewards.append(reward)
            assert info["is_success"] is (terminated and info["all_placed"])
            if terminated:
                ended = True
                break
    assert ended
    assert info["is_success"] is True
    assert not truncated
    instructions = [s.instruction for s in env.world.tasks[0].subtasks]
    assert list(dict.fromkeys(texts)) == instructions
    assert max(rewards) == 2.0
    assert rewards == sorted(rewards) or max(rewards[:5]) < 1.0 <= rewards[-1]
    env.close()


def test_intent_mode_goes_through_the_controller():
    class Recorder:
        def __init__(self):
            self.calls, self.resets = [], 0

        def reset(self, ids=None):
            self.resets += 1

        def __call__(self, proprioception, intent):
            self.calls.append((proprioception.shape, intent.shape))
            return torch.zeros(1, 28)

    controller = Recorder()
    env = RearrangeEnv("living_room_1", control_mode="intent", controller=controller, **SMALL)
    assert env.action_space.shape == (14,)
    env.reset(seed=0)
    env.step(INTENT_LOW)
    assert controller.calls == [((1, 223), (1, 14))]
    assert controller.resets == 1
    env.close()


def test_render_shows_three_parts_and_follows_the_episode(env):
    env.reset(seed=0)
    first = env.render()
    assert first.shape == (336, 672, 3)
    assert first[:288, :384].std() > 10, "the third-person view is blank"
    assert first[:288, 384:].std() > 10, "the head camera is blank"
    assert first[288:].max() > 200, "there is no instruction"
    for _ in range(5):
        env.step(stand(env) + 0.3)
    assert not np.array_equal(env.render(), first)


def test_it_can_be_used_after_close(env):
    before, _ = env.reset(seed=3)
    env.close()
    env.close()
    after, _ = env.reset(seed=3)
    np.testing.assert_array_equal(before["pixels"]["head"], after["pixels"]["head"])
    np.testing.assert_array_equal(before["agent_pos"], after["agent_pos"])


def test_task_and_instruction_are_known_before_the_scene_is_compiled():
    env = RearrangeEnv("living_room_3", **SMALL)
    assert env.task == "living_room_3"
    assert env.task_description
    assert env._world is None
    with pytest.raises(gym.error.ResetNeeded):
        env.step(np.zeros(28, np.float32))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"control_mode": "torque"}, "control_mode: 'torque' is not valid; valid: joint, intent"),
        ({"control_mode": "intent"}, "controller: .* needs a controller"),
        ({"render_mode": "human"}, "render_mode: 'human'"),
        ({"observation_height": 0}, "observation_height: 0"),
    ],
)
def test_bad_arguments_are_named(arguments, message):
    with pytest.raises(ValueError, match=message):
        RearrangeEnv("living_room_1", **arguments)


def test_an_unknown_task_is_named():
    with pytest.raises(TaskError, match="no_such_task"):
        RearrangeEnv("no_such_task")


def test_a_bad_action_is_named(env):
    env.reset(seed=0)
    with pytest.raises(ValueError, match=r"action: shape \(14,\)"):
        env.step(np.zeros(14, np.float32))
    with pytest.raises(ValueError, match="28 non-finite"):
        env.step(np.full(28, np.nan, np.float32))


def test_who_does_not_look_is_shown_the_last_picture_again():
    env = RearrangeEnv("living_room_1")
    try:
        first = env.reset(seed=0)[0]["pixels"]["head"]
        asked = []
        env.wants_picture = lambda world: asked.append(int(world.episode_step[0])) or len(asked) == 3
        shown = [env.step(np.full(28, 0.3, np.float32))[0] for _ in range(3)]
        assert asked == [1, 2, 3]
        assert all(np.array_equal(s["pixels"]["head"], first) for s in shown[:2])
        assert not np.array_equal(shown[2]["pixels"]["head"], first)
        assert not np.array_equal(shown[0]["agent_pos"], shown[1]["agent_pos"])
        env.wants_picture = lambda world: False
        assert np.array_equal(env.reset(seed=0)[0]["pixels"]["head"], first), "an episode begins with a picture"
    finally:
        env.close()
