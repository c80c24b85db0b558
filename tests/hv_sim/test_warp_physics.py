"""Warp's physics on its CPU device against `mujoco.batch`: the same robots, rooms, sizes, masses, resets.

Tolerances are five to eight times what was measured: 0.13 mm and 0.5 mrad after a second on the very same models, where
only 32 bits make the difference, and 7 mm from the models as they are shipped. The same batch gives the same bits run
after run; in other company the last bit of a sum may differ (1e-6 m after a second).
"""

import numpy as np
import pytest
import torch
from warp_scenes import DEVICE, changed_room, living_room, starts, targets

from hv_sim.mujoco_physics import MujocoPhysics
from hv_sim.physics import PhysicsState
from hv_sim.scene import compile_scene
from hv_sim.task import load_task
from hv_sim.warp_physics import WarpPhysics, warp_model

SECOND = 30
FIELDS = tuple(PhysicsState.__dataclass_fields__)
SAME_MODEL = {
    "link_pos_w": 1e-3, "link_rot_w": 3e-3, "joint_pos": 3e-3, "object_pos_w": 1e-4, "object_rot_w": 1e-4,
    "link_lin_vel_w": 1e-2, "joint_vel": 2e-2, "object_lin_vel_w": 1e-3, "body_contact_height_m": 1e-5,
}  # fmt: skip
"""Metres, radians, and those per second."""
APART_M = 0.04
"""How far robots may be from those of the shipped models after a second."""
COMPANY = 1e-4


def rollout(physics, steps: int = SECOND, ids=None, first: int = 0) -> PhysicsState:
    for target in targets(physics.num_envs, first + steps)[first:]:
        physics.step(target, ids)
    return physics.state()


def begun(models, qpos=None) -> WarpPhysics:
    physics = WarpPhysics(models, device=DEVICE)
    physics.reset(range(len(models)), qpos or starts(len(models)))
    return physics


@pytest.fixture(scope="module")
def models():
    return [living_room().model, changed_room(), living_room().model]


@pytest.fixture(scope="module")
def second(models) -> PhysicsState:
    """Three worlds of one batch after a second."""
    return rollout(begun(models))


def test_scenes_that_differ_in_sizes_and_masses_share_a_batch(models):
    other = compile_scene(load_task("living_room_2")).model
    physics = WarpPhysics([models[0], other, models[1]], device=DEVICE)
    assert [group.ids.tolist() for group in physics.groups] == [[0, 2], [1]]
    group = physics.groups[0]
    for row, model in enumerate((models[0], models[1])):
        np.testing.assert_allclose(group.model.body_mass.numpy()[row], model.body_mass, rtol=1e-6)
        np.testing.assert_allclose(group.model.geom_size.numpy()[row], model.geom_size, rtol=1e-6)
    assert group.model.dof_armature.shape[0] == 1, "what is the same is kept once"
    assert (physics.num_envs, physics.num_objects) == (3, 2)


def test_errors_name_what_is_wrong():
    with pytest.raises(ValueError, match="models: empty; at least one"):
        WarpPhysics([])


@pytest.mark.slow
def test_a_second_is_that_of_mujoco_batch(models, second):
    """With sizes and masses of its own in one of the worlds."""
    reference = MujocoPhysics([warp_model(m) for m in models], num_threads=1)
    reference.reset(range(3), starts(3))
    start = reference.state()
    expected = rollout(reference)
    for name, tolerance in SAME_MODEL.items():
        torch.testing.assert_close(getattr(second, name), getattr(expected, name), atol=tolerance, rtol=0, msg=name)
    assert torch.equal(second.body_contact, expected.body_contact)
    moved = (expected.link_pos_w - start.link_pos_w).norm(dim=-1).max()
    apart = (second.link_pos_w[0] - second.link_pos_w[1]).norm(dim=-1).max()
    assert moved > 0.05, "something happened"
    assert apart > 0.02, "sizes and masses matter"


@pytest.mark.slow
def test_a_second_is_near_that_of_the_shipped_models(models, second):
    reference = MujocoPhysics(models, num_threads=1)
    reference.reset(range(3), starts(3))
    expected = rollout(reference)
    assert (second.link_pos_w - expected.link_pos_w).norm(dim=-1).max() < APART_M
    assert (second.object_pos_w - expected.object_pos_w).norm(dim=-1).max() < 1e-3
    assert torch.equal(second.body_contact, expected.body_contact)


def assert_equal(state: PhysicsState, expected: PhysicsState, rows: list[int]) -> None:
    for name in FIELDS:
        assert torch.equal(getattr(state, name)[rows], getattr(expected, name)[rows]), name


@pytest.mark.slow
def test_run_after_run_is_the_same(models, second):
    assert_equal(rollout(begun(models)), second, [0, 1, 2])


@pytest.mark.slow
def test_company_makes_no_difference_but_rounding(models, second):
    physics = begun([models[1]], [starts(3)[1]])
    for target in targets(3, SECOND):
        physics.step(target[1:2])
    for name in SAME_MODEL:
        alone, together = getattr(physics.state(), name)[0], getattr(second, name)[1]
        torch.testing.assert_close(alone, together, atol=COMPANY, rtol=0, msg=name)


@pytest.mark.slow
def test_a_reset_forgets_what_was_and_leaves_the_others_running(models, second):
    physics = begun(models)
    before = rollout(physics, 10)
    physics.reset([1], [starts(3)[1]])
    after = physics.state()
    assert not after.joint_vel[1].any()
    assert_equal(after, before, [0, 2])
    for target in targets(3, SECOND)[10:]:
        physics.step(target)
    assert_equal(physics.state(), second, [0, 2])
    physics.reset([1], [starts(3)[1]])
    assert_equal(rollout(physics), second, [1])


@pytest.mark.slow
def test_stepping_some_leaves_the_others_untouched(models, second):
    physics = begun(models)
    before = rollout(physics, 12)
    paused = rollout(physics, 8, ids=[2, 0], first=12)
    assert_equal(paused, before, [1])
    assert_equal(rollout(physics, 10, ids=[0, 2], first=20), second, [0, 2])
    assert_equal(rollout(physics, SECOND - 12, ids=[1], first=12), second, [1])


@pytest.mark.slow
def test_data_is_the_state_in_mujocos_own_form(models):
    physics = begun(models)
    state = rollout(physics, 2)
    for env in range(3):
        data = physics.data(env)
        np.testing.assert_allclose(data.xpos[1:16], state.link_pos_w[env], atol=1e-5)
        assert data.time == pytest.approx(2 / 30, abs=1e-5)
        assert physics.model(env) is models[env]
