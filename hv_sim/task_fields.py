"""Readers for the fields of a task file.

A reader takes a decoded JSON value and the path of its field, and returns the value or raises `TaskError`.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Collection
from typing import Any

Reader = Callable[[Any, str], Any]

_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,59}")


class TaskError(ValueError):
    """A task that cannot be used: one line with the field's path, its value and what would be valid."""


def read_fields(data: Any, path: str, required: dict[str, Reader], optional: dict[str, Reader]) -> dict[str, Any]:
    """The values of an object's fields, each read by its reader.

    Raises:
        TaskError: a required field is missing, a field is unknown, or a reader refuses.
    """
    dot = f"{path}." if path else ""
    if not isinstance(data, dict):
        raise TaskError(
            f"{path or 'task'}: {shown(data)} is not an object; fields: {', '.join([*required, *optional])}"
        )
    for key in required:
        if key not in data:
            raise TaskError(f"{dot}{key}: missing; required fields here: {', '.join(required)}")
    readers = {**required, **optional}
    for key in data:
        if key not in readers:
            raise TaskError(f"{dot}{key}: unknown field; valid: {', '.join(readers)}")
    return {key: readers[key](value, f"{dot}{key}") for key, value in data.items()}


def shown(value: Any) -> str:
    """A value as JSON, cut to 60 characters, for messages."""
    text = json.dumps(value, default=str)
    return text if len(text) <= 60 else text[:57] + "..."


def unique_keys(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """For `json.loads(object_pairs_hook=...)`: an object none of whose keys is given twice."""
    result = dict(pairs)
    if len(result) < len(pairs):
        keys = [key for key, _ in pairs]
        raise TaskError(f"{next(k for k in keys if keys.count(k) > 1)}: given twice in one place")
    return result


def list_of(item: Reader, least: int, most: int) -> Reader:
    """Reader of a list of `least` to `most` entries."""

    def read(value: Any, path: str) -> tuple[Any, ...]:
        if not isinstance(value, list) or not least <= len(value) <= most:
            raise TaskError(f"{path}: {shown(value)} is not valid; valid: a list of {least} to {most} entries")
        return tuple(item(entry, f"{path}[{i}]") for i, entry in enumerate(value))

    return read


def one_of(valid: Collection[str], what: str) -> Reader:
    """Reader of one of a few words; `what` names them in the message."""

    def read(value: Any, path: str) -> str:
        if not isinstance(value, str) or value not in valid:
            raise TaskError(f"{path}: {shown(value)} is not a known {what}; valid: {', '.join(valid)}")
        return value

    return read


def number(low: float, high: float) -> Reader:
    """Reader of a finite number in a range."""

    def read(value: Any, path: str) -> float:
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
            raise TaskError(f"{path}: {shown(value)} is not valid; valid: a number from {low:g} to {high:g}")
        return float(value)

    return read


def vector(*ranges: tuple[float, float]) -> Reader:
    """Reader of a list with one number in each range."""

    def read(value: Any, path: str) -> tuple[float, ...]:
        if not isinstance(value, list) or len(value) != len(ranges):
            raise TaskError(f"{path}: {shown(value)} is not valid; valid: a list of {len(ranges)} numbers")
        return tuple(number(*r)(entry, f"{path}[{i}]") for i, (entry, r) in enumerate(zip(value, ranges, strict=True)))

    return read


def name(value: Any, path: str) -> str:
    """Reader of a name: 1 to 60 letters, digits, "_", "-" and "."."""
    if not isinstance(value, str) or not _NAME.fullmatch(value):
        raise TaskError(f"{path}: {shown(value)} is not a name; valid: 1 to 60 letters, digits, '_', '-' and '.'")
    return value


def sentence(value: Any, path: str) -> str:
    """Reader of a line of text, 1 to 200 characters."""
    if not isinstance(value, str) or not 1 <= len(value.strip()) <= 200 or not value.isprintable():
        raise TaskError(f"{path}: {shown(value)} is not valid; valid: one line of 1 to 200 characters")
    return value
