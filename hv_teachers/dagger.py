"""DAgger rounds of a student through LeRobot's own tools: record, join, train on, measure; each part is done once.

Round 0 is what the teacher does, and glances round the same rooms. In every later round the student of the round
before acts, the teacher takes over in a share beta ** round of the time and says at every state what should have been
done. All rounds' recordings are joined and the stock `lerobot-train` goes on from the last checkpoint. What exists
already in the folder is kept: after a kill the same call goes on with what is missing.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from datasets.utils.logging import disable_progress_bar
from lerobot.datasets.aggregate import aggregate_datasets

from hv_teachers.curves import plot_curve
from hv_teachers.engines import num_processes
from hv_teachers.recording import moved_into_place
from hv_teachers.whole_files import write_whole

CONFIG_FILE, TABLE_FILE, PICTURE_FILE = "dagger.json", "rounds.csv", "rounds.png"
_MAY_GROW = ("rounds", "workers")


class DaggerError(ValueError):
    """DAgger that cannot be done; the message is one line."""


@dataclass(frozen=True)
class DaggerRounds:
    """What is done in each round.

    Args:
        tasks: suite, tasks or files to record.
        rounds: rounds after the first.
        first_steps: optimiser steps on the teacher's own recording.
        steps: the same in each later round.
        beta: share of the time in which the teacher acts in round 1; its powers in the following ones.
        repeats: attempts of each task in every round.
        glances: pictures of each task from random places besides (`hv_teachers.glances`), once.
        frame_stride: see `hv_teachers.recording.RecordingConfig`.
        num_envs: attempts that a process simulates side by side.
        eval_suite, eval_tasks: what the student is measured on after each round.
        seed: of the whole.
        workers: processes, 0 for one per core.
        train: further options of `lerobot-train`, such as `--batch_size=64`.

    Raises:
        DaggerError: a field is not valid.
    """

    tasks: str = "seen"
    rounds: int = 3
    first_steps: int = 10_000
    steps: int = 5_000
    beta: float = 0.3
    repeats: int = 1
    glances: int = 48
    frame_stride: int = 6
    num_envs: int = 32
    eval_suite: str = "seen"
    eval_tasks: int = 24
    seed: int = 0
    workers: int = 0
    train: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        lowest = {"rounds": 0, "first_steps": 1, "steps": 1, "repeats": 1, "glances": 0, "eval_tasks": 1}
        for name, least in lowest.items():
            if getattr(self, name) < least:
                raise DaggerError(f"{name}: {getattr(self, name)} is not valid; valid: an integer >= {least}")
        if not 0 <= self.beta <= 1:
            raise DaggerError(f"beta: {self.beta} is not valid; valid: 0 to 1")


def run_rounds(folder: Path, config: DaggerRounds) -> list[dict[str, float]]:
    """Does the rounds that are missing in `folder`; returns the table, which is also `rounds.csv` and `rounds.png`.

    Raises:
        DaggerError: the folder is of other rounds, or a command failed; its output ends in the folder's log.
    """
    folder.mkdir(parents=True, exist_ok=True)
    _same_or_new(folder / CONFIG_FILE, config)
    table: list[dict[str, float]] = []
    policy: Path | None = None
    recordings: list[Path] = []
    for number in range(config.rounds + 1):
        place = folder / f"round_{number}"
        place.mkdir(exist_ok=True)
        recordings += _record(place, number, policy, config)
        policy = _train(place, number, policy, _joined(place, recordings), config)
        metrics = _evaluate(place, policy, config)
        table.append({"round": number, **metrics})
        _write_table(folder, table)
    return table


def _same_or_new(file: Path, config: DaggerRounds) -> None:
    wanted = json.loads(json.dumps(asdict(config)))
    if file.exists():
        before = json.loads(file.read_text())
        for name, value in wanted.items():
            if name not in _MAY_GROW and before.get(name) != value:
                raise DaggerError(f"{file.parent}: was begun with {name}={before.get(name)}, not {value}")
    write_whole(file, json.dumps(wanted, indent=1) + "\n")


def _record(place: Path, number: int, policy: Path | None, config: DaggerRounds) -> list[Path]:
    """What is new in a round: attempts, and in the first one glances."""
    root = place / f"recording_{number}"
    acting = ["--policy", "teacher"] if policy is None else ["--policy", policy, "--beta", config.beta**number]
    kinds: list[tuple[Path, list[object]]] = [(root, [*acting, "--repeats", config.repeats, "--end-when-fallen"])]
    if policy is None and config.glances:
        kinds.append((place / "glances", ["--glances", config.glances]))
    for folder, what in kinds:
        if not folder.exists():
            _run(
                place, "record", "--root", folder, "--tasks", config.tasks, "--seed", config.seed + 1000 * number,
                "--frame-stride", config.frame_stride, "--num-envs", config.num_envs,
                "--workers", num_processes(config.workers), *what,
            )  # fmt: skip
    return [folder for folder, _ in kinds]


def _joined(place: Path, recordings: Sequence[Path]) -> Path:
    """All recordings so far as one dataset."""
    if len(recordings) == 1:
        return recordings[0]
    root = place / "joined"
    if not root.exists():
        with moved_into_place(root) as written:
            disable_progress_bar()
            aggregate_datasets([r.name for r in recordings], root.name, roots=list(recordings), aggr_root=written)
    return root


def _train(place: Path, number: int, policy: Path | None, dataset: Path, config: DaggerRounds) -> Path:
    output, steps = place / "train", config.steps if number else config.first_steps
    last = output / "checkpoints" / "last" / "pretrained_model"
    if (output / "checkpoints" / f"{steps:06d}").exists():
        return last
    if last.exists():
        _run(place, "lerobot-train", f"--config_path={last / 'train_config.json'}", "--resume=true")
        return last
    if output.exists():
        shutil.rmtree(output)  # killed before its first checkpoint
    begin = ["--policy.type=hv"] if policy is None else [f"--policy.path={policy}"]
    _run(
        place, "lerobot-train", *begin, "--policy.push_to_hub=false", f"--dataset.repo_id={dataset.name}",
        f"--dataset.root={dataset}", f"--output_dir={output}", f"--steps={steps}", f"--save_freq={max(1, steps // 5)}",
        f"--seed={config.seed + number}", "--env_eval_freq=0", "--log_freq=50", *config.train,
    )  # fmt: skip
    return last


def _evaluate(place: Path, policy: Path, config: DaggerRounds) -> dict[str, float]:
    output = place / "evaluation"
    if not (output / "metrics.json").exists():
        _run(
            place, "evaluate", f"--policy={policy}", f"--suite={config.eval_suite}", "--n-tasks", config.eval_tasks,
            "--workers", num_processes(config.workers), "--output", output,
        )  # fmt: skip
    metrics = json.loads((output / "metrics.json").read_text())
    successes = {k: v for k, v in metrics["at_0.4"].items() if v is not None}
    return {**successes, "fall_rate": metrics["fall_rate"], "episodes": metrics["n_episodes"]}


def _run(place: Path, command: str, *arguments: object) -> None:
    """One of our commands or of LeRobot's, in a process of its own, its output to `COMMAND.log`."""
    ours = not command.startswith("lerobot-")
    program = (
        [sys.executable, "-m", f"hv_scripts.{command}"] if ours else [str(Path(sys.executable).with_name(command))]
    )
    log = place / f"{command}.log"
    with log.open("a") as file:
        print("+", command, *arguments, file=file, flush=True)
        done = subprocess.run([*program, *map(str, arguments)], stdout=file, stderr=subprocess.STDOUT)
    if done.returncode:
        lines = [line for line in log.read_text(errors="replace").splitlines() if line.strip()]
        raise DaggerError(f"{command}: failed ({lines[-1][:200]}); all of it: {log}")


def _write_table(folder: Path, table: Sequence[dict[str, float]]) -> None:
    lines = [",".join(table[0]), *(",".join(f"{v:g}" for v in row.values()) for row in table)]
    write_whole(folder / TABLE_FILE, "\n".join(lines) + "\n")
    shown = [c for c in table[0] if c.startswith("success")]
    plot_curve(folder / TABLE_FILE, folder / PICTURE_FILE, [*shown, "fall_rate"], x="round", smooth=1)
