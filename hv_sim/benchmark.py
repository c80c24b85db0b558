"""How fast the world is, beside the bare engines on the same scenes in the same run."""

from __future__ import annotations

import os
import time
from collections.abc import Sequence

import mujoco
import mujoco.batch
import numpy as np
import torch
from tqdm import tqdm

from hv_sim.humanoid import (
    ALL_CONAFFINITY,
    CONTROL_HZ,
    ENVIRONMENT_CONTYPE,
    ROBOT_NQ,
    add_humanoid,
    configure_physics,
    standing_qpos,
)
from hv_sim.physics_backends import make_renderer
from hv_sim.rendering import CameraRenderer
from hv_sim.task import Task
from hv_sim.world import RearrangeWorld

_BLOCK_STEPS = 10


def benchmark_simulation(
    tasks: Sequence[Task], *, num_envs: int = 256, num_steps: int = 150, num_threads: int = 0, rounds: int = 3
) -> dict[str, float]:
    """Control steps/s of `RearrangeWorld` with observations, and of bare `mujoco.batch`, on the same scenes and on a
    plane with nothing but the humanoid.

    All hold the standing pose with the same noise on the joint targets. They take turns every few steps, and of each
    turn the best of `rounds` counts: other load on the machine then hurts none more.

    Args:
        tasks: repeated in turn over the environments.
        num_envs: environments stepped together.
        num_steps: control steps of each round.
        num_threads: threads of the physics, 0 for one per core.
        rounds: repetitions.

    Returns:
        `world_steps_per_s`, `bare_steps_per_s`, their ratio `share_of_bare`; `lone_steps_per_s` on the plane and
        `scene_share_of_lone`, what the bare scenes reach of it; and the settings.

    Raises:
        ValueError: a number is below 1.
    """
    for name, value in (("num_envs", num_envs), ("num_steps", num_steps), ("rounds", rounds)):
        if value < 1:
            raise ValueError(f"{name}: {value} is not valid; valid: an integer >= 1")
    chosen = [tasks[i % len(tasks)] for i in range(num_envs)]
    world = RearrangeWorld(chosen, num_threads=num_threads)
    bare = BareBatches(world, num_threads)
    lone = LoneHumanoids(num_envs, num_threads)
    standing = torch.tensor(np.stack([s.initial_qpos[7:ROBOT_NQ] for s in world.scenes]), dtype=torch.float32)
    noise = 0.05 * torch.randn(num_steps, num_envs, 28, generator=torch.Generator().manual_seed(0))
    targets = standing + noise
    blocks = range(0, num_steps, _BLOCK_STEPS)
    seconds = np.empty((3, rounds, len(blocks)))
    for r in tqdm(range(rounds), desc="simulation"):
        world.reset(seeds=range(num_envs))
        bare.reset()
        lone.reset()
        for b, first in enumerate(blocks):
            block = targets[first : first + _BLOCK_STEPS]
            block_numpy = block.double().numpy()
            start = time.perf_counter()
            for target in block:
                world.step(target)
                world.observe()
            between = time.perf_counter()
            for target in block_numpy:
                bare.step(target)
            after = time.perf_counter()
            for target in block_numpy:
                lone.step(target)
            seconds[:, r, b] = between - start, after - between, time.perf_counter() - after
    world_s, bare_s, lone_s = seconds.min(axis=1).sum(axis=1)
    steps = num_envs * num_steps
    return {
        "world_steps_per_s": steps / world_s,
        "bare_steps_per_s": steps / bare_s,
        "share_of_bare": bare_s / world_s,
        "lone_steps_per_s": steps / lone_s,
        "scene_share_of_lone": lone_s / bare_s,
        "num_envs": num_envs,
        "num_steps": num_steps,
        "num_threads": num_threads or (os.cpu_count() or 1),
    }


def benchmark_rendering(tasks: Sequence[Task], *, size_px: int = 128, num_frames: int = 200) -> dict[str, float]:
    """Frames/s of the head camera: `CameraRenderer.render_batch`, and a bare `mujoco.Renderer` without shadows.

    Raises:
        ValueError: `num_frames` is below 1.
        hv_sim.gl_backend.GLError: no OpenGL library can render off screen here.
    """
    if num_frames < 1:
        raise ValueError(f"num_frames: {num_frames} is not valid; valid: an integer >= 1")
    world = RearrangeWorld(list(tasks), num_threads=1)
    renderer = CameraRenderer(size_px, size_px)
    renderer.render_batch(world.physics)
    rounds = -(-num_frames // world.num_envs)
    start = time.perf_counter()
    for _ in tqdm(range(rounds), desc=f"rendering {size_px} px"):
        renderer.render_batch(world.physics)
    ours = rounds * world.num_envs / (time.perf_counter() - start)
    renderer.close()

    model, data = world.physics.model(0), world.physics.data(0)
    with mujoco.Renderer(model, size_px, size_px) as bare:
        for flag in (mujoco.mjtRndFlag.mjRND_SHADOW, mujoco.mjtRndFlag.mjRND_REFLECTION):
            bare.scene.flags[flag] = False
        bare.update_scene(data, "head")
        bare.render()
        start = time.perf_counter()
        for _ in range(num_frames):
            bare.update_scene(data, "head")
            bare.render()
        plain = num_frames / (time.perf_counter() - start)
    return {"frames_per_s": ours, "bare_frames_per_s": plain, "size_px": size_px}


def benchmark_backend(
    tasks: Sequence[Task], *, physics: str, num_envs: int, num_steps: int = 60, size_px: int = 128, num_threads: int = 0
) -> dict[str, float]:
    """Control steps/s of `RearrangeWorld` with observations, and pictures/s of the head cameras, on one engine.

    Args:
        tasks: repeated in turn over the environments.
        physics: one of `hv_sim.physics_backends.BACKENDS`.
        num_envs: environments stepped together.
        num_steps: control steps that are timed, after ten that are not.
        size_px: side of a picture.
        num_threads: threads of `cpu`, 0 for one per core.

    Returns:
        `num_envs`, `control_steps_per_s`, `physics_steps_per_s` (the same without observations and instructor) and
        `pictures_per_s`.

    Raises:
        ValueError: a number is below 1, or there is no such engine here.
        hv_sim.gl_backend.GLError: `cpu`, and no OpenGL library can render off screen here.
    """
    for name, value in (("num_envs", num_envs), ("num_steps", num_steps), ("size_px", size_px)):
        if value < 1:
            raise ValueError(f"{name}: {value} is not valid; valid: an integer >= 1")
    world = RearrangeWorld([tasks[i % len(tasks)] for i in range(num_envs)], physics=physics, num_threads=num_threads)
    standing = torch.tensor(np.stack([s.initial_qpos[7:ROBOT_NQ] for s in world.scenes]), dtype=torch.float32)
    for _ in range(10):
        world.step(standing)
    start = time.perf_counter()
    for _ in range(num_steps):
        world.step(standing)
        world.observe()
    between = time.perf_counter()
    for _ in range(num_steps):
        world.physics.step(standing)
        world.physics.state()
    after = time.perf_counter()
    renderer = make_renderer(physics, size_px, size_px)
    renderer.render_batch(world.physics)
    begun = time.perf_counter()
    renderer.render_batch(world.physics)
    pictures_s = time.perf_counter() - begun
    renderer.close()
    steps = num_envs * num_steps
    return {
        "num_envs": num_envs,
        "control_steps_per_s": steps / (between - start),
        "physics_steps_per_s": steps / (after - between),
        "pictures_per_s": num_envs / pictures_s,
    }


class LoneHumanoids:
    """Humanoids on a plane, in bare `mujoco.batch`."""

    def __init__(self, num_envs: int, num_threads: int) -> None:
        spec = mujoco.MjSpec()
        add_humanoid(spec)
        floor = spec.worldbody.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[20, 20, 1])
        floor.contype, floor.conaffinity = ENVIRONMENT_CONTYPE, ALL_CONAFFINITY
        configure_physics(spec)
        model = spec.compile()
        self._substeps = round(1 / (CONTROL_HZ * model.opt.timestep))
        self._batch = mujoco.batch.Batch(model, num_envs, nthread=num_threads, persistent=True)
        self._control = self._batch.bind("ctrl")

    def reset(self) -> None:
        """Lets everybody stand."""
        self._batch.reset()
        self._batch.bind("qpos")[:] = standing_qpos((0.0, 0.0), 0.0)
        self._batch.forward()

    def step(self, targets: np.ndarray) -> None:
        """One control step with servo targets (N, 28), float64, radians."""
        self._control[:] = targets
        self._batch.step(nstep=self._substeps)


class BareBatches:
    """The scenes of a world in bare `mujoco.batch`, one batch for each number of objects (that fixes the layout)."""

    def __init__(self, world: RearrangeWorld, num_threads: int) -> None:
        layouts: dict[int, list[int]] = {}
        for env, scene in enumerate(world.scenes):
            layouts.setdefault(scene.model.nq, []).append(env)
        self._scenes = world.scenes
        self._substeps = round(1 / (CONTROL_HZ * world.scenes[0].model.opt.timestep))
        self.groups: list[tuple[np.ndarray, mujoco.batch.Batch, np.ndarray]] = []
        for ids in layouts.values():
            models = [world.scenes[i].model for i in ids]
            batch = mujoco.batch.Batch(models[0], len(ids), nthread=num_threads, persistent=True)
            batch.set_models(models)
            self.groups.append((np.array(ids), batch, batch.bind("ctrl")))

    def reset(self) -> None:
        """Puts every simulation into its scene's initial position."""
        for ids, batch, _ in self.groups:
            batch.reset()
            batch.bind("qpos")[:] = np.stack([self._scenes[i].initial_qpos for i in ids])
            batch.forward()

    def step(self, targets: np.ndarray) -> None:
        """One control step with servo targets (N, 28), float64, radians."""
        for ids, batch, control in self.groups:
            control[:] = targets[ids]
            batch.step(nstep=self._substeps)
