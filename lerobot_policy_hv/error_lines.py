"""One line instead of a traceback when a stock `lerobot-*` command is given bad input of ours."""

import os
import sys
from types import TracebackType

_OUR_PACKAGES = ("hv_sim", "hv_policy", "hv_teachers")


def report_input_errors_in_one_line() -> None:
    """Print errors that our packages define (`TaskError`, `CheckpointError`, ...) as one line, exit status 1.

    Those classes are raised for bad input only, and their message already names the field, the value and the valid
    choices. Every other exception keeps its traceback. Nothing is changed outside the `lerobot-*` programs.
    """
    if not os.path.basename(sys.argv[0]).startswith("lerobot-"):
        return
    show_traceback = sys.excepthook

    def show(kind: type[BaseException], error: BaseException, traceback: TracebackType | None) -> None:
        if kind.__module__.partition(".")[0] in _OUR_PACKAGES:
            print(f"error: {error}", file=sys.stderr)
        else:
            show_traceback(kind, error, traceback)

    sys.excepthook = show
