import av
import pytest
from live_cast import SpyCast

from hv_live.script import Line, ScriptError, play_script, read_script
from hv_live.simulation import Simulation

SCRIPT = """
# seconds  what is said
1.0   [end]
0.4   please wave at me
0.6\t[push -90]
0   Put the toaster on the console table.
0.8 [instructor on]
"""


def write(tmp_path, text):
    path = tmp_path / "lines.txt"
    path.write_text(text)
    return path


def test_a_script_is_played_by_the_simulated_clock_and_filmed(tmp_path):
    script = read_script(write(tmp_path, SCRIPT))
    assert script[0] == Line(0.0, text="Put the toaster on the console table.")
    assert script[2] == Line(0.6, action="push", word="-90")
    events = []
    cast = SpyCast()
    with Simulation("living_room_1", cast) as live:
        play_script(live, script, tmp_path / "film.mp4", lambda time_s, text: events.append((time_s, text)))
        assert live.instructor
    told = cast.actors["reader"].told
    assert told[:12] == ["Put the toaster on the console table."] * 12
    assert told[12:24] == ["please wave at me"] * 12
    assert len(told) == 30
    assert events[0] == (0.0, "Put the toaster on the console table.")
    assert events[2][1] == "[push -90]"
    with av.open(str(tmp_path / "film.mp4")) as film:
        frames = [frame.to_ndarray(format="rgb24") for frame in film.decode(video=0)]
    assert len(frames) == 15
    assert frames[0].shape == (336, 672, 3)
    assert frames[0].std() > 10
    assert sorted(p.name for p in tmp_path.iterdir()) == ["film.mp4", "lines.txt"]


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("", "no line"),
        ("# only this\n", "no line"),
        ("soon Put it there.", "lines.txt:1: 'soon' is not a time"),
        ("-1 Put it there.", "not a time"),
        ("nan Put it there.", "not a time"),
        ("1\n", "instruction"),
        ("1 [dance]", "valid: an instruction"),
        ("1 [instructor perhaps]", "on, off"),
        ("1 [push left]", "degrees"),
        ("0 ok\n1 " + "x" * 201, "lines.txt:2"),
    ],
)
def test_bad_scripts_are_refused_in_one_line(tmp_path, text, word):
    with pytest.raises(ScriptError, match=word) as caught:
        read_script(write(tmp_path, text))
    assert "\n" not in str(caught.value)


def test_what_cannot_be_done_ends_the_film_and_leaves_none(tmp_path):
    with (
        Simulation("living_room_1", SpyCast("teacher")) as live,
        pytest.raises(ScriptError, match=r"at 0\.1 s: 'dance'"),
    ):
        play_script(live, [Line(0.1, text="dance")], tmp_path / "film.mp4")
    assert not list(tmp_path.iterdir())
    with pytest.raises(ScriptError, match="cannot be read"):
        read_script(tmp_path / "none.txt")
