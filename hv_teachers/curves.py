"""Training curves as pictures: one panel for each quantity of a CSV, smoothed over the last rows."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np


def plot_curve(
    table: Path,
    picture: Path,
    columns: Sequence[str],
    x: str = "samples",
    smooth: int = 20,
    where: tuple[str, str] | None = None,
) -> None:
    """Draws `columns` of a CSV against `x` and writes a PNG whole or not at all.

    Args:
        table: the CSV; empty cells are left out.
        picture: where to write.
        columns: one panel each.
        x: column of the horizontal axis.
        smooth: rows of the moving average.
        where: a column and the value that rows must have there to be drawn.

    Raises:
        ValueError: a column is not in the table.
    """
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    with table.open() as file:
        rows = list(csv.DictReader(file))
    known = list(rows[0]) if rows else []
    if where is not None:
        rows = [r for r in rows if r.get(where[0]) == where[1]]
    missing = [c for c in (x, *columns) if c not in known]
    if missing:
        raise ValueError(f"columns: {missing} are not in {table}; valid: {known}")
    per_row = min(3, len(columns))
    figure, axes = pyplot.subplots(
        math.ceil(len(columns) / per_row),
        per_row,
        figsize=(4 * per_row, 2.6 * math.ceil(len(columns) / per_row)),
        squeeze=False,
    )
    for axis, column in zip(axes.flat, columns, strict=False):
        filled = [r for r in rows if r[column] != ""]
        across, values = (np.array([float(r[name]) for r in filled]) for name in (x, column))
        axis.plot(across, values, color="0.8", linewidth=0.8)
        window = min(smooth, len(values))
        if not window:
            continue
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
