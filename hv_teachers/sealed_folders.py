"""Folders with the checksums of what they held when they were finished, to tell later whether they are whole."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

from hv_teachers.whole_files import write_whole

SEAL_FILE = "checksums.json"


def seal(folder: Path) -> None:
    """Writes down the checksum of every file in a finished folder."""
    files = [path for path in sorted(folder.rglob("*")) if path.is_file() and path.name != SEAL_FILE]
    sums = {path.relative_to(folder).as_posix(): _checksum(path) for path in files}
    write_whole(folder / SEAL_FILE, json.dumps(sums, indent=1) + "\n")


def is_whole(folder: Path) -> bool:
    """Whether the folder was sealed, and every file is there, bit for bit, that was there then."""
    try:
        sealed = json.loads((folder / SEAL_FILE).read_text(encoding="utf-8"))
        return all(_checksum(folder / name) == value for name, value in sealed.items())
    except (OSError, ValueError, AttributeError):
        return False


def _checksum(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
