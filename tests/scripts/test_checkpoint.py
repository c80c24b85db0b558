"""hv-checkpoint prints paths of weights that load, and says so where there are none."""

from pathlib import Path

import pytest

from hv_policy.motor.prior import load_motor_prior
from hv_scripts import checkpoint


def test_prints_what_can_be_loaded(capsys):
    assert checkpoint.main(["motor_prior"]) == 0
    path = Path(capsys.readouterr().out.strip())
    assert load_motor_prior(path).config.hidden


def test_what_is_not_there_or_unknown_is_said_in_a_line(capsys):
    code = checkpoint.main(["student"])
    said = capsys.readouterr()
    if code:
        assert code == 2
        assert said.err.startswith("error: student: this package comes without it")
    else:
        assert (Path(said.out.strip()) / "config.json").is_file()
    with pytest.raises(SystemExit):
        checkpoint.main(["other"])
    assert "invalid choice: 'other'" in capsys.readouterr().err
