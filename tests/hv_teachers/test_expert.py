"""The planner's expert on packaged tasks."""

import pytest
import torch

from hv_policy.decision.view import Phase
from hv_sim.control import INTENT_HIGH, INTENT_LOW
from hv_sim.task import load_task
from hv_sim.world import RearrangeWorld
from hv_teachers.expert import PlannerExpert


def rollout(tasks, seeds, steps):
    world = RearrangeWorld(tasks, num_threads=1)
    world.reset(seeds=seeds)
    expert = PlannerExpert(world.num_envs)
    trail = []
    for _ in range(steps):
        intent, targets = expert(world)
        world.step(targets)
        trail.append((intent, targets))
    return world, expert, trail


def test_intents_and_targets_are_sane():
    _, _, trail = rollout([load_task("living_room_1"), load_task("living_room_8")], [0, 1], 90)
    intents, targets = (torch.stack(x) for x in zip(*trail, strict=True))
    assert torch.isfinite(intents).all()
    assert torch.isfinite(targets).all()
    assert (intents >= torch.tensor(INTENT_LOW) - 1e-5).all()
    assert (intents <= torch.tensor(INTENT_HIGH) + 1e-5).all()


def test_an_environment_alone_is_the_one_among_others():
    task, other = load_task("living_room_8"), load_task("living_room_3")
    alone, _, _ = rollout([task], [7], 120)
    many, _, _ = rollout([other, task], [1, 7], 120)
    torch.testing.assert_close(many.state.link_pos_w[1], alone.state.link_pos_w[0], atol=1e-4, rtol=0)


def test_a_new_episode_starts_the_script_anew():
    world, expert, _ = rollout([load_task("living_room_8")], [0], 150)
    assert expert.planner.clock_s.item() > 0.05
    world.reset(seeds=[1])
    expert(world)
    assert expert.planner.phase.item() == Phase.APPROACH
    assert expert.planner.clock_s.item() < 0.05


@pytest.mark.slow
def test_follows_two_instructions():
    world = RearrangeWorld([load_task("living_room_8"), load_task("living_room_3")], num_threads=1)
    world.reset(seeds=[11, 12])
    expert = PlannerExpert(2)
    while not world.done.all():
        world.step(expert(world)[1])
    records = world.records()
    assert max(r.num_finished for r in records) == 2, records
    assert any(max(r.distances_m) < 0.2 for r in records), records
