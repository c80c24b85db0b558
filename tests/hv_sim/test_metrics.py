"""Metrics from hand-made records; falls against a loop over MuJoCo's contacts."""

import json
import math

import mujoco
import numpy as np
import pytest
import torch

from hv_sim.humanoid import BODY_NAMES, add_humanoid, configure_physics, standing_qpos
from hv_sim.metrics import EpisodeRecord, is_fallen, save_metrics, summarize
from hv_sim.mujoco_physics import MujocoPhysics


def record(*distances, fallen=False, finished=0):
    return EpisodeRecord("task", 0, tuple(distances), fallen, finished, 100)


def test_rates_and_distances():
    summary = summarize([record(0.1, 0.3), record(0.39, 0.5, fallen=True), record(0.6, 0.05), record(0.15, 0.1)])
    assert summary["n_episodes"] == 4
    assert summary["fall_rate"] == 0.25
    assert summary["dist_1"] == pytest.approx((0.1 + 0.39 + 0.6 + 0.15) / 4)
    assert summary["dist_2"] == pytest.approx((0.3 + 0.5 + 0.05 + 0.1) / 4)
    assert summary["at_0.4"] == {"success_1": 0.75, "success_2": 0.75, "success_all": 0.5}
    assert summary["at_0.2"] == {"success_1": 0.5, "success_2": 0.5, "success_all": 0.25}


def test_a_distance_at_the_threshold_is_no_success():
    assert summarize([record(0.4)])["at_0.4"]["success_1"] == 0.0


def test_tasks_of_different_length_average_over_those_that_have_the_subtask():
    summary = summarize([record(0.1), record(0.1, 0.9, 0.1), record(0.9, 0.1, 0.3)])
    assert summary["at_0.4"] == pytest.approx(
        {"success_1": 2 / 3, "success_2": 0.5, "success_3": 1.0, "success_all": 1 / 3}
    )
    assert summary["dist_3"] == pytest.approx(0.2)


def test_a_distance_that_is_not_finite_fails_and_stays_out_of_the_mean():
    summary = summarize([record(math.nan, 0.1), record(0.2, 0.1)])
    assert summary["at_0.4"]["success_1"] == 0.5
    assert summary["dist_1"] == 0.2


def test_no_episode_is_an_error():
    with pytest.raises(ValueError, match="records: empty"):
        summarize([])


def test_save_metrics_is_valid_json_and_leaves_nothing_else(tmp_path):
    path = tmp_path / "out" / "metrics.json"
    save_metrics(path, [record(0.1, math.inf)], seed=3)
    document = json.loads(path.read_text())
    assert document["at_0.4"]["success_1"] == 1.0
    assert document["seed"] == 3
    assert document["episodes"][0]["distances_m"] == [0.1, None]
    assert [p.name for p in path.parent.iterdir()] == ["metrics.json"]


def test_save_metrics_keeps_the_old_file_when_it_fails(tmp_path):
    path = tmp_path / "metrics.json"
    path.write_text("old")
    with pytest.raises(TypeError):
        save_metrics(path, [record(0.1)], extra=object())
    assert path.read_text() == "old"
    assert len(list(tmp_path.iterdir())) == 1


def falling_humanoids() -> tuple[MujocoPhysics, mujoco.MjModel]:
    """Four humanoids that fall in different ways: on the face, the back, the side, and one seated low."""
    spec = mujoco.MjSpec()
    add_humanoid(spec)
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[10, 10, 1], contype=2, conaffinity=3)
    configure_physics(spec)
    model = spec.compile()
    starts, velocities = [], []
    for push in ([2.0, 0, 0], [-2.0, 0, 0], [0, 2.0, 0], [0, 0, 0]):
        velocity = np.zeros(model.nv)
        velocity[:3] = push
        starts.append(standing_qpos((0.0, 0.0), 0.3))
        velocities.append(velocity)
    physics = MujocoPhysics([model] * 4, num_threads=1)
    physics.reset(range(4), starts, velocities)
    return physics, model


def plain_is_fallen(model: mujoco.MjModel, data: mujoco.MjData) -> bool:
    for contact in data.contact:
        bodies = [model.geom_bodyid[g] for g in contact.geom]
        if 0 not in bodies or contact.dist > 0:
            continue
        name = model.body(max(bodies)).name
        if name in BODY_NAMES and "foot" not in name and "hand" not in name and contact.pos[2] < 0.15:
            return True
    return False


def test_falls_agree_with_the_contacts_of_plain_mujoco():
    physics, model = falling_humanoids()
    limp = torch.zeros(4, 28)
    seen = set()
    for _ in range(60):
        physics.step(limp)
        fallen = is_fallen(physics.state()).tolist()
        for env in range(4):
            data = physics.data(env)
            mujoco.mj_forward(model, data)
            assert fallen[env] == plain_is_fallen(model, data)
        seen.update(fallen)
    assert seen == {False, True}


def test_standing_is_no_fall():
    physics, _ = falling_humanoids()
    assert not is_fallen(physics.state()).any()
