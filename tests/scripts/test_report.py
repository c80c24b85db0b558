"""hv-report: figures of the page against the files', films in it, bad folders; in Chromium where there is one."""

import asyncio
import json
import re
import shutil

import numpy as np
import pytest
from chromium import MISSING, Chromium
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
    assert "50.0&nbsp;%" in text, "two of four episodes"
    assert "dropped: 1 of 8 (12.5 %)" in text
    assert "fell: 2 of 8 (25.0 %)" in text
    assert text.count("<video") == 1, "of the fall; nobody filmed the drop"
    assert "best: seen_000" in text
    assert "worst: seen_002" in text
    assert "72.4&nbsp;%" in text, "the paper's"
    assert not re.search(r"(src|href)=['\"](?!data:|#)", text), "it needs nothing beside it"
    assert [p.name for p in tmp_path.iterdir()] == ["report.html"]


def test_folders_without_results_are_refused(tmp_path, capsys):
    assert report.main([str(tmp_path), "--output", str(tmp_path / "r.html")]) == 2
    assert "neither metrics.json nor curve.csv" in capsys.readouterr().err
    assert report.main([str(tmp_path / "none"), "--output", str(tmp_path / "r.html")]) == 2
    assert not (tmp_path / "r.html").exists()


def test_rounds_of_dagger_and_damaged_curves(tmp_path, capsys):
    rounds = tmp_path / "dagger"
    rounds.mkdir()
    (rounds / "rounds.csv").write_text("round,success_all,fall_rate\n0,0.25,0.5\n1,0.375,0.25\n")
    page = tmp_path / "r.html"
    assert report.main([str(rounds), "--output", str(page)]) == 0
    text = page.read_text()
    assert "DAgger rounds: dagger" in text
    assert "<td>0.375</td>" in text
    (tmp_path / "training").mkdir()
    (tmp_path / "training" / "curve.csv").write_text("samples,loss\n")
    assert report.main([str(tmp_path / "training"), "--output", str(tmp_path / "s.html")]) == 2
    assert "curve.csv" in capsys.readouterr().err
    assert [p.name for p in (tmp_path / "training").iterdir()] == ["curve.csv"]


def test_what_was_put_aside_is_not_shown(folder, tmp_path):
    shutil.copytree(folder, tmp_path / "seen")
    shutil.copytree(folder, tmp_path / ".earlier" / "seen.0123abcd")
    page = tmp_path / "r.html"
    assert report.main([str(tmp_path), "--output", str(page)]) == 0
    assert page.read_text().count("planner on seen") == 1


@pytest.mark.skipif(bool(MISSING), reason=MISSING)
def test_chromium_shows_it_on_the_desktop_and_on_the_phone(folder, tmp_path):
    page = tmp_path / "report.html"
    assert report.main([str(folder), "--output", str(page)]) == 0

    async def main():
        async with Chromium() as browser:
            tab = await browser.open(page.as_uri())
            await tab.wait_for("document.readyState == 'complete'")
            for width, phone in ((1200, False), (390, True)):
                await tab.resize(width, 1600, phone=phone)
                await tab.wait_for(f"window.innerWidth == {width}")
                assert await tab.evaluate("document.documentElement.scrollWidth") <= width, "nothing is cut off"
                await tab.screenshot(tmp_path / f"{width}.png")
                shown = np.asarray(Image.open(tmp_path / f"{width}.png").convert("L"))
                assert shown.shape == (1600, width)
                assert shown.std() > 10, "there is something on the page"
            assert not await tab.evaluate("document.querySelector('video').checkVisibility()")
            await tab.evaluate("document.querySelector('.failure').scrollIntoView()")
            await tab.click(".failure summary")
            assert await tab.wait_for("document.querySelector('video').checkVisibility()")
            await tab.evaluate("document.querySelector('video').play()")
            await tab.wait_for("document.querySelector('video').currentTime > 0.2")

    asyncio.run(main())
