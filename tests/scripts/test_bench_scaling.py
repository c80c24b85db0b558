"""A short run leaves figures and tables, also in a page; what is wrong is said in a line."""

import json

import pytest

from hv_scripts.bench_scaling import MARKS, main, read_tables, with_tables

SMALL = ["--tasks=living_room_1", "--num-envs=4", "--num-steps=2", "--num-threads=1"]


def test_figures_and_tables_of_a_short_run(tmp_path, capsys):
    page = tmp_path / "scaling.md"
    page.write_text(f"# Scaling\n{MARKS[0]}\nold\n{MARKS[1]}\nthe end\n")
    arguments = ["practice", "memory", "--minutes=0.01", "--every=0.3", f"--output={tmp_path}", f"--docs={page}"]
    assert main([*arguments, *SMALL]) == 0
    [row] = json.loads((tmp_path / "practice.json").read_text())["rows"]
    text = page.read_text()
    assert text.startswith("# Scaling\n")
    assert text.endswith(f"{MARKS[1]}\nthe end\n")
    assert "old" not in text
    assert f"| **{row['share_of_bare_without_routes']:.0%}** |" in text
    assert "Growth over the later half" in text
    assert read_tables(tmp_path) in capsys.readouterr().out
    assert main(["environments", f"--output={tmp_path}", *SMALL]) == 0
    assert "| 16 environments |" in read_tables(tmp_path)


def test_recording_table(tmp_path):
    rows = [{"workers": n, "frames_per_s": 30.0 * n, "speedup": float(n), "joining_s": 3.0} for n in (1, 2)]
    (tmp_path / "recording.json").write_text(json.dumps({"machine": "two cores", "rows": rows}))
    assert "| 2 | 60.0 | 2.00 | 3.0 |\n\n(two cores)" in read_tables(tmp_path)


def test_motor_table(tmp_path):
    row = {"training_steps_per_s": 6000.0, "lone_steps_per_s": 12000.0, "share_of_lone": 0.5, "num_envs": 8}
    (tmp_path / "motor.json").write_text(json.dumps({"machine": "two cores", "rows": [row]}))
    assert "| training the motor prior, 8 environments | 6,000 | **50%** |" in read_tables(tmp_path)


def test_what_is_wrong_is_said_in_one_line(tmp_path, capsys):
    assert main(["practice", f"--output={tmp_path}", "--tasks=nowhere"]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    with pytest.raises(ValueError, match="nothing was measured into it"):
        read_tables(tmp_path)
    with pytest.raises(ValueError, match="the page has no"):
        with_tables("a page", "tables")
    with pytest.raises(SystemExit):
        main(["horses"])
    assert "'horses' is not valid; valid: motor, practice, environments" in capsys.readouterr().err
