import pytest
import torch
from policy_samples import make_config

from hv_policy.modeling_hv import HVPolicy
from hv_sim.suites import load_suite
from hv_teachers.student_diagnosis import diagnose


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    torch.manual_seed(0)
    policy = HVPolicy(make_config(form="belief", vocabulary=["the", "sofa"]))
    path = tmp_path_factory.mktemp("student")
    policy.save_pretrained(path)
    return path


def test_what_a_student_is_told_it_believes(folder):
    tasks = load_suite("seen")[:2]
    alone = diagnose(folder, tasks, 3, max_episode_steps=32)
    told = diagnose(folder, tasks, 3, ["object", "goal"], max_episode_steps=32)
    [errors] = [e for phase, e in told.errors.items() if phase == "APPROACH"]
    assert errors["object"] < 0.05
    assert errors["goal"] < 0.06, "odometry adds to it while the robot sets out"
    assert max(e["object"] for e in alone.errors.values()) > 0.3
    assert errors["pose"] < 0.1
    assert sum(alone.steps.values()) <= 64
    assert alone.success(None) == 0.0
    assert [len(alone.records), alone.fell_in] == [2, {}]


def test_what_it_cannot_be_told_is_refused_in_one_line(folder):
    with pytest.raises(ValueError, match="told: 'walls' is not valid; valid: object, goal, floor") as error:
        diagnose(folder, load_suite("seen")[:1], 0, ["walls"])
    assert "\n" not in str(error.value)
