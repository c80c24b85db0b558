"""A trained student as the package ships it: the checkpoint's files without what only training needs, and a model card.

The card is in LeRobot's form (front matter with `library_name`, `pipeline_tag`, `tags`, `model_name`) and takes its
figures from the `metrics.json` of evaluations, never from hand.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hv_teachers.corrected_student import load_student
from hv_teachers.evaluated_policies import checkpoint_fingerprint
from hv_teachers.recording import moved_into_place

_KINDS, _TRAINING_ONLY = (".json", ".safetensors"), ("train_config.json",)
_WEAK_BELOW = 0.2
_WEAK = (
    "- A suite above in which next to nothing succeeds asks in sentences and for things that it was not trained with: "
    "it still takes one thing for another there."
)
_FRONT = """---
library_name: lerobot
pipeline_tag: robotics
model_name: hv
tags: [robotics, lerobot, hv, humanoid, mujoco, vision-language-action]
license: apache-2.0
---
"""


def pack_student(checkpoint: Path, folder: Path, evaluations: Mapping[str, Path], trained: str) -> None:
    """Puts the student of `checkpoint` (a `pretrained_model` folder) into `folder`, which is replaced as a whole.

    Args:
        checkpoint: of the form `belief`.
        folder: where it shall lie.
        evaluations: suite -> folder of an `hv-eval` of this checkpoint.
        trained: the commands that made it, one per line.

    Raises:
        ValueError: the checkpoint is none, or an evaluation has no `metrics.json` or is of another policy.
    """
    load_student(checkpoint)
    measured = {}
    for suite, place in evaluations.items():
        file = place / "metrics.json"
        if not file.is_file():
            raise ValueError(f"evaluation: {place} is not valid; valid: a folder that hv-eval has finished")
        measured[suite] = json.loads(file.read_text())
    with moved_into_place(folder) as written:
        written.mkdir()
        for file in sorted(checkpoint.iterdir()):
            if file.suffix in _KINDS and file.name not in _TRAINING_ONLY:
                shutil.copy(file, written / file.name)
        config = json.loads((written / "config.json").read_text())
        config["pretrained_path"] = None  # of the machine that trained it
        (written / "config.json").write_text(json.dumps(config, indent=4) + "\n")
        same = {checkpoint_fingerprint(place, str(config["type"])) for place in (checkpoint, written)}
        for suite, metrics in measured.items():
            if metrics["plan"]["policy_hash"] not in same:
                raise ValueError(f"evaluation: {evaluations[suite]} is of another policy; valid: of {checkpoint}")
        (written / "README.md").write_text(model_card(config, measured, trained), encoding="utf-8")


def model_card(config: Mapping[str, Any], measured: Mapping[str, Mapping[str, Any]], trained: str) -> str:
    """The card's text, for a policy's `config.json` and the `metrics.json` of its evaluations by suite."""
    rows = [
        f"| {suite} | {_percent(m, 'success_1')} | {_percent(m, 'success_2')} | **{_percent(m, 'success_all')}** "
        f"| {m['at_0.2']['success_all']:.1%} | {m['dist_1']:.2f} / {m['dist_2']:.2f} | {m['fall_rate']:.1%} "
        f"| {m['n_episodes']} | {m['plan']['seed']} |"
        for suite, m in measured.items()
    ]
    lines = [
        _FRONT,
        "# hv student",
        "",
        f"Head camera ({config['image_size']} px), an English instruction and proprioception in, 28 joint targets "
        "out, 30 times a second, for the simulated humanoid of `hv_sim`. It sees where the object, its goal and the "
        "places to stand are, keeps a belief about them, decides on an intent, and a motor prior does it "
        "(`docs/student.md`). Nothing that only the simulator knows reaches it.",
        "",
        "    lerobot-eval --policy.path=$(hv-checkpoint student) --env.type=hv_sim --env.task=unseen",
        "",
        "| suite | object 1 | object 2 | all at 0.4 m | all at 0.2 m | miss (m) | falls | episodes | seed |",
        "|---|---|---|---|---|---|---|---|---|",
        *rows,
        "",
        "Unassisted, judged at the end of the episode; `hv-eval --policy=student --suite=SUITE --seed=SEED`, with "
        "`--n-tasks` where the episodes are fewer than the suite's tasks, gives the same figures.",
        "",
        "## Trained by",
        "",
        *(f"    {line}" for line in trained.strip().splitlines()),
        "",
        "## Limits",
        "",
        "- A simulated body in simulated rooms: nothing of it has been tried on a robot.",
        "- Free English is said again in words that it knows, wrongly one time in ten; kinds it never saw have none.",
        *(_WEAK for m in measured.values() if m["at_0.4"]["success_all"] < _WEAK_BELOW),
        "- It looks for things by turning round; what stands inside a closed cabinet is not found.",
        "",
    ]
    return "\n".join(lines)


def _percent(metrics: Mapping[str, Any], name: str) -> str:
    return f"{metrics['at_0.4'][name]:.1%}"
