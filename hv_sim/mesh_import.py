"""Meshes of the user's own (GLB, OBJ, STL, or a Sweet Home 3D `.sh3f` catalogue) made into objects to be carried.

What is seen is the mesh, simplified; what collides are boxes round its convex parts (coacd); where the hands press is
proposed from those boxes. Nothing is unpacked to disk, nothing outside the file is read.
"""

from __future__ import annotations

import io
import math
import re
import zipfile
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np
import trimesh
from trimesh.resolvers import ZipResolver

from hv_sim.glb_structure import check_glb
from hv_sim.objects import GRASP_WIDTH_M, MASS_KG, PACKAGED_KINDS, propose_grasps
from hv_sim.parts import Color, MeshShape, box
from hv_sim.user_objects import UserObject, write_object

SUFFIXES = (".glb", ".obj", ".stl", ".sh3f")
MAX_BYTES = 200_000_000
MAX_FACES = 1_000_000
DENSITY_KG_M3 = 140.0
"""Of the boxes that collide: furniture and household things are mostly hollow."""
HEIGHT_M = (0.1, 1.2)
_VISUAL_FACES, _DECOMPOSED_FACES, _SEEN_FACES = 6000, 4000, 12
_PARTS, _COLORS = 6, 10
_GRAY: Color = (0.6, 0.6, 0.6)


@dataclass(frozen=True)
class _Source:
    """One mesh of a file, with what a catalogue says about it."""

    name: str
    meshes: tuple[tuple[trimesh.Trimesh, Color], ...]
    size_m: tuple[float, float, float] | None  # as the catalogue wants it: depth, width, height


def import_file(
    file: Path,
    folder: Path,
    *,
    size_m: float | None = None,
    mass_kg: float | None = None,
    up: str | None = None,
    taken: set[str] | None = None,
    on_refused: Callable[[str], None] | None = None,
) -> Iterator[Path]:
    """Makes objects from a file and writes them below a folder; of a catalogue, those that can be carried.

    Args:
        file: `.glb`, `.obj`, `.stl` or `.sh3f`.
        folder: where objects are looked for (`hv_sim.user_objects`).
        size_m: length of the longest side; by default as the file says.
        mass_kg: by default from the volume.
        up: "y" or "z", the vertical axis; by default y for GLB, OBJ and catalogues, z for STL.
        taken: names that other files have been given; those given here are added. A taken name gets a number.
        on_refused: is told why a mesh of a catalogue was left out.

    Yields:
        Paths of `object.json` files.

    Raises:
        ValueError: the file is not a mesh, is broken, too large, or cannot be carried; one line that says why.
    """
    _check_file(file)
    names = set() if taken is None else taken
    up = up or ("z" if file.suffix.lower() == ".stl" else "y")
    if file.suffix.lower() != ".sh3f":
        source = _Source(_name(file.stem), _load(file.read_bytes(), file.suffix.lower(), str(file)), None)
        source = replace(source, name=_free_name(source.name, names))
        thing = make_object(source, size_m, mass_kg, up)
        names.add(source.name)
        yield write_object(thing, folder)
        return
    refused: list[str] = []

    def refuse(why: str) -> None:
        refused.append(why)
        if on_refused is not None:
            on_refused(why)

    before = len(names)
    for source in _catalogue(file, refuse):
        name = _free_name(source.name, names)
        try:
            thing = make_object(replace(source, name=name), size_m, mass_kg, up)
        except ValueError as error:
            refuse(str(error))
            continue
        names.add(name)
        yield write_object(thing, folder)
    if len(names) == before:
        raise ValueError(f"{file}: none of its {len(refused)} meshes can be carried; the first: {refused[:1]}")


def _free_name(name: str, taken: set[str]) -> str:
    """The name with a number where it is taken, by another mesh of a catalogue or by a kind of the package."""
    options = (name, *(f"{name}_{i}" for i in range(2, 1000)))
    return next(n for n in options if n not in taken and n not in PACKAGED_KINDS)


def make_object(source: _Source, size_m: float | None, mass_kg: float | None, up: str) -> UserObject:
    """An object from a mesh.

    Raises:
        ValueError: it is too small, too large or has no two opposite sides to press.
    """
    turned = [(_upright(mesh, up), color) for mesh, color in source.meshes]
    low = np.min([m.bounds[0] for m, _ in turned], axis=0)
    high = np.max([m.bounds[1] for m, _ in turned], axis=0)
    extent = high - low
    if not (extent > 1e-9).all():
        raise ValueError(f"{source.name}: it is flat; valid: a mesh with depth, width and height")
    scale = np.ones(3)
    if source.size_m is not None:
        scale = np.array(source.size_m) / extent
    if size_m is not None:
        scale = scale * (size_m / (extent * scale).max())
    size = extent * scale
    _check_size(source.name, size)
    placed = []
    for mesh, color in turned:
        mesh.apply_translation(-(low + high) / 2)
        mesh.apply_scale(scale)
        placed.append((mesh, color))
    boxes = _convex_boxes(_joined([m for m, _ in placed]), size)
    _, pressable = propose_grasps([box(_three(c), _three(s), _GRAY, collides=True) for c, s in boxes])
    if not pressable.any():
        raise ValueError(f"{source.name}: no two opposite sides are there for the hands to press")
    volume = sum(float(np.prod(s)) for _, s in boxes)
    mass = float(np.clip(DENSITY_KG_M3 * volume, *MASS_KG)) if mass_kg is None else float(mass_kg)
    if not MASS_KG[0] <= mass <= MASS_KG[1]:
        raise ValueError(f"{source.name}: mass_kg: {mass:g} is not valid; valid: {MASS_KG[0]:g} to {MASS_KG[1]:g}")
    return UserObject(
        name=source.name,
        noun=source.name.replace("_", " "),
        size_m=(float(size[0]), float(size[1]), float(size[2])),
        mass_kg=round(mass, 2),
        blocked=(),
        boxes=tuple((_three(c), _three(s)) for c, s in boxes),
        meshes=tuple(_visual(placed)),
    )


def _check_file(file: Path) -> None:
    if file.suffix.lower() not in SUFFIXES:
        raise ValueError(f"{file}: {file.suffix!r} is not a kind of mesh file; valid: {', '.join(SUFFIXES)}")
    if not file.is_file():
        raise ValueError(f"{file}: there is no such file")
    if file.stat().st_size > MAX_BYTES:
        raise ValueError(f"{file}: {file.stat().st_size} bytes; valid: at most {MAX_BYTES}")


def _check_size(name: str, size: np.ndarray) -> None:
    text = " x ".join(f"{s:.2f}" for s in size)
    low, high = GRASP_WIDTH_M
    if not (size[:2] >= low).all() or not (size[:2] <= high).all():
        raise ValueError(f"{name}: {text} m cannot be held; valid: {low:g} to {high:g} m across, so give --size")
    if not HEIGHT_M[0] <= size[2] <= HEIGHT_M[1]:
        raise ValueError(f"{name}: {text} m is not a height that works; valid: {HEIGHT_M[0]:g} to {HEIGHT_M[1]:g} m")


def _load(raw: bytes, suffix: str, label: str, resolver: ZipResolver | None = None):
    """The meshes of a file with their colours, checked."""
    if suffix == ".stl" and raw[:5] != b"solid" and len(raw) > 84:
        _check_faces(int.from_bytes(raw[80:84], "little"), label)
    if suffix == ".obj":
        _check_faces(raw.count(b"\nf "), label)
        for line in re.findall(rb"^\s*mtllib\s+(.+)$", raw, re.MULTILINE):
            _check_path(line.decode("utf-8", "replace").strip(), label)
    if suffix == ".glb":
        try:
            pictures = check_glb(raw)
        except ValueError as error:
            raise ValueError(f"{label}: {error}") from None
        for picture in pictures:
            _check_path(picture, label)
    try:
        with np.errstate(all="ignore"):  # coordinates are checked below
            loaded = trimesh.load_scene(io.BytesIO(raw), file_type=suffix[1:], resolver=resolver, process=False)
            whole = loaded.to_geometry() if not loaded.geometry else None
            parts = loaded.dump() if whole is None else [whole]
    except Exception as error:  # whatever a parser stumbles over in a broken file
        raise ValueError(f"{label}: not a readable {suffix[1:]} file ({' '.join(str(error).split())[:120]})") from None
    meshes = [m for m in parts if isinstance(m, trimesh.Trimesh) and len(m.faces)]
    if not meshes:
        raise ValueError(f"{label}: holds no face; valid: a mesh with faces")
    _check_faces(sum(len(m.faces) for m in meshes), label)
    for mesh in meshes:
        if not np.isfinite(mesh.vertices).all():
            raise ValueError(f"{label}: a vertex is not finite; valid: finite coordinates")
    return tuple((m, _color(m)) for m in meshes)


def _check_faces(count: int, label: str) -> None:
    if count > MAX_FACES:
        raise ValueError(f"{label}: {count} faces; valid: at most {MAX_FACES}, simplify the mesh first")


def _check_path(name: str, label: str) -> None:
    path = PurePosixPath(name.replace("\\", "/"))
    if path.is_absolute() or ".." in path.parts or ":" in name:
        raise ValueError(f"{label}: {name!r} leaves its folder; valid: names of files beside it")


def _catalogue(file: Path, refuse: Callable[[str], None]) -> Iterator[_Source]:
    """The meshes of a Sweet Home 3D catalogue, in its order; `refuse` is told of those that are broken."""
    try:
        with zipfile.ZipFile(file) as archive:
            for member in archive.infolist():
                _check_path(member.filename, str(file))
                if member.file_size > MAX_BYTES:
                    raise ValueError(f"{file}: {member.filename!r} is {member.file_size} bytes; valid: {MAX_BYTES}")
            text = archive.read("PluginFurnitureCatalog.properties").decode("latin-1")
            fields = dict(re.findall(r"^([A-Za-z]+#\d+)\s*[=:]\s*(.*?)\s*$", text, re.MULTILINE))
            for number in sorted({int(k.split("#")[1]) for k in fields}):
                entry = {k.split("#")[0]: v for k, v in fields.items() if k.endswith(f"#{number}")}
                model = entry.get("model", "").lstrip("/")
                suffix = Path(model).suffix.lower()
                if suffix != ".obj" or model not in archive.namelist():
                    refuse(f"{file}: item {number}: {model!r} is not an OBJ file in it")
                    continue
                # the model's materials are beside it in the archive
                beside = [n for n in archive.namelist() if n.lower().endswith(".mtl") and _folder(n) == _folder(model)]
                resolver = ZipResolver({PurePosixPath(n).name: io.BytesIO(archive.read(n)) for n in beside})
                try:
                    meshes = _load(archive.read(model), suffix, f"{file}: {model}", resolver)
                    size = tuple(float(entry[k]) / 100.0 for k in ("depth", "width", "height"))
                except (KeyError, ValueError) as error:
                    refuse(f"{file}: item {number}: {error}")
                    continue
                if not all(math.isfinite(s) and s > 0 for s in size):
                    refuse(f"{file}: item {number}: size {list(size)} m is not valid; valid: three numbers above 0")
                    continue
                yield _Source(_name(entry.get("name", Path(model).stem)), meshes, (size[0], size[1], size[2]))
    except (zipfile.BadZipFile, zlib.error, KeyError, EOFError, NotImplementedError, RuntimeError) as error:
        raise ValueError(f"{file}: not a readable catalogue ({error})") from None


def _folder(name: str) -> str:
    return str(PurePosixPath(name).parent)


def _color(mesh: trimesh.Trimesh) -> Color:
    """The mean colour of a mesh's material."""
    try:
        visual: Any = mesh.visual
        painted = getattr(visual, "material", visual)
        rgb = np.array(painted.main_color, dtype=np.float64)[:3] / 255.0
    except Exception:  # materials come in many kinds, and none matters enough to fail
        return _GRAY
    return (float(rgb[0]), float(rgb[1]), float(rgb[2])) if np.isfinite(rgb).all() else _GRAY


def _upright(mesh: trimesh.Trimesh, up: str) -> trimesh.Trimesh:
    """A copy with z up and the front, which files with y up have toward +z, toward +x."""
    copy = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    if up == "y":
        turn = np.array([[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]])
        copy.apply_transform(turn)
    return copy


def _convex_boxes(mesh: trimesh.Trimesh, size: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Centres and sizes of at most `_PARTS` boxes round the convex parts of a mesh."""
    import coacd

    coacd.set_log_level("off")
    simple = _simplified(mesh, _DECOMPOSED_FACES)
    parts = coacd.run_coacd(
        coacd.Mesh(np.asarray(simple.vertices), np.asarray(simple.faces)), threshold=0.12, max_convex_hull=_PARTS,
        preprocess_mode="on", preprocess_resolution=30, resolution=800, mcts_nodes=10, mcts_iterations=40, seed=0,
    )  # fmt: skip
    found = []
    for vertices, _ in parts[:_PARTS]:
        low = np.clip(vertices.min(0), -size / 2, size / 2)
        high = np.clip(vertices.max(0), -size / 2, size / 2)
        found.append(((low + high) / 2, np.maximum(high - low, 0.01)))
    # preprocessing thickens a mesh by a voxel: the whole is brought back to the mesh's own bounds
    lows = np.min([c - s / 2 for c, s in found], axis=0)
    highs = np.max([c + s / 2 for c, s in found], axis=0)
    stretch = size / (highs - lows)
    return [((c - (lows + highs) / 2) * stretch, s * stretch) for c, s in found]


def _visual(placed: list[tuple[trimesh.Trimesh, Color]]) -> Iterator[tuple[MeshShape, Color]]:
    """At most `_COLORS` meshes, of one colour each, with few enough faces to be drawn quickly."""
    groups: dict[tuple[int, ...], list[tuple[trimesh.Trimesh, Color]]] = {}
    for mesh, color in placed:
        groups.setdefault(tuple(round(4 * c) for c in color), []).append((mesh, color))
    largest = sorted(groups.values(), key=lambda g: -sum(m.area for m, _ in g))
    total = sum(len(m.faces) for m, _ in placed)
    for group in largest[:_COLORS]:
        whole = _joined([m for m, _ in group])
        share = max(_SEEN_FACES, round(_VISUAL_FACES * len(whole.faces) / max(total, 1)))
        simple = _simplified(whole, share)
        if len(simple.faces) < 4 or np.linalg.matrix_rank(simple.vertices - simple.vertices.mean(0), tol=1e-5) < 3:
            continue  # MuJoCo takes no flat mesh
        yield MeshShape(simple.vertices.astype(np.float32), simple.faces.astype(np.int32)), group[0][1]


def _joined(meshes: list[trimesh.Trimesh]) -> trimesh.Trimesh:
    counts = np.cumsum([0, *(len(m.vertices) for m in meshes)])
    faces = [m.faces + first for m, first in zip(meshes, counts, strict=False)]
    return trimesh.Trimesh(np.concatenate([m.vertices for m in meshes]), np.concatenate(faces), process=False)


def _simplified(mesh: trimesh.Trimesh, faces: int) -> trimesh.Trimesh:
    merged = trimesh.Trimesh(mesh.vertices, mesh.faces, process=True)
    return merged if len(merged.faces) <= faces else merged.simplify_quadric_decimation(face_count=faces)


def _name(text: str) -> str:
    return re.sub(r"[^a-z0-9]+", "_", text.lower()).strip("_")[:40] or "object"


def _three(v: np.ndarray) -> tuple[float, float, float]:
    return (round(float(v[0]), 5), round(float(v[1]), 5), round(float(v[2]), 5))
