"""The benchmark measures what it says: both sides step the same scenes for the same time."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import torch

from hv_sim.benchmark import BareBatches, benchmark_backend, benchmark_rendering, benchmark_simulation
from hv_sim.humanoid import ROBOT_NQ
from hv_sim.task import load_task
from hv_sim.world import RearrangeWorld

SCRIPT = Path(__file__).parents[2] / "scripts" / "bench_sim.py"


def test_the_bare_engine_does_the_same_physics():
    world = RearrangeWorld([load_task("living_room_1"), load_task("living_room_2")], num_threads=1)
    world.physics.reset([0, 1], [scene.initial_qpos for scene in world.scenes])
    bare = BareBatches(world, 1)
    bare.reset()
    targets = np.stack([scene.initial_qpos[7:ROBOT_NQ] for scene in world.scenes]) + 0.1
    for _ in range(6):
        world.step(torch.tensor(targets, dtype=torch.float32))
        bare.step(targets.astype(np.float32).astype(np.float64))
    assert sorted(env for ids, _, _ in bare.groups for env in ids) == [0, 1]
    for ids, batch, _ in bare.groups:
        for row, env in enumerate(ids):
            np.testing.assert_array_equal(batch.bind("qpos")[row], world.physics.data(env).qpos)


def test_figures_of_a_small_run():
    figures = benchmark_simulation([load_task("living_room_1")], num_envs=2, num_steps=4, num_threads=1, rounds=1)
    assert figures["world_steps_per_s"] > 0
    assert figures["share_of_bare"] == pytest.approx(figures["world_steps_per_s"] / figures["bare_steps_per_s"])
    assert figures["scene_share_of_lone"] == pytest.approx(figures["bare_steps_per_s"] / figures["lone_steps_per_s"])
    assert 0 < figures["scene_share_of_lone"] < 2
    pictures = benchmark_rendering([load_task("living_room_1")], size_px=16, num_frames=2)
    assert pictures["frames_per_s"] > 0
    assert pictures["bare_frames_per_s"] > 0


def test_figures_of_an_engine():
    settings = {"num_envs": 2, "num_steps": 2, "size_px": 16}
    figures = benchmark_backend([load_task("living_room_1")], physics="cpu", num_threads=1, **settings)
    assert figures.pop("num_envs") == 2
    assert min(figures.values()) > 0
    with pytest.raises(ValueError, match="num_steps: 0 is not valid"):
        benchmark_backend([load_task("living_room_1")], physics="cpu", **(settings | {"num_steps": 0}))


@pytest.mark.parametrize("name", ["num_envs", "num_steps", "rounds"])
def test_a_bad_number_is_named(name):
    with pytest.raises(ValueError, match=f"{name}: 0 is not valid"):
        benchmark_simulation([load_task("living_room_1")], **{name: 0})


@pytest.mark.parametrize("arguments", [["--task", "nowhere"], ["--num-envs", "0"]])
def test_the_command_fails_in_one_line(arguments):
    done = subprocess.run([sys.executable, SCRIPT, *arguments], capture_output=True, text=True)
    assert done.returncode == 1
    assert done.stderr.startswith("hv-bench-sim: ")
    assert done.stderr.count("\n") == 1
