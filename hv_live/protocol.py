"""What the page may say: one small JSON object a message, its fields checked one by one, and not too many of them.

{"type": "instruct", "text": "Put the vase on the table."}      {"type": "pause", "on": true}
{"type": "load", "task": "unseen_003"}                          {"type": "reset"}
{"type": "policy", "name": "teacher"}                           {"type": "instructor", "on": true}
{"type": "push", "direction_deg": 90, "speed_m_s": 0.5}         {"type": "record", "on": true}
{"type": "camera", "azimuth_deg": 30, "elevation_deg": -20, "distance_m": 4}     {"type": "camera_home"}
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from hv_sim.task_fields import Reader, TaskError, name, number, one_of, read_fields, sentence, unique_keys

MAX_MESSAGE_BYTES = 4096


class ProtocolError(ValueError):
    """A message that is not one of the above; one line that names field, value and what is valid."""


@dataclass(frozen=True)
class Instruct:
    """Give an instruction."""

    text: str


@dataclass(frozen=True)
class Pause:
    """Stop the clock, or let it run."""

    on: bool


@dataclass(frozen=True)
class Reset:
    """Begin the room anew."""


@dataclass(frozen=True)
class Load:
    """Go to another room."""

    task: str


@dataclass(frozen=True)
class Policy:
    """Let somebody else play."""

    name: str


@dataclass(frozen=True)
class PlayUser:
    """Let Algorithm 3 give the instructions, or stop it."""

    on: bool


@dataclass(frozen=True)
class Push:
    """Shove the robot; 0 is forward, 90 to its left."""

    direction_deg: float = 0.0
    speed_m_s: float = 0.5


@dataclass(frozen=True)
class Record:
    """Begin a dataset, or finish it."""

    on: bool


@dataclass(frozen=True)
class Orbit:
    """Look at the robot from there; degrees and metres as in MuJoCo's free camera."""

    azimuth_deg: float
    elevation_deg: float
    distance_m: float


@dataclass(frozen=True)
class OrbitHome:
    """Look from the corner of the room again."""


Command = Instruct | Pause | Reset | Load | Policy | PlayUser | Push | Record | Orbit | OrbitHome


def _flag(value: Any, path: str) -> bool:
    if not isinstance(value, bool):
        raise TaskError(f"{path}: {type(value).__name__} is not valid; valid: true, false")
    return value


_ON: dict[str, Reader] = {"on": _flag}
_ORBIT: dict[str, Reader] = {
    "azimuth_deg": number(-1e4, 1e4),
    "elevation_deg": number(-89.0, 20.0),
    "distance_m": number(1.0, 15.0),
}
_PUSH: dict[str, Reader] = {"direction_deg": number(-360.0, 360.0), "speed_m_s": number(0.0, 1.5)}
_KINDS: dict[str, tuple[Callable[..., Command], dict[str, Reader], dict[str, Reader]]] = {
    "instruct": (Instruct, {"text": sentence}, {}),
    "pause": (Pause, _ON, {}),
    "reset": (Reset, {}, {}),
    "load": (Load, {"task": name}, {}),
    "policy": (Policy, {"name": sentence}, {}),
    "instructor": (PlayUser, _ON, {}),
    "push": (Push, {}, _PUSH),
    "record": (Record, _ON, {}),
    "camera": (Orbit, _ORBIT, {}),
    "camera_home": (OrbitHome, {}, {}),
}


def parse_command(text: str) -> Command:
    """The command that a message holds.

    Raises:
        ProtocolError: it is too long, not JSON, of no known type, or one of its fields is not valid.
    """
    if len(text) > MAX_MESSAGE_BYTES:
        raise ProtocolError(f"message: {len(text)} characters; valid: at most {MAX_MESSAGE_BYTES}")
    try:
        data = json.loads(text, object_pairs_hook=unique_keys)
        if not isinstance(data, dict):
            raise ProtocolError("message: not an object")
        kind = one_of(tuple(_KINDS), "type of message")(data.pop("type", None), "type")
        make, required, optional = _KINDS[kind]
        return make(**read_fields(data, "", required, optional))
    except TaskError as error:
        raise ProtocolError(str(error)) from None
    except (ValueError, RecursionError) as error:
        if isinstance(error, ProtocolError):
            raise
        raise ProtocolError(f"message: not JSON ({' '.join(str(error).split())[:80]})") from None


def cost(command: Command) -> float:
    """How much of a visitor's allowance a command takes: what builds a scene costs as much as many small ones."""
    return {Load: 15.0, Record: 15.0, Policy: 8.0, Reset: 6.0, Instruct: 3.0}.get(type(command), 1.0)


@dataclass
class Allowance:
    """How much a visitor may ask for: some at once, and so much more every second.

    Args:
        burst: at once.
        per_second: how fast it grows again.
    """

    burst: float = 60.0
    per_second: float = 30.0
    _left: float | None = None
    _at_s: float = 0.0

    def take(self, amount: float, now_s: float) -> bool:
        """Takes it and says yes, or takes nothing and says no."""
        before = self.burst if self._left is None else self._left
        self._left = min(self.burst, before + (now_s - self._at_s) * self.per_second)
        self._at_s = now_s
        if amount > self._left:
            return False
        self._left -= amount
        return True
