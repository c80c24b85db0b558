"""The batched physics against a plain loop of `mj_step`, and its independence of the batch's company."""

import mujoco
import numpy as np
import pytest
import torch
from plain_ground import ground_model, random_state

from hv_sim.humanoid import BODY_NAMES, KP, NUM_BODIES, standing_qpos
from hv_sim.mujoco_physics import MujocoPhysics
from hv_sim.physics import PhysicsState

SUBSTEPS = 4
FIELDS = tuple(PhysicsState.__dataclass_fields__)


@pytest.fixture(scope="module")
def models() -> list[mujoco.MjModel]:
    """Three layouts: no box, one box, two boxes (one of them between the robot's hands' reach and the floor)."""
    return [ground_model(k, box_xy_m=(0.35, -0.2)) for k in range(3)]


def standing_start(model: mujoco.MjModel, seed: int) -> np.ndarray:
    qpos = model.qpos0.copy()
    rng = np.random.default_rng(seed)
    qpos[:35] = standing_qpos(rng.uniform(-0.2, 0.2, 2), rng.uniform(-0.5, 0.5))
    return qpos


def random_targets(start: np.ndarray, steps: int, seed: int) -> torch.Tensor:
    noise = torch.randn(steps, 28, generator=torch.Generator().manual_seed(seed))
    return torch.tensor(start[7:35], dtype=torch.float32) + 0.4 * noise


def plain_rollout(model, qpos, targets, qvel=None) -> mujoco.MjData:
    """The obvious loop, its velocity stage brought up to date at the end."""
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    if qvel is not None:
        data.qvel[:] = qvel
    for target in targets:
        data.ctrl[:] = target.double().numpy()
        for _ in range(SUBSTEPS):
            mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    return data


def batched_rollout(models, starts, targets, ids=None, **settings) -> MujocoPhysics:
    """`targets` (N, T, 28)."""
    physics = MujocoPhysics(models, **settings)
    physics.reset(range(len(models)), starts)
    for t in range(targets.shape[1]):
        physics.step(targets[:, t], ids)
    return physics


def test_twenty_control_steps_equal_plain_mj_step_bit_for_bit(models):
    starts = [standing_start(m, i) for i, m in enumerate(models)]
    targets = torch.stack([random_targets(s, 20, i) for i, s in enumerate(starts)])
    physics = batched_rollout(models, starts, targets, num_threads=1)
    contacts = []
    for env, model in enumerate(models):
        expected = plain_rollout(model, starts[env], targets[env])
        data = physics.data(env)
        np.testing.assert_array_equal(data.qpos, expected.qpos)
        np.testing.assert_array_equal(data.qvel, expected.qvel)
        contacts.append(expected.ncon)
    assert max(contacts) > 0


@pytest.mark.parametrize("hz", [120, 240])
def test_a_control_step_lasts_a_thirtieth_of_a_second(hz):
    model = ground_model(physics_hz=hz)
    physics = batched_rollout([model], [standing_start(model, 0)], torch.zeros(1, 6, 28), num_threads=1)
    assert physics.data(0).time == pytest.approx(0.2)


def assert_state_is_plain_mujocos(state: PhysicsState, env: int, model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """`data` must be forwarded."""
    objects = model.nbody - 1 - NUM_BODIES
    names = [(b, "link") for b in range(1, 16)] + [(16 + k, "object") for k in range(objects)]
    for body, kind in names:
        row = body - 1 if kind == "link" else body - 16
        spatial = np.zeros(6)
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, body, spatial, 0)
        expected = {
            "pos_w": data.xpos[body],
            "rot_w": data.xmat[body].reshape(3, 3),
            "lin_vel_w": spatial[3:],
            "ang_vel_w": spatial[:3],
        }
        for name, value in expected.items():
            found = getattr(state, f"{kind}_{name}")[env, row]
            np.testing.assert_allclose(found, value, atol=3e-6, rtol=1e-5, err_msg=f"{kind} {row} {name}")
    np.testing.assert_allclose(state.joint_pos[env], data.qpos[7:35], atol=1e-6)
    np.testing.assert_allclose(state.joint_vel[env], data.qvel[6:34], atol=1e-5)
    for b in range(NUM_BODIES):
        deepest = min(
            (c for c in data.contact if {int(model.geom_bodyid[g]) for g in (c.geom1, c.geom2)} == {0, b + 1}),
            key=lambda c: c.dist,
            default=None,
        )
        assert bool(state.body_contact[env, b]) == (deepest is not None), BODY_NAMES[b]
        height = 0.0 if deepest is None else deepest.pos[2]
        assert float(state.body_contact_height_m[env, b]) == pytest.approx(height, abs=1e-6)


def test_the_state_after_steps_is_plain_mujocos(models):
    """Not only positions: velocities and contacts belong to the same instant."""
    starts = [standing_start(m, i) for i, m in enumerate(models)]
    targets = torch.stack([random_targets(s, 12, i) for i, s in enumerate(starts)])
    physics = batched_rollout(models, starts, targets, num_threads=1)
    state = physics.state()
    assert state.object_pos_w.shape == (3, 2, 3)
    for env, model in enumerate(models):
        assert_state_is_plain_mujocos(state, env, model, plain_rollout(model, starts[env], targets[env]))


def test_the_state_after_a_reset_is_plain_mujocos(models):
    physics = MujocoPhysics(models, num_threads=1)
    rng = np.random.default_rng(0)
    poses = [random_state(m, rng, tilt_rad=3.0) for m in models]
    for qpos, qvel in poses:
        qpos[2] -= 1.1  # some bodies reach into the floor
        qvel[34:] = rng.normal(size=len(qvel) - 34)
    physics.reset([2, 0, 1], [poses[i][0] for i in (2, 0, 1)], [poses[i][1] for i in (2, 0, 1)])
    state = physics.state()
    for env, model in enumerate(models):
        data = mujoco.MjData(model)
        data.qpos[:], data.qvel[:] = poses[env]
        mujoco.mj_forward(model, data)
        assert_state_is_plain_mujocos(state, env, model, data)


def test_absent_objects_are_zero(models):
    physics = MujocoPhysics(models, num_threads=1)
    physics.reset(range(3), [standing_start(m, 0) for m in models])
    state = physics.state()
    assert physics.num_objects == 2
    for name in ("object_pos_w", "object_rot_w", "object_lin_vel_w", "object_ang_vel_w"):
        value = getattr(state, name)
        assert not value[0].any()
        assert not value[1, 1].any()
    assert state.object_rot_w[2, 1].any()
    for name in FIELDS:
        assert getattr(state, name).dtype == (torch.bool if name == "body_contact" else torch.float32), name


def test_results_do_not_depend_on_the_company(models):
    company = [models[i] for i in (1, 0, 2, 1, 0)]
    starts = [standing_start(m, i) for i, m in enumerate(company)]
    targets = torch.stack([random_targets(s, 10, i) for i, s in enumerate(starts)])
    together = batched_rollout(company, starts, targets, num_threads=2).state()
    for env in range(len(company)):
        physics = batched_rollout([company[env]], [starts[env]], targets[env : env + 1], num_threads=1)
        alone, objects = physics.state(), physics.num_objects
        for name in FIELDS:
            row = getattr(together, name)[env]
            row = row[:objects] if name.startswith("object") else row
            assert torch.equal(row, getattr(alone, name)[0]), name


def test_models_of_one_layout_keep_their_own_masses(models):
    heavy = ground_model(1, box_xy_m=(0.35, -0.2))
    heavy.body_mass[1] *= 2.0
    pair = [models[1], heavy]
    starts = [standing_start(m, 0) for m in pair]
    targets = torch.stack([random_targets(starts[0], 10, 0)] * 2)
    physics = batched_rollout(pair, starts, targets, num_threads=1)
    for env, model in enumerate(pair):
        assert physics.model(env).body_mass[1] == model.body_mass[1]
        np.testing.assert_array_equal(physics.data(env).qpos, plain_rollout(model, starts[env], targets[env]).qpos)
    assert not np.array_equal(physics.data(0).qpos, physics.data(1).qpos)


def test_stepping_some_leaves_the_others_untouched(models):
    company = [models[i] for i in (0, 1, 2, 0)]
    starts = [standing_start(m, i) for i, m in enumerate(company)]
    targets = torch.stack([random_targets(s, 6, i) for i, s in enumerate(starts)])
    physics = batched_rollout(company, starts, targets[:, :3], num_threads=1)
    before = physics.state()
    for t in range(3, 6):
        physics.step(targets[:, t], [3, 1])
    after = physics.state()
    for env in (0, 2):
        for name in FIELDS:
            assert torch.equal(getattr(before, name)[env], getattr(after, name)[env]), name
    for env, steps in ((0, 3), (1, 6), (2, 3), (3, 6)):
        expected = plain_rollout(company[env], starts[env], targets[env, :steps])
        np.testing.assert_array_equal(physics.data(env).qpos, expected.qpos)
    physics.step(targets[:, 0], [])
    assert torch.equal(physics.state().link_pos_w, after.link_pos_w)


def test_an_environment_that_paused_goes_on_as_if_it_had_not(models):
    start = standing_start(models[1], 0)
    targets = random_targets(start, 6, 0)
    physics = MujocoPhysics([models[1], models[1]], num_threads=1)
    physics.reset([0, 1], [start, start])
    for t in range(6):
        physics.step(torch.stack([targets[t], targets[t]]), [0])
    for t in range(6):
        physics.step(torch.stack([targets[t], targets[t]]), [1])
    np.testing.assert_array_equal(physics.data(0).qpos, physics.data(1).qpos)


def test_a_reset_forgets_what_was_before(models):
    start = standing_start(models[1], 0)
    targets = random_targets(start, 8, 0)[None]
    physics = batched_rollout([models[1]], [start], targets, num_threads=1)
    physics.reset([0], [start])
    assert torch.equal(physics.state().joint_vel, torch.zeros(1, 28))
    assert not physics.state().object_lin_vel_w.any()
    for t in range(8):
        physics.step(targets[:, t])
    np.testing.assert_array_equal(physics.data(0).qpos, plain_rollout(models[1], start, targets[0]).qpos)


def test_a_reset_of_one_leaves_the_others_running(models):
    starts = [standing_start(models[1], i) for i in range(2)]
    targets = torch.stack([random_targets(s, 8, i) for i, s in enumerate(starts)])
    physics = batched_rollout([models[1]] * 2, starts, targets[:, :4], num_threads=1)
    physics.reset(np.array([1]), [starts[1]])
    for t in range(4, 8):
        physics.step(targets[:, t])
    np.testing.assert_array_equal(physics.data(0).qpos, plain_rollout(models[1], starts[0], targets[0]).qpos)
    np.testing.assert_array_equal(physics.data(1).qpos, plain_rollout(models[1], starts[1], targets[1, 4:]).qpos)


def test_a_push_is_the_same_change_of_velocity_in_plain_mujoco(models):
    starts = [standing_start(m, i) for i, m in enumerate(models)]
    targets = torch.stack([random_targets(s, 8, i) for i, s in enumerate(starts)])
    physics = batched_rollout(models, starts, targets[:, :4], num_threads=1)
    push = np.array([[0.4, -0.3, 0.0], [0.0, 0.5, 0.1]])
    physics.push([2, 0], push)
    for t in range(4, 8):
        physics.step(targets[:, t])
    for env, velocity in ((2, push[0]), (0, push[1]), (1, np.zeros(3))):
        expected = mujoco.MjData(models[env])
        expected.qpos[:] = starts[env]
        for t in range(8):
            if t == 4:
                expected.qvel[:3] += velocity
            expected.ctrl[:] = targets[env, t].double().numpy()
            for _ in range(SUBSTEPS):
                mujoco.mj_step(models[env], expected)
        np.testing.assert_allclose(physics.data(env).qpos, expected.qpos, atol=1e-9, err_msg=f"environment {env}")


def test_joint_targets_are_servo_targets(models):
    """The torque on a joint that is off its target by e begins as kp e."""
    start = standing_start(models[0], 0)
    start[2] += 1.0
    physics = MujocoPhysics([models[0]], num_threads=1)
    physics.reset([0], [start])
    target = torch.tensor(start[None, 7:35], dtype=torch.float32)
    target[0, 5] += 0.1
    physics.step(target)
    data = physics.data(0)
    mujoco.mj_forward(models[0], data)
    expected = KP[5] * (float(target[0, 5]) - data.qpos[12]) - 0.1 * KP[5] * data.qvel[11]
    assert data.actuator_force[5] == pytest.approx(expected, abs=1e-9)
    assert data.qpos[12] > start[12] + 0.001


def test_data_can_be_rendered(models):
    """Kinematics and the head camera are those of the present state; an MjData that is handed in is used again."""
    starts = [standing_start(m, i) for i, m in enumerate(models)]
    targets = torch.stack([random_targets(s, 5, i) for i, s in enumerate(starts)])
    physics = batched_rollout(models, starts, targets, num_threads=1)
    expected = plain_rollout(models[2], starts[2], targets[2])
    scratch = mujoco.MjData(models[2])
    data = physics.data(2, scratch)
    assert data is scratch
    np.testing.assert_allclose(data.geom_xpos, expected.geom_xpos, atol=1e-12)
    np.testing.assert_allclose(data.camera("head").xpos, expected.camera("head").xpos, atol=1e-12)
    assert physics.model(2) is models[2]


def test_errors_name_what_is_wrong(models):
    with pytest.raises(ValueError, match="models: empty; at least one"):
        MujocoPhysics([])
    stranger = "<mujoco><worldbody><body><freejoint/><geom size='1'/></body></worldbody></mujoco>"
    other = mujoco.MjModel.from_xml_string(stranger)
    with pytest.raises(ValueError, match=r"models\[1\]: does not begin with the humanoid's bodies pelvis..left_foot"):
        MujocoPhysics([models[0], other])
    odd = ground_model()
    odd.opt.timestep = 0.007
    with pytest.raises(ValueError, match=r"models\[0\].opt.timestep: 0.007 does not divide 1/30 s"):
        MujocoPhysics([odd])
    with pytest.raises(ValueError, match=r"models: physics rates differ within one batch: \[4, 8\]"):
        MujocoPhysics([models[0], ground_model(physics_hz=240)])
