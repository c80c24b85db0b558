"""Objects of the user's own: folders that `hv-tasks import-mesh` writes, found through `HV_OBJECTS`.

Each object is a folder with `object.json` (sizes, mass, grasps, boxes for contact) and `visual.npz` (what it looks
like). `HV_OBJECTS` names the folders that hold them, separated by the system's path separator; `hv_objects` in the
working directory is always looked at. Their kinds may be named in task files like those of the package.
"""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hv_sim.object_kinds.kind import ObjectKind, Size
from hv_sim.parts import COLORS, Color, MeshShape, Part, box

SCHEMA = "hv_sim.object/1"
FOLDER = "hv_objects"
_MAX_BYTES = 50_000_000
_MAX_BOXES, _MAX_MESHES = 6, 12


@dataclass(frozen=True)
class UserObject:
    """What an object's folder says; metres and kg, frame in the middle of the bounding box, z up, front +x."""

    name: str
    noun: str
    size_m: Size
    mass_kg: float
    blocked: tuple[int, ...]
    boxes: tuple[tuple[tuple[float, float, float], tuple[float, float, float]], ...]
    """Centre and full size of each box that collides."""
    meshes: tuple[tuple[MeshShape, Color], ...]

    def kind(self) -> ObjectKind:
        """As a kind of object; made in another size, everything is stretched."""
        return ObjectKind(
            self._build, self.size_m, self.mass_kg, "gray", noun=self.noun,
            category="own", colors=("gray",), blocked=self.blocked, max_height_m=max(0.6, 1.5 * self.size_m[2]),
        )  # fmt: skip

    def _build(self, size: Size, color: Color) -> list[Part]:
        stretch = np.array(size) / self.size_m
        own = color == COLORS["gray"]
        parts = []
        for center, extent in self.boxes:
            at, full = np.array(center) * stretch, np.array(extent) * stretch
            share = float(np.prod(full))
            parts.append(box(_three(at), _three(full), color, collides=True, visible=not self.meshes, mass_share=share))
        for mesh, paint in self.meshes:
            shape = mesh.stretched(stretch)
            parts.append(Part("mesh", (1.0, 1.0, 1.0), (0.0, 0.0, 0.0), paint if own else color, mesh=shape))
        return parts


def user_kinds() -> dict[str, ObjectKind]:
    """The kinds in the folders of `HV_OBJECTS`; one that cannot be read is left out with a warning."""
    found: dict[str, ObjectKind] = {}
    folders = [Path(p) for p in os.environ.get("HV_OBJECTS", "").split(os.pathsep) if p] + [Path(FOLDER)]
    for folder in folders:
        for file in sorted(folder.glob("*/object.json")) if folder.is_dir() else ():
            try:
                thing = read_object(file.parent)
            except ValueError as error:
                warnings.warn(f"{error}; this object is left out", stacklevel=2)
                continue
            found.setdefault(thing.name, thing.kind())
    return found


def read_object(folder: Path) -> UserObject:
    """Reads an object's folder.

    Raises:
        ValueError: a file is missing or damaged; one line with the file and the reason.
    """
    file = folder / "object.json"
    try:
        if max(file.stat().st_size, (folder / "visual.npz").stat().st_size) > _MAX_BYTES:
            raise ValueError(f"larger than {_MAX_BYTES} bytes")
        data = json.loads(file.read_text(encoding="utf-8"))
        if data["schema"] != SCHEMA:
            raise ValueError(f"schema: {data['schema']!r}; valid: {SCHEMA!r}")
        boxes = tuple((_vector(b["center_m"]), _vector(b["size_m"])) for b in data["boxes"])
        if not 1 <= len(boxes) <= _MAX_BOXES:
            raise ValueError(f"boxes: {len(boxes)} of them; valid: 1 to {_MAX_BOXES}")
        return UserObject(
            name=str(data["name"]),
            noun=str(data["noun"]),
            size_m=_vector(data["size_m"]),
            mass_kg=_number(data["mass_kg"]),
            blocked=tuple(int(i) for i in data["blocked"]),
            boxes=boxes,
            meshes=_meshes(folder / "visual.npz", data["colors"]),
        )
    except (OSError, KeyError, TypeError, ValueError, RecursionError) as error:
        reason = f"{error} is missing" if isinstance(error, KeyError) else str(error)
        raise ValueError(f"{file}: not a readable object ({reason})") from None


def write_object(thing: UserObject, folder: Path) -> Path:
    """Writes an object's folder below `folder`; returns the path of its `object.json`."""
    target = folder / thing.name
    target.mkdir(parents=True, exist_ok=True)
    arrays: dict[str, Any] = {}
    for i, (mesh, _) in enumerate(thing.meshes):
        arrays[f"vertices_{i}"], arrays[f"faces_{i}"] = mesh.vertices_m, mesh.faces
    with (draft := target / ".visual.tmp").open("wb") as file:
        np.savez_compressed(file, **arrays)
    draft.replace(target / "visual.npz")
    data = {
        "schema": SCHEMA, "name": thing.name, "noun": thing.noun, "size_m": thing.size_m, "mass_kg": thing.mass_kg,
        "blocked": thing.blocked,
        "boxes": [{"center_m": c, "size_m": s} for c, s in thing.boxes],
        "colors": [color for _, color in thing.meshes],
    }  # fmt: skip
    draft = target / ".object.tmp"
    draft.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
    draft.replace(target / "object.json")
    return target / "object.json"


def _meshes(file: Path, colors: list[Any]) -> tuple[tuple[MeshShape, Color], ...]:
    if len(colors) > _MAX_MESHES:
        raise ValueError(f"colors: {len(colors)} of them; valid: at most {_MAX_MESHES}")
    with np.load(file, allow_pickle=False) as arrays:
        return tuple(
            (MeshShape(arrays[f"vertices_{i}"].astype(np.float32), arrays[f"faces_{i}"].astype(np.int32)), _vector(c))
            for i, c in enumerate(colors)
        )


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not np.isfinite(value):
        raise ValueError(f"{value!r} is not a number")
    return float(value)


def _vector(values: Mapping | Any) -> tuple[float, float, float]:
    x, y, z = values
    return (_number(x), _number(y), _number(z))


def _three(v: np.ndarray) -> tuple[float, float, float]:
    return (float(v[0]), float(v[1]), float(v[2]))
