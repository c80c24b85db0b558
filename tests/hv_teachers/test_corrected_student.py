"""An untrained student acts; what the teacher says of it must be what the teacher would say, and nothing else."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import torch
from policy_samples import TASKS as SENTENCES
from policy_samples import make_config, make_policy

from hv_policy.belief.places import GOAL, OBJECT
from hv_policy.modeling_hv import HVPolicy
from hv_sim.suites import load_suite
from hv_teachers.corrected_student import CorrectedStudent, load_student, teacher_leads
from hv_teachers.dataset_format import TEXT_COLUMNS
from hv_teachers.expert import TeacherExpert, expert_maker
from hv_teachers.recording import RecordingConfig, roll_attempts

TASKS = load_suite("seen")[:2]


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> str:
    torch.manual_seed(0)
    meta = SimpleNamespace(tasks=pd.DataFrame({"task_index": [0, 1]}, index=SENTENCES))
    policy = HVPolicy(make_config(form="belief"), dataset_meta=meta)
    place = tmp_path_factory.mktemp("student")
    policy.save_pretrained(place)
    return str(place)


def roll(folder: str, beta: float, tasks, config: RecordingConfig):
    return roll_attempts(tasks, lambda n: CorrectedStudent(n, folder, beta), config)


def test_with_the_teacher_in_the_lead_all_the_time_it_is_the_teacher(folder):
    config = RecordingConfig(seed=3, image_size_px=64, max_episode_steps=45, beta=1.0)
    [(_, led)] = roll(folder, 1.0, [(TASKS[0], 0)], config)
    [(_, taught)] = roll_attempts([(TASKS[0], 0)], lambda n: TeacherExpert(n), config)
    for a, b in zip(led, taught, strict=True):  # what is not remembered yet lies elsewhere, and weighs a little
        np.testing.assert_allclose(a["action"], b["action"], atol=2e-2)
        np.testing.assert_allclose(a["privileged.places"], b["privileged.places"], atol=2e-2)
        np.testing.assert_array_equal(a["privileged.phase"], b["privileged.phase"])


def test_the_student_goes_its_own_way_and_the_labels_tell_the_truth(folder):
    config = RecordingConfig(seed=3, image_size_px=64, max_episode_steps=45)
    [(_, own)] = roll(folder, 0.0, [(TASKS[0], 0)], config)
    [(_, led)] = roll_attempts([(TASKS[0], 0)], lambda n: TeacherExpert(n), config)
    assert np.abs(own[-1]["observation.state"] - led[-1]["observation.state"]).max() > 0.05
    for frame in own:  # object and goal as the observation has them, relative to the pelvis
        height = frame["observation.state"][0] * np.array([0, 0, 1])
        np.testing.assert_allclose(
            frame["privileged.places"][OBJECT] - height, frame["privileged.object"][:3], atol=1e-4
        )
        np.testing.assert_allclose(frame["privileged.places"][GOAL] - height, frame["privileged.goal"][:3], atol=1e-4)


def test_an_attempt_is_the_same_in_company(folder):
    config = RecordingConfig(seed=5, image_size_px=64, max_episode_steps=20, beta=0.5)
    (_, (_, second)) = roll(folder, 0.5, [(TASKS[0], 0), (TASKS[1], 0)], config)
    [(_, alone)] = roll(folder, 0.5, [(TASKS[1], 0)], config)
    for a, b in zip(second, alone, strict=True):
        for key in set(a) - {"task", *TEXT_COLUMNS}:
            np.testing.assert_allclose(a[key], b[key], atol=1e-4)


def test_the_lead_changes_in_stretches_drawn_from_the_episode():
    steps = list(range(0, 9000, 10))
    leads = teacher_leads([4] * len(steps), steps, 0.3).float()
    assert 0.15 < leads.mean() < 0.45
    assert (leads[1:] != leads[:-1]).float().mean() < 0.1
    assert not torch.equal(leads, teacher_leads([5] * len(steps), steps, 0.3).float())
    assert not teacher_leads([4] * 10, range(10), 0.0).any()


def test_other_policies_are_refused_in_one_line(folder, tmp_path):
    make_policy().save_pretrained(tmp_path / "direct")
    with pytest.raises(ValueError, match="form direct; valid: type hv, form belief"):
        load_student(tmp_path / "direct")
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "config.json").write_text("{")
    with pytest.raises(ValueError, match="cannot be read") as error:
        expert_maker(str(tmp_path / "broken"))
    assert "\n" not in str(error.value)
