"""LeRobot's side: the configuration, and LeRobot's own rollout on what it creates."""

import subprocess
import sys
from dataclasses import dataclass

import draccus
import gymnasium as gym
import numpy as np
import pytest
import torch
from lerobot.envs import env_to_policy_features, make_env
from lerobot.envs.configs import EnvConfig
from lerobot.processor import PolicyProcessorPipeline
from lerobot.scripts.lerobot_eval import rollout

from hv_sim.instructor import InstructorConfig
from hv_sim.lerobot_env import HvSimEnvConfig

SMALL = {"observation_height": 24, "observation_width": 24, "episode_length": 5}


@dataclass
class Pipeline:
    """What LeRobot's commands parse: a configuration that holds an environment's."""

    env: EnvConfig


class StandingPolicy(torch.nn.Module):
    """Holds fixed joint targets that depend on the instruction, and keeps what it was told."""

    def __init__(self) -> None:
        super().__init__()
        self.tasks: list[list[str]] = []
        self.shapes: dict[str, tuple[int, ...]] = {}

    def reset(self) -> None:
        self.tasks = []

    def select_action(self, batch: dict) -> torch.Tensor:
        self.tasks.append(list(batch["task"]))
        self.shapes = {k: tuple(v.shape) for k, v in batch.items() if isinstance(v, torch.Tensor)}
        return torch.zeros(len(batch["task"]), 28) + torch.tensor([[0.01 * (len(t) % 7)] for t in batch["task"]])


def no_steps() -> PolicyProcessorPipeline:
    return PolicyProcessorPipeline(steps=[])


def identity(batch):
    return batch


def roll(vec_env, seeds: list[int]) -> tuple[dict, StandingPolicy]:
    policy = StandingPolicy()
    result = rollout(vec_env, policy, no_steps(), no_steps(), identity, identity, seeds=seeds, return_observations=True)
    return result, policy


def seen(result: dict) -> np.ndarray:
    """(B, T, ...) everything that was observed in a rollout."""
    state, image = (result["observation"][f"observation.{k}"] for k in ("state", "images.head"))
    return torch.cat([state, image.flatten(2)], dim=2).numpy()


def test_the_type_is_registered_and_features_have_their_names():
    config = EnvConfig.get_choice_class("hv_sim")()
    assert isinstance(config, HvSimEnvConfig)
    assert config.type == "hv_sim"
    assert set(config.features) == set(config.features_map)
    features = env_to_policy_features(config)
    assert {k: f.shape for k, f in features.items()} == {
        "action": (28,),
        "observation.state": (223,),
        "observation.images.head": (3, 128, 128),
    }


def test_importing_the_configuration_does_not_import_mujoco():
    code = "import hv_sim.lerobot_env, sys; print('mujoco' in sys.modules)"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert out.strip() == "False"


def test_one_vector_env_for_each_task():
    envs = make_env(HvSimEnvConfig(task="living_room", **SMALL), n_envs=2)
    assert list(envs) == ["living_room"]
    assert list(envs["living_room"]) == list(range(8))
    tasks = [vec.call("task") for vec in envs["living_room"].values()]
    assert tasks == [(f"living_room_{i}",) * 2 for i in range(1, 9)]
    assert all(vec.call("_max_episode_steps") == (5, 5) for vec in envs["living_room"].values())


def test_task_ids_and_several_suites():
    config = HvSimEnvConfig(task="living_room,living_room_2", task_ids=[0], **SMALL)
    envs = make_env(config, n_envs=1)
    assert {suite: list(group) for suite, group in envs.items()} == {"living_room": [0], "living_room_2": [0]}
    with pytest.raises(ValueError, match=r"env.task_ids: 9 does not exist; valid: 0 to 7"):
        make_env(HvSimEnvConfig(task_ids=[9]), n_envs=1)


def test_lerobots_rollout_runs_and_does_not_depend_on_the_batch_size():
    def all_seen(n_envs: int) -> np.ndarray:
        vec = make_env(HvSimEnvConfig(task="living_room_1", **SMALL), n_envs=n_envs)["living_room_1"][0]
        parts = []
        for first in range(0, 4, n_envs):
            result, policy = roll(vec, list(range(first, first + n_envs)))
            assert policy.tasks[0] == list(vec.call("task_description"))
            assert policy.shapes["observation.state"] == (n_envs, 223)
            assert policy.shapes["observation.images.head"] == (n_envs, 3, 24, 24)
            parts.append(seen(result))
        vec.close()
        return np.concatenate(parts)

    one, two = all_seen(1), all_seen(2)
    assert one.shape[:2] == (4, 6)
    np.testing.assert_array_equal(one, two)
    assert len(np.unique(one[:, -1], axis=0)) == 4, "the seeds make no difference"


def test_nothing_succeeds_by_standing_and_it_can_be_rolled_again_after_close():
    vec = make_env(HvSimEnvConfig(task="living_room_1", **SMALL), n_envs=2)["living_room_1"][0]
    first, _ = roll(vec, [3, 4])
    vec.close()
    second, _ = roll(vec, [3, 4])
    vec.close()
    np.testing.assert_array_equal(seen(first), seen(second))
    assert not first["success"].any()
    assert first["done"][:, -1].all()


def test_an_ended_episode_stays_frozen_through_the_autoreset():
    vec = make_env(HvSimEnvConfig(task="living_room_1", **SMALL), n_envs=1)["living_room_1"][0]
    assert vec.metadata["autoreset_mode"] == gym.vector.AutoresetMode.NEXT_STEP
    vec.reset(seed=[0])
    for _ in range(5):
        last, *_, truncated, _ = vec.step(np.zeros((1, 28), np.float32))
    assert truncated.tolist() == [True]
    for _ in range(3):
        again, reward, *_, info = vec.step(np.ones((1, 28), np.float32))
        np.testing.assert_array_equal(again["agent_pos"], last["agent_pos"])
        assert reward.tolist() == [0.0]
        assert info["is_success"].tolist() == [False]
    vec.close()


@pytest.mark.slow
def test_asynchronous_workers_see_the_same_episode():
    config = HvSimEnvConfig(task="living_room_1", **SMALL)
    together = make_env(config, n_envs=2)["living_room_1"][0]
    apart = make_env(config, n_envs=2, use_async_envs=True)["living_room_1"][0]
    expected, _ = roll(together, [5, 6])
    result, _ = roll(apart, [5, 6])
    together.close()
    apart.close()
    np.testing.assert_array_equal(seen(result), seen(expected))


def test_intent_mode_builds_its_controller_from_a_name(monkeypatch):
    class Limp:
        def reset(self, ids=None):
            pass

        def __call__(self, proprioception, intent):
            return torch.zeros(len(intent), 28)

    monkeypatch.setitem(sys.modules, "a_controller", type(sys)("a_controller"))
    sys.modules["a_controller"].make = Limp
    config = HvSimEnvConfig(task="living_room_1", control_mode="intent", controller="a_controller:make", **SMALL)
    assert config.features["action"].shape == (14,)
    vec = make_env(config, n_envs=1)["living_room_1"][0]
    assert vec.single_action_space.shape == (14,)
    vec.reset(seed=[0])
    vec.step(np.zeros((1, 14), np.float32))
    vec.close()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"task": ""}, "env.task: empty"),
        ({"fps": 60}, "env.fps: 60"),
        ({"episode_length": 0}, "env.episode_length: 0"),
        ({"observation_width": -1}, "env.observation_width: -1"),
        ({"control_mode": "torque"}, "env.control_mode: 'torque'"),
        ({"control_mode": "intent"}, "env.controller: missing"),
    ],
)
def test_bad_configuration_is_named(arguments, message):
    with pytest.raises(ValueError, match=message):
        HvSimEnvConfig(**arguments)


def test_the_instructors_thresholds_come_from_the_command_line():
    arguments = ["--env.type=hv_sim", "--env.instructor.min_steps=60", "--env.instructor.max_object_speed_m_s=null"]
    config = draccus.parse(Pipeline, args=arguments).env
    assert isinstance(config, HvSimEnvConfig)
    assert config.instructor == InstructorConfig(min_steps=60, max_object_speed_m_s=None)
    config.task, config.observation_height = "living_room_1", 24
    vec = make_env(config, n_envs=1)["living_room_1"][0]
    assert vec.envs[0].unwrapped.world.instructor.config == config.instructor


def test_a_controller_that_does_not_exist_is_named():
    config = HvSimEnvConfig(task="living_room_1", control_mode="intent", controller="no_module:f", **SMALL)
    with pytest.raises(ValueError, match=r"env\.controller: 'no_module:f'"):
        make_env(config, n_envs=1)
