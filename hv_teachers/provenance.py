"""What else decides how an episode ends, beside policy, task and seed: code, physics and packages, as hashes."""

from __future__ import annotations

import ast
import functools
import hashlib
import importlib.util
import platform
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from hv_sim.task import Task
from hv_sim.world import RearrangeWorld

PACKAGES = ("mujoco", "torch", "lerobot", "numpy")
_OURS = ("hv_sim", "hv_policy", "hv_teachers", "lerobot_policy_hv")
_PLAYS = ("hv_teachers.episodes", "hv_teachers.evaluated_policies", "lerobot_policy_hv")


def versions() -> dict[str, str]:
    """Of the packages that compute, and of Python."""
    return {**{p: version(p) for p in PACKAGES}, "python": platform.python_version()}


@functools.cache
def code_hash(roots: Sequence[str] = _PLAYS) -> str:
    """Of our modules that play episodes, and of all of ours that they import; comments and docstrings do not count."""
    waiting, files = list(roots), {}
    while waiting:
        name = waiting.pop()
        file = _file_of(name)
        if name in files or file is None:
            continue
        tree = _without_docstrings(ast.parse(file.read_text(encoding="utf-8")))
        files[name] = hashlib.sha256(ast.dump(tree).encode()).hexdigest()
        waiting += _imports(tree)
    return hashlib.sha256(repr(sorted(files.items())).encode()).hexdigest()[:16]


def physics(task: Task) -> dict[str, Any]:
    """`physics_hz` and `physics_hash` of a task's compiled scene, the humanoid included."""
    model = RearrangeWorld([task], num_threads=1).physics.model(0)
    buffer = np.empty(mujoco.mj_sizeModel(model), dtype=np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return {
        "physics_hz": round(1.0 / model.opt.timestep),
        "physics_hash": hashlib.sha256(buffer.tobytes()).hexdigest()[:16],
    }


def _without_docstrings(tree: ast.Module) -> ast.Module:
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list):
            node.body = [n for n in body if not (isinstance(n, ast.Expr) and isinstance(n.value, ast.Constant))]  # type: ignore[attr-defined]
    return tree


def _imports(tree: ast.Module) -> list[str]:
    """Modules of ours that a module imports, wherever in it; `from a import b` may be a module a.b."""
    names = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            names += [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
    return [n for n in names if n.split(".")[0] in _OURS]


def _file_of(name: str) -> Path | None:
    """Of a module of ours; nothing is imported for it."""
    package, *parts = name.split(".")
    spec = importlib.util.find_spec(package)
    if spec is None or spec.origin is None:
        return None
    path = Path(spec.origin).parent.joinpath(*parts)
    return next((f for f in (path.with_suffix(".py"), path / "__init__.py") if f.is_file()), None)
