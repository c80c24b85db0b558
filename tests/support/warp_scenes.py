"""Scenes for tests of Warp: few, and all of one layout, since every other one has kernels of its own to be compiled."""

import copy
import functools
import os

import mujoco
import numpy as np
import pytest
import torch

from hv_sim.scene import FIRST_OBJECT_BODY, Scene, compile_scene
from hv_sim.task import load_task

pytest.importorskip("mujoco_warp", reason="Warp is not installed here: pip install 'lerobot_policy_hv[gpu]'")

DEVICE = os.environ.get("HV_WARP_DEVICE", "cpu")
"""`make gpu-check` names a GPU here."""


@functools.cache
def living_room() -> Scene:
    return compile_scene(load_task("living_room_1"))


def changed_room() -> mujoco.MjModel:
    """The living room with a heavier robot trunk, and a first object that is lighter, and smaller all over."""
    model = copy.copy(living_room().model)
    model.body_mass[2] *= 1.3
    model.body_inertia[2] *= 1.3
    model.body_mass[FIRST_OBJECT_BODY] *= 0.5
    model.body_inertia[FIRST_OBJECT_BODY] *= 0.5
    geoms = model.geom_bodyid == FIRST_OBJECT_BODY
    for field in ("geom_size", "geom_rbound", "geom_aabb", "geom_pos"):
        getattr(model, field)[geoms] *= 0.8
    mujoco.mj_setConst(model, mujoco.MjData(model))
    return model


def targets(num: int, steps: int, seed: int = 0) -> torch.Tensor:
    """(T, N, 28) joint targets that sway about the standing pose, another way in each world."""
    standing = torch.tensor(living_room().initial_qpos[7:35], dtype=torch.float32)
    sway = 0.2 * torch.randn(num, 28, generator=torch.Generator().manual_seed(seed))
    time = torch.arange(steps)[:, None, None] / 6
    return standing + sway * torch.sin(time)


def starts(num: int) -> list[np.ndarray]:
    """Standing, another way round in each world."""
    found = []
    for i in range(num):
        qpos = np.array(living_room().initial_qpos)
        qpos[3:7] = np.cos(0.2 * i), 0, 0, np.sin(0.2 * i)
        found.append(qpos)
    return found
