"""hv-tasks from the command line."""

import json
import re
from pathlib import Path

from PIL import Image
from stock_commands import error_lines, run_command

from hv_sim.objects import PACKAGED_KINDS
from hv_sim.suites import load_suite, read_tasks
from hv_sim.task import save_task


def tasks(*arguments):
    return run_command("hv-tasks", *arguments)


def test_verify_writes_a_verdict_for_each_task(tmp_path: Path):
    done = tasks("verify", "unseen:0-2", "living_room_1", "--output", tmp_path / "v.json", "--workers", "1")
    assert done.returncode == 0, done.stdout
    report = json.loads((tmp_path / "v.json").read_text())
    assert report["unseen:0-2"]["tasks"] == report["unseen:0-2"]["solvable"] == 3
    assert report["living_room_1"]["verdicts"][0]["walk_m"] > 0


def test_an_unreachable_goal_is_refused_in_one_line(tmp_path: Path):
    data = load_suite("seen")[0].to_dict()
    data["subtasks"] = data["subtasks"][:1]
    data["subtasks"][0]["goal_position_m"][2] = 2.5
    file = tmp_path / "wrong.json"
    file.write_text(json.dumps(data))
    done = tasks("verify", file)
    assert done.returncode == 2
    [line] = error_lines(done.stdout)
    assert "subtasks[0].goal_position_m" in line
    assert "in the air" in line


def test_an_own_task_with_own_words_is_verified(tmp_path: Path):
    task = load_suite("seen")[0]
    data = task.to_dict()
    data["subtasks"][0]["instruction"] = "Tidy this up, will you?"
    file = tmp_path / "mine.json"
    file.write_text(json.dumps(data))
    assert tasks("verify", file).returncode == 0
    save_task(task, file)
    assert "seen_000" in tasks("list", file).stdout


def test_unknown_names_are_refused(tmp_path: Path):
    for command in (
        ("verify", "unseen:0", "moon", "--output", tmp_path / "v.json"),
        ("generate", "moon", "--output", tmp_path),
        ("list", "moon"),
    ):
        done = tasks(*command)
        assert done.returncode == 2
        [line] = error_lines(done.stdout)
        assert "moon" in line
    assert not list(tmp_path.iterdir())


def test_what_cannot_be_shown_is_said_in_one_line(tmp_path: Path):
    done = run_command("hv-tasks", "view", "unseen:0", DISPLAY="", WAYLAND_DISPLAY="")
    assert (done.returncode, error_lines(done.stdout)) == (
        2, ["error: view: there is no display (DISPLAY is not set); hv-tasks gallery needs none"],
    )  # fmt: skip
    for size in ("0", "100000"):
        done = tasks("gallery", "unseen:0", "--size", size, "--output", tmp_path / "gallery")
        assert done.returncode == 2
        assert f"{size} is not valid; valid: 64 to 2048" in done.stdout
    assert not (tmp_path / "gallery").exists()


def test_list_counts_the_suites():
    done = tasks("list")
    assert done.returncode == 0
    assert "seen      350 tasks" in done.stdout
    assert "living_room_1" in done.stdout


def test_gallery_shows_every_task(tmp_path: Path):
    done = tasks("gallery", "seen:0-1", "--output", tmp_path / "g", "--size", "128")
    assert done.returncode == 0, done.stdout
    page = (tmp_path / "g" / "index.html").read_text()
    for task in load_suite("seen")[:2]:
        assert task.name in page
        assert all(p in page for s in task.subtasks for p in s.phrasings if "'" not in p)
        with Image.open(tmp_path / "g" / "pictures" / f"{task.name}_room.jpg") as picture:
            assert picture.size == (128, 96)
            assert len(set(picture.convert("RGB").getdata())) > 200, "something is to be seen"
    assert "<option>bedroom</option>" in page


def test_statistics_as_a_page_with_plots(tmp_path: Path):
    done = tasks("stats", "--output", tmp_path)
    assert done.returncode == 0, done.stdout
    page = (tmp_path / "benchmark_statistics.md").read_text()
    printed = tasks("stats").stdout
    for text in (page, printed):
        assert "| seen | 350 | 700 |" in text
        shares = next(line for line in text.splitlines() if line.startswith("| seen | from |"))
        assert 97 <= sum(int(s) for s in re.findall(r"(\d+) %", shares)) <= 103
        kinds = text[text.index("| kind |") :].splitlines()[2:]
        moved = [int(line.split("|")[3]) for line in kinds if line.startswith("|")]
        assert len(moved) == len(PACKAGED_KINDS)
        assert sum(moved) == 700
    assert (tmp_path / "pictures" / "benchmark.png").stat().st_size > 10_000


def test_a_broken_mesh_is_refused(tmp_path: Path):
    file = tmp_path / "a.obj"
    file.write_text("v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n")
    done = tasks("import-mesh", file, "--output", tmp_path / "own")
    assert done.returncode == 2
    [line] = error_lines(done.stdout)
    assert "not finite" in line
    assert not (tmp_path / "own").exists()


def test_practice_is_drawn_in_rooms_of_its_own(tmp_path: Path):
    arguments = ("generate", "practice", "--count", "2", "--unverified", "--workers", "1", "--output", tmp_path)
    done = tasks(*arguments)
    assert done.returncode == 0, done.stdout
    drawn = read_tasks(tmp_path / "practice.jsonl.gz")
    assert [task.name for task in drawn] == ["practice_000", "practice_001"]
    assert not {task.furniture for task in drawn} & {task.furniture for task in load_suite("seen")}
    listed = tasks("list", tmp_path / "practice.jsonl.gz").stdout
    assert all(task.subtasks[0].instruction in listed for task in drawn)
