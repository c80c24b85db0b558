"""The report: one HTML page that holds its pictures and films, for the desktop and the phone."""

from __future__ import annotations

import base64
import csv
import html
import io
import itertools
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

import av
import numpy as np
from PIL import Image

from hv_teachers.curves import plot_curve
from hv_teachers.episodes import FAILURES, PLACED_M, EpisodeOutcome, SubTaskOutcome
from hv_teachers.evaluation import read_outcomes, read_timing, typical_outcomes, video_path
from hv_teachers.published_results import PUBLISHED_TABLES, PublishedRow
from hv_teachers.results import Result
from hv_teachers.teacher_curve import CURVES

STRIP_FRAMES = 8
ROUNDS_TABLE, ROUNDS_PICTURE = "rounds.csv", "rounds.png"
"""As `hv_teachers.dagger` writes them."""
_BINS: dict[str, tuple[str, Callable[[SubTaskOutcome], float], tuple[float, ...]]] = {
    "distance": ("way of the object (m)", lambda s: s.way_m, (0, 1.5, 3, 4.5, 6, 99)),
    "from": ("height it is taken from (m)", lambda s: s.from_height_m, (-1, 0.1, 0.4, 0.7, 0.9, 9)),
    "to": ("height it is put on (m)", lambda s: s.to_height_m, (-1, 0.1, 0.4, 0.7, 0.9, 9)),
    "mass": ("mass (kg)", lambda s: s.mass_kg, (0, 1, 2, 4, 6, 99)),
}


def write_report(
    results: Sequence[Result], trainings: Sequence[Path], output: Path, rounds: Sequence[Path] = ()
) -> Path:
    """Writes the page, whole or not at all.

    Args:
        results: evaluations (`hv_teachers.results.find_results`).
        trainings: folders with a `curve.csv`.
        output: the HTML file.
        rounds: folders of hv-dagger, with a `rounds.csv`.

    Raises:
        hv_teachers.evaluation.EvaluationError: an evaluation's episodes are damaged.
        ValueError: a curve is damaged.
    """
    parts = [_overview(results), _published(results)]
    parts += [_rounds(folder) for folder in rounds]
    parts += [_training(folder) for folder in trainings]
    parts += [_evaluation(result) for result in results]
    page = _PAGE.replace("@CONTENT", "\n".join(p for p in parts if p))
    output.parent.mkdir(parents=True, exist_ok=True)
    draft = output.with_name(f".{output.name}.tmp")
    draft.write_text(page, encoding="utf-8")
    draft.replace(output)
    return output


def _overview(results: Sequence[Result]) -> str:
    if not results:
        return ""
    rows = []
    for r in results:
        m = r.metrics
        low, high = m["interval_0.4"]["success_all"]
        rows.append(
            f"<tr><td><a href='#{_anchor(r)}'>{_text(r.title)}</a></td><td>{_text(r.suite)}</td>"
            f"<td>{_bar(m['at_0.4']['success_all'], low, high)}</td><td>{_share(m['at_0.2']['success_all'])}</td>"
            f"<td>{_share(m['fall_rate'])}</td><td>{m['n_episodes']}</td></tr>"
        )
    head = "<tr><th>system</th><th>suite</th><th>all at 0.4 m</th><th>at 0.2 m</th><th>falls</th><th>episodes</th></tr>"
    return f"<section><h2>Evaluations</h2><div class='wide'><table>{head}{''.join(rows)}</table></div></section>"


def _published(results: Sequence[Result]) -> str:
    """Tables 1 to 5, the paper's rows with ours below each."""
    of = {(r.system, r.suite): r for r in sorted(results, key=lambda r: not r.part)}  # whole suites rather than parts
    sections = []
    for table in PUBLISHED_TABLES:
        rows = []
        for row in table.rows:
            rows.append(_published_row(row))
            ours = of.get((row.experiment, table.suite))
            rows.append(_our_row(ours) if ours else f"<tr class='ours'><td>{_text(row.experiment)}</td>{_MISSING}</tr>")
        extra = [r for r in results if r.suite == table.suite and r.system in ("planner", "teacher")]
        rows += [_our_row(r) for r in extra if table.number in (1, 3)]
        sections.append(
            f"<h3>Table {table.number}. {_text(table.title)}</h3><div class='wide'><table><tr><th>system</th>"
            "<th>object 1</th><th>object 2</th><th>all</th><th>miss 1 (m)</th><th>miss 2 (m)</th></tr>"
            f"{''.join(rows)}</table></div>"
        )
    note = "<p>Published figures in grey; ours below each, on our own tasks and robot room, at 0.4 m.</p>"
    return f"<section><h2>Beside the paper</h2>{note}{''.join(sections)}</section>"


_MISSING = "<td colspan='5' class='faint'>not run yet</td>"


def _published_row(row: PublishedRow) -> str:
    miss = "".join(f"<td>{'' if d is None else f'{d:.3f}'}</td>" for d in (row.dist_1, row.dist_2))
    shares = "".join(f"<td>{_share(v)}</td>" for v in (row.success_1, row.success_2, row.success_all))
    return f"<tr class='paper'><td>{_text(row.system)} (published)</td>{shares}{miss}</tr>"


def _our_row(result: Result) -> str:
    m = result.metrics
    shares = "".join(f"<td>{_share(m['at_0.4'].get(k))}</td>" for k in ("success_1", "success_2", "success_all"))
    miss = "".join(f"<td>{m[k]:.3f}</td>" if m.get(k) is not None else "<td></td>" for k in ("dist_1", "dist_2"))
    return f"<tr class='ours'><td><a href='#{_anchor(result)}'>{_text(result.title)}</a></td>{shares}{miss}</tr>"


def _training(folder: Path) -> str:
    pictures = []
    for kind, columns in CURVES.items():
        target = folder / f"curve_{kind}.png"
        if target.exists():
            pictures.append((f"{kind}: {', '.join(columns[:3])}, ...", target.read_bytes()))
    if not pictures and (folder / "curve.png").exists():
        pictures.append(("", (folder / "curve.png").read_bytes()))
    if not pictures:
        with (folder / "curve.csv").open(encoding="utf-8") as file:
            shown = [c for c in file.readline().strip().split(",") if c not in ("samples", "kind")][:6]
        with tempfile.TemporaryDirectory() as place:
            plot_curve(folder / "curve.csv", Path(place) / "curve.png", shown)
            pictures.append(("", (Path(place) / "curve.png").read_bytes()))
    name = _text("/".join(folder.resolve().parts[-2:]))
    figures = "".join(
        f"<figure><img alt='training curves of {name}' src='{_data(png, 'image/png')}'>"
        f"<figcaption>{_text(title)}</figcaption></figure>"
        for title, png in pictures
    )
    return f"<section><h2>Training: {name}</h2>{figures}</section>"


def _rounds(folder: Path) -> str:
    """The rounds of hv-dagger, as a table and as its picture."""
    with (folder / ROUNDS_TABLE).open(encoding="utf-8") as file:
        rows = list(csv.reader(file))
    head = "".join(f"<th>{_text(name.replace('_', ' '))}</th>" for name in rows[0]) if rows else ""
    body = "".join(f"<tr>{''.join(f'<td>{_text(cell)}</td>' for cell in row)}</tr>" for row in rows[1:])
    picture = folder / ROUNDS_PICTURE
    table = f"<div class='wide'><table><tr>{head}</tr>{body}</table></div>"
    if picture.is_file():
        table += f"<figure><img alt='rounds' src='{_data(picture.read_bytes(), 'image/png')}'></figure>"
    return f"<section><h2>DAgger rounds: {_text(folder.name)}</h2>{table}</section>"


def _evaluation(result: Result) -> str:
    outcomes = read_outcomes(result.folder)
    title = f"<h2 id='{_anchor(result)}'>{_text(result.system)} on {_text(result.suite)}</h2>"
    plan, versions = result.metrics["plan"], result.metrics.get("versions", {})
    facts = ", ".join(f"{k} {v}" for k, v in versions.items())
    about = (
        f"<p class='faint'>{_text(str(plan.get('policy_hash')))}, tasks {_text(str(plan.get('tasks')))}, "
        f"seed {plan.get('seed')}, {plan.get('repeats')} repeats; {_text(facts)}{_text(_took(result.folder))}</p>"
    )
    if not outcomes:
        return f"<section>{title}{about}</section>"
    subtasks = [s for o in outcomes for s in o.subtasks]
    panels = [
        _panel("room", [(k.replace("_", " "), v["success"], v["n"]) for k, v in result.metrics["rooms"].items()]),
        *(_panel(name, _binned(subtasks, value, edges)) for name, value, edges in _BINS.values()),
        _panel("kind of object", _by_kind(subtasks)),
    ]
    return (
        f"<section>{title}{about}<div class='panels'>{''.join(panels)}</div>"
        f"{_failures(result, outcomes)}{_strips(result, outcomes)}</section>"
    )


def _took(folder: Path) -> str:
    episodes, seconds = read_timing(folder)
    return f"; {episodes} episodes took {seconds / 60:.1f} minutes" if episodes else ""


def _binned(
    subtasks: Sequence[SubTaskOutcome], value: Callable[[SubTaskOutcome], float], edges: Sequence[float]
) -> list[tuple[str, float, int]]:
    rows = []
    for low, high in itertools.pairwise(edges):
        inside = [s.distance_m < PLACED_M for s in subtasks if low <= value(s) < high]
        label = (
            f"under {high:g}" if low == edges[0] else f"over {low:g}" if high == edges[-1] else f"{low:g} to {high:g}"
        )
        if inside:
            rows.append((label, sum(inside) / len(inside), len(inside)))
    return rows


def _by_kind(subtasks: Sequence[SubTaskOutcome]) -> list[tuple[str, float, int]]:
    kinds: dict[str, list[bool]] = {}
    for s in subtasks:
        kinds.setdefault(s.object_kind, []).append(s.distance_m < PLACED_M)
    rows = [(k.replace("_", " "), sum(v) / len(v), len(v)) for k, v in kinds.items()]
    return sorted(rows, key=lambda row: (row[1], row[0]))


def _panel(title: str, rows: Sequence[tuple[str, float, int]]) -> str:
    lines = "".join(
        f"<div class='line'><span>{_text(label)} <small>{count}</small></span>{_bar(share)}</div>"
        for label, share, count in rows
    )
    return f"<div class='panel'><h4>success by {_text(title)}</h4><div class='lines'>{lines}</div></div>"


def _failures(result: Result, outcomes: Sequence[EpisodeOutcome]) -> str:
    """How many sub-tasks failed for each reason, and a film of one where there is one."""
    total = sum(len(o.subtasks) for o in outcomes)
    items = []
    for reason in FAILURES:
        of_it = [o for o in outcomes if any(s.failure == reason for s in o.subtasks)]
        if not of_it:
            continue
        count = sum(s.failure == reason for o in outcomes for s in o.subtasks)
        filmed = [o for o in of_it if _film(result, o).exists()]
        film = _video(_film(result, filmed[0]), filmed[0].record.task) if filmed else ""
        items.append(
            f"<details class='failure'><summary>{reason.replace('_', ' ')}: {count} of {total} "
            f"({100 * count / total:.1f} %)</summary>{film or '<p class=faint>no film (hv-eval --film)</p>'}</details>"
        )
    return f"<h3>Why sub-tasks failed</h3>{''.join(items)}" if items else ""


def _strips(result: Result, outcomes: Sequence[EpisodeOutcome]) -> str:
    best, *others = typical_outcomes(outcomes)
    shown = []
    for title, outcome in (("best", best), *((("worst", others[0]),) if others else ())):
        path = _film(result, outcome)
        if path.exists():
            misses = ", ".join(f"{d:.2f} m" for d in outcome.record.distances_m)
            shown.append(
                f"<figure><img class='strip' alt='the {title} episode' src='{_data(film_strip(path), 'image/jpeg')}'>"
                f"<figcaption>{title}: {_text(outcome.record.task)}, misses {misses}</figcaption></figure>"
            )
    return f"<h3>Best and worst episode</h3>{''.join(shown)}" if shown else ""


def film_strip(path: Path, frames: int = STRIP_FRAMES, height_px: int = 168) -> bytes:
    """A JPEG of frames of a video, evenly spread and side by side (four a row)."""
    with av.open(str(path)) as container:
        pictures = [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]
    chosen = [pictures[round(i * (len(pictures) - 1) / max(1, frames - 1))] for i in range(frames)]
    small = []
    for picture in chosen:
        width = round(picture.shape[1] * height_px / picture.shape[0])
        small.append(np.asarray(Image.fromarray(picture).resize((width, height_px))))
    rows = [np.hstack(small[i : i + 4]) for i in range(0, len(small), 4)]
    buffer = io.BytesIO()
    Image.fromarray(np.vstack([r for r in rows if r.shape == rows[0].shape])).save(buffer, "JPEG", quality=82)
    return buffer.getvalue()


def _film(result: Result, outcome: EpisodeOutcome) -> Path:
    return video_path(result.folder, outcome.record.task, outcome.repeat)


def _video(path: Path, task: str) -> str:
    source = _data(path.read_bytes(), "video/mp4")
    return f"<video controls muted preload='none' src='{source}'></video><p class='faint'>{_text(task)}</p>"


def _data(content: bytes, kind: str) -> str:
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"


def _bar(share: float, low: float | None = None, high: float | None = None) -> str:
    whisker = ""
    if low is not None and high is not None:
        whisker = f"<i style='left:{100 * low:.1f}%;width:{100 * (high - low):.1f}%'></i>"
    return f"<span class='bar'><b style='width:{100 * share:.1f}%'></b>{whisker}<em>{_share(share)}</em></span>"


def _share(value: float | None) -> str:
    return "" if value is None else f"{100 * value:.1f}&nbsp;%"


def _anchor(result: Result) -> str:
    return html.escape(f"{result.system}-{result.suite}".replace("/", "-").replace(" ", "-"), quote=True)


def _text(text: str) -> str:
    return html.escape(text, quote=True)


_PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>hv report</title><style>
:root { color-scheme: light dark; --line: #8884; --ours: #1f6fb2; --faint: #777; }
body { font: 15px/1.45 system-ui, sans-serif; margin: 0 auto; padding: 0 16px 60px; max-width: 68em; }
h1 { margin: 28px 0 4px; } h2 { margin: 36px 0 8px; border-bottom: 1px solid var(--line); } h4 { margin: 8px 0; }
table { border-collapse: collapse; width: 100%; } td, th { padding: 4px 10px 4px 0; text-align: left; }
tr { border-bottom: 1px solid var(--line); } .wide { overflow-x: auto; }
.paper td { color: var(--faint); } .ours td:first-child { padding-left: 14px; } .faint, small { color: var(--faint); }
.bar { position: relative; display: inline-block; width: 140px; height: 18px; background: #8882; border-radius: 3px; }
.bar b { position: absolute; inset: 0 auto 0 0; background: var(--ours); border-radius: 3px; opacity: .55; }
.bar i { position: absolute; top: 8px; height: 2px; background: currentColor; opacity: .6; }
.bar { margin-right: 54px; } .bar em { position: absolute; left: calc(100% + 6px); white-space: nowrap; }
.bar em { font-style: normal; font-size: 12px; line-height: 18px; }
.panels { display: grid; grid-template-columns: repeat(auto-fill, minmax(300px, 1fr)); gap: 8px 28px; }
.lines { max-height: 260px; overflow-y: auto; }
.line { display: flex; justify-content: space-between; gap: 8px; margin: 2px 0; }
figure { margin: 10px 0; } img, video { max-width: 100%; } .failure { margin: 4px 0; } summary { cursor: pointer; }
</style></head><body><h1>hv report</h1>
<p class="faint">Success: the object ends within 0.4 m of its goal, judged at the end. Whiskers: 95 %.</p>
@CONTENT
</body></html>
"""
