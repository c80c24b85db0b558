"""The whole path once, small: record an expert, train on it, evaluate; and the trained student that comes with the
package, filmed on a seen and an unseen task. About six minutes on two cores.

    make demo        (or: hv-demo --output outputs/demo)

Leaves in the output folder: demo.mp4, the student (third person left, head camera right, the instruction underneath),
expert.mp4, metrics.json, the dataset, the checkpoint and the logs of the stock `lerobot-train` and `lerobot-eval`.
"""

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

TASKS = ("living_room_8", "living_room_3")
STUDENTS_TASKS = ("seen_044", "unseen_058")
STUDENTS_SEED = 11
TRAINING_STEPS = 60
EVALUATION_STEPS = 240  # of an episode: 8 s, enough to see the untrained-looking student lose its balance

OFFLINE = {
    "HF_HUB_OFFLINE": "1",
    "HF_DATASETS_OFFLINE": "1",
    "TOKENIZERS_PARALLELISM": "false",
    "PYTHONHASHSEED": "0",
    "OMP_WAIT_POLICY": "passive",  # threads that spin while waiting stall a machine shared with others
}


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, default=Path("outputs/demo"), help="folder; an earlier demo is replaced")
    output = parser.parse_args(arguments).output
    if output.exists() and not (output / "demo.mp4").exists() and any(output.iterdir()):
        print(f"error: --output: {output} exists and does not look like an earlier demo", file=sys.stderr)
        return 1
    os.environ.update(OFFLINE)

    from hv_sim.gl_backend import GLError
    from hv_teachers.dataset_format import RecordingError

    started = time.perf_counter()
    partial = output.with_name(f"{output.name}.partial-{os.getpid()}")
    try:
        run_demo(partial)
        shutil.rmtree(output, ignore_errors=True)
        partial.replace(output)
    except (CommandError, RecordingError, GLError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    finally:
        shutil.rmtree(partial, ignore_errors=True)
    minutes = (time.perf_counter() - started) / 60
    print(f"Done in {minutes:.1f} minutes: watch {output / 'demo.mp4'}, read {output / 'metrics.json'}")
    return 0


def run_demo(folder: Path) -> None:
    """Fills `folder`, step by step: dataset, checkpoint, evaluation, film, metrics."""
    from lerobot.utils.io_utils import write_video

    from hv_sim.metrics import save_metrics
    from hv_sim.task import load_task
    from hv_teachers.expert import PlannerExpert
    from hv_teachers.recording import RecordingConfig, record_dataset
    from hv_teachers.replay import replay_episode

    folder.mkdir(parents=True)
    tasks = {name: load_task(name) for name in TASKS}
    dataset, seconds = folder / "dataset", {}

    clock = time.perf_counter()
    report = record_dataset(dataset, list(tasks.values()), PlannerExpert, RecordingConfig(seed=0))
    seconds["record"] = time.perf_counter() - clock

    clock = time.perf_counter()
    training = folder / "train"
    run_stock_command(
        "lerobot-train",
        [
            "--policy.type=hv",
            "--policy.push_to_hub=false",
            "--policy.device=cpu",
            f"--dataset.repo_id={dataset.name}",
            f"--dataset.root={dataset}",
            f"--output_dir={training}",
            f"--steps={TRAINING_STEPS}",
            "--batch_size=32",
            "--num_workers=0",
            "--log_freq=20",
            "--env_eval_freq=0",
        ],
        folder / "train.log",
    )
    seconds["train"] = time.perf_counter() - clock

    clock = time.perf_counter()
    evaluation = folder / "eval"
    run_stock_command(
        "lerobot-eval",
        [
            f"--policy.path={training / 'checkpoints' / 'last' / 'pretrained_model'}",
            "--policy.device=cpu",
            "--env.type=hv_sim",
            f"--env.task={','.join(TASKS)}",
            f"--env.episode_length={EVALUATION_STEPS}",
            "--eval.n_episodes=1",
            "--eval.batch_size=1",
            f"--output_dir={evaluation}",
        ],
        folder / "eval.log",
    )
    seconds["evaluate"] = time.perf_counter() - clock

    clock = time.perf_counter()
    replayed = []
    furthest = max(report.attempts, key=lambda attempt: (attempt.num_finished, attempt.num_frames))
    for attempt in report.attempts:
        record, frames = replay_episode(dataset, tasks[attempt.task], attempt, frame_stride=2)
        replayed.append(record)
        if attempt is furthest:
            write_video(folder / "expert.mp4", frames, fps=15)
    shown = film_student(folder)
    seconds["film"] = time.perf_counter() - clock

    trained = json.loads((evaluation / "eval_info.json").read_text())["overall"]
    save_metrics(
        folder / "metrics.json",
        replayed,
        who="PlannerExpert",
        student=shown,
        trained_here={key: trained[key] for key in ("avg_max_reward", "pc_success", "n_episodes") if key in trained},
        dataset={"episodes": report.num_episodes, "frames": report.frames_recorded, "failed": report.num_failed},
        filmed={"task": furthest.task, "repeat": furthest.repeat},
        seconds={name: round(value, 1) for name, value in seconds.items()},
    )


def film_student(folder: Path) -> list[dict[str, Any]]:
    """Lets the student that comes with the package play `STUDENTS_TASKS`: `folder/demo.mp4`; how each episode ended."""
    from lerobot.utils.io_utils import write_video

    from hv_sim.task import resolve_tasks
    from hv_teachers.evaluation import EvaluationConfig, evaluate, read_outcomes, video_path

    tasks, played = [task for name in STUDENTS_TASKS for task in resolve_tasks(name)], folder / "student"
    print(f"the student plays {' and '.join(STUDENTS_TASKS)} ...", flush=True)
    config = EvaluationConfig(policy="student", suite="demo", seed=STUDENTS_SEED)
    evaluate(config, tasks, played, videos=[task.name for task in tasks])
    films = [iter_frames(video_path(played, task.name, 0)) for task in tasks]
    write_video(folder / "demo.mp4", [frame for film in films for frame in film], fps=15)
    records = [outcome.record for outcome in read_outcomes(played)]
    return [
        {"task": r.task, "distances_m": [round(d, 3) for d in r.distances_m], "fallen": r.fallen} for r in records
    ]


def iter_frames(film: Path) -> Iterator[np.ndarray]:
    """(H, W, 3) uint8 frames of a film."""
    import av

    with av.open(str(film)) as opened:
        for frame in opened.decode(video=0):
            yield frame.to_ndarray(format="rgb24")


class CommandError(RuntimeError):
    """A stock command failed; the message is one line that names its log."""


def run_stock_command(name: str, arguments: list[str], log: Path) -> None:
    """Runs `name` of this Python's environment offline; shows its progress bars and keeps everything else in `log`.

    Raises:
        CommandError: it exits with another status than 0.
    """
    print(f"{name} {' '.join(arguments[:2])} ...   (everything it says: {log.name})", flush=True)
    command = [str(Path(sys.executable).with_name(name)), *arguments]
    environment = {**os.environ, **OFFLINE}
    said = []
    with (
        open(log, "wb") as file,
        subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as process,
    ):
        assert process.stdout is not None
        pending = b""
        while chunk := os.read(process.stdout.fileno(), 4096):
            file.write(chunk)
            *lines, pending = re.split(rb"[\r\n]", pending + chunk)
            for line in (raw.decode(errors="replace").strip() for raw in lines):
                if re.search(r"\d+%\|", line):
                    print(f"\r\033[K{line[:110]}", end="", flush=True)
                elif line:
                    said.append(line)
    print("\r\033[K", end="", flush=True)
    if process.returncode:
        kept = log.parent.with_name(f"{log.parent.name}-failed.log")
        log.replace(kept)
        last = said[-1][:200] if said else "it said nothing"
        raise CommandError(f"{name} failed (status {process.returncode}, all it said is in {kept}): {last}")


if __name__ == "__main__":
    sys.exit(main())
