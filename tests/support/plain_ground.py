"""Plain MuJoCo scenes for tests: the humanoid, a floor and, if wanted, loose boxes beside it."""

import mujoco
import numpy as np
import torch

from hv_sim.humanoid import (
    ALL_CONAFFINITY,
    ENVIRONMENT_CONTYPE,
    JOINT_RANGE_RAD,
    ROBOT_NQ,
    ROBOT_NV,
    add_humanoid,
    configure_physics,
    standing_qpos,
)
from hv_sim.mujoco_physics import MujocoPhysics
from hv_sim.observations import proprioception


def ground_model(num_boxes: int = 0, *, physics_hz: int = 120, box_xy_m: tuple[float, float] = (1.5, 0.0)):
    """Compiled: robot, floor, and boxes of .2 m and 1 kg in a row along y that begins at `box_xy_m`."""
    spec = mujoco.MjSpec()
    add_humanoid(spec)
    floor = spec.worldbody.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[20, 20, 1])
    floor.contype, floor.conaffinity = ENVIRONMENT_CONTYPE, ALL_CONAFFINITY
    for k in range(num_boxes):
        body = spec.worldbody.add_body(name=f"box_{k}", pos=[box_xy_m[0], box_xy_m[1] + 0.5 * k, 0.1])
        body.add_freejoint()
        geom = body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.1, 0.1, 0.1], mass=1.0)
        geom.contype, geom.conaffinity, geom.condim = ENVIRONMENT_CONTYPE, ALL_CONAFFINITY, 4
    configure_physics(spec, physics_hz)
    return spec.compile()


def random_state(
    model: mujoco.MjModel, rng: np.random.Generator, *, tilt_rad: float = 0.6, speed: float = 1.0
) -> tuple[np.ndarray, np.ndarray]:
    """A robot above the floor with any yaw, a bounded tilt, and joints anywhere within their limits; qpos and qvel."""
    qpos = model.qpos0.copy()
    qpos[:3] = rng.uniform([-2, -2, 1.5], [2, 2, 2.0])
    yaw, axis = rng.uniform(-np.pi, np.pi), rng.normal(size=3)
    axis[2] = 0
    tilt, turn = np.zeros(4), np.array([np.cos(yaw / 2), 0, 0, np.sin(yaw / 2)])
    mujoco.mju_axisAngle2Quat(tilt, axis / np.linalg.norm(axis), rng.uniform(0, tilt_rad))
    mujoco.mju_mulQuat(qpos[3:7], turn, tilt)
    qpos[7:ROBOT_NQ] = rng.uniform(JOINT_RANGE_RAD[:, 0], JOINT_RANGE_RAD[:, 1])
    qvel = np.zeros(model.nv)
    qvel[:ROBOT_NV] = speed * rng.normal(size=ROBOT_NV)
    return qpos, qvel


def random_poses(num: int, seed: int, spread: float = 0.5) -> np.ndarray:
    """(num, 35): joints anywhere within a share of their ranges, the root tilted a little."""
    rng = np.random.default_rng(seed)
    qpos = np.tile(standing_qpos((0.0, 0.0), 0.0), (num, 1))
    qpos[:, 7:] = spread * rng.uniform(JOINT_RANGE_RAD[:, 0], JOINT_RANGE_RAD[:, 1], (num, 28))
    turn = rng.normal(0, 0.15, (num, 4)) + np.array([1, 0, 0, 0])
    qpos[:, 3:7] = turn / np.linalg.norm(turn, axis=1, keepdims=True)
    return qpos


def play(controller, intents, num: int, steps: int) -> tuple[MujocoPhysics, torch.Tensor]:
    """Runs `controller` on `num` standing robots; `intents(step)` gives (num, 14). Returns physics and (num,)
    lowest pelvis."""
    physics = MujocoPhysics([ground_model()] * num, num_threads=1)
    physics.reset(range(num), [standing_qpos((0.0, 0.0), 0.3 * i) for i in range(num)])
    lowest = torch.full((num,), 9.0)
    for step in range(steps):
        physics.step(controller(proprioception(physics.state()), intents(step)))
        lowest = torch.minimum(lowest, physics.state().link_pos_w[:, 0, 2])
    return physics, lowest
