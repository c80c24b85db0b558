"""hv-live from the command line."""

import json
import re
import signal
import subprocess
import sys
import urllib.request

import av
import pytest

from hv_scripts import live


def test_it_serves_this_machine_alone_until_it_is_told_to_end(tmp_path):
    command = [sys.executable, "-m", "hv_scripts.live", "--port=0", "--no-browser", "--policy=planner"]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=tmp_path
    ) as process:
        try:
            assert process.stdout is not None
            line = process.stdout.readline()
            found = re.search(r"http://127\.0\.0\.1:(\d+)/ ", line)
            assert found, line
            with urllib.request.urlopen(f"http://127.0.0.1:{found[1]}/", timeout=20) as page:
                assert b"<title>hv live" in page.read()
            with urllib.request.urlopen(f"http://127.0.0.1:{found[1]}/status", timeout=20) as status:
                assert json.load(status)["simulation"] == "idle"
            listening = open(f"/proc/{process.pid}/net/tcp").read() + open(f"/proc/{process.pid}/net/tcp6").read()
            port = f"{int(found[1]):04X}"
            addresses = re.findall(rf"\s([0-9A-F]+):{port} [0-9A-F]+:0000 0A", listening)
            assert addresses == ["0100007F"], "127.0.0.1 and nothing else"
            process.send_signal(signal.SIGTERM)
            assert process.wait(20) == 0
            assert "Traceback" not in process.stdout.read()
        finally:
            process.kill()


def test_a_film_without_a_page(tmp_path, capsys):
    script, film = tmp_path / "lines.txt", tmp_path / "film.mp4"
    script.write_text("0.2 Put the toaster on the console table.\n0.6 [end]\n")
    arguments = ["--headless", "--script", str(script), "--output", str(film), "--policy=planner"]
    assert live.main(arguments) == 0
    said = capsys.readouterr().out
    assert "0.20 s  Put the toaster on the console table." in said
    with av.open(str(film)) as container:
        assert container.streams.video[0].frames == 9
    script.write_text("0.2 dance\n")
    assert live.main(arguments) == 2
    assert re.fullmatch(r"error: at 0\.2 s: 'dance': .*\n", capsys.readouterr().err)


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["--policy=nobody"], "nobody"),
        (["--task=moon"], "moon"),
        (["--policy=planner", "--host=203.0.113.7", "--no-browser"], "203.0.113.7"),
        (["--headless"], "--script"),
        (["--script=x.txt"], "--headless"),
        (["--headless", "--script=x.txt", "--output=film.gif"], ".mp4"),
        (["--port=70000"], "70000"),
    ],
)
def test_what_is_wrong_is_said(arguments, word, capsys):
    try:
        status = live.main(arguments)
    except SystemExit as exit:
        status = exit.code
    assert status == 2
    assert word in capsys.readouterr().err.splitlines()[-1]
