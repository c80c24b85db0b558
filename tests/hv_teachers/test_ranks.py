"""Two processes do what one does: their exchanges, and a whole training; and what is killed goes on."""

import csv
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest
import torch

from hv_policy.decision.weights import load_decision
from hv_teachers.ranks import Ranks, joined_ranks, own_gpu, places
from hv_teachers.style import FRAME_DIM, MotionSet
from hv_teachers.teacher_config import training_config
from hv_teachers.teacher_training import train_teacher

SUPPORT = Path(__file__).parents[1] / "support" / "two_ranks.py"
SETTINGS = {
    "tasks": "living_room", "part": "single", "env.num_envs": 4, "env.num_threads": 1, "new_tasks_every": 2,
    "teacher.hidden": [16], "teacher.phase_hidden": [8], "teacher.geometry": 2,
    "dagger.samples": 80, "dagger.round_steps": 10, "dagger.batch_size": 32, "dagger.expert_steps": 4,
    "ppo.samples": 48, "ppo.steps_per_iteration": 4, "ppo.critic_hidden": [16], "ppo.critic_warmup": 1,
    "ppo.imitation_batches": 1, "style.hidden": [16], "style.batch_size": 16, "style.batches": 1,
    "style.replay_size": 40, "style.replay_keep": 8, "name": "teacher",
}  # fmt: skip
TIMES = ("minutes", "steps_per_s", "simulation_share")
OWN_MEANS = ("value_loss", "surrogate_loss")
"""Of the last mini-batch's shares: means of the processes' own, which are not the mean over all."""
FIGURES, MOST_WEIGHTS, WEIGHTS = 2e-4, 1e-5, 1e-3
"""Tolerances of the curve's figures, of 99 % of the weights and of all, after two rounds and three iterations. Sums in
another order are all that differs; but Adam makes a step, of at most the learning rate, also of a gradient that is
nothing but rounding. Measured: 1e-5, 2e-6, 2e-4."""


def prepare(folder):
    """A motion set, so that none has to be recorded."""
    motion = MotionSet.of([torch.randn(60, FRAME_DIM, generator=torch.Generator().manual_seed(0))])
    motion.save(folder / "motion_set.safetensors")
    return folder


def command(output):
    values = [f"{key}={value}" for key, value in SETTINGS.items()]
    return ["-m", "hv_scripts.train_teacher", "stage=1", f"output={output}", *values]


def environment(**more):
    return {**os.environ, "OMP_NUM_THREADS": "1", **more}


def torchrun(*arguments):
    starter = [sys.executable, "-m", "torch.distributed.run", "--standalone", "--nproc-per-node=2"]
    return subprocess.run([*starter, *arguments], capture_output=True, text=True, env=environment(), timeout=500)


def start_two(output):
    """The same as torchrun does, without its own process: it shields its children from a kill."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = str(free.getsockname()[1])
    return [
        subprocess.Popen(
            [sys.executable, *command(output)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            env=environment(RANK=str(r), LOCAL_RANK=str(r), WORLD_SIZE="2", MASTER_ADDR="127.0.0.1", MASTER_PORT=port),
        )
        for r in range(2)
    ]  # fmt: skip


def curve(folder):
    with (folder / "curve.csv").open() as file:
        return [{k: v for k, v in row.items() if k not in TIMES} for row in csv.DictReader(file)]


def weights(folder):
    return load_decision(folder / "teacher.safetensors").state_dict()


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    folder = prepare(tmp_path_factory.mktemp("alone"))
    train_teacher(training_config(SETTINGS), folder, progress=False)
    return folder


@pytest.fixture(scope="module")
def two(tmp_path_factory):
    folder = prepare(tmp_path_factory.mktemp("two"))
    done = torchrun(*command(folder))
    assert done.returncode == 0, done.stderr
    return folder


def test_two_processes_exchange_what_one_holds():
    done = torchrun(SUPPORT)
    assert done.returncode == 0, done.stderr
    assert "rank 0 is right" in done.stderr
    assert "rank 1 is right" in done.stderr


@pytest.mark.slow
def test_two_processes_train_as_one_does(alone, two):
    one, both = curve(alone), curve(two)
    assert [r["kind"] for r in both] == ["dagger"] * 2 + ["ppo"] * 3
    for mine, theirs in zip(one, both, strict=True):
        assert mine.keys() == theirs.keys()
        for name in mine.keys() - {"kind", *OWN_MEANS}:
            assert (mine[name] == "") == (theirs[name] == ""), name
            if mine[name] != "":
                assert float(theirs[name]) == pytest.approx(float(mine[name]), abs=FIGURES, rel=1e-3), name
    first, second = weights(alone), weights(two)
    apart = torch.cat([(second[name].float() - value.float()).abs().flatten() for name, value in first.items()])
    assert apart.quantile(0.99) < MOST_WEIGHTS
    assert apart.max() < WEIGHTS
    assert sorted(p.name for p in two.glob("*rank1*")) == ["resume_rank1_128.pt"]
    assert not list(two.rglob("*.tmp"))


@pytest.mark.slow
def test_killed_processes_go_on(two, tmp_path):
    prepare(tmp_path)
    processes = start_two(tmp_path)
    deadline = time.time() + 300
    while not (tmp_path / "resume.pt").exists() and processes[0].poll() is None and time.time() < deadline:
        time.sleep(0.02)
    processes[1].send_signal(signal.SIGKILL)
    assert processes[0].wait(timeout=300) != 0  # it does not wait for the dead
    processes[1].wait()
    assert (tmp_path / "resume.pt").exists()
    assert len(curve(tmp_path)) < len(curve(two))
    assert [p.wait(timeout=500) for p in start_two(tmp_path)] == [0, 0]
    assert curve(tmp_path) == curve(two)
    assert all(torch.equal(value, weights(tmp_path)[name]) for name, value in weights(two).items())
    with pytest.raises(ValueError, match=r"holds a training by 2 processes, not 1; valid: as many as before"):
        train_teacher(training_config(SETTINGS), tmp_path, progress=False)


def test_environments_must_be_a_multiple():
    assert [Ranks(r, 2).share(4) for r in range(2)] == [slice(0, 2), slice(2, 4)]
    with pytest.raises(ValueError, match=r"env\.num_envs: 5 is not valid for 2 processes; valid: a multiple of it"):
        Ranks(1, 2).share(5)


def test_a_lone_process_is_what_it_was(monkeypatch):
    monkeypatch.delenv("WORLD_SIZE", raising=False)
    with joined_ranks() as ranks:
        assert ranks == Ranks(0, 1)
    values = torch.randn(3, 2)
    mean, std = ranks.moments(values)
    assert torch.equal(mean, values.mean(0))
    assert torch.equal(std, values.std(0))
    assert places(torch.tensor([3, 1]), 4).tolist() == [-1, 1, -1, 0]


def test_each_process_has_its_gpu():
    assert own_gpu(1, None, 0) is None
    assert [own_gpu(r, None, 2) for r in range(3)] == ["0", "1", "0"]
    assert own_gpu(1, "4,7", 2) == "7"
