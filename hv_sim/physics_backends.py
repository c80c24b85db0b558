"""The physics engines there are, by the names that configurations use."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import mujoco
import numpy as np

from hv_sim.physics import PhysicsBackend
from hv_sim.rendering import HEAD_CAMERA, CameraRenderer

BACKENDS = ("cpu", "warp")
"""`cpu`: `mujoco.batch`, with OpenGL for pictures; every figure of ours was made with it. `warp`: `mujoco_warp` and its
ray caster, for NVIDIA GPUs; docs/scaling.md says how far the two are apart."""


class BatchRenderer(Protocol):
    """Pictures of the simulations of a backend."""

    def render_batch(self, physics: Any, ids: Sequence[int] | None = None, camera: str = HEAD_CAMERA) -> np.ndarray:
        """Pictures of simulations `ids` (default: all), (n, height, width, 3) uint8."""

    def close(self) -> None:
        """Frees what was made for pictures."""


def check_backend(name: str, where: str = "physics") -> None:
    """Raises ValueError, naming the field `where`, unless it is the name of a backend."""
    if name not in BACKENDS:
        raise ValueError(f"{where}: {name!r} is not valid; valid: {', '.join(BACKENDS)}")


def make_physics(name: str, models: Sequence[mujoco.MjModel], *, num_threads: int = 0) -> PhysicsBackend:
    """A backend for these scenes, one a simulation.

    Args:
        name: one of `BACKENDS`.
        models: as `PhysicsBackend` wants them.
        num_threads: of `cpu`, 0 for one per core.

    Raises:
        ValueError: the name is unknown, its engine is not installed, or a model is not valid.
    """
    check_backend(name)
    if name == "cpu":
        from hv_sim.mujoco_physics import MujocoPhysics

        return MujocoPhysics(models, num_threads=num_threads)
    from hv_sim.warp_physics import WarpPhysics

    return WarpPhysics(models)


def make_renderer(name: str, height_px: int = 128, width_px: int = 128) -> BatchRenderer:
    """What renders the simulations of a backend.

    Raises:
        ValueError: the name is unknown, its engine is not installed, or a size is not positive.
    """
    check_backend(name)
    if name == "cpu":
        return CameraRenderer(height_px, width_px)
    from hv_sim.warp_rendering import WarpRenderer

    return WarpRenderer(height_px, width_px)
