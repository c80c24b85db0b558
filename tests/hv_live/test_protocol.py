import json

import pytest

from hv_live import protocol
from hv_live.protocol import Allowance, ProtocolError, cost, parse_command


@pytest.mark.parametrize(
    ("message", "command"),
    [
        ({"type": "instruct", "text": "Put it there."}, protocol.Instruct("Put it there.")),
        ({"type": "pause", "on": True}, protocol.Pause(True)),
        ({"type": "reset"}, protocol.Reset()),
        ({"type": "load", "task": "unseen_003"}, protocol.Load("unseen_003")),
        ({"type": "policy", "name": "teacher"}, protocol.Policy("teacher")),
        ({"type": "instructor", "on": False}, protocol.PlayUser(False)),
        ({"type": "push"}, protocol.Push(0.0, 0.5)),
        ({"type": "push", "direction_deg": -90, "speed_m_s": 1}, protocol.Push(-90.0, 1.0)),
        ({"type": "record", "on": True}, protocol.Record(True)),
        (
            {"type": "camera", "azimuth_deg": 10, "elevation_deg": -20, "distance_m": 3},
            protocol.Orbit(10.0, -20.0, 3.0),
        ),
        ({"type": "camera_home"}, protocol.OrbitHome()),
    ],
)
def test_every_command(message, command):
    assert parse_command(json.dumps(message)) == command


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("", "JSON"),
        ("null", "object"),
        ("[1]", "object"),
        ("[" * 3000, "JSON"),
        ("{}", "type"),
        ('{"type": 7}', "type"),
        ('{"type": {"a": 1}}', "type"),
        ('{"type": "shutdown"}', "valid: instruct"),
        ('{"type": "instruct"}', "text: missing"),
        ('{"type": "instruct", "text": 5}', "text: 5"),
        ('{"type": "instruct", "text": "  "}', "text"),
        ('{"type": "instruct", "text": "a\\u0000b"}', "text"),
        ('{"type": "instruct", "text": "%s"}' % ("x" * 201), "200"),
        ('{"type": "pause", "on": 1}', "true, false"),
        ('{"type": "pause", "on": true, "off": false}', "off: unknown"),
        ('{"type": "pause", "on": true, "on": false}', "twice"),
        ('{"type": "load", "task": "../../etc/passwd"}', "not a name"),
        ('{"type": "push", "speed_m_s": 40}', "0 to 1.5"),
        ('{"type": "push", "speed_m_s": NaN}', "speed_m_s"),
        ('{"type": "camera", "azimuth_deg": 1e999, "elevation_deg": 0, "distance_m": 3}', "azimuth_deg"),
        ('{"type": "camera", "azimuth_deg": true, "elevation_deg": 0, "distance_m": 3}', "azimuth_deg"),
        ('{"type": "reset", "pad": "%s"}' % ("x" * 5000), "at most 4096"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(text, word):
    with pytest.raises(ProtocolError, match=word) as caught:
        parse_command(text)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 300


def test_an_allowance_runs_out_and_comes_back():
    allowance = Allowance(burst=10, per_second=2)
    assert all(allowance.take(1, 5.0) for _ in range(10))
    assert not allowance.take(1, 5.0)
    assert not allowance.take(1, 5.4)
    assert allowance.take(1, 5.6)
    assert not allowance.take(11, 1e6), "never more than the burst"


def test_building_a_room_costs_more_than_turning_the_camera():
    assert cost(protocol.Load("a")) > 5 * cost(protocol.Orbit(0, 0, 3))
