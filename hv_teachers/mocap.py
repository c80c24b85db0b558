"""Motion capture for the style reward: clips in the format of Isaac Lab's humanoid AMP task.

Isaac Lab's wheel holds `humanoid_walk`, `humanoid_run` and `humanoid_dance` (`pip download --no-deps isaaclab==3.0.0`);
they show this very humanoid, but its three-axis joints as exponential maps (rotation vectors). Ours are three hinges in
a row, x then y then z, so the angles are converted.
"""

from __future__ import annotations

import io
import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from scipy.spatial.transform import Rotation

from hv_sim.humanoid import BODY_NAMES, CONTROL_HZ, JOINT_NAMES, NUM_BODIES, NUM_JOINTS
from hv_sim.physics import PhysicsState
from hv_teachers.style import MotionSet, style_frame

BALL_JOINTS = {"abdomen": 0, "neck": 3, "right_shoulder": 6, "left_shoulder": 10,
               "right_hip": 14, "right_ankle": 18, "left_hip": 21, "left_ankle": 25}  # fmt: skip
"""Joints of three hinges, and the first of them in `hv_sim.humanoid.JOINT_NAMES`."""

_MAX_BYTES = 50_000_000


@dataclass(frozen=True)
class Motion:
    """A clip of T frames at the control rate, world frame; float64."""

    joint_pos: np.ndarray  # (T, 28) rad, our hinges
    joint_vel: np.ndarray  # (T, 28) rad/s
    link_pos_w: np.ndarray  # (T, 15, 3) m
    link_rot_w: np.ndarray  # (T, 15, 3, 3)
    link_lin_vel_w: np.ndarray  # (T, 15, 3) m/s
    link_ang_vel_w: np.ndarray  # (T, 15, 3) rad/s

    def state(self) -> PhysicsState:
        """The clip as a batch of T robots with one absent object."""
        t = len(self.joint_pos)

        def tensor(array: np.ndarray) -> torch.Tensor:
            return torch.as_tensor(array, dtype=torch.float32)

        nothing = torch.zeros(t, 1, 3)
        return PhysicsState(
            link_pos_w=tensor(self.link_pos_w),
            link_rot_w=tensor(self.link_rot_w),
            link_lin_vel_w=tensor(self.link_lin_vel_w),
            link_ang_vel_w=tensor(self.link_ang_vel_w),
            joint_pos=tensor(self.joint_pos),
            joint_vel=tensor(self.joint_vel),
            object_pos_w=nothing,
            object_rot_w=torch.zeros(t, 1, 3, 3),
            object_lin_vel_w=nothing,
            object_ang_vel_w=nothing,
            body_contact=torch.zeros(t, NUM_BODIES, dtype=torch.bool),
            body_contact_height_m=torch.zeros(t, NUM_BODIES),
        )


def load_motion(source: Path | io.BytesIO, name: str | None = None) -> Motion:
    """Reads a clip of Isaac Lab's format, at 30 frames a second.

    Args:
        source: the .npz file.
        name: what errors call it (default: its path).

    Raises:
        ValueError: a field is missing or has another shape, the skeleton is another one, or the clip's frame rate is
            not a multiple of 30.
    """
    name = str(source) if name is None else name
    try:
        with np.load(source, allow_pickle=False) as file:
            data = {key: file[key] for key in file.files}
    except (OSError, ValueError, zipfile.BadZipFile) as error:
        raise ValueError(f"{name}: cannot be read as a motion: {error}") from None
    wanted = ("fps", "dof_names", "body_names", "dof_positions", "body_positions", "body_rotations")
    missing = [key for key in wanted if key not in data]
    if missing:
        raise ValueError(f"{name}: {missing} are missing; a motion has {list(wanted)}")
    for key, ours in (("dof_names", JOINT_NAMES), ("body_names", BODY_NAMES)):
        if tuple(data[key].tolist()) != ours:
            raise ValueError(f"{name}: {key} is {data[key].tolist()}; valid: {list(ours)}")
    t = len(data["dof_positions"])
    shapes = {
        "dof_positions": (t, NUM_JOINTS),
        "body_positions": (t, NUM_BODIES, 3),
        "body_rotations": (t, NUM_BODIES, 4),
    }
    for key, shape in shapes.items():
        if data[key].shape != shape or not np.isfinite(data[key]).all():
            raise ValueError(f"{name}: {key} has shape {data[key].shape} or is not finite; valid: {shape}")
    fps = int(data["fps"])
    if fps <= 0 or fps % CONTROL_HZ or t < 3 * (fps // CONTROL_HZ):
        raise ValueError(f"{name}: {t} frames at {fps} a second; valid: a multiple of {CONTROL_HZ}, at least .1 s")
    every = fps // CONTROL_HZ
    position = data["body_positions"][::every].astype(np.float64)
    rotation = Rotation.from_quat(data["body_rotations"][::every].reshape(-1, 4), scalar_first=True)
    matrices = rotation.as_matrix().reshape(len(position), NUM_BODIES, 3, 3)
    joints = hinge_angles(data["dof_positions"][::every].astype(np.float64))
    return Motion(
        joint_pos=joints,
        joint_vel=np.gradient(joints, 1.0 / CONTROL_HZ, axis=0),
        link_pos_w=position,
        link_rot_w=matrices,
        link_lin_vel_w=np.gradient(position, 1.0 / CONTROL_HZ, axis=0),
        link_ang_vel_w=_angular_velocity(matrices),
    )


def wheel_motions(wheel: Path) -> dict[str, Motion]:
    """The humanoid clips inside an isaaclab wheel, by name (`humanoid_walk`, ...); nothing is unpacked or imported.

    Raises:
        ValueError: the file is no wheel, or holds no such clip.
    """
    try:
        with zipfile.ZipFile(wheel) as archive:
            members = [m for m in archive.infolist() if Path(m.filename).name.startswith("humanoid_")]
            members = [m for m in members if m.filename.endswith(".npz") and m.file_size < _MAX_BYTES]
            motions = {Path(m.filename).stem: load_motion(io.BytesIO(archive.read(m)), m.filename) for m in members}
    except (OSError, zipfile.BadZipFile) as error:
        raise ValueError(f"{wheel}: cannot be read as a wheel: {error}") from None
    if not motions:
        raise ValueError(f"{wheel}: holds no humanoid_*.npz; valid: an isaaclab wheel")
    return motions


def hinge_angles(exponential_map: np.ndarray) -> np.ndarray:
    """(T, 28) joint angles with three-axis joints as rotation vectors -> (T, 28) angles of hinges x, y, z in a row.

    Of the two triples that give a rotation the one nearer to the frame before is taken (for the first frame: to zero).
    """
    angles = np.array(exponential_map, dtype=np.float64)
    for first in BALL_JOINTS.values():
        here = slice(first, first + 3)
        direct = Rotation.from_rotvec(exponential_map[:, here]).as_euler("XYZ")
        other = np.stack([direct[:, 0] + np.pi, np.pi - direct[:, 1], direct[:, 2] + np.pi], -1)
        before = np.zeros(3)
        for t, candidates in enumerate(zip(direct, other, strict=True)):
            near = [before + (c - before + np.pi) % (2 * np.pi) - np.pi for c in candidates]
            before = min(near, key=lambda c: float(np.abs(c - before).sum()))
            angles[t, here] = before
    return angles


def motion_clips(motions: list[Motion], *, seed: int) -> MotionSet:
    """Clips for the discriminator; as mocap shows no object, one stands somewhere 1 to 4 m from where a clip begins."""
    rng = np.random.default_rng(seed)
    clips = []
    for motion in motions:
        angle, distance = rng.uniform(-np.pi, np.pi), rng.uniform(1.0, 4.0)
        away = distance * np.array([np.cos(angle), np.sin(angle)])
        place = np.array([*(motion.link_pos_w[0, 0, :2] + away), rng.uniform(0.1, 1.0)])
        state = motion.state()
        clips.append(style_frame(state, torch.as_tensor(place, dtype=torch.float32).expand(len(motion.joint_pos), 3)))
    return MotionSet.of(clips)


def _angular_velocity(rotation: np.ndarray) -> np.ndarray:
    """(T, B, 3, 3) -> (T, B, 3) rad/s, world frame, by central differences."""
    first, last = (
        np.maximum(np.arange(len(rotation)) - 1, 0),
        np.minimum(np.arange(len(rotation)) + 1, len(rotation) - 1),
    )
    turned = rotation[last] @ rotation[first].swapaxes(-1, -2)
    vector = Rotation.from_matrix(turned.reshape(-1, 3, 3)).as_rotvec().reshape(*rotation.shape[:2], 3)
    return vector * (CONTROL_HZ / (last - first))[:, None, None]
