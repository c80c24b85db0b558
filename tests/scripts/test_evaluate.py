"""hv-eval from the command line."""

import json
from pathlib import Path

from stock_commands import error_lines, run_command


def test_a_short_evaluation(tmp_path: Path):
    done = run_command(
        "hv-eval", "--policy=planner", "--suite=chain3", "--n-tasks=2", "--max-episode-steps=20", "--workers=1",
        "--output", tmp_path / "e",
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
    metrics = json.loads((tmp_path / "e" / "metrics.json").read_text())
    assert metrics["n_episodes"] == 2
    assert "success_3" in metrics["at_0.4"]
    assert "object 3" in done.stdout


def test_what_is_wrong_is_said_in_one_line(tmp_path: Path):
    for arguments, word in (
        (("--policy=nobody", "--suite=unseen:0"), "nobody"),
        (("--policy=planner", "--suite=moon"), "moon"),
        (("--policy=planner", "--suite=unseen", "--n-tasks=67"), "--n-tasks"),
    ):
        done = run_command("hv-eval", *arguments, "--output", tmp_path / "e")
        assert done.returncode == 2
        [line] = error_lines(done.stdout)
        assert word in line
    assert not (tmp_path / "e").exists()
