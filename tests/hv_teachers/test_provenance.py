"""Hashes of code and physics: they change with what decides an episode, and with nothing else."""

import subprocess
import sys

from hv_sim.suites import load_suite
from hv_teachers import provenance

PACKAGE = {
    "hv_sim/__init__.py": "",
    "hv_sim/a.py": '"""Doc."""\nfrom hv_sim import b\n\ndef f():\n    """Doc."""\n    return b.x\n',
    "hv_sim/b.py": "x = 1  # one\n",
    "hv_sim/c.py": "x = 1\n",
}


def hash_of(folder, **changes):
    for name, text in (PACKAGE | {k.replace("__", "/") + ".py": v for k, v in changes.items()}).items():
        (folder / name).parent.mkdir(exist_ok=True, parents=True)
        (folder / name).write_text(text)
    program = (
        "import importlib.util, sys; sys.path.insert(0, sys.argv[2])\n"
        "spec = importlib.util.spec_from_file_location('provenance', sys.argv[1])\n"
        "import types; sys.modules['hv_sim.task'] = sys.modules['hv_sim.world'] = types.ModuleType('stub')\n"
        "sys.modules['stub'] = sys.modules['hv_sim.task']\n"
        "sys.modules['hv_sim.task'].Task = sys.modules['hv_sim.world'].RearrangeWorld = object\n"
        "module = importlib.util.module_from_spec(spec); spec.loader.exec_module(module)\n"
        "print(module.code_hash(('hv_sim.a',)))"
    )
    arguments = [sys.executable, "-c", program, provenance.__file__, str(folder)]
    return subprocess.run(arguments, capture_output=True, text=True, check=True).stdout.strip()


def test_code_counts_and_comments_do_not(tmp_path):
    before = hash_of(tmp_path)
    assert hash_of(tmp_path, hv_sim__b="x = 1  # another remark\n") == before
    assert hash_of(tmp_path, hv_sim__a=PACKAGE["hv_sim/a.py"].replace("Doc", "Other")) == before
    assert hash_of(tmp_path, hv_sim__c="x = 2\n") == before, "nothing imports it"
    assert hash_of(tmp_path, hv_sim__b="x = 2\n") != before


def test_what_plays_episodes_is_counted(monkeypatch):
    seen = set()
    real = provenance._file_of
    monkeypatch.setattr(provenance, "_file_of", lambda name: (seen.add(name), real(name))[1])
    provenance.code_hash.__wrapped__()
    for name in ("hv_sim.world", "hv_policy.motor.gait", "hv_policy.belief.student", "hv_teachers.planner"):
        assert name in seen
    assert "hv_teachers.motor_env" not in seen


def test_physics_of_another_scene_is_another():
    first, second = (provenance.physics(task) for task in load_suite("unseen")[:2])
    assert first == provenance.physics(load_suite("unseen")[0])
    assert first["physics_hz"] == second["physics_hz"] == 120
    assert first["physics_hash"] != second["physics_hash"]
