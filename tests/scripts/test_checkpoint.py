"""hv-checkpoint prints paths of weights that load, and says so where there are none."""

from pathlib import Path

import pytest

from hv_policy import network_file
from hv_policy.motor.prior import load_motor_prior
from hv_scripts import checkpoint
from hv_teachers.corrected_student import load_student


def test_prints_what_can_be_loaded(capsys):
    assert checkpoint.main(["motor_prior"]) == 0
    path = Path(capsys.readouterr().out.strip())
    assert load_motor_prior(path).config.hidden


def test_the_student_is_there_whole(capsys):
    assert checkpoint.main(["student"]) == 0
    folder = Path(capsys.readouterr().out.strip())
    assert load_student(folder).config.form == "belief"
    card = (folder / "README.md").read_text()
    assert "| seen |" in card
    assert "| unseen |" in card
    assert sum(file.stat().st_size for file in folder.parent.rglob("*")) < 30e6


def test_what_is_not_there_or_unknown_is_said_in_a_line(capsys, monkeypatch, tmp_path):
    monkeypatch.setattr(network_file, "SHIPPED_STUDENT", tmp_path / "student")
    assert checkpoint.main(["student"]) == 2
    assert capsys.readouterr().err.startswith("error: student: this package comes without it")
    with pytest.raises(SystemExit):
        checkpoint.main(["other"])
    assert "invalid choice: 'other'" in capsys.readouterr().err
