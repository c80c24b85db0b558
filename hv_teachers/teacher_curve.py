"""The curve of a teacher's training: a table, TensorBoard and pictures."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

from torch.utils.tensorboard import SummaryWriter

from hv_teachers.curves import plot_curve

CURVES = {
    "dagger": ("action_loss", "phase_wrong", "success", "all_success", "accepted", "fallen", "distance_m"),
    "ppo": ("reward", "style_reward", "success", "all_success", "accepted", "fallen", "distance_m", "value_loss"),
}


class TrainingCurve:
    """Rows of `curve.csv` and TensorBoard; what a killed run had written beyond its checkpoint is cut off."""

    def __init__(self, output: Path, samples: int) -> None:
        self.path = output / "curve.csv"
        self.rows: list[dict[str, Any]] = []
        if samples and self.path.exists():
            with self.path.open() as file:
                self.rows = [row for row in csv.DictReader(file) if int(row["samples"]) <= samples]
        self.board = SummaryWriter(str(output / "tensorboard"), purge_step=samples or None)

    def add(self, kind: str, row: dict[str, Any]) -> None:
        self.rows.append({"kind": kind, **row})
        for name, value in row.items():
            self.board.add_scalar(f"{kind}/{name}", float(value), int(row["samples"]))

    def flush(self) -> None:
        self.board.flush()
        names: dict[str, None] = {"kind": None, "samples": None}
        for row in self.rows:
            names |= dict.fromkeys(row)
        temporary = self.path.with_suffix(".tmp")
        with temporary.open("w", newline="") as file:
            writer = csv.DictWriter(file, fieldnames=list(names), restval="")
            writer.writeheader()
            writer.writerows(self.rows)
        temporary.replace(self.path)
        for kind, columns in CURVES.items():
            rows = [row for row in self.rows if row["kind"] == kind]
            present = [c for c in columns if any(str(row.get(c, "")) != "" for row in rows)]
            if rows and present:
                plot_curve(
                    self.path,
                    self.path.with_name(f"curve_{kind}.png"),
                    present,
                    smooth=max(1, len(rows) // 10),
                    where=("kind", kind),
                )


def episode_means(sums: dict[str, float], steps: int) -> dict[str, float]:
    """Rewards a step, and shares of the episodes that ended."""
    row = {name: round(value / steps, 5) for name, value in sums.items() if not name.startswith("n_")}
    episodes, subtasks = sums.get("n_episodes", 0.0), sums.get("n_subtasks", 0.0)
    row["episodes"] = int(episodes)
    if episodes:
        row |= {
            "success": round(sums["n_successes"] / subtasks, 4),
            "all_success": round(sums["n_all_successes"] / episodes, 4),
            "accepted": round(sums["n_accepted"] / subtasks, 4),
            "fallen": round(sums["n_fallen"] / episodes, 4),
            "distance_m": round(sums["n_distance"] / subtasks, 4),
        }
    return row
