"""Looks through a GLB file's table of contents before a parser is let loose on it, to say plainly what is wrong."""

from __future__ import annotations

import json
from typing import Any

_HEADER_BYTES = 20


def check_glb(raw: bytes) -> list[str]:
    """Checks that a GLB file holds all that its meshes refer to.

    Args:
        raw: the file.

    Returns:
        Names of pictures outside the file, which are not read.

    Raises:
        ValueError: it is no GLB, keeps its data in another file, or a mesh refers to something that is not there; the
            message lacks the file's name.
    """
    try:
        length = int.from_bytes(raw[12:16], "little")
        if raw[:4] != b"glTF" or raw[16:20] != b"JSON" or _HEADER_BYTES + length > len(raw):
            raise ValueError("it has no header")
        contents = json.loads(raw[_HEADER_BYTES : _HEADER_BYTES + length])
        if not isinstance(contents, dict):
            raise ValueError("its contents are not an object")
    except (ValueError, RecursionError) as error:
        raise ValueError(f"not a readable glb file ({error})") from None
    for i, buffer in enumerate(_list(contents, "buffers")):
        uri = _text(buffer, "uri")
        if uri and not uri.startswith("data:"):
            raise ValueError(f"buffers[{i}].uri: {uri[:60]!r} is another file; valid: a .glb with everything inside")
    accessors, views = _list(contents, "accessors"), _list(contents, "bufferViews")
    for i, mesh in enumerate(_list(contents, "meshes")):
        for j, primitive in enumerate(_list(mesh, "primitives")):
            where = f"meshes[{i}].primitives[{j}]"
            attributes = primitive.get("attributes") if isinstance(primitive, dict) else None
            if not isinstance(attributes, dict) or "POSITION" not in attributes:
                raise ValueError(f"{where}.attributes.POSITION: missing; valid: the number of an accessor")
            _check_index(f"{where}.attributes.POSITION", attributes["POSITION"], accessors, "accessors")
            if "indices" in primitive:
                _check_index(f"{where}.indices", primitive["indices"], accessors, "accessors")
    for i, accessor in enumerate(accessors):
        if isinstance(accessor, dict) and "bufferView" in accessor:
            _check_index(f"accessors[{i}].bufferView", accessor["bufferView"], views, "bufferViews")
    pictures = [_text(image, "uri") for image in _list(contents, "images")]
    return [uri for uri in pictures if uri and not uri.startswith("data:")]


def _check_index(where: str, value: Any, things: list[Any], name: str) -> None:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < len(things):
        raise ValueError(f"{where}: {value!r} is not there; valid: one of the file's {len(things)} {name}")


def _list(data: Any, key: str) -> list[Any]:
    value = data.get(key) if isinstance(data, dict) else None
    return value if isinstance(value, list) else []


def _text(data: Any, key: str) -> str:
    value = data.get(key) if isinstance(data, dict) else None
    return value if isinstance(value, str) else ""
