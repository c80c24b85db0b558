from pathlib import Path

import pytest

from hv_scripts.demo import CommandError, main, run_stock_command

TALKATIVE = "import sys; print('settings: 1'); print(' 50%|#####     | 1/2', end='\\r'); print('the end'); sys.exit({})"


def test_shows_progress_only_and_keeps_the_rest(tmp_path: Path, capsys):
    run_stock_command("python", ["-c", TALKATIVE.format(0)], tmp_path / "a.log")
    shown = capsys.readouterr().out
    assert "50%|" in shown
    assert "settings: 1\n" not in shown.partition("a.log")[2]
    assert "settings: 1" in (tmp_path / "a.log").read_text()


def test_a_failure_is_one_line_that_names_the_kept_log(tmp_path: Path):
    folder = tmp_path / "demo"
    folder.mkdir()
    with pytest.raises(CommandError, match=r"python failed \(status 3, .*demo-failed\.log\): the end") as error:
        run_stock_command("python", ["-c", TALKATIVE.format(3)], folder / "a.log")
    assert "\n" not in str(error.value)
    assert "settings: 1" in (tmp_path / "demo-failed.log").read_text()


def test_a_folder_that_is_no_demo_is_left_alone(tmp_path: Path, capsys):
    (tmp_path / "thesis.tex").write_text("years of work")
    assert main(["--output", str(tmp_path)]) == 1
    assert "does not look like an earlier demo" in capsys.readouterr().err
    assert (tmp_path / "thesis.tex").read_text() == "years of work"
