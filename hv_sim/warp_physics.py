"""Batched physics on NVIDIA GPUs, or slowly on the CPU: `mujoco_warp`, one batch for each kind of scene.

Simulations share a batch when everything that Warp does not keep for each world is the same: the sizes, the shapes'
kinds, what collides with what, meshes and textures. Sizes, masses, poses and colours may differ. So few tasks with many
worlds each are fast, and as many tasks as worlds are not.

Warp computes in 32 bits, and has no `noslip` iterations for the discrete integrator (see `warp_model`).
"""

from __future__ import annotations

import copy
import dataclasses
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import torch
from torch import Tensor

from hv_sim.humanoid import CONTROL_HZ, ROBOT_NQ
from hv_sim.physics import PhysicsState, contact_addresses, layout_of, objects_in, state_of, substeps_of

MAX_CONTACTS, MAX_CONSTRAINTS = 96, 512
"""Room for each world; a robot that stands among two objects takes about 16 and 80."""

_FIELDS = ("qpos", "qvel", "xpos", "xmat", "cvel", "subtree_com", "sensordata")
_STATE = (
    "time", "qpos", "qvel", "ctrl", "qacc_warmstart", "tree_asleep", "tree_awake", "body_awake", "body_awake_ind",
    "dof_awake_ind", "ntree_awake", "nbody_awake", "nv_awake",
)  # fmt: skip
"""What a simulation goes on from."""

_UNIMPORTANT = {"dof_length"}
"""Warp keeps it once; all it does is to scale the speed below which something may fall asleep."""


def require_warp() -> tuple[Any, Any]:
    """The modules `warp` and `mujoco_warp`.

    Raises:
        ValueError: they are not installed.
    """
    try:
        import warp

        warp.config.log_level = max(warp.config.log_level, warp.LOG_WARNING)  # not a line for every kernel
        import mujoco_warp
    except ImportError as error:
        raise ValueError(
            f"physics: 'warp' is not installed here ({error}); install it with: pip install 'lerobot_policy_hv[gpu]'"
        ) from None
    return warp, mujoco_warp


def warp_model(model: mujoco.MjModel) -> mujoco.MjModel:
    """The model as Warp can step it: a copy without `noslip` iterations, which Warp has for other integrators only."""
    able = copy.copy(model)
    able.opt.noslip_iterations = 0
    return able


@dataclass
class WarpGroup:
    """The simulations of one kind of scene.

    Attributes:
        ids: (n,) their numbers in the whole batch.
        models: n scenes as they were given.
        able: the first of them as Warp steps it.
        model: Warp's model, with a row per world of what differs.
        data: Warp's data.
        graph: one control step, recorded on a GPU.
    """

    ids: np.ndarray
    models: list[mujoco.MjModel]
    able: mujoco.MjModel
    model: Any
    data: Any
    contact_address: np.ndarray
    steps_made: int = 0
    graph: Any = None


class WarpPhysics:
    """`PhysicsBackend` on `mujoco_warp`.

    Args:
        models: one compiled scene per simulation.
        device: of Warp, such as `cuda:0` or `cpu` (default: the GPU if there is one).
        max_contacts: room for contacts of a world; what does not fit is left out, with a warning.
        max_constraints: room for constraint rows of a world.

    Raises:
        ValueError: Warp is not installed, a model does not begin with the humanoid, or its time step does not divide
            the control step.
    """

    def __init__(
        self,
        models: Sequence[mujoco.MjModel],
        *,
        control_hz: int = CONTROL_HZ,
        device: str | None = None,
        max_contacts: int = MAX_CONTACTS,
        max_constraints: int = MAX_CONSTRAINTS,
    ) -> None:
        self._wp, self._mjw = require_warp()
        self._substeps = substeps_of(models, control_hz)
        self.num_envs = len(models)
        self.num_objects = max(objects_in(model) for model in models)
        self.device = self._wp.get_device(device) if device else self._wp.get_preferred_device()
        self._warned = False
        with self._wp.ScopedDevice(self.device):
            self.groups = self._make_groups(models, max_contacts, max_constraints)
        self._group_of = np.empty(self.num_envs, dtype=np.int64)
        self._row_of = np.empty(self.num_envs, dtype=np.int64)
        for g, group in enumerate(self.groups):
            self._group_of[group.ids] = g
            self._row_of[group.ids] = np.arange(len(group.ids))

    def reset(
        self, ids: Sequence[int] | np.ndarray, qpos: Sequence[np.ndarray], qvel: Sequence[np.ndarray] | None = None
    ) -> None:
        order = np.asarray(ids, dtype=np.int64)
        for g, group in enumerate(self.groups):
            chosen = np.nonzero(self._group_of[order] == g)[0]
            if not len(chosen):
                continue
            rows = self._row_of[order[chosen]]
            data = group.data
            mask = np.zeros(len(group.ids), dtype=bool)
            mask[rows] = True
            with self._wp.ScopedDevice(self.device):
                self._mjw.reset_data(group.model, data, reset=self._wp.array(mask, dtype=bool))
                position = np.stack([qpos[i] for i in chosen])
                _put(data.qpos, rows, position)
                _put(data.ctrl, rows, position[:, 7:ROBOT_NQ])
                if qvel is not None:
                    _put(data.qvel, rows, np.stack([qvel[i] for i in chosen]))
                self._mjw.step1(group.model, data)

    def step(self, joint_targets: Tensor, ids: Sequence[int] | np.ndarray | None = None) -> None:
        targets = joint_targets.detach().to("cpu", torch.float32).numpy()
        active = np.ones(self.num_envs, dtype=bool)
        if ids is not None:
            active[:] = False
            active[np.asarray(ids, dtype=np.int64)] = True
        for group in self.groups:
            if not active[group.ids].any():
                continue
            still = np.nonzero(~active[group.ids])[0]
            data = group.data
            with self._wp.ScopedDevice(self.device):
                # Warp steps every world: those that shall stand still are put back
                before = {name: getattr(data, name).numpy()[still] for name in _STATE} if len(still) else {}
                data.ctrl.assign(targets[group.ids])
                self._advance(group)
                for name, rows in before.items():
                    _put(getattr(data, name), still, rows)
                if before:
                    self._mjw.step1(group.model, data)
            self._check_room(group)

    def state(self) -> PhysicsState:
        views = [{name: getattr(group.data, name).numpy() for name in _FIELDS} for group in self.groups]
        groups = [(g.ids, view, g.contact_address) for g, view in zip(self.groups, views, strict=True)]
        return state_of(groups, self.num_envs, self.num_objects)

    def model(self, env: int) -> mujoco.MjModel:
        return self.groups[self._group_of[env]].models[self._row_of[env]]

    def data(self, env: int, data: mujoco.MjData | None = None) -> mujoco.MjData:
        group, row = self.groups[self._group_of[env]], int(self._row_of[env])
        model = group.models[row]
        data = mujoco.MjData(model) if data is None else data
        data.time = float(group.data.time.numpy()[row])
        data.qpos[:], data.qvel[:] = group.data.qpos.numpy()[row], group.data.qvel.numpy()[row]
        data.ctrl[:] = group.data.ctrl.numpy()[row]
        mujoco.mj_kinematics(model, data)
        mujoco.mj_camlight(model, data)
        return data

    # inside

    def _make_groups(
        self, models: Sequence[mujoco.MjModel], max_contacts: int, max_constraints: int
    ) -> list[WarpGroup]:
        """Scenes of one kind together; a model that appears many times is converted once."""
        kinds: list[tuple[mujoco.MjModel, Any, list[int]]] = []
        converted: dict[int, Any] = {}
        kind_of: dict[int, int] = {}
        for i, model in enumerate(models):
            if id(model) not in converted:
                one = converted[id(model)] = self._mjw.put_model(warp_model(model))
                alike = (k for k, (first, theirs, _) in enumerate(kinds) if _same_kind(first, model, theirs, one))
                kind_of[id(model)] = next(alike, len(kinds))
                if kind_of[id(model)] == len(kinds):
                    kinds.append((model, self._mjw.put_model(warp_model(model)), []))
            kinds[kind_of[id(model)]][2].append(i)
        groups = []
        for first, warp, ids in kinds:
            able, members = warp_model(first), [models[i] for i in ids]
            _expand(warp, [converted[id(m)] for m in members])
            # stable order of contacts, constraints and sums: the same numbers run after run
            warp.opt.deterministic = int(self._mjw.DeterminismType.ALL)
            warp.opt.warn_overflow = 0
            data = self._mjw.make_data(able, len(ids), nconmax=max_contacts, njmax=max_constraints)
            _place_static_geoms(data, members)
            groups.append(WarpGroup(np.array(ids), members, able, warp, data, contact_addresses(first)))
        return groups

    def _advance(self, group: WarpGroup) -> None:
        """One control step; the kinematics are those at its end."""
        if self.device.is_cuda and group.steps_made == 1:  # every kernel is compiled by now
            with self._wp.ScopedCapture(self.device) as capture:
                self._substep(group)
            group.graph = capture.graph
        group.steps_made += 1
        if group.graph is None:
            self._substep(group)
        else:
            self._wp.capture_launch(group.graph)

    def _substep(self, group: WarpGroup) -> None:
        # never `forward`: for the discrete integrator it adds to what `step2` then adds to again
        for _ in range(self._substeps):
            self._mjw.step2(group.model, group.data)
            self._mjw.step1(group.model, group.data)

    def _check_room(self, group: WarpGroup) -> None:
        kinds = self._mjw.OverflowType
        room = kinds.NEFC | kinds.NJMAX_NNZ | kinds.BROADPHASE | kinds.NARROWPHASE | kinds.CCD | kinds.NVMAX
        if not self._warned and (group.data.overflow.numpy() & int(room)).any():
            self._warned = True
            warnings.warn("warp: a world had more contacts or constraints than max_contacts or max_constraints hold; "
                          "some were left out", stacklevel=3)  # fmt: skip


def batched_fields(warp: Any) -> list[dataclasses.Field]:
    """Fields of Warp's model that may have a row per world."""
    shapes = [(field, getattr(field.type, "shape", None)) for field in dataclasses.fields(warp)]
    return [field for field, shape in shapes if shape and shape[0] == "*"]


def _same_kind(first: mujoco.MjModel, model: mujoco.MjModel, theirs: Any, own: Any) -> bool:
    """Whether two scenes can be worlds of one batch."""
    if layout_of(first) != layout_of(model) or not np.array_equal(first.tex_data, model.tex_data):
        return False
    others = {field.name for field in batched_fields(own)} | _UNIMPORTANT
    names = [field.name for field in dataclasses.fields(own) if field.name not in others]
    return all(_equal(getattr(theirs, name), getattr(own, name)) for name in names)


def _equal(a: Any, b: Any) -> bool:
    if type(a) is not type(b):
        return False
    if hasattr(a, "numpy"):
        return a.shape == b.shape and np.array_equal(a.numpy(), b.numpy(), equal_nan=a.numpy().dtype.kind == "f")
    if dataclasses.is_dataclass(a):
        return all(_equal(getattr(a, f.name), getattr(b, f.name)) for f in dataclasses.fields(a))
    if isinstance(a, (tuple, list)):
        return len(a) == len(b) and all(map(_equal, a, b))
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(_equal(a[k], b[k]) for k in a)
    if isinstance(a, np.ndarray):
        return np.array_equal(a, b)
    return bool(a == b)


def _expand(warp: Any, members: Sequence[Any]) -> None:
    """Gives `warp` a row per world of every field in which its worlds differ."""
    import warp as wp

    unlike = {id(m): m for m in members}
    for field in batched_fields(warp):
        rows = {key: getattr(m, field.name).numpy()[:1] for key, m in unlike.items()}
        first = next(iter(rows.values()))
        if any(not np.array_equal(first, other) for other in rows.values()):
            stacked = np.concatenate([rows[id(m)] for m in members])
            setattr(warp, field.name, wp.array(stacked, dtype=getattr(warp, field.name).dtype))


def _place_static_geoms(data: Any, models: Sequence[mujoco.MjModel]) -> None:
    """Puts what belongs to the room where each world has it: Warp never moves it again."""
    places: dict[int, tuple[np.ndarray, np.ndarray]] = {}
    for model in models:
        if id(model) not in places:
            scratch = mujoco.MjData(model)
            mujoco.mj_kinematics(model, scratch)
            places[id(model)] = scratch.geom_xpos.copy(), scratch.geom_xmat.reshape(-1, 3, 3).copy()
    data.geom_xpos.assign(np.stack([places[id(m)][0] for m in models]).astype(np.float32))
    data.geom_xmat.assign(np.stack([places[id(m)][1] for m in models]).astype(np.float32))


def _put(array: Any, rows: np.ndarray, values: np.ndarray) -> None:
    """Writes rows of one of Warp's arrays."""
    whole = array.numpy().copy()
    whole[rows] = values
    array.assign(whole)
