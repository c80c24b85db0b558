"""The gymnasium environment `hv_sim/Rearrange-v0`: one humanoid, one room, one instruction after another."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import torch
from gymnasium import spaces
from torch import Tensor

from hv_sim.control import CONTROL_MODES, INTENT_HIGH, INTENT_LOW, Controller
from hv_sim.humanoid import CONTROL_HZ, JOINT_RANGE_RAD
from hv_sim.instructor import InstructorConfig
from hv_sim.observations import PROPRIOCEPTION_DIM
from hv_sim.physics_backends import check_backend
from hv_sim.rendering import CameraRenderer, best_corner, compose_video_frame, follow_camera, third_person_size_px
from hv_sim.task import Task, load_task
from hv_sim.world import RearrangeWorld

SUCCESS_THRESHOLD_M = 0.4


class RearrangeEnv(gym.Env[dict[str, Any], np.ndarray]):
    """A task as a gymnasium environment.

    Observation: `pixels` -> `head` (height, width, 3) uint8, the head camera; `agent_pos` (223,) float32,
    proprioception.
    Action: 28 joint targets in radians, or 14 intents (`hv_sim.control.INTENT_NAMES`). Targets somewhat beyond the
    joint limits are passed on as they are: a servo pushes with kp times the difference, and balancing may need the
    push.
    Reward: sub-tasks finished plus the progress of the current one, in [0, 1); so the maximum over an episode tells how
    far it came. `terminated` when the last sub-task is finished and held, `truncated` at `max_episode_steps`.

    `info` has, after reset and every step, `is_success` (bool: every object lies within 0.4 m of its goal and the
    episode is over, for success is judged at the end), `all_placed` (the same for the present moment),
    `subtask_index`, `num_finished`, `fallen` (latched) and `object_goal_distance_m` (S,). After the episode's end the
    environment stands still: `step` repeats the last observation with reward 0.

    The task and the seed of `reset` decide an episode completely.

    Args:
        task: a task, the name of a packaged one, or the path of a task file.
        control_mode: `joint` or `intent`.
        controller: turns intents into joint targets; needed in intent mode, and refused otherwise.
        max_episode_steps: control steps before the episode is cut off (default: `RearrangeWorld`'s).
        observation_height: of the head camera's picture, pixels.
        observation_width: of the head camera's picture, pixels.
        render_mode: `rgb_array`, or None.
        instructor: thresholds of Algorithm 3.
        physics: one of `hv_sim.physics_backends.BACKENDS`; pictures are OpenGL's all the same.

    Raises:
        ValueError: an argument is out of its range; the message names it.
        hv_sim.task.TaskError: the task is unknown or invalid.
        hv_sim.gl_backend.GLError: at the first picture, when no OpenGL library can render off screen.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": CONTROL_HZ}  # noqa: RUF012  gymnasium declares it so

    def __init__(
        self,
        task: Task | str | Path = "living_room_1",
        *,
        control_mode: str = "joint",
        controller: Controller | None = None,
        max_episode_steps: int | None = None,
        observation_height: int = 128,
        observation_width: int = 128,
        render_mode: str | None = "rgb_array",
        instructor: InstructorConfig | None = None,
        physics: str = "cpu",
    ) -> None:
        if control_mode not in CONTROL_MODES:
            raise ValueError(f"control_mode: {control_mode!r} is not valid; valid: {', '.join(CONTROL_MODES)}")
        if (control_mode == "intent") != (controller is not None):
            need = "needs a controller" if control_mode == "intent" else "takes no controller"
            raise ValueError(f"controller: control_mode={control_mode} {need}; valid: intent with one, joint without")
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ValueError(f"render_mode: {render_mode!r} is not valid; valid: rgb_array, None")
        for name, value in (("observation_height", observation_height), ("observation_width", observation_width)):
            if value < 1:
                raise ValueError(f"{name}: {value} is not valid; valid: an integer >= 1")
        self._task = task if isinstance(task, Task) else load_task(task)
        check_backend(physics)
        self._controller, self._instructor, self._physics = controller, instructor, physics
        self._max_episode_steps = RearrangeWorld.default_max_episode_steps([self._task])
        if max_episode_steps is not None:
            self._max_episode_steps = max_episode_steps
        self.control_mode, self.render_mode = control_mode, render_mode
        low, high = JOINT_RANGE_RAD.T if control_mode == "joint" else (INTENT_LOW, INTENT_HIGH)
        self.action_space = spaces.Box(low.astype(np.float32), high.astype(np.float32), dtype=np.float32)
        self.observation_space = spaces.Dict(
            {
                "pixels": spaces.Dict(
                    {"head": spaces.Box(0, 255, (observation_height, observation_width, 3), dtype=np.uint8)}
                ),
                "agent_pos": spaces.Box(-np.inf, np.inf, (PROPRIOCEPTION_DIM,), dtype=np.float32),
            }
        )
        self._head_renderer = CameraRenderer(observation_height, observation_width)
        self._third_person_renderer = CameraRenderer(*third_person_size_px())
        self._world: RearrangeWorld | None = None
        self._corner_w: np.ndarray | None = None
        self._head_image: np.ndarray | None = None
        self._shown: np.ndarray | None = None
        self.wants_picture: Callable[[RearrangeWorld], bool] | None = None
        """For whoever does not look at every picture: where this says no, an observation shows the last one again."""
        self._video_frame: np.ndarray | None = None

    @property
    def task(self) -> str:
        """Name of the task."""
        return self._task.name

    @property
    def task_description(self) -> str:
        """The instruction in force; it changes in the course of an episode."""
        return self._task.subtasks[0].instruction if self._world is None else self._world.instructions()[0]

    @property
    def world(self) -> RearrangeWorld:
        """The batched world of one environment behind this one, compiled when it is first needed."""
        if self._world is None:
            self._world = RearrangeWorld(
                [self._task],
                instructor=self._instructor,
                max_episode_steps=self._max_episode_steps,
                physics=self._physics,
                num_threads=1,
            )
        return self._world

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Begins an episode; `options` are ignored."""
        super().reset(seed=seed)
        episode_seed = int(self.np_random.integers(2**31)) if seed is None else seed
        self.world.reset(seeds=[episode_seed])
        if self._controller is not None:
            self._controller.reset(None)
        self._forget_pictures()
        self._shown = None
        return self._observation(), self._info()

    def step(self, action: np.ndarray) -> tuple[dict[str, Any], float, bool, bool, dict[str, Any]]:
        """One control step of 1/30 s.

        Raises:
            ValueError: the action has another shape, or is not finite.
        gymnasium.error.ResetNeeded: there was no reset yet.
        """
        if self._world is None:
            raise gym.error.ResetNeeded("step: called before reset")
        world = self._world
        command = np.asarray(action, dtype=np.float32)
        if command.shape != self.action_space.shape or not np.isfinite(command).all():
            raise ValueError(
                f"action: shape {command.shape} with {int((~np.isfinite(command)).sum())} non-finite numbers is not "
                f"valid; valid: {self.action_space.shape} finite numbers"
            )
        was_done = bool(world.done[0])
        if not was_done:
            targets = torch.from_numpy(command)[None]
            if self._controller is not None:
                targets = self._controller(world.observe().proprioception, targets)
            self.step_world(targets)
        terminated = bool(world.finished[0])
        truncated = bool(world.done[0]) and not terminated
        reward = 0.0 if was_done else float(world.progress()[0])
        return self._observation(), reward, terminated, truncated, self._info()

    def step_world(self, joint_targets: Tensor) -> None:
        """One control step with servo targets (1, 28) in rad, for those who need no observation."""
        self.world.step(joint_targets)
        self._forget_pictures()

    def render(self) -> np.ndarray | None:
        """(336, 672, 3) uint8: third person left, head camera right, the instruction underneath."""
        if self.render_mode is None:
            return None
        if self._video_frame is None:
            world = self.world
            model, data = world.physics.model(0), world.physics.data(0)
            bounds = world.room_bounds_xy_m(0)
            if self._corner_w is None:
                self._corner_w = best_corner(*bounds, world.places_xy_m(0))
            robot_xy_m = world.state.link_pos_w[0, 0, :2].numpy()
            camera, self._corner_w = follow_camera(model, data, robot_xy_m, bounds, self._corner_w)
            third_person = self._third_person_renderer.render(model, data, camera)
            self._video_frame = compose_video_frame(third_person, self._head_picture(), self.task_description)
        return self._video_frame.copy()

    def close(self) -> None:
        """Frees the scene and the OpenGL contexts; a later `reset` makes them anew."""
        self._head_renderer.close()
        self._third_person_renderer.close()
        self._world = None
        self._forget_pictures()

    def _head_picture(self) -> np.ndarray:
        if self._head_image is None:
            physics = self.world.physics
            self._head_image = self._head_renderer.render(physics.model(0), physics.data(0))
        return self._head_image

    def _forget_pictures(self) -> None:
        self._head_image = self._video_frame = None

    def _observation(self) -> dict[str, Any]:
        proprioception = self.world.observe().proprioception[0].numpy()
        if self._shown is None or self.wants_picture is None or self.wants_picture(self.world):
            self._shown = self._head_picture()
        return {"pixels": {"head": self._shown.copy()}, "agent_pos": proprioception.astype(np.float32)}

    def _info(self) -> dict[str, Any]:
        world = self.world
        distances = world.object_goal_distances_m()[0, : len(self._task.subtasks)]
        all_placed = bool((distances < SUCCESS_THRESHOLD_M).all())
        return {
            "is_success": all_placed and bool(world.done[0]),
            "all_placed": all_placed,
            "subtask_index": int(world.subtask_index[0]),
            "num_finished": int(world.num_finished[0]),
            "fallen": bool(world.fallen[0]),
            "object_goal_distance_m": distances.numpy().copy(),
        }
