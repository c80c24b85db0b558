"""hv-tasks: lists, verifies, draws, counts and shows the benchmark's tasks, and turns meshes into objects."""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable
from pathlib import Path

from hv_sim.gl_backend import GLError
from hv_sim.task import TaskError


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    known = "a suite (seen, unseen, single, chain3, chain5), some of its tasks (unseen:0-9), a task's name, or a file"

    listing = commands.add_parser("list", help="names, rooms and instructions of tasks")
    listing.add_argument("tasks", nargs="?", default="", help=f"{known}; without it, what there is")

    verify = commands.add_parser("verify", help="check that tasks are solvable")
    verify.add_argument("tasks", nargs="*", default=["seen", "unseen", "single", "chain3", "chain5"], help=known)
    verify.add_argument("--output", type=Path, help="a JSON file for the verdicts")
    verify.add_argument("--workers", type=_count, default=0, help="processes (default: one a core)")

    generate = commands.add_parser("generate", help="draw the suites anew, byte for byte, or rooms to practise in")
    generate.add_argument(
        "suites",
        nargs="*",
        default=["seen", "unseen", "single", "chain3", "chain5"],
        help="suites, or practice: as many tasks as you like on floor plans that no suite has",
    )
    generate.add_argument("--count", type=_count, default=400, help="tasks of practice (400)")
    generate.add_argument(
        "--unverified", action="store_true", help="practice to be looked at only (hv-record --glances): 10 x as fast"
    )
    generate.add_argument("--output", type=Path, required=True, help="folder for the files")
    generate.add_argument("--workers", type=_count, default=0, help="processes (default: one a core)")

    stats = commands.add_parser("stats", help="counts and distributions of the suites, as tables and as plots")
    stats.add_argument("--output", type=Path, help="folder for benchmark_statistics.md and plots (default: print only)")

    gallery = commands.add_parser("gallery", help="one HTML page with a picture and the instructions of every task")
    gallery.add_argument("tasks", nargs="*", default=["seen", "unseen"], help=known)
    gallery.add_argument("--output", type=Path, required=True, help="folder for index.html and the pictures")
    gallery.add_argument("--size", type=_pixels, default=256, help="width of the pictures, 64 to 2048 pixels")

    view = commands.add_parser("view", help="open a task in MuJoCo's viewer")
    view.add_argument("task", help="a task's name, suite:number, or file")

    mesh = commands.add_parser("import-mesh", help="turn GLB, OBJ, STL or .sh3f files into objects for your tasks")
    mesh.add_argument("files", nargs="+", type=Path)
    mesh.add_argument("--output", type=Path, default=Path("hv_objects"), help="folder of your objects")
    mesh.add_argument("--size", type=float, help="longest side in metres (default: as the file says)")
    mesh.add_argument("--mass", type=float, help="kg (default: from the volume)")
    mesh.add_argument(
        "--up", choices=["y", "z"], help="the file's vertical axis (default: y for GLB and OBJ, z for STL)"
    )

    args = parser.parse_args()
    try:
        return _COMMANDS[args.command](args)
    except BrokenPipeError:  # whoever read the list has read enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except (TaskError, GLError, OSError) as error:
        print(f"error: {' '.join(str(error).split())}", file=sys.stderr)
        return 2


def _count(text: str) -> int:
    value = int(text)
    if value < 0:
        raise argparse.ArgumentTypeError(f"{text} is not valid; valid: 0 or more")
    return value


def _pixels(text: str) -> int:
    value = int(text)
    if not 64 <= value <= 2048:
        raise argparse.ArgumentTypeError(f"{text} is not valid; valid: 64 to 2048")
    return value


def _list(args: argparse.Namespace) -> int:
    from hv_sim.suites import SUITES, load_suite
    from hv_sim.task import available_tasks, resolve_tasks

    if not args.tasks:
        for name in SUITES:
            print(f"{name:<8} {len(load_suite(name)):>4} tasks")
        print("by hand:", ", ".join(available_tasks()))
        return 0
    for task in resolve_tasks(args.tasks):
        print(f"{task.name}  ({task.room.kind})")
        for subtask in task.subtasks:
            print(f"    {subtask.instruction}")
    return 0


def _verify(args: argparse.Namespace) -> int:
    from hv_scripts.task_jobs import verify_all
    from hv_sim.suites import SUITES
    from hv_sim.task import resolve_tasks
    from hv_teachers.task_verification import CHECKS

    report, failures = {}, 0
    chosen = {name: resolve_tasks(name) for name in args.tasks}  # an unknown name is refused before the work begins
    print(f"{'tasks':<14}{'number':>7}{'solvable':>9}  " + "".join(f"{c:>11}" for c in CHECKS))
    for name, tasks in chosen.items():
        # what is written by hand may use any words
        grammar = name.split(":", 1)[0].split("_", 1)[0] in SUITES
        verdicts = verify_all(tasks, grammar, args.workers, name)
        solvable = sum(v.solvable for v in verdicts)
        failures += len(verdicts) - solvable
        print(
            f"{Path(name).name[:13]:<14}{len(verdicts):>7}{solvable:>9}  "
            + "".join(f"{sum(v.failed == c for v in verdicts):>11}" for c in CHECKS)
        )
        report[name] = {
            "tasks": len(verdicts), "solvable": solvable,
            "verdicts": [vars(v) | {"solvable": v.solvable} for v in verdicts],
        }  # fmt: skip
        for v in verdicts:
            if not v.solvable:
                print(f"error: {v.task}: {v.failed}: {v.reason}", file=sys.stderr)
    if args.output:
        args.output.parent.mkdir(parents=True, exist_ok=True)
        draft = args.output.with_name(f".{args.output.name}.tmp")
        draft.write_text(json.dumps(report, indent=1) + "\n")
        draft.replace(args.output)
        print(f"written: {args.output}")
    return 1 if failures else 0


def _generate(args: argparse.Namespace) -> int:
    from hv_scripts.task_jobs import generate_practice, generate_suite
    from hv_sim.suites import suite_path, write_tasks

    for name in args.suites:
        if name != "practice":
            suite_path(name)  # an unknown name is refused before the work begins
    seen = None
    for name in args.suites:
        path = args.output / f"{name}.jsonl.gz"
        if name == "practice":
            tasks = generate_practice(args.count, not args.unverified, args.workers)
        else:
            tasks = generate_suite(name, args.workers, seen)
        seen = tasks if name == "seen" else seen
        write_tasks(path, tasks)
        print(f"written: {path}")
    return 0


def _stats(args: argparse.Namespace) -> int:
    from hv_scripts.task_statistics import all_tables, write_statistics

    if args.output:
        print(f"written: {write_statistics(args.output)}")
    else:
        print(all_tables())
    return 0


def _gallery(args: argparse.Namespace) -> int:
    from hv_scripts.task_gallery import write_gallery
    from hv_sim.task import resolve_tasks

    tasks = [task for name in args.tasks for task in resolve_tasks(name)]
    print(f"written: {write_gallery(tasks, args.output, args.size)}")
    return 0


def _view(args: argparse.Namespace) -> int:
    import mujoco
    import mujoco.viewer

    from hv_sim.scene import compile_scene
    from hv_sim.task import TaskError, resolve_tasks

    tasks = resolve_tasks(args.task)
    if len(tasks) != 1:
        raise TaskError(f"view: {args.task} are {len(tasks)} tasks; valid: one, such as {args.task}:0")
    if sys.platform == "linux" and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise TaskError("view: there is no display (DISPLAY is not set); hv-tasks gallery needs none")
    scene = compile_scene(tasks[0])
    data = mujoco.MjData(scene.model)
    data.qpos[:] = scene.initial_qpos
    mujoco.mj_forward(scene.model, data)
    mujoco.viewer.launch(scene.model, data)
    return 0


def _import_mesh(args: argparse.Namespace) -> int:
    from hv_sim.mesh_import import import_file

    failed = 0
    taken: set[str] = set()
    for file in args.files:
        try:
            for path in import_file(
                file, args.output, size_m=args.size, mass_kg=args.mass, up=args.up, taken=taken,
                on_refused=lambda why: print(f"left out: {why}", file=sys.stderr),
            ):  # fmt: skip
                print(f"written: {path}", flush=True)
        except ValueError as error:
            print(f"error: {error}", file=sys.stderr)
            failed += 1
    return 2 if failed else 0


_COMMANDS: dict[str, Callable[[argparse.Namespace], int]] = {
    "list": _list, "verify": _verify, "generate": _generate, "stats": _stats, "gallery": _gallery, "view": _view,
    "import-mesh": _import_mesh,
}  # fmt: skip

if __name__ == "__main__":
    raise SystemExit(main())
