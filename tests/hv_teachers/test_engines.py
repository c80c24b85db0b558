"""Every job is done once, whoever is killed on the way."""

import os
import sys

import jobs_that_die
import pytest

from hv_teachers.engines import Slice, check_engine, run_jobs


def results(folder, deaths, **settings):
    jobs = [(i, str(folder), deaths.get(i, 0)) for i in range(6)]
    return sorted(run_jobs(jobs_that_die.multiply, jobs, prepare=jobs_that_die.prepare, arguments=(7,), **settings))


WANTED = [(i, 7 * i) for i in range(6)]


def test_one_process_is_this_one(tmp_path):
    assert results(tmp_path, {}, workers=1) == WANTED
    assert jobs_that_die.FACTOR == 7


def test_killed_processes_are_replaced(tmp_path):
    assert results(tmp_path, {1: 1, 4: 2}, workers=2) == WANTED
    killed = [path.name.split("_") for path in tmp_path.iterdir()]
    assert sorted(number for number, _ in killed) == ["1", "4", "4"]
    assert str(os.getpid()) not in {pid for _, pid in killed}


def test_an_error_is_an_error():
    for workers in (1, 2):
        with pytest.raises(ValueError, match="nobody can do it"):
            list(run_jobs(jobs_that_die.fail, [1, 2], workers=workers))


@pytest.mark.slow
def test_ray_does_the_same(tmp_path):
    pytest.importorskip("ray", reason="Ray is not installed here: pip install 'lerobot_policy_hv[ray]'")
    assert results(tmp_path, {1: 1, 4: 2}, workers=2, engine="ray") == WANTED
    assert len(list(tmp_path.iterdir())) == 3
    with pytest.raises(ValueError, match="nobody can do it"):
        list(run_jobs(jobs_that_die.fail, [1], workers=1, engine="ray"))


def test_engines_are_known_and_installed(monkeypatch):
    with pytest.raises(ValueError, match="engine: 'horse' is not valid; valid: pool, ray"):
        check_engine("horse")
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(ValueError, match=r"'ray' is not installed here .*pip install 'lerobot_policy_hv\[ray\]'"):
        check_engine("ray")


def test_slices_share_the_jobs_out():
    slices = [Slice.parse(f"{i}/3") for i in range(3)]
    assert [[n for n in range(7) if n in s] for s in slices] == [[0, 3, 6], [1, 4], [2, 5]]
    for text in ("3/3", "1", "-1/3", "a/b", "0/0", "1/"):
        with pytest.raises(ValueError, match="shard: "):
            Slice.parse(text)
