"""Each observation against plain MuJoCo: mj_forward and mj_objectVelocity on random states, in obvious loops."""

import math

import mujoco
import numpy as np
import pytest
import torch

from hv_sim.humanoid import BODY_NAMES, add_humanoid, configure_physics
from hv_sim.mujoco_physics import MujocoPhysics
from hv_sim.observations import (
    PROPRIOCEPTION_DIM,
    PROPRIOCEPTION_SLICES,
    Heading,
    goal_observation,
    object_observation,
    proprioception,
    rotation_6d,
    waypoint_observation,
)

NUM_OBJECTS = 2
NUM_STATES = 6


def two_object_model() -> mujoco.MjModel:
    spec = mujoco.MjSpec()
    add_humanoid(spec)
    for k in range(NUM_OBJECTS):
        body = spec.worldbody.add_body(name=f"object_{k}", pos=[2.0 + k, 0, 1])
        body.add_freejoint()
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.1, 0.2, 0.15], mass=1.0)
    configure_physics(spec)
    return spec.compile()


def random_rotation(rng: np.random.Generator) -> np.ndarray:
    quat = rng.normal(size=4)
    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, quat / np.linalg.norm(quat))
    return matrix.reshape(3, 3)


class PlainMujoco:
    """One state in plain MuJoCo, with the heading frame worked out from the root's yaw."""

    def __init__(self, model: mujoco.MjModel, qpos: np.ndarray, qvel: np.ndarray) -> None:
        self.model, self.data = model, mujoco.MjData(model)
        self.data.qpos[:], self.data.qvel[:] = qpos, qvel
        mujoco.mj_forward(model, self.data)
        root = self.rotation("pelvis")
        yaw = math.atan2(root[1, 0], root[0, 0])
        self.world_from_heading = np.array(
            [[math.cos(yaw), -math.sin(yaw), 0], [math.sin(yaw), math.cos(yaw), 0], [0, 0, 1]]
        )

    def position(self, body: str) -> np.ndarray:
        return self.data.body(body).xpos.copy()

    def rotation(self, body: str) -> np.ndarray:
        return self.data.body(body).xmat.reshape(3, 3).copy()

    def velocity(self, body: str) -> tuple[np.ndarray, np.ndarray]:
        """Linear and angular velocity of the body frame's origin, world axes."""
        spatial = np.zeros(6)
        body_id = self.model.body(body).id
        mujoco.mj_objectVelocity(self.model, self.data, mujoco.mjtObj.mjOBJ_XBODY, body_id, spatial, 0)
        return spatial[3:], spatial[:3]

    def in_heading(self, vector: np.ndarray) -> np.ndarray:
        return self.world_from_heading.T @ vector

    def relative(self, point: np.ndarray) -> np.ndarray:
        return self.in_heading(point - self.position("pelvis"))

    def six(self, rotation: np.ndarray) -> np.ndarray:
        local = self.world_from_heading.T @ rotation
        return np.concatenate([local[:, 0], local[:, 1]])


@pytest.fixture(scope="module")
def states():
    """Random states as the batched backend and as plain MuJoCo see them."""
    rng = np.random.default_rng(3)
    model = two_object_model()
    qpos, qvel = [], []
    for _ in range(NUM_STATES):
        q, v = np.zeros(model.nq), rng.normal(size=model.nv)
        q[:3] = np.array([0, 0, 1.5]) + rng.normal(size=3)
        q[7:35] = rng.uniform(model.jnt_range[1:29, 0], model.jnt_range[1:29, 1])
        for start in (3, 38, 45):
            q[start : start + 4] = rng.normal(size=4)
            q[start : start + 4] /= np.linalg.norm(q[start : start + 4])
        q[35:38], q[42:45] = np.array([3, 0, 1]) + rng.normal(size=3), np.array([-3, 0, 1]) + rng.normal(size=3)
        qpos.append(q)
        qvel.append(v)
    physics = MujocoPhysics([model] * NUM_STATES, num_threads=1)
    physics.reset(range(NUM_STATES), qpos, qvel)
    return physics.state(), [PlainMujoco(model, q, v) for q, v in zip(qpos, qvel, strict=True)]


def assert_close(actual: torch.Tensor, expected: list[np.ndarray]) -> None:
    np.testing.assert_allclose(actual.numpy(), np.array(expected), atol=2e-5, rtol=1e-5)


def test_proprioception_has_223_numbers_in_the_declared_groups(states):
    state, _ = states
    assert proprioception(state).shape == (NUM_STATES, 223)
    assert PROPRIOCEPTION_DIM == 223
    sizes = {name: part.stop - part.start for name, part in PROPRIOCEPTION_SLICES.items()}
    assert sizes == {
        "root_height": 1,
        "link_positions": 42,
        "link_rotations": 90,
        "link_linear_velocities": 45,
        "link_angular_velocities": 45,
    }


def test_root_height(states):
    state, plain = states
    part = proprioception(state)[:, PROPRIOCEPTION_SLICES["root_height"]]
    assert_close(part, [p.position("pelvis")[2:] for p in plain])


def test_link_positions(states):
    state, plain = states
    part = proprioception(state)[:, PROPRIOCEPTION_SLICES["link_positions"]]
    assert_close(part, [np.concatenate([p.relative(p.position(b)) for b in BODY_NAMES[1:]]) for p in plain])


def test_link_rotations(states):
    state, plain = states
    part = proprioception(state)[:, PROPRIOCEPTION_SLICES["link_rotations"]]
    assert_close(part, [np.concatenate([p.six(p.rotation(b)) for b in BODY_NAMES]) for p in plain])


def test_link_linear_velocities(states):
    state, plain = states
    part = proprioception(state)[:, PROPRIOCEPTION_SLICES["link_linear_velocities"]]
    assert_close(part, [np.concatenate([p.in_heading(p.velocity(b)[0]) for b in BODY_NAMES]) for p in plain])


def test_link_angular_velocities(states):
    state, plain = states
    part = proprioception(state)[:, PROPRIOCEPTION_SLICES["link_angular_velocities"]]
    assert_close(part, [np.concatenate([p.in_heading(p.velocity(b)[1]) for b in BODY_NAMES]) for p in plain])


def test_object(states):
    state, plain = states
    index = torch.tensor([i % NUM_OBJECTS for i in range(NUM_STATES)])
    expected = []
    for p, k in zip(plain, index.tolist(), strict=True):
        body = f"object_{k}"
        linear, angular = p.velocity(body)
        expected.append(
            np.concatenate(
                [p.relative(p.position(body)), p.six(p.rotation(body)), p.in_heading(linear), p.in_heading(angular)]
            )
        )
    assert_close(object_observation(state, index), expected)


def test_goal_and_waypoint(states):
    state, plain = states
    rng = np.random.default_rng(5)
    positions = rng.normal(size=(NUM_STATES, 3))
    rotations = np.stack([random_rotation(rng) for _ in range(NUM_STATES)])
    heading = Heading.of(state)
    goal = goal_observation(torch.tensor(positions).float(), torch.tensor(rotations).float(), heading)
    assert_close(
        goal,
        [np.concatenate([p.relative(x), p.six(r)]) for p, x, r in zip(plain, positions, rotations, strict=True)],
    )
    waypoint = waypoint_observation(torch.tensor(positions).float(), heading)
    assert_close(waypoint, [p.relative(x) for p, x in zip(plain, positions, strict=True)])


def test_observations_do_not_change_when_the_scene_is_moved_and_turned(states):
    """Walking the whole world elsewhere leaves all but the world frame alone."""
    state, _ = states
    yaw = 1.1
    turn = torch.tensor([[math.cos(yaw), -math.sin(yaw), 0], [math.sin(yaw), math.cos(yaw), 0], [0, 0, 1]])
    shift = torch.tensor([3.0, -2.0, 0.0])
    moved = type(state)(
        **{
            **vars(state),
            "link_pos_w": state.link_pos_w @ turn.T + shift,
            "link_rot_w": turn @ state.link_rot_w,
            "link_lin_vel_w": state.link_lin_vel_w @ turn.T,
            "link_ang_vel_w": state.link_ang_vel_w @ turn.T,
        }
    )
    torch.testing.assert_close(proprioception(moved), proprioception(state), atol=3e-5, rtol=1e-4)


def test_a_root_that_points_straight_up_has_a_heading(states):
    state, _ = states
    up = torch.tensor([[0.0, 0, -1], [0, 1, 0], [1, 0, 0]]).expand(NUM_STATES, 15, 3, 3)
    heading = Heading.of(type(state)(**{**vars(state), "link_rot_w": up}))
    assert heading.cos.tolist() == [1.0] * NUM_STATES
    assert heading.sin.tolist() == [0.0] * NUM_STATES


def test_rotation_6d_is_the_x_axis_then_the_y_axis():
    rotation = torch.arange(9.0).view(3, 3)
    assert rotation_6d(rotation).tolist() == [0, 3, 6, 1, 4, 7]


def test_a_batch_of_one_gives_the_same_bits_as_the_batch(states):
    state, _ = states
    whole = proprioception(state)
    for i in range(NUM_STATES):
        alone = type(state)(**{name: value[i : i + 1] for name, value in vars(state).items()})
        assert torch.equal(proprioception(alone)[0], whole[i])
