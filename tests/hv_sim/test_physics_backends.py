"""The engines by name."""

import sys

import pytest
from plain_ground import ground_model

from hv_sim.mujoco_physics import MujocoPhysics
from hv_sim.physics_backends import make_physics, make_renderer
from hv_sim.rendering import CameraRenderer
from hv_sim.task import load_task
from hv_sim.world import RearrangeWorld


def test_cpu_is_mujoco_batch_and_opengl():
    assert isinstance(make_physics("cpu", [ground_model()], num_threads=1), MujocoPhysics)
    assert isinstance(make_renderer("cpu", 8, 8), CameraRenderer)


def test_an_unknown_engine_is_refused_with_those_there_are():
    for make in (lambda: make_physics("abacus", [ground_model()]), lambda: make_renderer("abacus")):
        with pytest.raises(ValueError, match=r"physics: 'abacus' is not valid; valid: cpu, warp"):
            make()
    with pytest.raises(ValueError, match=r"physics: 'abacus' is not valid; valid: cpu, warp"):
        RearrangeWorld([load_task("living_room_1")], physics="abacus")


def test_without_warp_it_is_said_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco_warp", None)
    with pytest.raises(ValueError, match=r"'warp' is not installed here .*pip install 'lerobot_policy_hv\[gpu\]'"):
        make_physics("warp", [ground_model()])
