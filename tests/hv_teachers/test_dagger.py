import csv
import json
from pathlib import Path

import pytest
from lerobot.datasets.lerobot_dataset import LeRobotDataset

from hv_teachers.dagger import DaggerError, DaggerRounds, run_rounds


@pytest.mark.parametrize(
    ("field", "value"), [("rounds", -1), ("first_steps", 0), ("repeats", 0), ("glances", -2), ("beta", 1.5)]
)
def test_fields_are_checked_in_one_line(field: str, value: float):
    with pytest.raises(DaggerError, match=f"{field}: {value} is not valid") as error:
        DaggerRounds(**{field: value})
    assert "\n" not in str(error.value)


def test_a_folder_of_other_rounds_is_refused(tmp_path: Path):
    (tmp_path / "dagger.json").write_text(json.dumps({"tasks": "single", "seed": 4}))
    with pytest.raises(DaggerError, match="was begun with tasks=single, not seen"):
        run_rounds(tmp_path, DaggerRounds(tasks="seen"))


def test_what_a_command_says_last_is_the_error(tmp_path: Path):
    with pytest.raises(DaggerError, match=r"record: failed \(error: .*moon_base"):
        run_rounds(tmp_path, DaggerRounds(tasks="moon_base", workers=1))
    assert not (tmp_path / "rounds.csv").exists()


@pytest.mark.slow
def test_two_rounds_and_a_third_that_keeps_them(tmp_path: Path):
    settings = dict(
        tasks="living_room_1", first_steps=4, steps=2, glances=6, eval_suite="seen", eval_tasks=1, workers=1,
        num_envs=1, train=("--batch_size=4", "--num_workers=0", "--policy.device=cpu"),
    )  # fmt: skip
    run_rounds(tmp_path, DaggerRounds(rounds=1, **settings))
    written = {f: f.stat().st_mtime_ns for f in tmp_path.rglob("*.safetensors")}
    table = run_rounds(tmp_path, DaggerRounds(rounds=2, **settings))
    assert [row["round"] for row in table] == [0, 1, 2]
    for file, when in written.items():
        assert file.stat().st_mtime_ns == when, file
    rows = list(csv.DictReader((tmp_path / "rounds.csv").open()))
    assert len(rows) == 3
    assert {"success_all", "fall_rate"} <= set(rows[0])
    assert (tmp_path / "rounds.png").stat().st_size > 1000
    last = LeRobotDataset("joined", root=tmp_path / "round_2" / "joined")
    parts = [tmp_path / "round_0" / name for name in ("recording_0", "glances")]
    parts += [tmp_path / f"round_{k}" / f"recording_{k}" for k in (1, 2)]
    assert last.meta.total_frames == sum(LeRobotDataset(p.name, root=p).meta.total_frames for p in parts)
    config = json.loads((tmp_path / "round_2/train/checkpoints/last/pretrained_model/config.json").read_text())
    assert "round_1" in config["pretrained_path"]
