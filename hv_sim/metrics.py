"""What an evaluation reports: success of each sub-task and of all, placement distance, falls."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from torch import Tensor

from hv_sim.humanoid import BODY_NAMES
from hv_sim.physics import PhysicsState

SUCCESS_THRESHOLDS_M = (0.4, 0.2)
"""Both are always reported; 0.4 m is the headline (HumanVLA judges teachers at 0.2 m, vision students at 0.4 m)."""

FALL_HEIGHT_M = 0.15
_MAY_TOUCH = ("right_foot", "left_foot", "right_hand", "left_hand")
_FALL_BODIES = [i for i, name in enumerate(BODY_NAMES) if name not in _MAY_TOUCH]


@dataclass(frozen=True)
class EpisodeRecord:
    """How one episode ended. `distances_m` is the final distance of object and goal, one for each sub-task."""

    task: str
    seed: int
    distances_m: tuple[float, ...]
    fallen: bool
    num_finished: int
    num_steps: int

    def succeeded(self, threshold_m: float) -> tuple[bool, ...]:
        """Success of each sub-task: its object is nearer to its goal than that. A non-finite distance fails."""
        return tuple(math.isfinite(d) and d < threshold_m for d in self.distances_m)


def is_fallen(state: PhysicsState) -> Tensor:
    """(N,) bool: a body other than feet and hands touches the static world less than 0.15 m above the floor."""
    touches = state.body_contact[:, _FALL_BODIES]
    low = state.body_contact_height_m[:, _FALL_BODIES] < FALL_HEIGHT_M
    return (touches & low).any(dim=1)


def summarize(records: Sequence[EpisodeRecord]) -> dict[str, Any]:
    """The metrics of an evaluation, ready for JSON.

    Keys: `n_episodes`, `fall_rate`, `dist_1` .. `dist_n` (mean final distance in m), and `at_0.4` and `at_0.2`, each
    with `success_1` .. `success_n` and `success_all`, rates between 0 and 1 (Table 1 of the paper gives them in
    percent). The i-th figure averages over the episodes that have an i-th sub-task; a distance that is not finite
    counts as a failure and is left out of the mean distance.

    Raises:
        ValueError: there is no episode, or one without a sub-task.
    """
    if not records:
        raise ValueError("records: empty; at least one episode is needed")
    if any(not record.distances_m for record in records):
        raise ValueError("records: an episode has no sub-task; valid: one distance for each sub-task")
    num_subtasks = max(len(record.distances_m) for record in records)
    summary: dict[str, Any] = {
        "n_episodes": len(records),
        "fall_rate": _mean([record.fallen for record in records]),
    }
    for i in range(num_subtasks):
        distances = [record.distances_m[i] for record in records if len(record.distances_m) > i]
        summary[f"dist_{i + 1}"] = _mean([d for d in distances if math.isfinite(d)])
    for threshold_m in SUCCESS_THRESHOLDS_M:
        outcomes = [record.succeeded(threshold_m) for record in records]
        rates = {
            f"success_{i + 1}": _mean([outcome[i] for outcome in outcomes if len(outcome) > i])
            for i in range(num_subtasks)
        }
        summary[f"at_{threshold_m}"] = {**rates, "success_all": _mean([all(outcome) for outcome in outcomes])}
    return summary


def save_metrics(path: str | Path, records: Sequence[EpisodeRecord], **extra: Any) -> dict[str, Any]:
    """Writes summary, `extra` and every episode's record to a JSON file, whole or not at all; returns the summary."""
    summary = summarize(records)
    document = {**summary, **extra, "episodes": [_finite(asdict(record)) for record in records]}
    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    temporary = target.with_name(f".{target.name}.{os.getpid()}.tmp")
    try:
        temporary.write_text(json.dumps(document, indent=2, allow_nan=False) + "\n")
        temporary.replace(target)
    finally:
        temporary.unlink(missing_ok=True)
    return summary


def _mean(values: Sequence[float | bool]) -> float | None:
    return sum(float(v) for v in values) / len(values) if values else None


def _finite(record: dict[str, Any]) -> dict[str, Any]:
    record["distances_m"] = [d if math.isfinite(d) else None for d in record["distances_m"]]
    return record
