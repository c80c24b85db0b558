"""How practice and recording scale on this machine: against the bare engine, against environments, objects and
processes, and whether memory stays flat.

Everything is measured beside what it is compared with, in the same run.
"""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from tqdm import tqdm

from hv_policy.decision.network import DecisionConfig, DecisionNetwork
from hv_policy.motor.embodiment import CONTROL_DT_S
from hv_policy.motor.prior import load_shipped_motor_prior
from hv_sim.benchmark import BareBatches, LoneHumanoids
from hv_sim.humanoid import standing_qpos
from hv_sim.task import Task
from hv_teachers.engines import Slice
from hv_teachers.expert import expert_maker
from hv_teachers.motor_env import MotorEnvConfig
from hv_teachers.motor_training import MotorTraining, MotorTrainingConfig
from hv_teachers.recording import RecordingConfig
from hv_teachers.routes import replan_routes
from hv_teachers.sharded_recording import record_shards
from hv_teachers.teacher import Decision
from hv_teachers.teacher_env import TeacherEnv, TeacherEnvConfig

SECONDS_PER_SUBTASK = 25.0
"""What the planner takes for a sub-task, in the mean."""
LONE_HUMANOIDS = 256
_BLOCK_STEPS = 10
_MB = 1e6


def benchmark_teacher_env(
    tasks: Sequence[Task], *, num_envs: int = 256, num_steps: int = 100, num_threads: int = 0, rounds: int = 3
) -> dict[str, float]:
    """Control steps/s of the practice environment, and of bare `mujoco.batch` on the same scenes with the same targets.

    A step of the environment is `look` and `act`: everything that teachers and critics see, the step itself, rewards,
    style windows, instructor, ends and beginnings of episodes. All do what the planner does in its first seconds, from
    a recording of its joint targets. They take turns every few steps, and of each turn the best of `rounds` counts:
    other load on the machine then hurts neither more. Routes are planned where a sub-task begins, which is seldom; they
    are timed by themselves and counted as one in `SECONDS_PER_SUBTASK` for each environment. The motor prior, a
    network below the teachers' own, is timed beside it; labels and networks are not in it.

    Args:
        tasks: repeated in turn over the environments.
        num_envs: environments stepped together.
        num_steps: control steps of each round.
        num_threads: threads of the physics, 0 for one per core; everything else has one, as in a training.
        rounds: repetitions.

    Returns:
        `env_steps_per_s` with routes, `bare_steps_per_s`, their ratio `share_of_bare`; `share_of_bare_without_routes`;
        `share_of_bare_with_prior`, the ratio if routes and the motor prior are counted; `route_ms`, what planning one
        takes; and the settings.

    Raises:
        ValueError: a number is below 1.
    """
    _refuse_small(num_envs=num_envs, num_steps=num_steps, rounds=rounds)
    torch.set_num_threads(1)
    prior = load_shipped_motor_prior()
    teacher = DecisionConfig(action="joints", hidden=(1,), phase_hidden=(1,), geometry=0)
    config = TeacherEnvConfig(num_envs=num_envs, num_threads=num_threads)
    env = TeacherEnv([tasks[i % len(tasks)] for i in range(num_envs)], config, teacher, prior, seed=0)
    bare = BareBatches(env.world, num_threads)
    everyone, intent = torch.arange(num_envs), torch.zeros(num_envs, 14)
    actions = _planned_actions(env, num_steps)
    targets = [DecisionNetwork(teacher).from_units(action).double().numpy() for action in actions]
    blocks = range(0, num_steps, _BLOCK_STEPS)
    seconds, route_s = np.empty((3, rounds, len(blocks))), np.empty(rounds)
    for r in tqdm(range(rounds), desc=f"practice, {num_envs} environments", leave=False):
        env.episodes.zero_()  # the same episodes again
        env.begin(everyone)
        env.forget_sight()
        bare.reset()
        start = time.perf_counter()
        replan_routes(env.world, everyone)
        route_s[r] = (time.perf_counter() - start) / num_envs
        for b, first in enumerate(blocks):
            start = time.perf_counter()
            with torch.no_grad():
                for action in actions[first : first + _BLOCK_STEPS]:
                    env.act(env.look(), action)
            between = time.perf_counter()
            for row in targets[first : first + _BLOCK_STEPS]:
                bare.step(row)
            after = time.perf_counter()
            with torch.no_grad():
                for _ in actions[first : first + _BLOCK_STEPS]:
                    prior(env.look().proprioception, intent)
            seconds[:, r, b] = between - start, after - between, time.perf_counter() - after
    env_s, bare_s, prior_s = seconds.min(axis=1).sum(axis=1)
    steps = num_envs * num_steps
    with_routes_s = env_s + route_s.min() * steps * CONTROL_DT_S / SECONDS_PER_SUBTASK
    return {
        "env_steps_per_s": steps / with_routes_s,
        "bare_steps_per_s": steps / bare_s,
        "share_of_bare": bare_s / with_routes_s,
        "share_of_bare_without_routes": bare_s / env_s,
        "share_of_bare_with_prior": bare_s / (with_routes_s + prior_s),
        "route_ms": 1000 * route_s.min(),
        "num_envs": num_envs,
        "num_steps": num_steps,
        "num_threads": num_threads or (os.cpu_count() or 1),
    }


def _planned_actions(env: TeacherEnv, num_steps: int) -> list[torch.Tensor]:
    """(N, 28) joint targets, in the networks' units, of the planner's first control steps in an environment's tasks."""
    actions, everyone = [], torch.ones(env.num_envs, dtype=torch.bool)
    with torch.no_grad():
        for _ in tqdm(range(num_steps), desc="recording what to do", leave=False):
            seen = env.look()
            label = env.label(seen)
            actions.append(env.follow(label, everyone, Decision(label.anchors, label.memory, label.action)))
            env.act(seen, actions[-1])
    return actions


def benchmark_motor_training(
    *, num_envs: int | None = None, iterations: int = 6, num_threads: int = 0, lone_steps: int = 10
) -> dict[str, float]:
    """Control steps/s of the motor prior's training, and of bare `mujoco.batch` with 256 humanoids alone on a plane.

    An iteration of the training is what `hv-train-motor` repeats: scenes with and without boxes, intents, planner, base
    controller, rewards, new episodes, and PPO's update. They take turns, and of both the median counts.

    Args:
        num_envs: environments of the training; None: as many as it has by default.
        iterations: that are timed, after one that is not.
        num_threads: threads of the physics, 0 for one per core.
        lone_steps: control steps of the bare engine after each iteration.

    Returns:
        `training_steps_per_s`, `lone_steps_per_s`, their ratio `share_of_lone`, and `num_envs`.

    Raises:
        ValueError: a number is below 1.
    """
    env = MotorEnvConfig(num_threads=num_threads)
    env = replace(env, num_envs=env.num_envs if num_envs is None else num_envs)
    _refuse_small(num_envs=env.num_envs, iterations=iterations, lone_steps=lone_steps)
    training = MotorTraining(MotorTrainingConfig(env=env))
    lone = LoneHumanoids(LONE_HUMANOIDS, num_threads)
    standing = np.tile(standing_qpos((0.0, 0.0), 0.0)[7:], (LONE_HUMANOIDS, 1))
    targets = standing + 0.05 * np.random.default_rng(0).standard_normal((lone_steps, LONE_HUMANOIDS, 28))
    training.iterate()
    seconds = np.empty((2, iterations))
    for i in tqdm(range(iterations), desc=f"motor training, {env.num_envs} environments", leave=False):
        start = time.perf_counter()
        training.iterate()
        between = time.perf_counter()
        lone.reset()
        begun = time.perf_counter()
        for row in targets:
            lone.step(row)
        seconds[:, i] = between - start, time.perf_counter() - begun
    training_s, lone_s = np.median(seconds, axis=1)
    steps_per_s, lone_per_s = training.samples_per_iteration / training_s, LONE_HUMANOIDS * lone_steps / lone_s
    return {
        "training_steps_per_s": steps_per_s,
        "lone_steps_per_s": lone_per_s,
        "share_of_lone": steps_per_s / lone_per_s,
        "num_envs": env.num_envs,
    }


def benchmark_recording(
    tasks: Sequence[Task], *, workers: Sequence[int] = (1, 2), max_episode_steps: int = 600, image_size_px: int = 128
) -> list[dict[str, float]]:
    """Frames/s that so many processes record of the same attempts, their start included; then one of them joins.

    Args:
        tasks: one attempt each, four side by side in a process.
        workers: numbers of processes.
        max_episode_steps: control steps of an attempt.
        image_size_px: side of a picture.

    Returns:
        For each number: `workers`, `frames`, `seconds`, `frames_per_s`, `speedup` over the first, and `joining_s`.

    Raises:
        ValueError: a number is below 1.
        hv_sim.gl_backend.GLError: no OpenGL library can render off screen here.
    """
    _refuse_small(max_episode_steps=max_episode_steps, image_size_px=image_size_px, workers=min(workers))
    config = RecordingConfig(max_episode_steps=max_episode_steps, image_size_px=image_size_px)
    rows: list[dict[str, float]] = []
    for count in workers:
        with tempfile.TemporaryDirectory() as folder:
            root, expert = Path(folder) / "recorded", expert_maker("planner")
            begun = time.perf_counter()
            report = record_shards(root, tasks, expert, config, workers=count, only=Slice(0, 1))
            seconds = time.perf_counter() - begun
            record_shards(root, tasks, expert, config, workers=count)
            joining_s = time.perf_counter() - begun - seconds
        rate = report.frames_recorded / seconds
        first = rows[0]["frames_per_s"] if rows else rate
        rows.append(
            {
                "workers": count,
                "frames": report.frames_recorded,
                "seconds": seconds,
                "frames_per_s": rate,
                "speedup": rate / first,
                "joining_s": joining_s,
            }
        )
    return rows


def watch_memory(
    tasks: Sequence[Task],
    *,
    minutes: float = 60.0,
    num_envs: int = 64,
    every_s: float = 60.0,
    num_threads: int = 0,
    tell: Callable[[dict[str, float]], None] | None = None,
) -> dict[str, Any]:
    """Memory of this process while the planner practises: episodes end and begin, routes are planned anew.

    Args:
        tasks: repeated in turn over the environments.
        minutes: how long.
        num_envs: environments.
        every_s: seconds between two looks.
        num_threads: of the physics.
        tell: is given each look.

    Returns:
        `looks`, a list of `minute`, `resident_mb` (VmRSS), `steps` (control steps of all environments together) and
        `episodes` begun; and `growth_mb_per_hour`, the slope of a line through the later half of them.

    Raises:
        ValueError: a number is not positive.
    """
    _refuse_small(num_envs=num_envs)
    for name, value in (("minutes", minutes), ("every_s", every_s)):
        if not value > 0:
            raise ValueError(f"{name}: {value} is not valid; valid: a number above 0")
    torch.set_num_threads(1)
    config = TeacherEnvConfig(num_envs=num_envs, num_threads=num_threads, steps_per_subtask=600)
    chosen = [tasks[i % len(tasks)] for i in range(num_envs)]
    env = TeacherEnv(chosen, config, DecisionConfig(), load_shipped_motor_prior(), seed=0)
    looks: list[dict[str, float]] = []
    begun, steps = time.perf_counter(), 0
    while True:
        passed = time.perf_counter() - begun
        if passed >= len(looks) * every_s or passed >= 60 * minutes:
            looks.append(
                {
                    "minute": round(passed / 60, 3),
                    "resident_mb": resident_bytes() / _MB,
                    "steps": steps,
                    "episodes": int(env.episodes.sum()),
                }
            )
            if tell is not None:
                tell(looks[-1])
            if passed >= 60 * minutes:
                break
        with torch.no_grad():
            seen = env.look()
            label = env.label(seen)
            env.senses.memory = label.remembered.clone()
            env.senses.lost = label.lost
            env.act(seen, label.action)
        steps += num_envs
    later = looks[len(looks) // 2 :] if len(looks) > 3 else looks
    slope = np.polyfit([k["minute"] for k in later], [k["resident_mb"] for k in later], 1)[0] if len(later) > 1 else 0.0
    return {"looks": looks, "growth_mb_per_hour": 60 * float(slope), "num_envs": num_envs}


def resident_bytes() -> int:
    """This process's memory in RAM (VmRSS of Linux)."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


def _refuse_small(**numbers: int) -> None:
    for name, value in numbers.items():
        if value < 1:
            raise ValueError(f"{name}: {value} is not valid; valid: an integer >= 1")
