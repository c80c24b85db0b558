"""What evaluations found, gathered: which system, which suite, which figures; and the leaderboard made of them."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from hv_sim.suites import SUITES, load_suite
from hv_teachers.episodes import tasks_fingerprint
from hv_teachers.evaluation import EPISODES_FILE, METRICS_FILE, EvaluationError
from hv_teachers.published_results import PUBLISHED_TABLES

EXPERIMENT_FILE = "experiment.json"
EARLIER_FOLDER = ".earlier"
"""Where an experiment puts evaluations that are of another policy, code or configuration than the present one."""
README_MARKS = ("<!-- results: written by hv-experiment -->", "<!-- end of results -->")
_NEEDED = ("at_0.4", "at_0.2", "fall_rate", "n_episodes", "plan")


EARLIER, EARLIER_NOTE = "†", "† On the suite's tasks as they were before they were last redrawn."


@dataclass(frozen=True)
class Result:
    """An evaluation's metrics under the name of its system; `folder` is where its episodes and videos are."""

    system: str
    suite: str
    metrics: dict[str, Any]
    folder: Path

    @property
    def is_earlier(self) -> bool:
        """It was measured on a whole suite that holds other tasks now."""
        plan = self.metrics["plan"]
        if self.suite not in SUITES or "tasks" not in plan:
            return False
        count, present = _present_tasks(self.suite)
        return plan.get("n_tasks") == count and plan["tasks"] != present

    @property
    def part(self) -> str:
        """How many of the suite's tasks it was measured on, where that is not all of them."""
        played = self.metrics["plan"].get("n_tasks")
        if self.suite not in SUITES or played is None or played == _present_tasks(self.suite)[0]:
            return ""
        return f" ({played} tasks)"

    @property
    def budget(self) -> str:
        """How many control steps an experiment trained its teachers on, where it did."""
        samples = self.metrics.get("trained_samples")
        return "" if samples is None else f" ({samples / 1e6:.1f} M samples)"

    @property
    def title(self) -> str:
        """The system, with what it was trained on, how many tasks if not all, marked if `is_earlier`."""
        return self.system + self.budget + self.part + (f" {EARLIER}" if self.is_earlier else "")


def read_result(path: Path) -> Result:
    """Reads a `metrics.json`; the system's name is the experiment's beside it, else what was evaluated.

    Raises:
        EvaluationError: it is not an evaluation's.
    """
    try:
        metrics = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise EvaluationError(f"{path}: not a readable metrics.json ({' '.join(str(error).split())})") from None
    missing = [key for key in _NEEDED if not isinstance(metrics, dict) or key not in metrics]
    if missing:
        raise EvaluationError(f"{path}: {missing[0]} is missing; valid: a metrics.json of hv-eval")
    about = path.with_name(EXPERIMENT_FILE)
    plan = metrics["plan"]
    if about.is_file():
        system = str(json.loads(about.read_text(encoding="utf-8"))["name"])
    else:
        system = str(metrics.get("experiment") or Path(str(plan["policy"])).name)
    return Result(system, str(plan["suite"]), metrics, path.parent)


def find_results(folders: Iterable[Path]) -> list[Result]:
    """Every evaluation in or below some folders, by suite and success; one that lies in two places once, where its
    episodes are.

    Raises:
        EvaluationError: a folder does not exist, or a metrics.json is damaged.
    """
    found = []
    for folder in folders:
        if not folder.exists():
            raise EvaluationError(f"{folder}: there is no such folder")
        paths = [folder] if folder.is_file() else sorted(folder.rglob(METRICS_FILE))
        paths = [p for p in paths if EARLIER_FOLDER not in p.relative_to(folder).parts]
        found += [read_result(p) for p in paths]
    once: dict[str, Result] = {}
    for result in sorted(found, key=lambda r: not (r.folder / EPISODES_FILE).is_file()):
        figures = {key: result.metrics[key] for key in _NEEDED}
        once.setdefault(json.dumps([result.system, figures], sort_keys=True), result)
    found = list(once.values())
    order = {name: i for i, name in enumerate(SUITES)}
    found.sort(key=lambda r: (order.get(r.suite, len(order)), -r.metrics["at_0.4"]["success_all"], r.system))
    return found


def leaderboard(results: Sequence[Result]) -> str:
    """The text of `RESULTS.md`: a table for each suite, and the paper's rows where they compare."""
    lines = [
        "# Results",
        "",
        "Written by `hv-experiment` from the files in `results/`; not to be edited. Success: the object ends within",
        "0.4 m (0.2 m) of its goal, judged at the end of the episode, unassisted. In brackets: 95 % interval (Wilson).",
    ]
    for suite in dict.fromkeys(r.suite for r in results):
        chosen = [r for r in results if r.suite == suite]
        count = max(_num_subtasks(r.metrics) for r in chosen)
        heads = [f"object {i + 1}" for i in range(count)]
        lines += ["", f"## {suite}", ""]
        lines.append(f"| system | {' | '.join(heads)} | all at 0.4 m | all at 0.2 m | miss (m) | falls | episodes |")
        lines.append("|---" * (count + 6) + "|")
        for r in chosen:
            m = r.metrics
            each = [_percent(m["at_0.4"].get(f"success_{i + 1}")) for i in range(count)]
            low, high = m["interval_0.4"]["success_all"]
            away = [m.get(f"dist_{i + 1}") for i in range(_num_subtasks(m))]
            misses = " / ".join("-" if d is None else f"{d:.2f}" for d in away)
            lines.append(
                f"| {r.title} | {' | '.join(each)} | **{_percent(m['at_0.4']['success_all'])}**"
                f" [{100 * low:.1f}, {100 * high:.1f}] | {_percent(m['at_0.2']['success_all'])} | {misses}"
                f" | {_percent(m['fall_rate'])} | {m['n_episodes']} |"
            )
        for table in PUBLISHED_TABLES:
            if table.suite == suite:
                for row in table.rows:
                    miss = f"{row.dist_1} / {row.dist_2}" if row.dist_1 is not None else ""
                    each = [_percent(row.success_1), _percent(row.success_2), *[""] * (count - 2)]
                    lines.append(
                        f"| *{row.system}, published (Table {table.number})* | {' | '.join(each)}"
                        f" | {_percent(row.success_all)} | | {miss} | | |"
                    )
    if any(r.is_earlier for r in results):
        lines += ["", EARLIER_NOTE]
    return "\n".join(lines) + "\n"


def readme_table(results: Sequence[Result]) -> str:
    """A small table for the README: success of whole episodes at 0.4 m, systems down, suites across."""
    suites = [s for s in SUITES if any(r.suite == s for r in results)]
    shares = {(r.system, r.suite): r.metrics["at_0.4"]["success_all"] for r in results}
    earlier = {(r.system, r.suite) for r in results if r.is_earlier}
    parts = {(r.system, r.suite): r.part for r in results}
    systems = sorted({r.system for r in results}, key=lambda name: -max(v for (n, _), v in shares.items() if n == name))
    lines = [f"| success, all objects at 0.4 m | {' | '.join(suites)} |", "|---" * (len(suites) + 1) + "|"]
    for system in systems:
        cells = [
            _percent(shares.get((system, s))) + parts.get((system, s), "") + EARLIER * ((system, s) in earlier)
            for s in suites
        ]
        lines.append(f"| {system} | {' | '.join(cells)} |")
    for system in ("HumanoidVerse-T", "HumanoidVerse-S"):
        rows = {t.suite: row for t in PUBLISHED_TABLES if t.number in (1, 3) for row in t.rows if row.system == system}
        cells = [_percent(rows[s].success_all) if s in rows else "" for s in suites]
        lines.append(f"| *{system}, published, on their tasks* | {' | '.join(cells)} |")
    if earlier:
        lines += ["", EARLIER_NOTE]
    return "\n".join(lines)


def with_results(readme: str, results: Sequence[Result]) -> str:
    """A README's text with the table between its two marks (`README_MARKS`) made anew; unchanged if it has none."""
    begin, end = README_MARKS
    if begin not in readme or end not in readme:
        return readme
    before, rest = readme.split(begin, 1)
    return f"{before}{begin}\n{readme_table(results)}\n{end}{rest.split(end, 1)[1]}"


@cache
def _present_tasks(suite: str) -> tuple[int, str]:
    """How many tasks a suite has, and their fingerprint."""
    tasks = load_suite(suite)
    return len(tasks), tasks_fingerprint(tasks)


def _num_subtasks(metrics: dict[str, Any]) -> int:
    return sum(1 for key in metrics["at_0.4"] if key != "success_all")


def _percent(share: float | None) -> str:
    return "" if share is None else f"{100 * share:.1f} %"
