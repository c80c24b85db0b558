"""The student beside stock ACT: both really act and learn, and the figures fit together."""

from pathlib import Path

import pytest
import torch

from hv_policy.network_file import SHIPPED_STUDENT
from hv_sim.suites import load_suite
from hv_teachers.corrected_student import load_student
from hv_teachers.student_benchmark import STEPS_IN_TURN, benchmark_latency, benchmark_training, stock_act


@pytest.fixture(scope="module")
def student():
    return load_student(Path(SHIPPED_STUDENT))


def test_act_is_lerobots_own_and_asked_at_every_step(student):
    act = stock_act(student)
    batch = {"observation.images.head": torch.rand(1, 3, 128, 128), "observation.state": torch.rand(1, 223)}
    first, second = act.select_action(batch), act.select_action({**batch, "observation.state": torch.zeros(1, 223)})
    assert first.shape == (1, 28)
    assert not torch.equal(first, second), "no queue of old actions"
    assert sum(p.numel() for p in act.parameters()) > 40e6


def test_latency(student):
    threads = torch.get_num_threads()
    figures = benchmark_latency(student, load_suite("seen")[0], STEPS_IN_TURN)
    assert torch.get_num_threads() == threads
    assert 0 < figures["student_median_ms"] <= figures["student_p95_ms"]
    ratio = figures["act_mean_ms"] / figures["student_mean_ms"]
    assert figures["times_as_fast_as_act"] == pytest.approx(ratio)
    assert ratio > 2, "seven on an idle machine"


def test_training(student):
    before = {name: value.clone() for name, value in student.named_parameters() if value.requires_grad}
    figures = benchmark_training(student, load_suite("seen")[:2], 4, 1.0)
    assert any(not torch.equal(before[name], value) for name, value in student.named_parameters() if name in before)
    assert figures["student_samples_per_s"] > figures["act_samples_per_s"] > 0
