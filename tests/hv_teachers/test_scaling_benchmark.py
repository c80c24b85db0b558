"""What is measured is what is said: the same scenes on both sides, frames that were recorded, this process's memory."""

import gc

import numpy as np
import pytest

from hv_sim.task import load_task
from hv_teachers.scaling_benchmark import (
    benchmark_motor_training,
    benchmark_recording,
    benchmark_teacher_env,
    resident_bytes,
    watch_memory,
)


def test_practice_beside_the_bare_engine():
    figures = benchmark_teacher_env([load_task("living_room_1")], num_envs=2, num_steps=4, num_threads=1, rounds=1)
    assert figures["share_of_bare"] == pytest.approx(figures["env_steps_per_s"] / figures["bare_steps_per_s"])
    assert 0 < figures["share_of_bare_with_prior"] < figures["share_of_bare"]
    assert (figures["num_envs"], figures["num_steps"], figures["num_threads"]) == (2, 4, 1)


def test_training_of_the_motor_prior_beside_the_bare_engine():
    figures = benchmark_motor_training(num_envs=4, iterations=1, num_threads=1, lone_steps=1)
    assert figures["share_of_lone"] == pytest.approx(figures["training_steps_per_s"] / figures["lone_steps_per_s"])
    assert figures["num_envs"] == 4
    with pytest.raises(ValueError, match="iterations: 0 is not valid"):
        benchmark_motor_training(iterations=0)


def test_recording_counts_frames():
    [row] = benchmark_recording([load_task("living_room_1")], workers=[1], max_episode_steps=3, image_size_px=16)
    assert (row["workers"], row["frames"], row["speedup"]) == (1, 3, 1.0)
    assert row["joining_s"] > 0
    assert row["frames_per_s"] == pytest.approx(3 / row["seconds"])


def test_memory_is_looked_at_while_the_planner_practises():
    told = []
    found = watch_memory(
        [load_task("living_room_1")], minutes=0.02, every_s=0.3, num_envs=2, num_threads=1, tell=told.append
    )
    assert told == found["looks"]
    assert len(told) >= 4
    assert told[0]["steps"] == 0 < told[-1]["steps"]
    assert told[-1]["minute"] >= 0.02
    assert all(look["resident_mb"] > 50 for look in told)
    assert np.isfinite(found["growth_mb_per_hour"])


def test_resident_memory_grows_with_what_is_held():
    gc.collect()  # what earlier tests leave must not be freed in between
    before = resident_bytes()
    held = np.ones(40_000_000)
    assert resident_bytes() - before > 0.8 * held.nbytes


@pytest.mark.parametrize("name", ["num_envs", "num_steps", "rounds"])
def test_a_bad_number_is_named(name):
    with pytest.raises(ValueError, match=f"{name}: 0 is not valid"):
        benchmark_teacher_env([load_task("living_room_1")], **{name: 0})
    with pytest.raises(ValueError, match="minutes: 0 is not valid; valid: a number above 0"):
        watch_memory([load_task("living_room_1")], minutes=0)
