"""Meshes made into objects, against trimesh's own figures; broken and hostile files."""

import io
import json
import os
import struct
import warnings
import zipfile
from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh

from hv_sim import objects
from hv_sim.mesh_import import MAX_FACES, import_file
from hv_sim.scene import compile_scene
from hv_sim.task import ObjectPlacement, RobotStart, Room, SubTask, Task, check_task
from hv_sim.user_objects import read_object, user_kinds, write_object


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    """A small table, z up: a top on four legs."""
    parts = [trimesh.creation.box((0.36, 0.40, 0.04), trimesh.transformations.translation_matrix((0, 0, 0.38)))]
    for x in (-0.15, 0.15):
        for y in (-0.17, 0.17):
            leg = trimesh.creation.box((0.05, 0.05, 0.36), trimesh.transformations.translation_matrix((x, y, 0.18)))
            parts.append(leg)
    file = tmp_path_factory.mktemp("meshes") / "My Table.stl"
    trimesh.util.concatenate(parts).export(file)
    return file


@pytest.fixture(scope="module")
def imported(table, tmp_path_factory):
    folder = tmp_path_factory.mktemp("hv_objects")
    return read_object(next(iter(import_file(table, folder))).parent)


def test_size_and_boxes_are_the_meshs(imported):
    assert imported.name == "my_table"
    assert imported.noun == "my table"
    np.testing.assert_allclose(imported.size_m, (0.36, 0.40, 0.40), atol=1e-4)
    low = np.min([np.subtract(c, np.divide(s, 2)) for c, s in imported.boxes], axis=0)
    high = np.max([np.add(c, np.divide(s, 2)) for c, s in imported.boxes], axis=0)
    np.testing.assert_allclose(high - low, imported.size_m, atol=1e-3)
    assert 1 < len(imported.boxes) <= 6, "a table is more than its bounding box"
    volume = sum(np.prod(s) for _, s in imported.boxes)
    assert volume < 0.75 * np.prod(imported.size_m)


def test_it_stands_and_can_be_told_about_in_a_task(imported, monkeypatch):
    monkeypatch.setitem(objects.OBJECT_KINDS, "my_table", imported.kind())
    thing = ObjectPlacement("table", "my_table", (1.0, 0.0, 0.18), size_m=(0.3, 0.36, 0.36))
    goal = SubTask("table", (-1.0, 0.0, 0.18), 0.0, "Bring my table here.")
    task = Task("own", Room(), RobotStart(), (), (thing,), (goal,))
    scene = compile_scene(task)
    data = mujoco.MjData(scene.model)
    data.qpos[:] = scene.initial_qpos
    data.qpos[37] = 0.18
    for _ in range(120):
        data.qpos[:35], data.qvel[:34] = scene.initial_qpos[:35] + 5.0 * np.eye(35)[2], 0.0
        mujoco.mj_step(scene.model, data)
    np.testing.assert_allclose(data.qpos[35:38], (1.0, 0.0, 0.18), atol=0.005)
    check_task(task)


def test_own_kinds_are_found_through_the_environment(imported, tmp_path, monkeypatch):
    write_object(imported, tmp_path)
    monkeypatch.setenv("HV_OBJECTS", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    assert set(user_kinds()) == {"my_table"}
    (tmp_path / "my_table" / "object.json").write_text('{"schema": "hv_sim.object/1"}')
    with pytest.warns(UserWarning, match="boxes.* is missing"):
        assert user_kinds() == {}


def test_glb_and_obj_are_turned_upright_and_keep_their_colours(tmp_path):
    box = trimesh.creation.box((0.2, 0.5, 0.3))  # y up: .5 m tall, .3 deep, .2 wide
    box.visual.face_colors = [255, 0, 0, 255]
    for suffix in ("glb", "obj"):
        file = tmp_path / f"box.{suffix}"
        box.export(file)
        thing = read_object(next(iter(import_file(file, tmp_path / suffix))).parent)
        np.testing.assert_allclose(thing.size_m, (0.3, 0.2, 0.5), atol=1e-3)
        assert thing.name == "box_2", "a kind of the package has that name"
    assert thing.blocked == ()


def test_a_catalogue_gives_sizes_and_names(tmp_path):
    obj = trimesh.creation.box((1, 1, 1)).export(file_type="obj")
    catalogue = "id=x\nname#1=Blue Crate\nmodel#1=/m/a.obj\nwidth#1=30\ndepth#1=25\nheight#1=40\n"
    catalogue += "name#2=Endless\nmodel#2=/m/a.obj\nwidth#2=inf\ndepth#2=25\nheight#2=40\n"
    catalogue += "name#3=Gone\nmodel#3=/m/b.obj\nwidth#3=30\ndepth#3=25\nheight#3=40\n"
    catalogue += "name#4=Huge\nmodel#4=/m/a.obj\nwidth#4=300\ndepth#4=25\nheight#4=40\n"
    file = tmp_path / "c.sh3f"
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("PluginFurnitureCatalog.properties", catalogue)
        archive.writestr("m/a.obj", obj)
    refused: list[str] = []
    paths = list(import_file(file, tmp_path / "out", on_refused=refused.append))
    assert [p.parent.name for p in paths] == ["blue_crate"]
    assert len(refused) == 3
    assert "cannot be held" in refused[2]
    assert "size" in refused[0]
    assert "'m/b.obj' is not an OBJ file in it" in refused[1]
    np.testing.assert_allclose(read_object(paths[0].parent).size_m, (0.25, 0.30, 0.40), atol=1e-4)


def test_files_of_one_name_do_not_overwrite_each_other(tmp_path):
    taken: set[str] = set()
    for suffix in ("glb", "obj", "stl"):
        file = tmp_path / f"thing.{suffix}"
        trimesh.creation.box((0.2, 0.3, 0.3)).export(file)
        list(import_file(file, tmp_path / "out", taken=taken))
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == ["thing", "thing_2", "thing_3"]


def _damaged_zip():
    """A catalogue whose compressed data are spoilt."""
    raw = bytearray(_packed("PluginFurnitureCatalog.properties", b"id=x\n" * 400))
    raw[70:90] = b"\xff" * 20
    return bytes(raw)


def _encrypted_zip():
    """A catalogue that says of itself that it is encrypted."""
    raw = bytearray(_packed("PluginFurnitureCatalog.properties", b"id=x\n"))
    raw[6] |= 1
    raw[raw.index(b"PK\x01\x02") + 8] |= 1
    return bytes(raw)


def _packed(name, content):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(name, content)
    return buffer.getvalue()


def _stl_header(faces):
    return b"\0" * 80 + faces.to_bytes(4, "little") + b"\0" * 100


def _zip(**entries):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, content in entries.items():
            archive.writestr(name.replace("__", "/").replace("DOTS", ".."), content)
    return buffer.getvalue()


def _glb(edit):
    """A box as a GLB file whose table of contents `edit` has changed."""
    raw = trimesh.creation.box((0.2, 0.3, 0.3)).export(file_type="glb")
    length = int.from_bytes(raw[12:16], "little")
    contents = json.loads(raw[20 : 20 + length])
    edit(contents)
    text = json.dumps(contents).encode()
    text += b" " * (-len(text) % 4)
    body = len(text).to_bytes(4, "little") + b"JSON" + text + raw[20 + length :]
    return b"glTF" + (2).to_bytes(4, "little") + (12 + len(body)).to_bytes(4, "little") + body


def _primitive(contents):
    return contents["meshes"][0]["primitives"][0]


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.stl", _stl_header(10_000_000), f"10000000 faces; valid: at most {MAX_FACES}"),
        ("a.stl", b"solid nothing\nendsolid nothing\n", "holds no face|not a readable"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 nan 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n", "not finite"),
        ("a.obj", b"mtllib ../../etc/passwd\nv 0 0 0\n", "leaves its folder"),
        ("a.obj", b"mtllib /etc/passwd\nv 0 0 0\n", "leaves its folder"),
        ("a.obj", b"", "holds no face|not a readable"),
        ("a.glb", b"glTF junk", "not a readable glb"),
        (
            "a.glb",
            _glb(lambda d: d["buffers"][0].update(uri="other.bin")),
            r"buffers\[0\].uri: 'other.bin' is another file",
        ),
        (
            "a.glb",
            _glb(lambda d: d.pop("accessors")),
            r"POSITION: \d is not there; valid: one of the file's 0 accessors",
        ),
        ("a.glb", _glb(lambda d: _primitive(d).update(indices=99)), r"primitives\[0\].indices: 99 is not there"),
        ("a.glb", _glb(lambda d: _primitive(d)["attributes"].clear()), "POSITION: missing"),
        ("a.glb", _glb(lambda d: d["bufferViews"].clear()), r"accessors\[0\].bufferView: 0 is not there"),
        ("a.glb", _glb(lambda d: d.update(images=[{"uri": "../../secret.png"}])), "leaves its folder"),
        ("a.ply", b"", "valid: .glb, .obj, .stl, .sh3f"),
        ("a.sh3f", b"junk", "not a readable catalogue"),
        ("a.sh3f", _zip(DOTS__evil="x"), "leaves its folder"),
        ("a.sh3f", _zip(x="x"), "not a readable catalogue"),
        ("a.sh3f", _damaged_zip(), "not a readable catalogue"),
        ("a.sh3f", _encrypted_zip(), "not a readable catalogue"),
        ("a.obj", b"v 0 0 0\nv .3 0 0\nv 0 .3 0\nf 1 2 3\n", "flat"),
        ("a.stl", trimesh.creation.box((3, 3, 3)).export(file_type="stl"), "cannot be held"),
    ],
)
def test_what_cannot_be_imported_is_refused_in_one_line(tmp_path, name, content, message):
    file = tmp_path / name
    file.write_bytes(content)
    with pytest.raises(ValueError, match=message) as caught:
        list(import_file(file, tmp_path / "out"))
    assert "\n" not in str(caught.value)
    assert not list((tmp_path / "out").rglob("*.json")) if (tmp_path / "out").exists() else True


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(ValueError, match="no such file"):
        list(import_file(tmp_path / "none.obj", tmp_path))


def test_a_coordinate_that_is_not_finite_is_refused_without_a_warning(tmp_path):
    raw = bytearray(trimesh.creation.box((0.2, 0.3, 0.3)).export(file_type="stl"))
    raw[96:100] = struct.pack("<f", float("inf"))
    file = tmp_path / "a.stl"
    file.write_bytes(bytes(raw))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(ValueError, match="a vertex is not finite"):
            list(import_file(file, tmp_path / "out"))


def test_an_untouched_glb_is_imported(tmp_path):
    file = tmp_path / "a.glb"
    file.write_bytes(_glb(lambda contents: None))
    [path] = import_file(file, tmp_path / "out")
    np.testing.assert_allclose(sorted(read_object(path.parent).size_m), (0.2, 0.3, 0.3), atol=1e-4)


PACK = Path(os.environ.get("HV_FURNITURE_PACK", "/usr/share/sweethome3d/furniture/BlendSwap-CC-0.sh3f"))


@pytest.mark.slow
@pytest.mark.skipif(not PACK.is_file(), reason=f"{PACK} is not here: Debian's sweethome3d-furniture, HV_FURNITURE_PACK")
def test_debians_furniture_pack(tmp_path):
    refused: list[str] = []
    paths = list(import_file(PACK, tmp_path, on_refused=refused.append))
    assert len(paths) > 15
    assert len(paths) + len(refused) >= 170, "every item is either taken or left out with a reason"
    assert all("\n" not in why for why in refused)
    for path in paths[::5]:
        thing = read_object(path.parent)
        assert all(s > 0 for s in thing.size_m)
        assert thing.boxes
        assert thing.meshes
