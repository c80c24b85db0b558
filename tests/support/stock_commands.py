"""Runs the commands that users type, as they type them: in a process of their own, with no network."""

import os
import subprocess
import sys
from pathlib import Path


def run_command(name: str, *arguments: object, **environment: str) -> subprocess.CompletedProcess[str]:
    """Runs `name` of this Python's environment; stdout and stderr come back together, as `stdout`.

    Nothing tells it to stay offline; instead, whatever it should ask of a hub or proxy goes to a closed port.
    """
    closed = "http://127.0.0.1:9"
    settings = {
        **{key: value for key, value in os.environ.items() if not key.startswith(("HF_", "PYTEST_"))},
        "HF_ENDPOINT": closed,
        "HTTPS_PROXY": closed,
        "HTTP_PROXY": closed,
        "OMP_NUM_THREADS": "1",
        "OMP_WAIT_POLICY": "passive",
        **environment,
    }
    command = [str(Path(sys.executable).with_name(name)), *map(str, arguments)]
    return subprocess.run(
        command, env=settings, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=300
    )


def error_lines(output: str) -> list[str]:
    """The lines that begin with `error:`; fails if there is a traceback as well."""
    assert "Traceback" not in output, output[-2000:]
    return [line for line in output.splitlines() if line.startswith("error:")]
