"""Counts and distributions of the suites, as tables and as plots."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np

from hv_sim.objects import OBJECT_KINDS, PACKAGED_KINDS
from hv_sim.places import layout_at
from hv_sim.rooms import ROOM_KINDS
from hv_sim.suites import SUITES, load_suite
from hv_sim.task import Task, built_object

_HEIGHTS_M = ((-0.1, 0.1), (0.1, 0.5), (0.5, 0.7), (0.7, 0.8), (0.8, 1.0))
"""Of tops: the floor, low tables and pallets, stands, tables, counters."""


def suite_table() -> str:
    """A Markdown table with one row a suite."""
    rows = [
        f"| suite | tasks | sub-tasks | {' | '.join(k.replace('_', ' ') for k in ROOM_KINDS)} | floor plans |"
        " kinds moved | categories | instructions | words | way (m) | mass (kg) |",
        "|---" * (9 + len(ROOM_KINDS)) + "|",
    ]
    for name in SUITES:
        tasks = load_suite(name)
        facts = _facts(tasks)
        rooms = Counter(t.room.kind for t in tasks)
        said = {p for t in tasks for s in t.subtasks for p in s.phrasings}
        plans = {(t.room, t.furniture) for t in tasks}
        cells = [
            name, len(tasks), len(facts["mass"]), *(rooms[k] for k in ROOM_KINDS), len(plans), len(set(facts["kind"])),
            len({OBJECT_KINDS[k].category for k in facts["kind"]}), len(said),
            _spread(facts["words"], 0), _spread(facts["way"], 1), _spread(facts["mass"], 1),
        ]  # fmt: skip
        rows.append("| " + " | ".join(str(c) for c in cells) + " |")
    return "\n".join(rows)


def heights_table() -> str:
    """A Markdown table: from and to which heights objects are moved, in shares of a suite's sub-tasks."""
    rows = [
        f"| suite | | {' | '.join(_height_name(low, high) for low, high in _HEIGHTS_M)} |",
        "|---" * (2 + len(_HEIGHTS_M)) + "|",
    ]
    for name in SUITES:
        facts = _facts(load_suite(name))
        for key in ("from", "to"):
            counts = [sum(low <= h < high for h in facts[key]) for low, high in _HEIGHTS_M]
            cells = [f"{100 * c / len(facts[key]):.0f} %" for c in counts]
            rows.append(f"| {name} | {key} | {' | '.join(cells)} |")
    return "\n".join(rows)


def kinds_table() -> str:
    """A Markdown table: how often each kind of object is moved in each suite."""
    counts = {name: Counter(_facts(load_suite(name))["kind"]) for name in SUITES}
    rows = [f"| kind | category | {' | '.join(SUITES)} |", "|---" * (2 + len(SUITES)) + "|"]
    for kind, spec in PACKAGED_KINDS.items():
        cells = " | ".join(str(counts[name][kind]) for name in SUITES)
        rows.append(f"| {spec.noun} | {spec.category} | {cells} |")
    return "\n".join(rows)


def all_tables() -> str:
    """All that is counted, as Markdown."""
    return (
        f"{suite_table()}\n\nHeights of what objects are taken from and put on:\n\n{heights_table()}\n\n"
        f"How often each kind of object is moved:\n\n{kinds_table()}"
    )


def write_statistics(folder: Path) -> Path:
    """Writes `benchmark_statistics.md` and its plots below a folder; returns the page."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    folder.joinpath("pictures").mkdir(parents=True, exist_ok=True)
    figure, axes = plt.subplots(2, 3, figsize=(13, 7))
    panels = {
        "way": ("straight way of the object (m)", np.arange(0, 9.5, 0.5)),
        "mass": ("mass (kg)", np.arange(0, 8.5, 0.5)),
        "words": ("words in an instruction", np.arange(4, 32, 1)),
        "from": ("height of the support at the start (m)", np.arange(0, 1.05, 0.1)),
        "to": ("height of the support at the goal (m)", np.arange(0, 1.05, 0.1)),
    }
    facts = {name: _facts(load_suite(name)) for name in ("seen", "unseen")}
    for axis, (key, (title, bins)) in zip(axes.flat, panels.items(), strict=False):
        for name, color in (("seen", "#1f6fb2"), ("unseen", "#d1342f")):
            axis.hist(facts[name][key], bins=bins, density=True, alpha=0.55, label=name, color=color)
        axis.set_xlabel(title)
        axis.set_ylabel("share")
        axis.set_yticks([])
    axes.flat[0].legend()
    categories = Counter(OBJECT_KINDS[k].category for k in facts["seen"]["kind"]).most_common()
    axes.flat[5].barh([c for c, _ in categories][::-1], [n for _, n in categories][::-1], color="#1f6fb2")
    axes.flat[5].tick_params(axis="y", labelsize=6)
    axes.flat[5].set_xlabel("objects to be moved, seen")
    figure.tight_layout()
    figure.savefig(folder / "pictures" / "benchmark.png", dpi=90)
    plt.close(figure)
    page = folder / "benchmark_statistics.md"
    text = (
        "# The suites in numbers\n\nWritten by `hv-tasks stats --output docs`. Ranges are 5 %, median and 95 %.\n\n"
        f"{all_tables()}\n\n![Distributions of the seen and unseen suites](pictures/benchmark.png)\n"
    )
    draft = page.with_name(f".{page.name}.tmp")
    draft.write_text(text, encoding="utf-8")
    draft.replace(page)
    return page


def _facts(tasks: list[Task]) -> dict[str, list]:
    """Of every sub-task: kind and mass of what is moved, how far, from and to what height, words of its phrasings."""
    found: dict[str, list] = {k: [] for k in ("kind", "mass", "way", "from", "to", "words")}
    for task in tasks:
        placed = {o.name: o for o in task.objects}
        for i, subtask in enumerate(task.subtasks):
            thing = placed[subtask.object]
            built = built_object(thing)
            start = layout_at(task, i).poses[subtask.object][0]
            found["kind"].append(thing.kind)
            found["mass"].append(built.mass_kg)
            found["way"].append(float(np.hypot(*np.subtract(subtask.goal_position_m, start)[:2])))
            found["from"].append(float(start[2] - built.half_extents_m[2]))
            found["to"].append(float(subtask.goal_position_m[2] - built.half_extents_m[2]))
            found["words"] += [len(p.split()) for p in subtask.phrasings]
    return found


def _height_name(low_m: float, high_m: float) -> str:
    return "floor" if low_m < 0 else f"{low_m:g} to {high_m:g} m"


def _spread(values: list, digits: int) -> str:
    return " / ".join(f"{v:.{digits}f}" for v in np.percentile(values, [5, 50, 95]))
