import pytest

from hv_live.clock import CONTROL_DT_S, Clock, Rate


class Watch:
    def __init__(self):
        self.now_s = 100.0

    def __call__(self):
        return self.now_s


def run(step_s: float, seconds: float) -> tuple[int, Clock]:
    watch = Watch()
    clock = Clock(watch)
    steps = 0
    while watch.now_s < 100.0 + seconds:
        watch.now_s += step_s
        clock.tick()
        steps += 1
        watch.now_s += clock.wait_s()
    return steps, clock


def test_a_fast_machine_keeps_real_time():
    steps, clock = run(0.005, 10.0)
    assert steps == pytest.approx(300, abs=2)
    assert clock.speed == pytest.approx(1.0, abs=0.02)


def test_a_slow_machine_slows_the_clock_and_skips_nothing():
    steps, clock = run(2 * CONTROL_DT_S, 10.0)
    assert steps == pytest.approx(150, abs=2)
    assert clock.speed == pytest.approx(0.5, abs=0.02)


def test_a_pause_is_not_caught_up_with():
    watch = Watch()
    clock = Clock(watch)
    clock.tick()
    watch.now_s += 60.0
    clock.start()
    clock.tick()
    assert clock.wait_s() == pytest.approx(CONTROL_DT_S)
    watch.now_s += 5.0  # late without a pause: made up for a little
    clock.tick()
    late = 0
    while clock.wait_s() == 0.0:
        clock.tick()
        late += 1
    assert 1 <= late <= 4


def test_rate():
    watch = Watch()
    rate = Rate(watch)
    for _ in range(60):
        watch.now_s += 0.05
        rate.tick()
    assert rate.per_second == pytest.approx(20, abs=1)
