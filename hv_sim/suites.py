"""Suites: the benchmark's tasks, files that come with the package, one JSON document a line (`docs/benchmark.md`)."""

from __future__ import annotations

import functools
import gzip
import io
import json
import os
import re
from collections.abc import Iterable
from pathlib import Path

from hv_sim.task import Task, parse_task
from hv_sim.task_fields import TaskError, unique_keys

SUITES = ("seen", "unseen", "single", "chain3", "chain5")
"""`seen` 350 and `unseen` 66 tasks with two objects, `single` 700 with one (Algorithm 1 of the paper applied to
`seen`), `chain3` 100 and `chain5` 60 with three and five."""

SUITE_SIZES = {"seen": 350, "unseen": 66, "single": 700, "chain3": 100, "chain5": 60}

_FOLDER = Path(__file__).parent / "suite_files" / "v1"
_MAX_FILE_BYTES = 200_000_000
_SELECTION = re.compile(r"(?P<suite>[a-z0-9]+)(:(?P<first>\d+)(-(?P<last>\d+))?)?")


def suite_path(name: str) -> Path:
    """Where a suite's file lies.

    Raises:
        TaskError: there is no such suite.
    """
    if name not in SUITES:
        raise TaskError(f"suite: {name!r} does not exist; valid: {', '.join(SUITES)}")
    return _FOLDER / f"{name}.jsonl.gz"


def load_suite(name: str) -> list[Task]:
    """The tasks of a suite in `SUITES`, in order. They were checked and verified when they were made.

    Raises:
        TaskError: there is no such suite.
    """
    return list(_packaged(suite_path(name)))


def select_tasks(text: str) -> list[Task] | None:
    """The tasks of `seen`, `seen:3` (the fourth), `seen:0-15` (the first sixteen), or of a task's name in a suite.

    None when the text does not name anything in the suites.

    Raises:
        TaskError: the suite has fewer tasks.
    """
    match = _SELECTION.fullmatch(text)
    if match and match["suite"] in SUITES:
        tasks = load_suite(match["suite"])
        if match["first"] is None:
            return tasks
        first = int(match["first"])
        last = first if match["last"] is None else int(match["last"])
        if not first <= last < len(tasks):
            raise TaskError(f"task: {text!r} is not in the suite; valid: {match['suite']}:0 to {len(tasks) - 1}")
        return tasks[first : last + 1]
    suite = text.split("_", 1)[0]
    if suite in SUITES and text != suite:
        return [task for task in load_suite(suite) if task.name == text] or None
    return None


def read_tasks(path: str | os.PathLike[str], *, check: bool = True) -> list[Task]:
    """Reads a file of tasks, one JSON document a line (`.jsonl` or `.jsonl.gz`).

    Args:
        path: the file.
        check: also check that everything fits (`hv_sim.task.check_task`).

    Raises:
        TaskError: it cannot be read, or a line is not a valid task; the message names file and line.
    """
    file = Path(path)
    tasks = []
    try:
        raw = file.read_bytes()
        if file.suffix == ".gz":
            with gzip.GzipFile(fileobj=io.BytesIO(raw)) as stream:
                raw = stream.read(_MAX_FILE_BYTES + 1)
        if len(raw) > _MAX_FILE_BYTES:
            raise TaskError(f"{file}: larger than {_MAX_FILE_BYTES} bytes")
        lines = raw.decode("utf-8").splitlines()
    except (OSError, EOFError, UnicodeDecodeError, gzip.BadGzipFile) as error:
        raise TaskError(f"{file}: not a readable file of tasks ({error})") from None
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        try:
            data = json.loads(line, object_pairs_hook=unique_keys)
            tasks.append(Task.from_dict(data) if check else parse_task(data))
        except TaskError as error:
            raise TaskError(f"{file}:{number}: {error}") from None
        except (ValueError, RecursionError) as error:
            raise TaskError(f"{file}:{number}: not a JSON document ({error})") from None
    if not tasks:
        raise TaskError(f"{file}: holds no task")
    return tasks


def write_tasks(path: str | os.PathLike[str], tasks: Iterable[Task]) -> None:
    """Writes tasks one a line, compressed where the name ends in `.gz`; the same tasks give the same bytes."""
    target = Path(path)
    text = "".join(json.dumps(task.to_dict(), separators=(",", ":")) + "\n" for task in tasks)
    raw = text.encode("utf-8")
    if target.suffix == ".gz":
        buffer = io.BytesIO()
        with gzip.GzipFile(filename="", mode="wb", compresslevel=9, fileobj=buffer, mtime=0) as stream:
            stream.write(raw)
        raw = buffer.getvalue()
    target.parent.mkdir(parents=True, exist_ok=True)
    draft = target.with_name(f".{target.name}.{os.getpid()}.tmp")
    try:
        draft.write_bytes(raw)
        draft.replace(target)
    finally:
        draft.unlink(missing_ok=True)


@functools.cache
def _packaged(path: Path) -> tuple[Task, ...]:
    return tuple(read_tasks(path, check=False))
