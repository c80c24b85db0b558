"""What a policy may know: proprioception (223), object (15), goal (9) and waypoint (3), all in the heading frame.

The heading frame turns with the yaw of the root (pelvis): x forward, y left, z up. Positions are relative to the
root, velocities are absolute and only rotated. A rotation is six numbers: the first two columns of its matrix, one
after the other (Tables 9 to 11 of the paper; HumanVLA, NeurIPS 2024).
"""

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np
import torch
from torch import Tensor

from hv_sim.humanoid import NUM_BODIES
from hv_sim.physics import PhysicsState

_GROUPS = (
    ("root_height", 1),
    ("link_positions", 3 * (NUM_BODIES - 1)),
    ("link_rotations", 6 * NUM_BODIES),
    ("link_linear_velocities", 3 * NUM_BODIES),
    ("link_angular_velocities", 3 * NUM_BODIES),
)


def _slices() -> dict[str, slice]:
    slices, start = {}, 0
    for name, size in _GROUPS:
        slices[name] = slice(start, start + size)
        start += size
    return slices


PROPRIOCEPTION_SLICES = _slices()
"""Where each group lies in the proprioception vector. Links are in `hv_sim.humanoid.BODY_NAMES` order (positions
without the root, which is their origin)."""
PROPRIOCEPTION_DIM = sum(size for _, size in _GROUPS)
OBJECT_DIM, GOAL_DIM, WAYPOINT_DIM = 15, 9, 3
BPS_POINTS = 200


@dataclass
class Observation:
    """Everything the privileged policies see, for every environment; float32."""

    proprioception: Tensor  # (N, 223)
    object: Tensor  # (N, 15) position, rotation, linear and angular velocity of the current sub-task's object
    goal: Tensor  # (N, 9) position and rotation of its goal
    waypoint: Tensor  # (N, 3) where to walk next
    bps: Tensor  # (N, 200, 3) geometry of the object, scaled to the unit ball
    half_extents: Tensor  # (N, 3) of the object's bounding box, m


@dataclass
class Heading:
    """The heading frame of every environment: origin and the cosine and sine of its yaw in the world."""

    origin_w: Tensor  # (N, 3)
    cos: Tensor  # (N,)
    sin: Tensor  # (N,)

    @staticmethod
    def of(state: PhysicsState) -> Heading:
        """The heading frame of the root: yaw is atan2(R[1, 0], R[0, 0]), and 0 where its x-axis is vertical."""
        x, y = state.link_rot_w[:, 0, 0, 0], state.link_rot_w[:, 0, 1, 0]
        norm = torch.sqrt(x * x + y * y)
        upright = norm > 1e-6
        return Heading(
            origin_w=state.link_pos_w[:, 0],
            cos=torch.where(upright, x / norm, torch.ones_like(x)),
            sin=torch.where(upright, y / norm, torch.zeros_like(y)),
        )

    def rotate(self, vector_w: Tensor) -> Tensor:
        """World vectors (N, ..., 3) in the heading frame.

        Written out by component: it is the fastest way, and each environment's result does not depend on its company.
        """
        shape = (-1,) + (1,) * (vector_w.ndim - 2)
        c, s = self.cos.view(shape), self.sin.view(shape)
        x, y, z = vector_w.unbind(-1)
        return torch.stack([c * x + s * y, c * y - s * x, z], dim=-1)

    def rotate_6d(self, rotation_w: Tensor) -> Tensor:
        """World rotation matrices (N, ..., 3, 3) in the heading frame, as (N, ..., 6)."""
        shape = (-1,) + (1,) * (rotation_w.ndim - 2)
        c, s = self.cos.view(shape), self.sin.view(shape)
        x, y, z = rotation_w[..., :2].unbind(-2)  # rows of the matrix, first two columns: (N, ..., 2)
        columns = torch.stack([c * x + s * y, c * y - s * x, z], dim=-1)  # (N, ..., 2, 3)
        return columns.flatten(-2)

    def relative(self, position_w: Tensor) -> Tensor:
        """World points (N, ..., 3) relative to the root, in the heading frame."""
        origin = self.origin_w.view(-1, *(1,) * (position_w.ndim - 2), 3)
        return self.rotate(position_w - origin)


def rotation_6d(rotation: Tensor) -> Tensor:
    """Rotation matrices (..., 3, 3) as (..., 6): the first two columns, one after the other."""
    return rotation[..., :2].transpose(-1, -2).flatten(-2)


def proprioception(state: PhysicsState, heading: Heading | None = None) -> Tensor:
    """(N, 223) root height above the floor, link positions, rotations, linear and angular velocities (Table 9)."""
    heading = Heading.of(state) if heading is None else heading
    seen = torch.empty(len(state.link_pos_w), PROPRIOCEPTION_DIM)
    links = state.link_pos_w, state.link_rot_w, state.link_lin_vel_w, state.link_ang_vel_w
    _fill_proprioception(seen.numpy(), *(x.contiguous().numpy() for x in (*links, heading.cos, heading.sin)))
    return seen


@numba.njit(cache=True)
def _fill_proprioception(
    out: np.ndarray,
    pos: np.ndarray,
    rot: np.ndarray,
    lin_vel: np.ndarray,
    ang_vel: np.ndarray,
    cos: np.ndarray,
    sin: np.ndarray,
) -> None:
    """`proprioception` of links (N, 15, 3), (N, 15, 3, 3), robot by robot."""
    for i in range(len(out)):
        row, c, s = out[i], cos[i], sin[i]
        row[0] = pos[i, 0, 2]
        at = 1
        for k in range(1, NUM_BODIES):
            x, y, z = pos[i, k, 0] - pos[i, 0, 0], pos[i, k, 1] - pos[i, 0, 1], pos[i, k, 2] - pos[i, 0, 2]
            row[at], row[at + 1], row[at + 2] = c * x + s * y, c * y - s * x, z
            at += 3
        for k in range(NUM_BODIES):
            for column in range(2):
                x, y, z = rot[i, k, 0, column], rot[i, k, 1, column], rot[i, k, 2, column]
                row[at], row[at + 1], row[at + 2] = c * x + s * y, c * y - s * x, z
                at += 3
        for velocities in (lin_vel, ang_vel):
            for k in range(NUM_BODIES):
                x, y, z = velocities[i, k, 0], velocities[i, k, 1], velocities[i, k, 2]
                row[at], row[at + 1], row[at + 2] = c * x + s * y, c * y - s * x, z
                at += 3


def object_observation(state: PhysicsState, object_index: Tensor, heading: Heading | None = None) -> Tensor:
    """(N, 15) position, rotation, linear and angular velocity of object `object_index` (N,) int64 (Table 10)."""
    heading = Heading.of(state) if heading is None else heading
    rows = torch.arange(len(object_index), device=object_index.device)
    vectors = torch.stack(
        [
            state.object_pos_w[rows, object_index] - heading.origin_w,
            state.object_lin_vel_w[rows, object_index],
            state.object_ang_vel_w[rows, object_index],
        ],
        dim=1,
    )
    rotated = heading.rotate(vectors).flatten(1)
    rotation = heading.rotate_6d(state.object_rot_w[rows, object_index])
    return torch.cat([rotated[:, :3], rotation, rotated[:, 3:]], dim=1)


def goal_observation(goal_pos_w: Tensor, goal_rot_w: Tensor, heading: Heading) -> Tensor:
    """(N, 9) position and rotation of the goal pose, given in the world as (N, 3) and (N, 3, 3) (Table 11)."""
    return torch.cat([heading.relative(goal_pos_w), heading.rotate_6d(goal_rot_w)], dim=1)


def waypoint_observation(waypoint_w: Tensor, heading: Heading) -> Tensor:
    """(N, 3) the waypoint, given in the world as (N, 3), relative to the root in the heading frame (Table 11)."""
    return heading.relative(waypoint_w)
