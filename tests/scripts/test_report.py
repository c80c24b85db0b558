"""hv-report: figures of the page against the files', films in it, bad folders; in Chromium where there is one."""

import json
import re
import shutil
import subprocess

import numpy as np
import pytest
from PIL import Image

from hv_scripts import report
from hv_sim.metrics import EpisodeRecord
from hv_teachers.episodes import EpisodeOutcome, SubTaskOutcome
from hv_teachers.evaluation import metrics_of, video_path


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Four made-up episodes, two of them filmed."""
    from lerobot.utils.io_utils import write_video

    folder = tmp_path_factory.mktemp("report") / "eval"
    folder.mkdir()
    outcomes = []
    for i, (misses, failures) in enumerate(
        [((0.1, 0.2), ("", "")), ((0.1, 2.0), ("", "dropped")), ((3.0, 4.0), ("fell", "fell")), ((0.1, 0.3), ("", ""))]
    ):
        parts = tuple(
            SubTaskOutcome("box" if k else "vase", 1.0 + i, 2.0, 0.0, 0.8, d, 12.0, True, f)
            for k, (d, f) in enumerate(zip(misses, failures, strict=True))
        )
        record = EpisodeRecord(f"seen_{i:03d}", i, misses, failures[0] == "fell", 2, 500)
        outcomes.append(EpisodeOutcome(record, 0, "kitchen", parts))
    for i in (0, 2):
        path = video_path(folder, f"seen_{i:03d}", 0)
        path.parent.mkdir(exist_ok=True)
        write_video(path, [np.full((64, 128, 3), 20 * k + i, np.uint8) for k in range(10)], fps=15)
    (folder / "episodes.jsonl").write_text("".join(o.to_json() + "\n" for o in outcomes))
    plan = {"policy": "planner", "suite": "seen", "policy_hash": "p-1", "tasks": "t", "seed": 0, "repeats": 1}
    metrics = {**metrics_of(outcomes), "plan": plan, "versions": {"mujoco": "3"}}
    (folder / "metrics.json").write_text(json.dumps(metrics))
    return folder


def test_the_page_holds_the_figures_and_the_films(folder, tmp_path, capsys):
    page = tmp_path / "report.html"
    assert report.main([str(folder), "--output", str(page)]) == 0
    assert "1 evaluations, 0 trainings" in capsys.readouterr().out
    text = page.read_text()
    assert "50.0 %" in text, "two of four episodes"
    assert "dropped: 1 of 8 (12.5 %)" in text
    assert "fell: 2 of 8 (25.0 %)" in text
    assert text.count("<video") == 1, "of the fall; nobody filmed the drop"
    assert "best: seen_000" in text
    assert "worst: seen_002" in text
    assert "72.4 %" in text, "the paper's"
    assert not re.search(r"(src|href)=['\"](?!data:|#)", text), "it needs nothing beside it"
    assert [p.name for p in tmp_path.iterdir()] == ["report.html"]


def test_folders_without_results_are_refused(tmp_path, capsys):
    assert report.main([str(tmp_path), "--output", str(tmp_path / "r.html")]) == 2
    assert "neither metrics.json nor curve.csv" in capsys.readouterr().err
    assert report.main([str(tmp_path / "none"), "--output", str(tmp_path / "r.html")]) == 2
    assert not (tmp_path / "r.html").exists()


@pytest.mark.skipif(shutil.which("chromium") is None, reason="Debian's chromium is not installed")
@pytest.mark.parametrize("width", [1200, 390])
def test_chromium_shows_it(folder, tmp_path, width):
    page, picture = tmp_path / "report.html", tmp_path / "shot.png"
    assert report.main([str(folder), "--output", str(page)]) == 0
    chromium = [
        "chromium", "--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking",
        "--disable-component-update", "--disable-sync", "--no-first-run", "--hide-scrollbars",
        f"--user-data-dir={tmp_path / 'profile'}", f"--window-size={width},1600",
    ]  # fmt: skip
    subprocess.run([*chromium, f"--screenshot={picture}", page.as_uri()], check=True, timeout=120, capture_output=True)
    shown = np.asarray(Image.open(picture).convert("L"))
    assert shown.shape == (1600, width)
    assert shown.std() > 10, "there is something on the page"
    done = subprocess.run([*chromium, "--dump-dom", page.as_uri()], check=True, timeout=120, capture_output=True)
    assert b"Beside the paper" in done.stdout
