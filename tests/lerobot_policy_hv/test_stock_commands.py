"""The stock `lerobot-*` commands with `--policy.type=hv` and `--env.type=hv_sim`, run as a user runs them."""

import json
import re
import shutil
import socket
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from safetensors.torch import load_file
from stand_still import StandStill
from stock_commands import error_lines, run_command

from hv_sim.rearrange_env import RearrangeEnv
from hv_sim.task import resolve_tasks, save_task
from hv_teachers.episodes import Episode, film_episode
from hv_teachers.evaluated_policies import load_evaluated_policy
from hv_teachers.recording import RecordingConfig, record_dataset

POLICY = ("--policy.push_to_hub=false", "--policy.device=cpu")
ENVIRONMENT = (
    "--env.type=hv_sim",
    "--env.task=living_room_1",
    "--env.episode_length=10",
    "--env.observation_height=64",
    "--env.observation_width=64",
    "--eval.use_async_envs=false",
)


@pytest.fixture(scope="module")
def dataset(tmp_path_factory) -> Path:
    root = tmp_path_factory.mktemp("data") / "standing"
    record_dataset(root, resolve_tasks("living_room")[:2], StandStill, RecordingConfig(0, 64, 24))
    return root


@pytest.fixture(scope="module")
def run_folder(tmp_path_factory, dataset: Path) -> Path:
    """The output folder of a training run of four steps, with a checkpoint after two."""
    folder = tmp_path_factory.mktemp("train") / "run"
    done = run_command(
        "lerobot-train",
        "--policy.type=hv",
        "--policy.form=direct",
        *POLICY,
        "--policy.image_size=64",
        "--policy.memory_dropout=0",  # chance would keep a resumed run from repeating the same steps exactly
        "--policy.word_dropout=0",
        f"--dataset.repo_id={dataset.name}",
        f"--dataset.root={dataset}",
        f"--output_dir={folder}",
        "--steps=4",
        "--save_freq=2",
        "--log_freq=1",
        "--batch_size=4",
        "--num_workers=0",
    )
    assert done.returncode == 0, done.stdout[-3000:]
    assert len(re.findall(r"action_error:0\.\d+", done.stdout)) == 4
    return folder


def checkpoint(run_folder: Path, step: int) -> Path:
    return run_folder / "checkpoints" / f"{step:06d}" / "pretrained_model"


@pytest.mark.parametrize("command", ["lerobot-train", "lerobot-eval"])
def test_the_choices_are_listed(command: str):
    shown = run_command(command, "--help").stdout
    assert re.search(r"--policy\.type \{[^}]*\bhv\b[^}]*\}", shown)
    assert re.search(r"--env\.type \{[^}]*\bhv_sim\b[^}]*\}", shown)


def test_the_vocabulary_and_the_statistics_are_in_the_checkpoint(run_folder: Path, dataset: Path):
    config = json.loads((checkpoint(run_folder, 4) / "config.json").read_text())
    instructions = " ".join(task.subtasks[0].instruction for task in resolve_tasks("living_room")[:2]).lower()
    assert config["type"] == "hv"
    assert config["vocabulary"] == sorted(config["vocabulary"])
    assert set(re.findall("[a-z]+", instructions)) <= set(config["vocabulary"])
    weights = load_file(checkpoint(run_folder, 4) / "model.safetensors")
    mean = json.loads((dataset / "meta" / "stats.json").read_text())["observation.state"]["mean"]
    assert weights["network.state_units.mean"].tolist() == pytest.approx(mean, abs=1e-6)


def test_resumed_training_continues(run_folder: Path, tmp_path: Path):
    """From the checkpoint after two steps on, the same two steps follow as in the uninterrupted run."""
    copy = tmp_path / "run"
    shutil.copytree(run_folder, copy, symlinks=True)
    shutil.rmtree(copy / "checkpoints" / "000004")
    config = checkpoint(copy, 2) / "train_config.json"
    done = run_command("lerobot-train", f"--config_path={config}", "--resume=true", f"--output_dir={copy}")
    assert done.returncode == 0, done.stdout[-3000:]
    assert re.findall(r"step:(\d+)", done.stdout) == ["3", "4"]
    expected = load_file(checkpoint(run_folder, 4) / "model.safetensors")
    resumed = load_file(checkpoint(copy, 4) / "model.safetensors")
    assert expected.keys() == resumed.keys()
    start = load_file(checkpoint(copy, 2) / "model.safetensors")
    moved = sum(float((expected[key] - start[key]).abs().sum()) for key in expected)
    apart = sum(float((expected[key] - resumed[key]).abs().sum()) for key in expected)
    assert moved > 0
    assert apart < 1e-3 * moved


@pytest.mark.slow
def test_two_processes_train_one_student(dataset: Path, tmp_path: Path):
    """Accelerate starts the stock trainer twice; gradients are shared, so there is one checkpoint, and it loads."""
    folder = tmp_path / "run"
    done = run_command(
        "accelerate",
        "launch",
        "--multi_gpu",  # its launcher of many processes; --cpu starts one
        "--num_processes=2",
        "--num_machines=1",
        "--mixed_precision=no",
        "--dynamo_backend=no",
        f"--main_process_port={free_port()}",
        Path(sys.executable).with_name("lerobot-train"),
        "--policy.type=hv",
        *POLICY,
        "--policy.image_size=64",
        f"--dataset.repo_id={dataset.name}",
        f"--dataset.root={dataset}",
        f"--output_dir={folder}",
        "--steps=2",
        "--save_freq=2",
        "--log_freq=1",
        "--batch_size=4",
        "--num_workers=0",
        ACCELERATE_USE_CPU="true",
    )
    assert done.returncode == 0, done.stdout[-3000:]
    assert "Effective batch size: 4 x 2 = 8" in done.stdout
    assert len(re.findall(r"\bloss:\d", done.stdout)) == 2, "one process speaks"
    weights = load_file(checkpoint(folder, 2) / "model.safetensors")
    assert all(value.isfinite().all() for value in weights.values())


def free_port() -> int:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return int(listener.getsockname()[1])


def test_evaluation_runs_whatever_the_batch_size(run_folder: Path, tmp_path: Path):
    episodes = []
    for batch_size in (1, 2):
        folder = tmp_path / f"batch_{batch_size}"
        done = run_command(
            "lerobot-eval",
            f"--policy.path={checkpoint(run_folder, 4)}",
            "--policy.device=cpu",
            *ENVIRONMENT,
            "--eval.n_episodes=2",
            f"--eval.batch_size={batch_size}",
            f"--output_dir={folder}",
        )
        assert done.returncode == 0, done.stdout[-3000:]
        info = json.loads((folder / "eval_info.json").read_text())
        assert info["overall"]["n_episodes"] == 2
        assert len(list(folder.rglob("*.mp4"))) == 2
        episodes.append(info["per_task"][0]["metrics"])
    assert episodes[0]["successes"] == episodes[1]["successes"] == [False, False]
    assert episodes[0]["sum_rewards"] == pytest.approx(episodes[1]["sum_rewards"], abs=1e-4)


def test_hv_eval_plays_what_lerobot_eval_plays(run_folder: Path, tmp_path: Path):
    """The same tasks and seeds: the same successes, and the same rewards. One task is done from the start."""
    hard = resolve_tasks("living_room_1")[0]
    first = hard.subtasks[0]
    place = next(o.position_m for o in hard.objects if o.name == first.object)
    near = (place[0] + 0.02, *place[1:])
    easy = replace(hard, name="easy", subtasks=(replace(first, goal_position_m=near),))
    policy = load_evaluated_policy(str(checkpoint(run_folder, 4)))
    for task, succeeds in ((easy, True), (hard, False)):
        file = tmp_path / f"{task.name}.json"
        save_task(task, file)
        done = run_command(
            "lerobot-eval",
            f"--policy.path={checkpoint(run_folder, 4)}",
            "--policy.device=cpu",
            *(option for option in ENVIRONMENT if not option.startswith("--env.task=")),
            f"--env.task={file}",
            "--eval.n_episodes=2",
            "--eval.batch_size=1",
            "--seed=40",
            f"--output_dir={tmp_path / task.name}",
        )
        assert done.returncode == 0, done.stdout[-3000:]
        metrics = json.loads((tmp_path / task.name / "eval_info.json").read_text())["per_task"][0]["metrics"]
        assert metrics["successes"] == [succeeds] * 2
        for seed, reward in zip((40, 41), metrics["sum_rewards"], strict=True):
            env = RearrangeEnv(task, max_episode_steps=10, observation_height=64, observation_width=64)
            observation, _ = env.reset(seed=seed)
            policy.reset(1)
            total, over = 0.0, False
            while not over:
                observation, step_reward, ended, cut, info = env.step(policy(env.world, observation)[0].numpy())
                total, over = total + step_reward, ended or cut
            record = env.world.records()[0]
            env.close()
            assert info["is_success"] == succeeds
            assert total == pytest.approx(reward, abs=1e-5)
            assert film_episode(Episode(task, 0, seed), policy, 10).record == record, "hv-eval's, to the bit"


def test_a_checkpoint_of_another_shape_is_refused_in_one_line(run_folder: Path, tmp_path: Path):
    other = tmp_path / "other"
    shutil.copytree(checkpoint(run_folder, 4), other)
    config = json.loads((other / "config.json").read_text())
    (other / "config.json").write_text(json.dumps(config | {"size": "base"}))
    done = run_command(
        "lerobot-eval",
        f"--policy.path={other}",
        "--policy.device=cpu",
        *ENVIRONMENT,
        f"--output_dir={tmp_path / 'out'}",
    )
    assert done.returncode == 1
    [line] = error_lines(done.stdout)
    assert line.startswith(f"error: checkpoint {other}: network.")
    assert line.endswith("it was made with another configuration")
