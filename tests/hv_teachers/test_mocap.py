"""Motion capture in Isaac Lab's format: synthetic clips, and the wheel's own where it is at hand."""

import io
import os
import zipfile
from pathlib import Path

import mujoco
import numpy as np
import pytest
from plain_ground import ground_model
from scipy.spatial.transform import Rotation

from hv_sim.humanoid import BODY_NAMES, JOINT_NAMES
from hv_teachers.mocap import BALL_JOINTS, hinge_angles, load_motion, motion_clips, wheel_motions
from hv_teachers.style import FRAME_DIM

WHEEL = Path(os.environ.get("HV_ISAACLAB_WHEEL", "isaaclab.whl"))


def forward(model, position, quat, joints):
    """Positions (15, 3) and quaternions (15, 4) of the links by MuJoCo's kinematics."""
    data = mujoco.MjData(model)
    data.qpos[:3], data.qpos[3:7], data.qpos[7:35] = position, quat, joints
    mujoco.mj_kinematics(model, data)
    return data.xpos[1:16].copy(), data.xquat[1:16].copy()


def write_clip(target, frames=60, **changes):
    """A swaying robot at 60 frames a second; its hinges stay clear of a quarter turn except the shoulders."""
    model = ground_model()
    t = np.arange(frames) / 60.0
    rng = np.random.default_rng(0)
    joints = 0.4 * np.sin(2 * np.pi * t[:, None] * rng.uniform(0.3, 1.0, 28) + rng.uniform(0, 6, 28))
    joints[:, 7] = -1.0 - 1.2 * np.sin(np.pi * t)  # right shoulder y swings through a quarter turn
    position = np.stack([0.8 * t, 0.1 * np.sin(t), 0.85 + 0 * t], -1)
    quat = Rotation.from_euler("z", 0.5 * t[:, None]).as_quat(scalar_first=True)
    links = [forward(model, *row) for row in zip(position, quat, joints, strict=True)]
    exponential = joints.copy()
    for first in BALL_JOINTS.values():
        here = slice(first, first + 3)
        exponential[:, here] = Rotation.from_euler("XYZ", joints[:, here]).as_rotvec()
    arrays = {
        "fps": np.array(60),
        "dof_names": np.array(JOINT_NAMES),
        "body_names": np.array(BODY_NAMES),
        "dof_positions": exponential.astype(np.float32),
        "body_positions": np.stack([p for p, _ in links]).astype(np.float32),
        "body_rotations": np.stack([q for _, q in links]).astype(np.float32),
    }
    np.savez(target, **(arrays | changes))
    return joints[::2]


def check_against_own_positions(motion):
    model = ground_model()
    for t in range(0, len(motion.joint_pos), 3):
        quat = Rotation.from_matrix(motion.link_rot_w[t, 0]).as_quat(scalar_first=True)
        positions, _ = forward(model, motion.link_pos_w[t, 0], quat, motion.joint_pos[t])
        np.testing.assert_allclose(positions, motion.link_pos_w[t], atol=3e-4)


def test_exponential_maps_become_hinges(tmp_path):
    joints = write_clip(tmp_path / "sway.npz")
    motion = load_motion(tmp_path / "sway.npz")
    assert len(motion.joint_pos) == 30
    check_against_own_positions(motion)
    np.testing.assert_allclose(motion.joint_pos, joints, atol=2e-3)
    assert np.abs(motion.joint_vel).max() < 12  # no jump from one triple of angles to the other
    # walks at .8 m/s and turns at .5 rad/s
    np.testing.assert_allclose(motion.link_lin_vel_w[5:-5, 0, 0], 0.8, atol=1e-3)
    np.testing.assert_allclose(motion.link_ang_vel_w[5:-5, 0, 2], 0.5, atol=1e-3)


def test_hinges_take_the_nearer_triple():
    angles = np.zeros((40, 28))
    angles[:, 7] = np.linspace(-0.5, -2.6, 40)  # past a quarter turn, where the usual Euler angles jump
    exponential = angles.copy()
    exponential[:, 6:9] = Rotation.from_euler("XYZ", angles[:, 6:9]).as_rotvec()
    np.testing.assert_allclose(hinge_angles(exponential), angles, atol=1e-6)


def test_clips_have_an_object_that_stands_still(tmp_path):
    write_clip(tmp_path / "sway.npz")
    motion = motion_clips([load_motion(tmp_path / "sway.npz")], seed=3)
    assert motion.frames.shape == (30, FRAME_DIM)
    distance = motion.frames[:, -3:-1].norm(dim=-1)
    assert 0.9 < float(distance[0]) < 4.1


def test_a_wheel_is_read_without_unpacking(tmp_path):
    inner = io.BytesIO()
    write_clip(inner, frames=20)
    with zipfile.ZipFile(tmp_path / "x.whl", "w") as archive:
        archive.writestr("isaaclab_tasks/motions/humanoid_sway.npz", inner.getvalue())
        archive.writestr("isaaclab_tasks/motions/other.npz", b"")
    assert list(wheel_motions(tmp_path / "x.whl")) == ["humanoid_sway"]
    with zipfile.ZipFile(tmp_path / "y.whl", "w") as archive:
        archive.writestr("nothing", b"")
    with pytest.raises(ValueError, match=r"holds no humanoid_\*\.npz"):
        wheel_motions(tmp_path / "y.whl")


def test_bad_files_are_named(tmp_path):
    write_clip(tmp_path / "a.npz", fps=np.array(50))
    with pytest.raises(ValueError, match=r"60 frames at 50 a second; valid: a multiple of 30"):
        load_motion(tmp_path / "a.npz")
    write_clip(tmp_path / "b.npz", dof_names=np.array(JOINT_NAMES[::-1]))
    with pytest.raises(ValueError, match=r"dof_names is .*; valid:"):
        load_motion(tmp_path / "b.npz")
    np.savez(tmp_path / "c.npz", fps=np.array(60))
    with pytest.raises(ValueError, match="are missing; a motion has"):
        load_motion(tmp_path / "c.npz")
    np.savez(tmp_path / "d.npz", fps=np.array([{}], dtype=object))
    with pytest.raises(ValueError, match="cannot be read as a motion"):
        load_motion(tmp_path / "d.npz")


@pytest.mark.skipif(not WHEEL.is_file(), reason="set HV_ISAACLAB_WHEEL to the file of pip download isaaclab==3.0.0")
def test_the_wheels_own_clips():
    motions = wheel_motions(WHEEL)
    assert set(motions) == {"humanoid_walk", "humanoid_run", "humanoid_dance"}
    for motion in motions.values():
        check_against_own_positions(motion)
