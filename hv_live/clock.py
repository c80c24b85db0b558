"""Real time, or slower: every control step is done, and the clock says how fast that went."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable

from hv_sim.humanoid import CONTROL_HZ

CONTROL_DT_S = 1.0 / CONTROL_HZ
_WINDOW_S = 2.0
_CATCH_UP_S = 0.1
"""So far behind, a late clock makes up for it; what is beyond is lost, and the simulation slower than real time."""


class Clock:
    """Says when the next control step is due.

    Args:
        now: seconds of a steady clock; another one for tests.
    """

    def __init__(self, now: Callable[[], float] = time.perf_counter) -> None:
        self._now = now
        self._due = now()
        self._steps: deque[float] = deque()
        self._since = self._due

    def start(self) -> None:
        """Begins, or goes on after a pause: nothing is to be caught up with."""
        self._due = self._since = self._now()
        self._steps.clear()

    def wait_s(self) -> float:
        """How long to wait until the next step is due; 0 when it is late."""
        return max(0.0, self._due - self._now())

    def tick(self) -> None:
        """A step was done."""
        now = self._now()
        self._due = max(self._due + CONTROL_DT_S, now - _CATCH_UP_S)
        self._steps.append(now)
        while self._steps and self._steps[0] < now - _WINDOW_S:
            self._steps.popleft()

    @property
    def speed(self) -> float:
        """Simulated seconds a second over the last two: 1 is real time."""
        now = self._now()
        span = min(_WINDOW_S, now - self._since)
        recent = sum(at >= now - span for at in self._steps)
        return recent * CONTROL_DT_S / span if span > 0.5 else 1.0


class Rate:
    """How often something happened a second, over the last two."""

    def __init__(self, now: Callable[[], float] = time.perf_counter) -> None:
        self._now = now
        self._at: deque[float] = deque(maxlen=200)

    def tick(self) -> None:
        """It happened."""
        self._at.append(self._now())

    @property
    def per_second(self) -> float:
        """How often."""
        since = self._now() - _WINDOW_S
        return sum(at >= since for at in list(self._at)) / _WINDOW_S
