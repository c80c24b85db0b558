"""LeRobot's view of the environment: `--env.type=hv_sim`.

`lerobot-eval` gets one vectorised environment per task, and the seed of an episode is counted within its task. So the
result of an evaluation depends neither on the batch size nor on the order of the tasks.

Importing this module is cheap: no MuJoCo.
"""

from __future__ import annotations

import functools
import importlib
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import gymnasium as gym
from lerobot.configs import FeatureType, PolicyFeature
from lerobot.envs.configs import EnvConfig
from lerobot.utils.constants import ACTION, OBS_IMAGES, OBS_STATE

from hv_sim import ENV_ID
from hv_sim.instructor import InstructorConfig

if TYPE_CHECKING:
    from hv_sim.rearrange_env import RearrangeEnv

_STATE_DIM, _NUM_JOINTS, _NUM_INTENTS = 223, 28, 14
_IMAGE_KEY = f"{OBS_IMAGES}.head"


class EnvConfigError(ValueError):
    """A field of the environment's configuration is out of its range; the message is one line that names it."""


@EnvConfig.register_subclass("hv_sim")
@dataclass
class HvSimEnvConfig(EnvConfig):
    """Configuration of `hv_sim/Rearrange-v0` for LeRobot.

    Raises:
        EnvConfigError: a field is out of its range; the message names it.
    """

    task: str | None = "living_room"
    """A packaged task, a prefix of packaged tasks, or a task file; several separated by commas. Each prefix is a
    suite."""
    task_ids: list[int] | None = None
    """Positions within each suite to keep (default: all)."""
    fps: int = 30
    episode_length: int | None = None
    """Control steps before an episode is cut off (default: the environment's)."""
    observation_height: int = 128
    observation_width: int = 128
    control_mode: str = "joint"
    """`joint`: 28 joint targets in radians; `intent`: 14 intents, which need `controller`."""
    controller: str | None = None
    """`module:function` that builds the controller of intent mode when called without arguments."""
    instructor: InstructorConfig = field(default_factory=InstructorConfig)
    """When the next instruction is given: `--env.instructor.min_steps=60` and so on."""
    render_mode: str = "rgb_array"
    features: dict[str, PolicyFeature] = field(default_factory=dict)
    features_map: dict[str, str] = field(
        default_factory=lambda: {ACTION: ACTION, "agent_pos": OBS_STATE, _IMAGE_KEY: _IMAGE_KEY}
    )

    def __post_init__(self) -> None:
        if not self.task:
            raise EnvConfigError("env.task: empty; valid: a task name, a prefix of task names or a task file")
        if self.fps != 30:
            raise EnvConfigError(f"env.fps: {self.fps} is not valid; valid: 30")
        for name in ("observation_height", "observation_width", "episode_length"):
            value = getattr(self, name)
            if value is not None and value < 1:
                raise EnvConfigError(f"env.{name}: {value} is not valid; valid: an integer >= 1")
        if self.control_mode not in ("joint", "intent"):
            raise EnvConfigError(f"env.control_mode: {self.control_mode!r} is not valid; valid: joint, intent")
        if self.control_mode == "intent" and not self.controller:
            raise EnvConfigError(
                "env.controller: missing; control_mode=intent needs `module:function` that builds a controller"
            )
        num_actions = _NUM_JOINTS if self.control_mode == "joint" else _NUM_INTENTS
        image_shape = (self.observation_height, self.observation_width, 3)
        self.features = {
            ACTION: PolicyFeature(type=FeatureType.ACTION, shape=(num_actions,)),
            "agent_pos": PolicyFeature(type=FeatureType.STATE, shape=(_STATE_DIM,)),
            _IMAGE_KEY: PolicyFeature(type=FeatureType.VISUAL, shape=image_shape),
        }

    @property
    def package_name(self) -> str:
        """Package whose import registers the gymnasium id."""
        return "hv_sim"

    @property
    def gym_id(self) -> str:
        """The gymnasium id, whatever the task."""
        return ENV_ID

    @property
    def gym_kwargs(self) -> dict[str, Any]:
        """Arguments of `hv_sim.rearrange_env.RearrangeEnv` apart from the task."""
        return {
            "control_mode": self.control_mode,
            "instructor": self.instructor,
            "max_episode_steps": self.episode_length,
            "observation_height": self.observation_height,
            "observation_width": self.observation_width,
            "render_mode": self.render_mode,
        }

    def create_envs(self, n_envs: int, use_async_envs: bool = False) -> dict[str, dict[int, Any]]:
        """One vectorised environment of `n_envs` copies for each task: {suite: {task_id: vector env}}.

        Scenes, workers and OpenGL contexts come into being when an environment is first reset. Sub-environments freeze
        at the end of their episode and reset at the next step's turn (NEXT_STEP), as LeRobot's rollout expects.

        Raises:
            EnvConfigError: `n_envs` is below 1, or a task id does not exist.
            hv_sim.task.TaskError: a task is unknown or invalid.
            hv_sim.gl_backend.GLError: nothing can render here; said before LeRobot makes its output folders.
        """
        from lerobot.envs.utils import _LazyAsyncVectorEnv

        from hv_sim.gl_backend import require_gl
        from hv_sim.task import resolve_tasks

        if n_envs < 1:
            raise EnvConfigError(f"n_envs: {n_envs} is not valid; valid: an integer >= 1")
        require_gl()
        envs: dict[str, dict[int, Any]] = {}
        for name in (part.strip() for part in str(self.task).split(",")):
            if not name:
                continue
            tasks = resolve_tasks(name)
            suite = envs.setdefault(_suite_name(name), {})
            spaces: tuple[Any, ...] = ()
            for task_id in self._selected(len(tasks)):
                task = tasks[task_id]
                make = functools.partial(_make_env, task.to_dict(), self.controller, self.gym_kwargs)
                if use_async_envs and n_envs > 1:
                    lazy = _LazyAsyncVectorEnv([make] * n_envs, *spaces)
                    spaces = (lazy.observation_space, lazy.action_space, lazy.metadata)
                    suite[task_id] = lazy
                else:
                    suite[task_id] = ReopenableSyncVectorEnv([make] * n_envs)
        return envs

    def _selected(self, num_tasks: int) -> list[int]:
        if self.task_ids is None:
            return list(range(num_tasks))
        for task_id in self.task_ids:
            if not 0 <= task_id < num_tasks:
                raise EnvConfigError(f"env.task_ids: {task_id} does not exist; valid: 0 to {num_tasks - 1}")
        return sorted(set(self.task_ids))


class ReopenableSyncVectorEnv(gym.vector.SyncVectorEnv):
    """A synchronous vector env that freezes sub-environments at their episode's end and can be used after `close`.

    LeRobot closes each task's environment after its turn, and evaluates it again later in a training run.
    """

    def __init__(self, env_fns: list[Callable[[], gym.Env]]) -> None:
        from lerobot.envs.utils import freeze_after_episode_end

        frozen = [freeze_after_episode_end(make) for make in env_fns]
        super().__init__(frozen, autoreset_mode=gym.vector.AutoresetMode.NEXT_STEP)

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Resets every sub-environment; see `gymnasium.vector.VectorEnv.reset`."""
        self.closed = False
        return super().reset(seed=seed, options=options)


def load_controller(name: str) -> Any:
    """Builds a controller from `module:function`.

    Raises:
        ValueError: the name has another form, or there is no such module or function.
    """
    module_name, _, function = name.partition(":")
    try:
        return getattr(importlib.import_module(module_name), function)()
    except (ImportError, AttributeError, ValueError) as error:
        raise EnvConfigError(f"env.controller: {name!r} cannot be built ({error}); valid: module:function") from error


def _make_env(task: dict[str, Any], controller: str | None, gym_kwargs: dict[str, Any]) -> RearrangeEnv:
    from hv_sim.rearrange_env import RearrangeEnv
    from hv_sim.task import Task

    built = None if controller is None else load_controller(controller)
    return RearrangeEnv(Task.from_dict(task), controller=built, **gym_kwargs)


def _suite_name(task: str) -> str:
    """A name fit for a folder: LeRobot stores videos under it."""
    stem = Path(task).name.split(".")[0] if "/" in task or task.endswith(".json") else task
    return re.sub(r"[^A-Za-z0-9_-]+", "_", stem)
