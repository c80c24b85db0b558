"""The interface between the world and a physics engine: many simulations of different scenes, stepped together."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import mujoco
import numpy as np
import torch
from torch import Tensor

from hv_sim.humanoid import BODY_NAMES, NUM_BODIES, ROBOT_NQ, ROBOT_NV


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
    """Many independent simulations, one scene each, that share nothing but the clock.

    Every backend takes one compiled scene per simulation: robot first (`hv_sim.humanoid.add_humanoid`), then one free
    body per object.
    """

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


def substeps_of(models: Sequence[mujoco.MjModel], control_hz: int) -> int:
    """Physics steps in a control step, after a check that the models can be stepped together.

    Raises:
        ValueError: there is no model, one does not begin with the humanoid, its time step does not divide the control
            step, or the time steps differ.
    """
    if not models:
        raise ValueError("models: empty; at least one scene is needed")
    substeps = set()
    for i, model in enumerate(models):
        if model.nq < ROBOT_NQ or model.nbody <= NUM_BODIES or model.body(1).name != BODY_NAMES[0]:
            bodies = f"{BODY_NAMES[0]}..{BODY_NAMES[-1]}"
            raise ValueError(f"models[{i}]: does not begin with the humanoid's bodies {bodies}")
        exact = 1.0 / (control_hz * model.opt.timestep)
        if abs(exact - round(exact)) > 1e-6 or round(exact) < 1:
            raise ValueError(f"models[{i}].opt.timestep: {model.opt.timestep} does not divide 1/{control_hz} s")
        substeps.add(round(exact))
    if len(substeps) > 1:
        raise ValueError(f"models: physics rates differ within one batch: {sorted(substeps)} steps per control step")
    return substeps.pop()


def objects_in(model: mujoco.MjModel) -> int:
    """K, how many movable objects a scene has."""
    return (model.nq - ROBOT_NQ) // 7


def contact_addresses(model: mujoco.MjModel) -> np.ndarray:
    """(15,) where in `sensordata` each body's contact sensor begins."""
    return np.array([model.sensor(f"contact_{b}").adr[0] for b in BODY_NAMES])


def layout_of(model: mujoco.MjModel) -> tuple[int, ...]:
    """What fixes the layout of a model's mjData: its sizes."""
    names = "nq nv nu na nbody njnt ngeom nsite ncam nlight nsensordata nmocap nbvh"
    return tuple(int(getattr(model, name)) for name in names.split())


def state_of(
    groups: Iterable[tuple[np.ndarray, Mapping[str, np.ndarray], np.ndarray]], num_envs: int, num_objects: int
) -> PhysicsState:
    """The state of simulations from MuJoCo's arrays at the velocity stage.

    Args:
        groups: of simulations of one layout: their numbers (n,); `qpos`, `qvel`, `xpos`, `xmat` (any shape of 9 numbers
            a body), `cvel`, `subtree_com`, `sensordata`, a row per simulation; and their `contact_addresses`.
        num_envs: simulations in all groups together.
        num_objects: rows for objects, at least as many as any layout has.
    """

    def empty(*shape: int) -> np.ndarray:
        return np.zeros((num_envs, *shape), dtype=np.float32)

    links = {"pos": empty(NUM_BODIES, 3), "rot": empty(NUM_BODIES, 3, 3)}
    links |= {"lin_vel": empty(NUM_BODIES, 3), "ang_vel": empty(NUM_BODIES, 3)}
    objects = {name: empty(num_objects, *array.shape[2:]) for name, array in links.items()}
    joint_pos, joint_vel = empty(ROBOT_NQ - 7), empty(ROBOT_NV - 6)
    contact, height = np.zeros((num_envs, NUM_BODIES), dtype=bool), empty(NUM_BODIES)
    for ids, view, address in groups:
        n, k = len(ids), (view["qpos"].shape[1] - ROBOT_NQ) // 7
        first = 1 + NUM_BODIES
        robot_com = np.broadcast_to(view["subtree_com"][:, 1:2], (n, NUM_BODIES, 3))
        parts = (
            (links, slice(1, first), robot_com, slice(None)),
            (objects, slice(first, first + k), view["subtree_com"][:, first : first + k], slice(0, k)),
        )
        for out, bodies, com, rows in parts:
            position, spatial = view["xpos"][:, bodies], view["cvel"][:, bodies]
            angular = spatial[..., :3]
            out["pos"][ids, rows] = position
            out["rot"][ids, rows] = view["xmat"][:, bodies].reshape(n, -1, 3, 3)
            out["ang_vel"][ids, rows] = angular
            # cvel is the velocity of the point at the root's centre of mass, rotation first (MuJoCo, "mjData.cvel")
            lever, linear = position - com, spatial[..., 3:].copy()
            for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):  # np.cross takes three times as long
                linear[..., a] += angular[..., b] * lever[..., c] - angular[..., c] * lever[..., b]
            out["lin_vel"][ids, rows] = linear
        joint_pos[ids], joint_vel[ids] = view["qpos"][:, 7:ROBOT_NQ], view["qvel"][:, 6:ROBOT_NV]
        found = view["sensordata"][:, address] > 0
        contact[ids], height[ids] = found, np.where(found, view["sensordata"][:, address + 3], 0.0)
    return PhysicsState(
        **{f"link_{name}_w": torch.from_numpy(array) for name, array in links.items()},
        joint_pos=torch.from_numpy(joint_pos),
        joint_vel=torch.from_numpy(joint_vel),
        **{f"object_{name}_w": torch.from_numpy(array) for name, array in objects.items()},
        body_contact=torch.from_numpy(contact),
        body_contact_height_m=torch.from_numpy(height),
    )
