"""Is a task solvable? Compiles it, lets it settle, and goes through it as the planner would, sub-task by sub-task.

Nothing is carried out: standing, reaching and putting down are checked by kinematics, the ways by the route planner,
and that an object stays where it shall go by simulating it there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
import torch

from hv_policy.motor.embodiment import ARM_JOINTS, HAND_RADIUS_M, TORSO_OFFSET_M
from hv_policy.motor.kinematics import arm_forward_kinematics, rotation_y, shoulder_positions
from hv_policy.motor.reference import feet_ahead, standing_pose
from hv_sim.grounding import fits
from hv_sim.humanoid import ROBOT_NQ, ROBOT_NV
from hv_sim.navigation import SubTaskRoute, plan_subtask
from hv_sim.places import layout_at
from hv_sim.scene import Scene, compile_scene, rotation_about_z
from hv_sim.task import SUPPORT_TOLERANCE_M, Task, TaskError
from hv_teachers.postures import reach_posture

SETTLE_S = 1.5
TIPPED_RAD = 0.05
"""More than this, or than `SUPPORT_TOLERANCE_M`, while it settles, and a thing does not stand where it was put."""
REACHED_M = 0.03
LOWEST_GRASP_M = 0.05
LACKING_M, MISSED_M = 0.005, 0.1
"""Room and way that may be missing: less than the grid's cells tell apart."""
LONGEST_WAY_M = 15.0
_OUT_OF_THE_WAY_M = 5.0

CHECKS = ("compiles", "settles", "says", "stands", "reaches", "walks", "goal_stays")
"""What is checked: the scene compiles; nothing moves or tips; each instruction fits one object and one goal; there is
room to stand and step back; the hands reach; ways lead there; the object stays where it was put."""


@dataclass(frozen=True)
class Verdict:
    """What came of a task: the first check in `CHECKS` that failed and why, or two empty strings."""

    task: str
    failed: str = ""
    reason: str = ""
    walk_m: float = 0.0
    """Way of the robot over all sub-tasks."""

    @property
    def solvable(self) -> bool:
        """Whether every check was passed."""
        return not self.failed


def verify_task(task: Task, *, ambiguity: bool = True) -> Verdict:
    """Goes through all `CHECKS` until one fails.

    Args:
        task: a valid task (`hv_sim.task.check_task`).
        ambiguity: also check the instructions; leave it out for hand-written ones, whose words may be any.
    """
    try:
        scene = compile_scene(task)
    except (TaskError, ValueError) as error:
        return Verdict(task.name, "compiles", str(error))
    names = scene.object_names
    poses = scene.initial_qpos[ROBOT_NQ:].reshape(-1, 7).copy()
    data = mujoco.MjData(scene.model)
    reason = _settle(scene, data, poses)
    if reason:
        return Verdict(task.name, "settles", reason)
    robot = np.array(task.robot.position_m, dtype=float)
    walked = 0.0
    for i, subtask in enumerate(task.subtasks):
        k = int(scene.subtask_object[i])
        if ambiguity:
            layout = layout_at(task, i)
            wrong = [s for s in subtask.phrasings if not fits(s, layout, subtask.object, subtask.goal_position_m)]
            if wrong:
                return Verdict(task.name, "says", f"subtasks[{i}]: {wrong[0]!r} may mean something else")
        rotations = np.stack([rotation_about_z(2 * np.arctan2(q[6], q[3])) for q in poses])
        route = plan_subtask(scene, i, robot, poses[:, :3], rotations)
        if route.lacking_m > LACKING_M:
            return Verdict(task.name, "stands", f"subtasks[{i}]: no room to stand before {names[k]!r} or its goal")
        goal = np.array([*subtask.goal_position_m, *_quaternion(subtask.goal_yaw_rad)])
        for what, pose, stand in (
            (f"{names[k]!r}", poses[k], route.pick_stand_xy_yaw),
            (f"the goal of {names[k]!r}", goal, route.place_stand_xy_yaw),
        ):
            gap = reaching_error_m(route.grasp_o, pose, stand)
            if gap > REACHED_M:
                return Verdict(task.name, "reaches", f"subtasks[{i}]: the hands end {gap:.2f} m short of {what}")
        way = _way_m(robot, route)
        if route.missed_m > MISSED_M or way > LONGEST_WAY_M:
            return Verdict(task.name, "walks", f"subtasks[{i}]: no way leads to {names[k]!r} and on to its goal")
        walked += way
        poses[k] = goal
        reason = _settle(scene, data, poses)
        if reason:
            return Verdict(task.name, "goal_stays", f"subtasks[{i}]: {reason}")
        stand = route.place_stand_xy_yaw
        robot = stand[:2] - 0.7 * np.array([np.cos(stand[2]), np.sin(stand[2])])
    return Verdict(task.name, walk_m=round(walked, 2))


def reaching_error_m(grasp_o: np.ndarray, pose: np.ndarray, stand_xy_yaw: Sequence[float] | np.ndarray) -> float:
    """How far the hands of a robot that stands somewhere and bends for it end from an object's sides.

    Args:
        grasp_o: (2, 3) where the (left, right) hand touches, in the object's frame.
        pose: (7,) position and quaternion of the object, upright, world frame.
        stand_xy_yaw: (3,) where the robot stands and looks.
    """
    x, y, yaw = (float(v) for v in stand_xy_yaw)
    touch_w = pose[:3] + grasp_o @ rotation_about_z(2 * np.arctan2(pose[6], pose[3])).T
    outward = touch_w - touch_w.mean(0)
    outward /= np.maximum(np.linalg.norm(outward, axis=1, keepdims=True), 1e-6)
    hands_h = (touch_w + HAND_RADIUS_M * outward - [x, y, 0.0]) @ rotation_about_z(yaw)
    if hands_h[:, 2].min() < LOWEST_GRASP_M:
        return float(LOWEST_GRASP_M - hands_h[:, 2].min() + REACHED_M)
    hands = torch.tensor(hands_h[::-1].copy(), dtype=torch.float32)[None]  # right, left
    upright = feet_ahead(torch.tensor([0.84]), torch.tensor([0.05]))
    ahead_of_feet = hands[..., 0].mean(1) - upright
    height, pitch = reach_posture(hands[..., 2].mean(1), ahead_of_feet, (hands[:, 0] - hands[:, 1]).norm(dim=-1))
    # bending moves the pelvis back over the feet, which stay
    hands[..., 0] += (feet_ahead(height, pitch) - upright)[:, None]
    joints, lean = standing_pose(height, pitch, hands)
    torso_rot = rotation_y(pitch)
    pelvis = torch.stack([torch.zeros_like(height), torch.zeros_like(height), height], -1)
    torso = pelvis + rotation_y(lean)[:, :, 2] * TORSO_OFFSET_M[2]
    arms = joints[:, ARM_JOINTS]
    reached = arm_forward_kinematics(shoulder_positions(torso, torso_rot), torso_rot, arms)[0]
    return float((reached - hands).norm(dim=-1).max())


def _settle(scene: Scene, data: mujoco.MjData, poses: np.ndarray) -> str:
    """Lets the objects (K, 7) settle without the robot; says what does not stay where it was put, or ""."""
    mujoco.mj_resetData(scene.model, data)
    robot = scene.initial_qpos[:ROBOT_NQ].copy()
    robot[2] += _OUT_OF_THE_WAY_M
    data.qpos[ROBOT_NQ:] = poses.ravel()
    for _ in range(round(SETTLE_S / scene.model.opt.timestep)):
        data.qpos[:ROBOT_NQ], data.qvel[:ROBOT_NV] = robot, 0.0
        mujoco.mj_step(scene.model, data)
    now = data.qpos[ROBOT_NQ:].reshape(-1, 7)
    for name, before, after in zip(scene.object_names, poses, now, strict=True):
        moved = float(np.linalg.norm(after[:3] - before[:3]))
        up = 1 - 2 * (after[4] ** 2 + after[5] ** 2)
        if not moved < SUPPORT_TOLERANCE_M or not up > np.cos(TIPPED_RAD):
            return f"{name!r} does not stay where it stands: it moves {moved:.3f} m"
    return ""


def _quaternion(yaw_rad: float) -> tuple[float, float, float, float]:
    return (float(np.cos(yaw_rad / 2)), 0.0, 0.0, float(np.sin(yaw_rad / 2)))


def _way_m(start: np.ndarray, route: SubTaskRoute) -> float:
    points = np.vstack([start[:2], route.waypoints_to_object, route.waypoints_to_goal])
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
