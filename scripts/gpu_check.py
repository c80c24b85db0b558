"""make gpu-check: what the GPU engine does on this machine, from tests to a training; nothing is downloaded.

    python -m hv_scripts.gpu_check --output outputs/gpu_check --minutes 25

Leaves tests.log (parity of Warp on the GPU with MuJoCo on the CPU), throughput.json and throughput.md (worlds against
control steps/s and pictures/s), and training/ (a teacher, by DAgger, with its curve). Beside the training most of the
time goes into compiling kernels, the first time.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

WORLDS = (64, 256, 1024, 4096)
MOST_MINUTES = 25.0
ROOT = Path(__file__).resolve().parents[1]


def main(arguments: list[str] | None = None) -> int:
    """Runs the checks in turn; 0 if every one went well."""
    options = _parse(arguments)
    try:
        device = find_gpu()
    except ValueError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    options.output.mkdir(parents=True, exist_ok=True)
    print(f"device: {device}", flush=True)
    tests = parity_tests(options.output / "tests.log")
    measure(options.output)
    trained = train(options.output / "training", options.minutes)
    print(f"parity tests {'passed' if tests else 'FAILED'}; training {'went well' if trained else 'FAILED'}")
    print(f"results: {options.output}")
    return 0 if tests and trained else 1


def find_gpu() -> str:
    """Name of the first NVIDIA GPU that Warp can use.

    Raises:
        ValueError: there is none, or Warp is not installed.
    """
    from hv_sim.warp_physics import require_warp

    warp, _ = require_warp()
    devices = warp.get_cuda_devices()
    if not devices:
        raise ValueError(
            "no NVIDIA GPU was found on this machine (warp lists none); gpu-check checks nothing without one"
        )
    return f"{devices[0].alias} ({devices[0].name})"


def parity_tests(log: Path) -> bool:
    """Runs every test of Warp on the GPU; whether all passed."""
    command = [sys.executable, "-m", "pytest", "-k", "warp", "tests", "-v"]
    done = subprocess.run(
        command, cwd=ROOT, env={**os.environ, "HV_WARP_DEVICE": "cuda:0"}, text=True, stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    )  # fmt: skip
    log.write_text(done.stdout)
    print(f"parity tests: {done.stdout.strip().splitlines()[-1]}", flush=True)
    return done.returncode == 0


def measure(output: Path) -> None:
    """Writes the table of throughputs."""
    from hv_sim.benchmark import benchmark_backend
    from hv_sim.task import load_task
    from hv_teachers.whole_files import write_whole

    rows: list[dict[str, Any]] = []
    for physics, counts in (("cpu", WORLDS[:2]), ("warp", WORLDS)):
        for num in counts:
            rows.append(
                {"physics": physics, **benchmark_backend([load_task("living_room_1")], physics=physics, num_envs=num)}
            )
            write_whole(output / "throughput.json", json.dumps(rows, indent=1) + "\n")
            write_whole(output / "throughput.md", table(rows))
    print(table(rows), flush=True)


def table(rows: list[dict[str, Any]]) -> str:
    """The figures of `hv_sim.benchmark.benchmark_backend` as Markdown."""
    lines = [
        "| engine | worlds | control steps/s, observed | control steps/s, physics and its state | pictures/s, 128 px |",
        "|---|---|---|---|---|",
    ]
    for row in rows:
        figures = (row["control_steps_per_s"], row["physics_steps_per_s"], row["pictures_per_s"])
        lines.append(f"| {row['physics']} | {row['num_envs']} | " + " | ".join(f"{f:,.0f}" for f in figures) + " |")
    return "\n".join(lines) + "\n"


def train(output: Path, minutes: float) -> bool:
    """Trains Stage 1 on the GPU engine until the time is over; whether it got as far as a checkpoint."""
    command = [
        sys.executable, "-m", "hv_scripts.train_teacher", "stage=1", f"output={output}", "tasks=living_room",
        "part=single", "env.physics=warp", "env.num_envs=512", "ppo.samples=0", "dagger.samples=1e8", "name=gpu_check",
    ]  # fmt: skip
    with (output.with_suffix(".log")).open("w") as log:
        process = subprocess.Popen(command, cwd=ROOT, stdout=log, stderr=subprocess.STDOUT)
        try:
            process.wait(timeout=60 * minutes)
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)  # a checkpoint is whole or not there
            process.wait()
    return (output / "teacher.safetensors").exists() and (output / "curve.csv").exists()


def _parse(arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, default=Path("outputs/gpu_check"))
    parser.add_argument("--minutes", type=float, default=MOST_MINUTES, help="of the training, at most 25")
    options = parser.parse_args(arguments)
    if not 0 < options.minutes <= MOST_MINUTES:
        parser.error(f"--minutes: {options.minutes} is not valid; valid: more than 0, at most {MOST_MINUTES:.0f}")
    return options


if __name__ == "__main__":
    sys.exit(main())
