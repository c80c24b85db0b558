"""Style features against plain MuJoCo; windows and motion sets against lists."""

import mujoco
import numpy as np
import pytest
import torch
from plain_ground import ground_model, random_state

from hv_sim.mujoco_physics import MujocoPhysics
from hv_teachers.style import FRAME_DIM, WINDOW_FRAMES, MotionSet, StyleHistory, style_frame


def slow_frame(model, qpos, qvel) -> np.ndarray:
    """Table 12 from one MjData: hinge by hinge, velocities by mj_objectVelocity."""
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = qpos, qvel
    mujoco.mj_forward(model, data)
    forward = data.xmat[1].reshape(3, 3)[:, 0]
    yaw = np.arctan2(forward[1], forward[0])
    c, s = np.cos(yaw), np.sin(yaw)
    to_heading = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]])
    velocity = np.zeros(6)
    mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, 1, velocity, 0)
    parts = [data.xpos[1][2:], to_heading @ velocity[3:], to_heading @ velocity[:3]]
    parts.append((to_heading @ data.xmat[1].reshape(3, 3))[:, :2].T.ravel())
    for body in range(2, 16):
        joints = [j for j in range(model.njnt) if model.jnt_bodyid[j] == body]
        if not joints:
            continue  # a hand
        quat = np.array([1.0, 0, 0, 0])
        for j in joints:
            turn, product = np.zeros(4), np.zeros(4)
            mujoco.mju_axisAngle2Quat(turn, model.jnt_axis[j], data.qpos[model.jnt_qposadr[j]])
            mujoco.mju_mulQuat(product, quat, turn)
            quat = product
        matrix = np.zeros(9)
        mujoco.mju_quat2Mat(matrix, quat)
        parts.append(matrix.reshape(3, 3)[:, :2].T.ravel())
    parts.append(data.qvel[6:34])
    for name in ("right_hand", "left_hand", "right_foot", "left_foot", "head"):
        parts.append(to_heading @ (data.body(name).xpos - data.xpos[1]))
    parts.append(to_heading @ (data.xpos[16] - data.xpos[1]))
    return np.concatenate(parts)


def test_frames_are_table_12():
    model = ground_model(1)
    rng = np.random.default_rng(0)
    states = [random_state(model, rng) for _ in range(12)]
    physics = MujocoPhysics([model] * 12, num_threads=1)
    physics.reset(range(12), [q for q, _ in states], [v for _, v in states])
    state = physics.state()
    frames = style_frame(state, state.object_pos_w[:, 0])
    assert frames.shape == (12, FRAME_DIM) == (12, 131)
    slow = np.stack([slow_frame(model, q, v) for q, v in states])
    np.testing.assert_allclose(frames.numpy(), slow, atol=2e-4)


def test_history_is_the_last_ten_frames():
    history = StyleHistory(2)
    trails = [[], []]
    for step in range(25):
        if step == 13:
            history.reset(torch.tensor([1]))
            trails[1] = []
        frame = torch.randn(2, FRAME_DIM)
        windows = history.add(frame)
        for i in range(2):
            trails[i].append(frame[i])
            wanted = [trails[i][max(0, k)] for k in range(len(trails[i]) - WINDOW_FRAMES, len(trails[i]))]
            torch.testing.assert_close(windows[i], torch.cat(wanted))


def test_windows_stay_within_a_clip(tmp_path):
    # every number of a frame says its clip and its time
    clips = [torch.arange(t)[:, None].expand(t, FRAME_DIM) + 1000.0 * i for i, t in enumerate((30, 4, 12))]
    motion = MotionSet.of(clips)
    assert len(motion.starts) == 21 + 3
    motion.save(tmp_path / "m.safetensors")
    windows = MotionSet.load(tmp_path / "m.safetensors").sample(500).view(500, WINDOW_FRAMES, FRAME_DIM)[..., 0]
    assert (windows.diff(dim=1) == 1).all()
    assert set((windows[:, 0] // 1000).tolist()) == {0.0, 2.0}
    joined = motion.joined(MotionSet.of([clips[0] + 5000]))
    windows = joined.sample(500).view(500, WINDOW_FRAMES, FRAME_DIM)[..., 0]
    assert (windows.diff(dim=1) == 1).all()
    assert windows.max() > 5000


def test_bad_clips_are_refused(tmp_path):
    with pytest.raises(ValueError, match="none of 1 has 10 frames"):
        MotionSet.of([torch.zeros(9, FRAME_DIM)])
    with pytest.raises(ValueError, match=r"shape \(20, 5\) is not valid; valid: \(frames, 131\)"):
        MotionSet.of([torch.zeros(20, 5)])
    (tmp_path / "no.safetensors").write_bytes(b"nothing")
    with pytest.raises(ValueError, match="cannot be read"):
        MotionSet.load(tmp_path / "no.safetensors")
