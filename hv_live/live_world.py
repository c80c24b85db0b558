"""A world of one environment that goes on for ever and whose instruction may change at any control step."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import torch
from torch import Tensor

from hv_sim.mujoco_physics import MujocoPhysics
from hv_sim.places import Layout
from hv_sim.scene import Scene, rotation_about_z
from hv_sim.task import RobotStart, SubTask, Task
from hv_sim.world import RearrangeWorld

_FOREVER = 2**62


class LiveWorld(RearrangeWorld):
    """`RearrangeWorld` for one robot: its sub-tasks are those that were given so far, the last one in force.

    Everything that plays a world plays this one. The second and later instructions count as later sub-tasks, whether
    the earlier ones were done or not.

    Args:
        task: the room, and with its first sub-task what is to be done first.
    """

    def __init__(self, task: Task) -> None:
        super().__init__([replace(task, subtasks=task.subtasks[:1])], max_episode_steps=_FOREVER, num_threads=1)
        self.whole_scene = _with_subtasks(self.scenes[0], task.subtasks)
        """The scene with all sub-tasks of the task, given or not."""
        self.goal_known = True
        """False for words that nobody could ground: only a policy that reads may know what to do."""

    @property
    def done(self) -> Tensor:
        """(1,) bool: never; a robot that has nothing to do stands."""
        return torch.zeros(1, dtype=torch.bool)

    @property
    def current(self) -> SubTask:
        """The sub-task in force."""
        return self.tasks[0].subtasks[-1]

    def give(self, subtask: SubTask) -> None:
        """Puts another sub-task in force, now."""
        self.goal_known = True
        self._add(subtask)

    def give_words(self, sentence: str) -> None:
        """Puts words in force whose goal is not known; the instructor will not find them done."""
        self._add(replace(self.current, instruction=sentence, paraphrases=()))
        self.goal_known = False

    def restart(self, seed: int) -> None:
        """Begins anew with the task's first sub-task."""
        self.goal_known = True
        self._take(_with_subtasks(self.whole_scene, self.whole_scene.task.subtasks[:1]))
        self.reset(seeds=[seed])

    def step(self, joint_targets: Tensor) -> None:
        if not self.goal_known:
            self._forget_time()
        super().step(joint_targets)

    def layout(self) -> Layout:
        """Where everything is now, for reading a sentence; what is at the robot's left is so as it now stands."""
        x, y, yaw = self.robot_xy_yaw()
        state = self.state
        yaws = torch.atan2(state.object_rot_w[0, :, 1, 0], state.object_rot_w[0, :, 0, 0]).tolist()
        poses = {}
        for k, name in enumerate(self.whole_scene.object_names):
            px, py, pz = state.object_pos_w[0, k].tolist()
            poses[name] = ((px, py, pz), yaws[k])
        return Layout(replace(self.whole_scene.task, robot=RobotStart((x, y), yaw)), poses, fresh=True)

    def robot_xy_yaw(self) -> tuple[float, float, float]:
        """Where the pelvis is and looks: m, m, rad; world frame."""
        x, y = self.state.link_pos_w[0, 0, :2].tolist()
        return x, y, float(torch.atan2(self._heading.sin, self._heading.cos)[0])

    def push(self, velocity_m_s: np.ndarray) -> None:
        """Adds a (3,) world velocity to the robot, as a shove would."""
        assert isinstance(self.physics, MujocoPhysics)
        self.physics.push([0], velocity_m_s[None])

    def _add(self, subtask: SubTask) -> None:
        self._take(_with_subtasks(self.scenes[0], (*self.tasks[0].subtasks, subtask)))
        self.instructor.num_finished[0] = len(self.tasks[0].subtasks) - 1
        self._forget_time()
        self._begin_subtask([0])

    def _forget_time(self) -> None:
        self.instructor.steps_since_instruction[0] = self.instructor.steps_held[0] = 0

    def _take(self, scene: Scene) -> None:
        """Lets everything that knows the scene know another list of sub-tasks of it."""
        self.scenes[0] = self.navigator.scenes[0] = scene
        self.tasks[0] = scene.task
        self.instructor.num_subtasks[0] = scene.num_subtasks
        self.subtask_exists = torch.ones(1, scene.num_subtasks, dtype=torch.bool)
        self.subtask_object = torch.as_tensor(scene.subtask_object).long()[None]
        self.goal_pos_w = torch.as_tensor(scene.goal_pos_w).float()[None]
        self.goal_rot_w = torch.as_tensor(scene.goal_rot_w).float()[None]


def _with_subtasks(scene: Scene, subtasks: tuple[SubTask, ...]) -> Scene:
    return replace(
        scene,
        task=replace(scene.task, subtasks=subtasks),
        subtask_object=np.array([scene.object_names.index(s.object) for s in subtasks]),
        goal_pos_w=np.array([s.goal_position_m for s in subtasks]),
        goal_rot_w=np.stack([rotation_about_z(s.goal_yaw_rad) for s in subtasks]),
    )
