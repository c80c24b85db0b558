"""The interface between the world and a physics engine: many simulations of different scenes, stepped together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import mujoco
import numpy as np
from torch import Tensor


@dataclass
class PhysicsState:
    """Kinematic state of every simulation after a control step; float32, world frame, SI units.

    K is the largest number of movable objects in the batch; the rows of absent objects are zero (their rotation too).
    Velocities are those of the link frame's origin. `body_contact` says which bodies touch the static world (floor,
    walls, furniture), `body_contact_height_m` how high the deepest of these contacts lies (zero without contact).
    """

    link_pos_w: Tensor  # (N, 15, 3)
    link_rot_w: Tensor  # (N, 15, 3, 3)
    link_lin_vel_w: Tensor  # (N, 15, 3)
    link_ang_vel_w: Tensor  # (N, 15, 3)
    joint_pos: Tensor  # (N, 28)
    joint_vel: Tensor  # (N, 28)
    object_pos_w: Tensor  # (N, K, 3)
    object_rot_w: Tensor  # (N, K, 3, 3)
    object_lin_vel_w: Tensor  # (N, K, 3)
    object_ang_vel_w: Tensor  # (N, K, 3)
    body_contact: Tensor  # (N, 15) bool
    body_contact_height_m: Tensor  # (N, 15)


class PhysicsBackend(Protocol):
    """Many independent simulations, one scene each, that share nothing but the clock."""

    num_envs: int
    num_objects: int

    def reset(
        self, ids: Sequence[int] | np.ndarray, qpos: Sequence[np.ndarray], qvel: Sequence[np.ndarray] | None = None
    ) -> None:
        """Puts simulations `ids` at rest, or at `qvel`, in the given generalised positions."""

    def step(self, joint_targets: Tensor, ids: Sequence[int] | np.ndarray | None = None) -> None:
        """Advances simulations `ids` (default: all) by one control step with (N, 28) servo targets in radians."""

    def state(self) -> PhysicsState:
        """The state after the last `step` or `reset`."""

    def model(self, env: int) -> mujoco.MjModel:
        """The scene of one simulation, to render it or to check it against plain MuJoCo."""

    def data(self, env: int, data: mujoco.MjData | None = None) -> mujoco.MjData:
        """The state of one simulation with its kinematics computed."""
