import threading
import time

import pytest
from live_cast import SpyCast

from hv_live import protocol
from hv_live import session as session_module
from hv_live.session import MOST_WAITING, Session
from hv_sim.task import load_task


class Heard(list):
    def of(self, kind):
        return [m for m in self if isinstance(m, dict) and m["type"] == kind]


def until(condition, timeout_s=20.0):
    end = time.monotonic() + timeout_s
    while time.monotonic() < end:
        if value := condition():
            return value
        time.sleep(0.01)
    raise AssertionError("it did not come true")


@pytest.fixture
def run(tmp_path):
    """Builds sessions that are closed at the end."""
    sessions = []

    def make(cast=None, **options):
        heard = Heard()
        tasks = {"living_room_1": load_task("living_room_1")}
        made = Session(tasks, "living_room_1", cast or SpyCast(), tmp_path, heard.append, **options)
        sessions.append(made)
        return made, heard

    yield make
    for made in sessions:
        made.close()


def test_it_is_idle_until_somebody_comes_and_outlives_a_reload(run):
    session, heard = run(linger_s=0.5)
    time.sleep(0.1)
    assert session.simulation is None
    assert heard == []
    session.set_visitors(1)
    simulation = until(lambda: session.simulation)
    until(lambda: heard.of("state") and heard.of("room"))
    session.set_visitors(0)
    time.sleep(0.1)
    session.set_visitors(1)
    time.sleep(0.6)
    assert session.simulation is simulation, "a page that is loaded again finds it as it was"
    session.set_visitors(0)
    until(lambda: session.simulation is None)


def test_a_slow_machine_is_told_of_and_no_step_is_skipped(run):
    cast = SpyCast()
    actor = cast.actors["reader"]
    act = actor.act

    def slowly(world, picture):
        time.sleep(0.08)
        return act(world, picture)

    actor.act = slowly
    session, heard = run(cast)
    session.set_visitors(1)
    state = until(lambda: [s for s in heard.of("state") if s["slow"]])[-1]
    assert 0.05 < state["speed"] < 0.6
    assert state["step_ms"] > 1
    live = session.simulation
    session.send(protocol.Pause(True))
    until(lambda: heard.of("state")[-1]["paused"])
    assert len(actor.told) == int(live.world.episode_step[0]), "who plays was asked at every step"


def test_an_actor_that_fails_is_told_of_and_the_room_begins_anew(run, monkeypatch):
    monkeypatch.setattr(session_module, "AFTER_ERROR_S", 0.05)
    cast = SpyCast()
    actor = cast.actors["reader"]
    act, calls = actor.act, []

    def once_badly(world, picture):
        calls.append(1)
        intent, targets = act(world, picture)
        return intent, targets * float("nan") if len(calls) == 4 else targets

    actor.act = once_badly
    session, heard = run(cast)
    session.set_visitors(1)
    until(lambda: heard.of("error"))
    assert "not finite" in heard.of("error")[0]["text"]
    until(lambda: len(calls) > 8)


def test_too_many_commands_are_refused(run):
    cast = SpyCast()
    busy, go_on = threading.Event(), threading.Event()
    act = cast.actors["reader"].act

    def wait(world, picture):
        busy.set()
        go_on.wait(20)
        return act(world, picture)

    cast.actors["reader"].act = wait
    session, _ = run(cast)
    session.set_visitors(1)
    assert busy.wait(20)
    taken = [session.send(protocol.OrbitHome()) for _ in range(MOST_WAITING + 5)]
    go_on.set()
    assert taken == [True] * MOST_WAITING + [False] * 5
