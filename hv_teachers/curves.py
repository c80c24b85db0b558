"""Training curves as pictures: one panel for each quantity of a CSV, smoothed over the last rows."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np


def plot_curve(table: Path, picture: Path, columns: Sequence[str], x: str = "samples", smooth: int = 20) -> None:
    """Draws `columns` of a CSV against `x` and writes a PNG whole or not at all.

    Raises:
        ValueError: a column is not in the table.
    """
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    with table.open() as file:
        rows = list(csv.DictReader(file))
    known = list(rows[0]) if rows else []
    missing = [c for c in (x, *columns) if c not in known]
    if missing:
        raise ValueError(f"columns: {missing} are not in {table}; valid: {known}")
    across = np.array([float(r[x]) for r in rows])
    per_row = min(3, len(columns))
    figure, axes = pyplot.subplots(
        math.ceil(len(columns) / per_row),
        per_row,
        figsize=(4 * per_row, 2.6 * math.ceil(len(columns) / per_row)),
        squeeze=False,
    )
    for axis, column in zip(axes.flat, columns, strict=False):
        values = np.array([float(r[column] or "nan") for r in rows])
        axis.plot(across, values, color="0.8", linewidth=0.8)
        window = min(smooth, len(values))
        axis.plot(across[window - 1 :], np.convolve(values, np.ones(window) / window, "valid"), linewidth=1.5)
        axis.set_title(column.replace("_", " "), fontsize=10)
        axis.set_xlabel(x, fontsize=8)
        axis.grid(alpha=0.3)
    for axis in list(axes.flat)[len(columns) :]:
        axis.remove()
    figure.tight_layout()
    temporary = picture.with_suffix(".tmp.png")
    figure.savefig(temporary, dpi=90)
    pyplot.close(figure)
    temporary.replace(picture)
