"""A sealed folder is whole until a bit of it changes."""

from hv_teachers.sealed_folders import SEAL_FILE, is_whole, seal


def test_whole_until_something_changes(tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "x").write_bytes(b"123")
    (tmp_path / "y").write_bytes(b"")
    assert not is_whole(tmp_path), "never sealed"
    seal(tmp_path)
    assert is_whole(tmp_path)
    (tmp_path / "later").write_bytes(b"more")
    assert is_whole(tmp_path), "what came later is not its business"
    (tmp_path / "a" / "x").write_bytes(b"124")
    assert not is_whole(tmp_path)
    (tmp_path / "a" / "x").write_bytes(b"123")
    assert is_whole(tmp_path)
    (tmp_path / "y").unlink()
    assert not is_whole(tmp_path)
    seal(tmp_path)
    (tmp_path / SEAL_FILE).write_text("{")
    assert not is_whole(tmp_path)
