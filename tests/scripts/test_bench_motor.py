"""hv-bench-motor: the keys it promises, the same figures for the same seed, and clear refusals."""

import json
from pathlib import Path

import pytest
from stock_commands import error_lines, run_command

from hv_policy.motor.prior import load_shipped_motor_prior
from hv_scripts.bench_motor import BARS, table
from hv_teachers.motor_benchmark import MotorBenchmark, run_motor_benchmark


def test_bad_arguments_are_refused(tmp_path: Path):
    done = run_command("hv-bench-motor", "--episodes", "0", "--output", tmp_path)
    assert done.returncode == 2
    [line] = error_lines(done.stdout)
    assert "--episodes" in line
    (tmp_path / "junk.safetensors").write_bytes(b"junk")
    done = run_command("hv-bench-motor", "--weights", tmp_path / "junk.safetensors", "--output", tmp_path / "out")
    assert done.returncode == 2
    [line] = error_lines(done.stdout)
    assert "junk.safetensors" in line
    assert not (tmp_path / "out").exists()


def test_a_run_that_could_not_be_written_is_not_begun(tmp_path: Path):
    (tmp_path / "file").write_text("")
    done = run_command("hv-bench-motor", "--episodes", "4", "--output", tmp_path / "file")
    assert done.returncode == 2
    [line] = error_lines(done.stdout)
    assert "--output" in line


def test_what_is_not_a_number_is_short_of_its_bar():
    lines = table({"intent_survival": 0.97, "velocity_rmse": float("nan"), "hand_error_walking": 0.01, "episodes": 4.0})
    assert [line.split()[-1] for line in lines[1:]] == ["reached", "short", "reached", "4.000"]


@pytest.mark.slow
def test_the_same_seed_gives_the_same_figures(tmp_path: Path):
    for run in ("a", "b"):
        done = run_command("hv-bench-motor", "--episodes", "4", "--seed", "3", "--output", tmp_path / run)
        assert done.returncode == 0, done.stdout
    first, second = (json.loads((tmp_path / run / "motor.json").read_text()) for run in ("a", "b"))
    assert first == second
    assert set(BARS) <= set(first)
    assert first["physics_hz"] == 120


def test_figures_are_shares_and_errors(monkeypatch):
    import hv_teachers.motor_benchmark as benchmark

    for name, seconds in (("INTENT_S", 6.0), ("CARRY_S", 1.0), ("PUSH_S", 0.5)):
        monkeypatch.setattr(benchmark, name, seconds)
    result = run_motor_benchmark(load_shipped_motor_prior(), MotorBenchmark(episodes=12, seed=1, batch=12))
    assert set(BARS) <= set(result)
    for name in ("intent_survival", "carry_success", "push_survival", "carry_lifted", "carry_fall_rate"):
        assert 0.0 <= result[name] <= 1.0
    assert result["intent_survival"] == 1.0
    assert result["carry_success"] == 0.0, "nobody carries a box in a second"
    assert 0.0 < result["hand_error_standing"] < 0.1
