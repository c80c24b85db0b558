from pathlib import Path

import pytest
from stock_commands import error_lines, run_command


def record(root: Path, *arguments: str, **environment: str):
    return run_command("hv-record", "--root", root, "--max-episode-steps", "5", *arguments, **environment)


def test_an_existing_folder_is_refused_in_one_line(tmp_path: Path):
    (tmp_path / "mine").mkdir()
    done = record(tmp_path / "mine")
    assert done.returncode == 1
    assert error_lines(done.stdout) == [
        f"error: dataset {tmp_path / 'mine'}: exists already; choose another folder, or add to it with --resume"
    ]


def test_an_unknown_task_is_refused_with_those_that_exist(tmp_path: Path):
    done = record(tmp_path / "new", "--tasks", "moon_base")
    assert done.returncode == 1
    [line] = error_lines(done.stdout)
    assert "moon_base" in line
    assert "living_room_1" in line
    assert list(tmp_path.iterdir()) == []


def test_without_gl_nothing_is_left_behind(tmp_path: Path):
    done = record(tmp_path / "new", "--tasks", "living_room_1", MUJOCO_GL="disable")
    assert done.returncode == 1
    [line] = error_lines(done.stdout)
    assert "install libosmesa6" in line
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("value", ["0", "-3", "many"])
def test_counts_must_be_positive(tmp_path: Path, value: str):
    done = record(tmp_path / "new", "--repeats", value)
    assert done.returncode == 2
    assert "--repeats" in done.stdout


def test_records_what_it_says(tmp_path: Path):
    done = record(tmp_path / "new", "--tasks", "living_room_1", "--image-size", "32")
    assert done.returncode == 0, done.stdout[-2000:]
    assert f"{tmp_path / 'new'}: 1 episodes of 1 attempts (1 failed, 0 dropped" in done.stdout
    assert (tmp_path / "new" / "meta" / "info.json").exists()
