"""Batched physics on the CPU: `mujoco.batch`, one batch for each layout of mjData among the scenes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import mujoco.batch
import numpy as np
import torch
from torch import Tensor

from hv_sim.humanoid import CONTROL_HZ, ROBOT_NQ
from hv_sim.physics import PhysicsState, contact_addresses, layout_of, objects_in, state_of, substeps_of

_VELOCITY_STAGE = int(mujoco.mjtStage.mjSTAGE_VEL)
_FIELDS = ("qpos", "qvel", "ctrl", "xpos", "xmat", "cvel", "subtree_com", "sensordata", "xfrc_applied")


@dataclass
class _Group:
    """The simulations of one mjData layout."""

    ids: np.ndarray
    batch: mujoco.batch.Batch
    models: list[mujoco.MjModel]
    contact_address: np.ndarray
    view: dict[str, np.ndarray]
    pushed: bool = False


class MujocoPhysics:
    """`PhysicsBackend` on `mujoco.batch`: results are bit-identical whatever the batch's company or thread count.

    Args:
        models: one compiled scene per simulation. The same model may appear many times. Scenes of different layout are
            stepped in separate batches.
        num_threads: 0 for one thread per core.

    Raises:
        ValueError: a model does not begin with the humanoid, or its time step does not divide the control step.
    """

    def __init__(self, models: Sequence[mujoco.MjModel], *, control_hz: int = CONTROL_HZ, num_threads: int = 0) -> None:
        self._substeps = substeps_of(models, control_hz)
        self.num_envs = len(models)
        self._control_hz = control_hz
        layouts: dict[tuple[int, ...], list[int]] = {}
        for i, model in enumerate(models):
            layouts.setdefault(layout_of(model), []).append(i)
        self._groups = [_make_group([models[i] for i in ids], np.array(ids), num_threads) for ids in layouts.values()]
        self._group_of = np.empty(self.num_envs, dtype=np.int64)
        self._row_of = np.empty(self.num_envs, dtype=np.int64)
        for g, group in enumerate(self._groups):
            self._group_of[group.ids] = g
            self._row_of[group.ids] = np.arange(len(group.ids))
        self.num_objects = max(objects_in(model) for model in models)

    def reset(
        self, ids: Sequence[int] | np.ndarray, qpos: Sequence[np.ndarray], qvel: Sequence[np.ndarray] | None = None
    ) -> None:
        order = np.asarray(ids, dtype=np.int64)
        for g, group in enumerate(self._groups):
            chosen = np.nonzero(self._group_of[order] == g)[0]
            if not len(chosen):
                continue
            rows = self._row_of[order[chosen]]
            group.batch.reset(rows, stage=int(mujoco.mjtStage.mjSTAGE_NONE))
            group.view["qpos"][rows] = np.stack([qpos[i] for i in chosen])
            if qvel is not None:
                group.view["qvel"][rows] = np.stack([qvel[i] for i in chosen])
            group.view["ctrl"][rows] = group.view["qpos"][rows, 7:ROBOT_NQ]
            group.batch.forward(rows)

    def step(self, joint_targets: Tensor, ids: Sequence[int] | np.ndarray | None = None) -> None:
        targets = joint_targets.detach().to("cpu", torch.float64).numpy()
        active = None
        if ids is not None:
            active = np.zeros(self.num_envs, dtype=bool)
            active[np.asarray(ids, dtype=np.int64)] = True
        for group in self._groups:
            rows = None if active is None else np.nonzero(active[group.ids])[0]
            if rows is not None and not len(rows):
                continue
            if rows is None:
                group.view["ctrl"][:] = targets[group.ids]
            else:
                group.view["ctrl"][rows] = targets[group.ids[rows]]
            group.batch.step(rows, nstep=self._substeps, stage=_VELOCITY_STAGE)
            if group.pushed:
                group.view["xfrc_applied"][:] = 0.0
                group.pushed = False

    def push(self, ids: Sequence[int] | np.ndarray, velocity_m_s: np.ndarray) -> None:
        """Adds (n, 3) world velocities to whole robots, as an impulse of velocity times their mass would."""
        for env, velocity in zip(ids, velocity_m_s, strict=True):
            self._groups[self._group_of[env]].view["qvel"][self._row_of[env], :3] += velocity

    def apply_impulse(self, ids: Sequence[int] | np.ndarray, link: int, impulse_n_s: np.ndarray) -> None:
        """Pushes one link with (n, 3) world impulses in N s, spread over the next control step.

        Args:
            ids: simulations, (n,).
            link: index into `hv_sim.humanoid.BODY_NAMES`.
        """
        for env, impulse in zip(ids, impulse_n_s, strict=True):
            group, row = self._groups[self._group_of[env]], self._row_of[env]
            group.view["xfrc_applied"][row, 1 + link, :3] = impulse * self._control_hz
            group.pushed = True

    def state(self) -> PhysicsState:
        groups = [(g.ids, g.view, g.contact_address) for g in self._groups]
        return state_of(groups, self.num_envs, self.num_objects)

    def model(self, env: int) -> mujoco.MjModel:
        return self._groups[self._group_of[env]].models[self._row_of[env]]

    def data(self, env: int, data: mujoco.MjData | None = None) -> mujoco.MjData:
        group, row = self._groups[self._group_of[env]], int(self._row_of[env])
        data = group.batch.get_data(row, data)
        mujoco.mj_kinematics(group.models[row], data)
        mujoco.mj_camlight(group.models[row], data)
        return data


def _make_group(models: list[mujoco.MjModel], ids: np.ndarray, num_threads: int) -> _Group:
    # persistent: the next step goes on from the velocity stage computed here instead of doing it again (+20 % measured)
    batch = mujoco.batch.Batch(models[0], len(models), nthread=num_threads, persistent=True)
    if any(m is not models[0] for m in models):
        batch.set_models(models)
    view = {name: batch.bind(name) for name in _FIELDS}
    return _Group(ids, batch, models, contact_addresses(models[0]), view)
