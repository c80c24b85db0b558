"""hv-live: talk to the humanoid, live, in a browser; or play a script of timed instructions and film it.

hv-live                                                  # opens a page on this machine
hv-live --policy=outputs/train/hv --task=unseen:5        # your own LeRobot checkpoint, in another room
hv-live --headless --script lines.txt --output film.mp4  # no page: docs/live.md shows a script
"""

from __future__ import annotations

import argparse
import asyncio
import signal
import sys
import threading
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hv_live.actors import Cast
    from hv_sim.task import Task


def main(arguments: list[str] | None = None) -> int:
    options = _parse(arguments)
    from hv_live.actors import Cast
    from hv_live.script import ScriptError
    from hv_sim.gl_backend import GLError, require_gl
    from hv_sim.task import TaskError, load_task

    try:
        require_gl()
        task = load_task(options.task)
        cast = Cast(options.policy)
        if cast.warning:
            print(cast.warning, flush=True)
        if options.headless:
            return _film(options, task, cast)
        return asyncio.run(_serve(options, task, cast))
    except (TaskError, GLError, ScriptError, ValueError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130


def _film(options: argparse.Namespace, task: Task, cast: Cast) -> int:
    from hv_live.script import play_script, read_script
    from hv_live.simulation import Simulation

    script = read_script(options.script)
    with Simulation(task, cast, seed=options.seed) as live:
        play_script(live, script, options.output, lambda time_s, text: print(f"{time_s:7.2f} s  {text}", flush=True))
        if live.fallen:
            print("the robot fell")
    print(f"written: {options.output}")
    return 0


async def _serve(options: argparse.Namespace, task: Task, cast: Cast) -> int:
    from hv_live.rooms_on_offer import catalogue, rooms_on_offer
    from hv_live.server import LiveServer
    from hv_live.session import Session

    tasks = rooms_on_offer(task)
    server = LiveServer(
        lambda publish: Session(tasks, task.name, cast, options.recordings, publish),
        {"tasks": catalogue(tasks), "policies": [*cast.missing, *cast.names], "missing": cast.missing},
        host=options.host,
        port=options.port,
    )
    await server.start()
    print(f"hv-live: {server.url}   (policy: {cast.first}; Ctrl-C ends it)", flush=True)
    if not options.no_browser:
        threading.Thread(target=webbrowser.open, args=(server.url,), daemon=True).start()
    ended = asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(number, ended.set)
    try:
        await ended.wait()
    finally:
        await server.stop()
    return 0


def _parse(arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--policy", default="student", help="student, teacher, planner, or a folder (default: student)")
    parser.add_argument("--task", default="living_room_1", help="the first room: a task's name or file")
    parser.add_argument("--port", type=_port, default=8765, help="0 for any that is free (default: 8765)")
    parser.add_argument(
        "--host", default="127.0.0.1", help="address to listen on; beyond this machine it takes a token"
    )
    parser.add_argument("--no-browser", action="store_true", help="do not open a browser")
    parser.add_argument("--recordings", type=Path, default=Path("outputs/live"), help="folder for recorded datasets")
    parser.add_argument("--headless", action="store_true", help="no page: play --script and write --output")
    parser.add_argument("--script", type=Path, help="timed instructions")
    parser.add_argument("--output", type=Path, help="the film, .mp4")
    parser.add_argument("--seed", type=int, default=0, help="of the robot's start in a film")
    options = parser.parse_args(arguments)
    if options.headless and not (options.script and options.output):
        parser.error("--headless: needs --script and --output")
    if not options.headless and (options.script or options.output):
        parser.error("--script, --output: only with --headless")
    if options.output is not None and options.output.suffix != ".mp4":
        parser.error(f"--output: {options.output} is not valid; valid: a name that ends in .mp4")
    return options


def _port(text: str) -> int:
    if not text.isdecimal() or int(text) > 65535:
        raise argparse.ArgumentTypeError(f"{text} is not a port; valid: 0 to 65535")
    return int(text)


if __name__ == "__main__":
    raise SystemExit(main())
