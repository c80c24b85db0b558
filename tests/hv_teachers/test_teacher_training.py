"""Training a teacher for a moment: both phases, all three stages, and a kill that changes nothing."""

import csv
import os
import signal
import subprocess
import sys
import time

import pytest
import torch

from hv_policy.decision.weights import load_decision
from hv_teachers.style import FRAME_DIM, MotionSet
from hv_teachers.teacher import Teacher
from hv_teachers.teacher_config import read_yaml, training_config
from hv_teachers.teacher_recipe import read_recipe, train_recipe
from hv_teachers.teacher_training import train_teacher

TINY = {
    "tasks": "living_room",
    "part": "single",
    "env": {"num_envs": 4, "num_threads": 1, "end_when_placed": False},
    "teacher": {"hidden": [16], "phase_hidden": [8], "geometry": 2},
    "dagger": {"samples": 80, "round_steps": 10, "batch_size": 32, "expert_steps": 4},
    "ppo": {
        "samples": 120,
        "steps_per_iteration": 2,
        "critic_hidden": [16],
        "critic_warmup": 2,
        "imitation_batches": 1,
    },
    "style": {"hidden": [16], "batch_size": 16, "batches": 1, "replay_size": 40, "replay_keep": 8},
    "new_tasks_every": 2,
}
TIMES = ("minutes", "steps_per_s", "simulation_share")


def config(**changes):
    return training_config(TINY, changes)


def prepare(folder):
    """A motion set, so that none has to be recorded."""
    motion = MotionSet.of([torch.randn(60, FRAME_DIM, generator=torch.Generator().manual_seed(0))])
    folder.mkdir(exist_ok=True)
    motion.save(folder / "motion_set.safetensors")
    return folder


def curve(folder):
    with (folder / "curve.csv").open() as file:
        return [{k: v for k, v in row.items() if k not in TIMES} for row in csv.DictReader(file)]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = prepare(tmp_path_factory.mktemp("whole"))
    train_teacher(config(), folder, progress=False)
    return folder


def test_leaves_weights_and_curves(whole):
    rows = curve(whole)
    assert [r["kind"] for r in rows] == ["dagger"] * 2 + ["ppo"] * 15
    assert int(rows[-1]["samples"]) == 200
    assert float(rows[1]["beta"]) == 0.6
    assert float(rows[5]["style_reward"]) > 0
    assert float(rows[5]["style_good"]) > 0
    assert "action_loss" in rows[-1]
    assert (whole / "curve_dagger.png").stat().st_size > 1000
    assert (whole / "curve_ppo.png").stat().st_size > 1000
    assert any((whole / "tensorboard").iterdir())
    assert load_decision(whole / "teacher.safetensors").config == config().teacher
    assert not list(whole.glob("*.tmp"))


def test_stopped_early_it_goes_on(whole, tmp_path):
    prepare(tmp_path)
    for ppo in (0, 24, 120):  # the middle one stops between two checkpoints
        train_teacher(config(**{"ppo.samples": ppo}), tmp_path, progress=False)
    assert curve(tmp_path)[:2] == curve(whole)[:2]
    assert len(curve(tmp_path)) == len(curve(whole))
    with pytest.raises(ValueError, match=r"holds a training with another seed; choose another output"):
        train_teacher(config(seed=3), tmp_path, progress=False)


def test_stopped_at_a_checkpoint_of_ppo_it_goes_on_to_the_bit(whole, tmp_path):
    prepare(tmp_path)
    for ppo in (96, 120):
        train_teacher(config(**{"ppo.samples": ppo}), tmp_path, progress=False)
    assert curve(tmp_path)[2:] == curve(whole)[2:]
    first, second = (load_decision(f / "teacher.safetensors").state_dict() for f in (whole, tmp_path))
    assert all(torch.equal(first[k], second[k]) for k in first)


def test_a_motion_set_is_recorded_without_touching_those_who_practise(tmp_path):
    """Imitation alone, then a motion set of as many robots as practise: their controllers remember what they did."""
    from hv_teachers.ranks import Ranks
    from hv_teachers.teacher_training import _Trainer

    trainer = _Trainer(config(**{"motion_tasks": 4}), tmp_path, Ranks(), False)
    trainer._dagger_round()
    memory = trainer.prior.memory
    before = memory.select(torch.arange(4))
    trainer._begin_ppo()
    assert trainer.prior.memory is memory
    for name, value in vars(before).items():
        assert torch.equal(getattr(memory, name), value), name


def test_of_a_stage_that_ends_when_placed_nothing_after_it_is_learned(tmp_path):
    from hv_policy.decision.view import Phase
    from hv_teachers.ranks import Ranks
    from hv_teachers.teacher_training import _Trainer

    for ends in (True, False):
        trainer = _Trainer(config(**{"env.end_when_placed": ends}), prepare(tmp_path / str(ends)), Ranks(), False)
        trainer.env.look()
        trainer.env.senses.memory.phase[:2] = int(Phase.RELEASE)
        trainer._dagger_round()
        learned = trainer.buffer.all().here.phase
        assert bool((learned >= Phase.RELEASE).any()) is not ends
        assert len(learned) == (38 if ends else 40), "two labels of the first step"
        taught = trainer._taught(torch.tensor([Phase.LOWER, Phase.RELEASE, Phase.IDLE]))
        assert taught.tolist() == [True, not ends, not ends]


def test_killed_and_started_again_is_the_same(whole, tmp_path):
    prepare(tmp_path)
    arguments = [f"output={tmp_path}", "dagger.samples=80", "ppo.samples=120", *_flat(TINY)]
    command = [sys.executable, "-m", "hv_scripts.train_teacher", "stage=1", *arguments]
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment)
    deadline = time.time() + 120
    while not (tmp_path / "resume.pt").exists() and process.poll() is None and time.time() < deadline:
        time.sleep(0.02)
    time.sleep(0.5)  # somewhere in the middle of what follows
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert (tmp_path / "resume.pt").exists()
    subprocess.run(command, check=True, capture_output=True, env=environment)
    assert curve(tmp_path) == curve(whole)
    first, second = (load_decision(f / "teacher.safetensors").state_dict() for f in (whole, tmp_path))
    assert all(torch.equal(first[k], second[k]) for k in first)


def _flat(values, prefix=""):
    flat = []
    for key, value in values.items():
        if isinstance(value, dict):
            flat += _flat(value, f"{prefix}{key}.")
        elif f"{prefix}{key}" not in ("dagger.samples", "ppo.samples"):
            flat.append(f"{prefix}{key}={value}")
    return [*flat, "name=teacher"] if not prefix else flat


def test_a_recipe_goes_through_its_stages(tmp_path, whole):
    short = {k: v for k, v in TINY.items() if k not in ("tasks", "part")} | {
        "tasks": "living_room_1,living_room_8", "style": {"weight": 0.0},
        "dagger.samples": 0, "ppo.samples": 8, "env.num_envs": 2,
    }  # fmt: skip
    recipe = read_recipe("humanoidverse_teacher")
    train_recipe(recipe, tmp_path, {**short, "reuse.stage1": str(whole)}, progress=False)
    assert len(Teacher.load(tmp_path).networks) == 2
    assert [r["kind"] for r in curve(tmp_path / "stage2")] == ["ppo"] * 2
    assert "retreat_hand2object" in curve(tmp_path / "stage2")[0]
    # nobody has finished a first sub-task yet, so teacher 2 has nothing to learn from
    unchanged = load_decision(tmp_path / "stage3" / "teacher.safetensors").state_dict()
    start = load_decision(whole / "teacher.safetensors").state_dict()
    assert all(torch.equal(unchanged[k], start[k]) for k in start)
    with pytest.raises(ValueError, match=r"reuse\.stage9: no such stage; valid: stage1, stage2, stage3"):
        train_recipe(recipe, tmp_path, {"reuse.stage9": "x"}, progress=False)


def test_another_network_cannot_be_the_beginning(whole, tmp_path):
    values = read_yaml("teacher_stage2") | {"init": str(whole / "teacher.safetensors")}
    with pytest.raises(ValueError, match=r"init: .* is another network; teacher must be"):
        train_teacher(training_config(values, {"tasks": "living_room"}), tmp_path, progress=False)
    assert not any(tmp_path.iterdir())  # nothing was begun


def test_what_other_code_wrote_is_refused_in_a_line(tmp_path):
    prepare(tmp_path)
    train_teacher(config(**{"ppo.samples": 0}), tmp_path, progress=False)
    saved = torch.load(tmp_path / "resume.pt", weights_only=True)
    del saved["env"]["rising"]
    torch.save(saved, tmp_path / "resume.pt")
    with pytest.raises(ValueError, match=r"output: .*resume\.pt lacks 'rising', .* valid: a new folder"):
        train_teacher(config(**{"dagger.samples": 160, "ppo.samples": 0}), tmp_path, progress=False)
