"""hv-bench-scaling: how practice and recording scale on this machine, as figures, and as tables for docs/scaling.md.

    hv-bench-scaling                             # everything but an hour of watching memory: a quarter of an hour
    hv-bench-scaling motor                       # the motor prior's training beside bare mujoco.batch
    hv-bench-scaling practice                    # the practice environment beside bare mujoco.batch, 256 environments
    hv-bench-scaling environments                # control steps/s against the number of environments
    hv-bench-scaling objects                     # ... against objects in the scene
    hv-bench-scaling recording                   # frames/s of two processes beside one
    hv-bench-scaling memory --minutes 60         # resident memory while the planner practises
    hv-bench-scaling --docs docs/scaling.md      # writes the tables of all that was measured into the page

Each part leaves a JSON file in the output folder; tables are made of what is there. Measure on an idle machine.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

PARTS = ("motor", "practice", "environments", "objects", "recording", "memory")
MARKS = ("<!-- figures: written by hv-bench-scaling -->", "<!-- end of figures -->")
SCENES = {"1 object": "single:0-31", "2 objects": "seen:0-31", "3 objects": "chain3:0-31", "5 objects": "chain5:0-31"}


def main(arguments: list[str] | None = None) -> int:
    """Measures, prints the tables, and writes them where that is wanted."""
    options = _parse(arguments)
    from hv_sim.gl_backend import GLError
    from hv_sim.task import TaskError
    from hv_teachers.dataset_format import RecordingError
    from hv_teachers.whole_files import write_whole

    measure: dict[str, Callable[[argparse.Namespace], Any]] = {
        "motor": _motor,
        "practice": _practice,
        "environments": _environments,
        "objects": _objects,
        "recording": _recording,
        "memory": _memory,
    }
    parts = options.parts or ([] if options.docs else [p for p in PARTS if p != "memory"])
    try:
        for part in parts:
            figures = {"machine": machine(), "rows": measure[part](options)}
            write_whole(options.output / f"{part}.json", json.dumps(figures, indent=1) + "\n")
        tables = read_tables(options.output)
        if options.docs:
            write_whole(options.docs, with_tables(options.docs.read_text(encoding="utf-8"), tables))
    except (TaskError, GLError, RecordingError, ValueError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    print(tables, end="")
    print(f"figures: {options.output}" + (f"; tables: {options.docs}" if options.docs else ""))
    return 0


def machine() -> str:
    """Processor and cores, in words."""
    name = platform.machine()
    information = Path("/proc/cpuinfo")
    if information.exists():
        models = [line for line in information.read_text().splitlines() if line.startswith("model name")]
        name = models[0].partition(":")[2].strip() if models else name
    return f"{name}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f} before"


def read_tables(folder: Path) -> str:
    """Markdown of all parts that were measured into a folder.

    Raises:
        ValueError: nothing was.
    """
    makers: dict[str, Callable[[Any], str]] = {
        "motor": _motor_table,
        "practice": _practice_table,
        "environments": _count_table,
        "objects": _count_table,
        "recording": _recording_table,
        "memory": _memory_table,
    }
    tables = []
    for part in PARTS:
        path = folder / f"{part}.json"
        if path.exists():
            figures = json.loads(path.read_text(encoding="utf-8"))
            tables.append(f"{makers[part](figures['rows'])}\n({figures['machine']})\n")
    if not tables:
        raise ValueError(f"{folder}: nothing was measured into it; valid: a folder that hv-bench-scaling filled")
    return "\n".join(tables)


def with_tables(page: str, tables: str) -> str:
    """A page's text with what stands between its two marks (`MARKS`) made anew.

    Raises:
        ValueError: it does not have them.
    """
    begin, end = MARKS
    if begin not in page or end not in page:
        raise ValueError(f"docs: the page has no {begin} and {end}")
    before, rest = page.split(begin, 1)
    return f"{before}{begin}\n\n{tables}\n{end}{rest.split(end, 1)[1]}"


def _motor(options: argparse.Namespace) -> list[dict[str, Any]]:
    from hv_teachers.scaling_benchmark import benchmark_motor_training

    return [benchmark_motor_training(num_threads=options.num_threads)]


def _practice(options: argparse.Namespace) -> list[dict[str, Any]]:
    from hv_sim.task import resolve_tasks
    from hv_teachers.scaling_benchmark import benchmark_teacher_env

    tasks = resolve_tasks(options.tasks)
    return [
        benchmark_teacher_env(
            tasks, num_envs=options.num_envs, num_steps=options.num_steps, num_threads=options.num_threads
        )
    ]


def _environments(options: argparse.Namespace) -> list[dict[str, Any]]:
    from hv_sim.task import resolve_tasks
    from hv_teachers.scaling_benchmark import benchmark_teacher_env

    tasks = resolve_tasks(options.tasks)
    counts = [n for n in (16, 64, 256, 1024) if n <= 4 * options.num_envs]
    return [
        {
            "what": f"{n} environments",
            **benchmark_teacher_env(
                tasks, num_envs=n, num_steps=options.num_steps, num_threads=options.num_threads, rounds=2
            ),
        }
        for n in counts
    ]


def _objects(options: argparse.Namespace) -> list[dict[str, Any]]:
    from hv_sim.task import resolve_tasks
    from hv_teachers.scaling_benchmark import benchmark_teacher_env

    return [
        {
            "what": name,
            **benchmark_teacher_env(
                resolve_tasks(tasks), num_envs=options.num_envs, num_steps=options.num_steps,
                num_threads=options.num_threads, rounds=2,
            ),
        }
        for name, tasks in SCENES.items()
    ]  # fmt: skip


def _recording(options: argparse.Namespace) -> list[dict[str, Any]]:
    from hv_sim.task import resolve_tasks
    from hv_teachers.scaling_benchmark import benchmark_recording

    tasks = resolve_tasks(options.recorded)
    return benchmark_recording(tasks, workers=options.workers, max_episode_steps=options.max_episode_steps)


def _memory(options: argparse.Namespace) -> dict[str, Any]:
    from hv_sim.task import resolve_tasks
    from hv_teachers.scaling_benchmark import watch_memory

    def tell(look: dict[str, float]) -> None:
        print(
            f"{look['minute']:6.1f} min  {look['resident_mb']:8.1f} MB  {look['steps']:,.0f} control steps,"
            f" {look['episodes']:,.0f} episodes",
            flush=True,
        )

    return watch_memory(
        resolve_tasks(options.tasks), minutes=options.minutes, every_s=options.every, num_envs=options.num_envs // 4,
        num_threads=options.num_threads, tell=tell,
    )  # fmt: skip


def _motor_table(rows: list[dict[str, Any]]) -> str:
    [r] = rows
    return (
        "| | control steps/s | of bare |\n|---|---|---|\n"
        f"| bare `mujoco.batch`, humanoids alone on a plane | {r['lone_steps_per_s']:,.0f} | |\n"
        f"| training the motor prior, {r['num_envs']} environments |"
        f" {r['training_steps_per_s']:,.0f} | **{r['share_of_lone']:.0%}** |\n"
    )


def _practice_table(rows: list[dict[str, Any]]) -> str:
    from hv_teachers.scaling_benchmark import SECONDS_PER_SUBTASK

    [r] = rows
    with_prior, without = r["share_of_bare_with_prior"], r["share_of_bare_without_routes"]
    return (
        f"| {r['num_envs']} environments, {r['num_threads']} threads | control steps/s | of bare |\n|---|---|---|\n"
        f"| bare `mujoco.batch`, the same scenes | {r['bare_steps_per_s']:,.0f} | |\n"
        "| practice, observations and rewards included |"
        f" {without * r['bare_steps_per_s']:,.0f} | **{without:.0%}** |\n"
        f"| with routes, one in {SECONDS_PER_SUBTASK:.0f} s, {r['route_ms']:.1f} ms each |"
        f" {r['env_steps_per_s']:,.0f} | {r['share_of_bare']:.0%} |\n"
        f"| with the motor prior | {with_prior * r['bare_steps_per_s']:,.0f} | {with_prior:.0%} |\n"
    )


def _count_table(rows: list[dict[str, Any]]) -> str:
    lines = ["| | practice, control steps/s | bare | of bare |", "|---|---|---|---|"]
    for r in rows:
        figures = f"{r['env_steps_per_s']:,.0f} | {r['bare_steps_per_s']:,.0f} | {r['share_of_bare']:.0%}"
        lines.append(f"| {r['what']} | {figures} |")
    return "\n".join(lines) + "\n"


def _recording_table(rows: list[dict[str, Any]]) -> str:
    lines = ["| recording processes | frames/s | times one | then joining, s |", "|---|---|---|---|"]
    for r in rows:
        lines.append(f"| {r['workers']} | {r['frames_per_s']:,.1f} | {r['speedup']:.2f} | {r['joining_s']:.1f} |")
    return "\n".join(lines) + "\n"


def _memory_table(figures: dict[str, Any]) -> str:
    looks = figures["looks"]
    chosen = sorted({round(i * (len(looks) - 1) / 6) for i in range(7)})
    lines = ["| minute | resident, MB | control steps | episodes begun |", "|---|---|---|---|"]
    for look in (looks[i] for i in chosen):
        lines.append(
            f"| {look['minute']:.1f} | {look['resident_mb']:,.1f} | {look['steps']:,} | {look['episodes']:,} |"
        )
    return "\n".join(lines) + f"\n\nGrowth over the later half: {figures['growth_mb_per_hour']:+.1f} MB an hour.\n"


def _parse(arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"of {', '.join(PARTS)} (default: all but memory)")
    parser.add_argument("--output", type=Path, default=Path("outputs/scaling"))
    parser.add_argument("--docs", type=Path, help="write the tables between the marks of this page")
    parser.add_argument("--tasks", default="seen:0-255", help="tasks to practise on")
    parser.add_argument("--num-envs", type=int, default=256, help="environments of practice; memory: a quarter")
    parser.add_argument("--num-steps", type=int, default=100, help="control steps of a round")
    parser.add_argument("--num-threads", type=int, default=0, help="physics threads; 0: one per core")
    parser.add_argument("--recorded", default="seen:0-23", help="tasks to record, an attempt each")
    parser.add_argument("--max-episode-steps", type=int, default=600, help="control steps of a recorded attempt")
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2], help="numbers of recording processes")
    parser.add_argument("--minutes", type=float, default=60.0, help="of watching memory")
    parser.add_argument("--every", type=float, default=60.0, help="seconds from one look at memory to the next")
    options = parser.parse_args(arguments)
    unknown = [part for part in options.parts if part not in PARTS]
    if unknown:
        parser.error(f"part: {unknown[0]!r} is not valid; valid: {', '.join(PARTS)}")
    return options


if __name__ == "__main__":
    sys.exit(main())
