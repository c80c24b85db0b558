"""The teacher's memory against the planner's own, from a real approach until the object stands at its goal."""

import copy

import pytest
import torch

from hv_policy.decision.memory import VECTOR_DIM, TaskMemory
from hv_policy.decision.view import Phase
from hv_sim.task import load_task
from hv_sim.world import RearrangeWorld
from hv_teachers.expert import PlannerExpert
from hv_teachers.planner import ScriptedPlanner
from hv_teachers.planner_memory import lend_memory, memory_of
from hv_teachers.routes import RouteViews


@pytest.fixture(scope="module")
def trail():
    """Views, planner states after each step, and intents, of two rooms until one robot steps back from its goal."""
    world = RearrangeWorld([load_task("living_room_8"), load_task("living_room_3")], num_threads=1)
    world.reset(seeds=[11, 12])
    expert, routes = PlannerExpert(2), RouteViews(2)
    steps = []
    for _ in range(1500):
        before = memory_of(expert.planner)
        known = list(expert.routes._routes)
        lost = expert.planner.lost.clone()
        intent, targets = expert(world)
        # where a route was planned anew the planner began anew too, unless it had lost the object
        fresh = torch.tensor([a is not b for a, b in zip(known, expert.routes._routes, strict=True)]) & ~lost
        routes.follow(world)
        view = copy.deepcopy(routes.view(world))
        steps.append((before, view, intent, memory_of(expert.planner), fresh))
        world.step(targets)
        if (expert.planner.phase == Phase.RETREAT).any():
            break
    seen = {int(p) for _, _, _, after, _ in steps for p in after.phase}
    assert seen >= set(Phase) - {Phase.IDLE}
    return steps


def test_told_the_phases_it_remembers_what_the_planner_does(trail):
    memory = TaskMemory.of(2)
    for _, view, _, after, fresh in trail:
        memory.reset(fresh.nonzero()[:, 0])
        memory.advance(after.phase.clone(), view)
        memory.tick()
        begun = after.phase >= Phase.LIFT
        torch.testing.assert_close(memory.clock_s, after.clock_s)
        torch.testing.assert_close(memory.start_height, after.start_height)
        for name in ("from_hands", "offset", "from_object_w"):
            torch.testing.assert_close(getattr(memory, name)[begun], getattr(after, name)[begun])


def test_a_planner_that_borrows_the_memory_says_the_same(trail):
    for before, view, intent, after, fresh in trail[1:]:
        if fresh.any() or (before.start_height < 0).any():
            continue  # a reset came in between
        other = ScriptedPlanner(2)
        lend_memory(before, other)
        torch.testing.assert_close(other(view), intent)
        assert torch.equal(other.phase, after.phase)


def test_going_back_from_holding_means_lost(trail):
    _, view, _, _, _ = trail[-1]
    memory = TaskMemory.of(2)
    memory.advance(torch.tensor([int(Phase.CARRY), int(Phase.REACH)]), view)
    memory.tick()
    lost = memory.advance(torch.tensor([int(Phase.APPROACH), int(Phase.APPROACH)]), view)
    assert lost.tolist() == [True, False]
    assert memory.clock_s.tolist() == [0.0, 0.0]
    assert memory.start_height[0] < 0 < memory.start_height[1]


def test_vector_and_rows(trail):
    _, view, _, after, _ = next(step for step in trail if step[3].phase[0] == Phase.CARRY)
    assert after.vector(view).shape == (2, VECTOR_DIM)
    other = TaskMemory.of(2)
    merged = after.where(torch.tensor([True, False]), other)
    assert merged.phase.tolist() == [int(after.phase[0]), 0]
    merged.reset(torch.tensor([0]))
    assert merged.phase.tolist() == [0, 0]
    assert after.phase[0] != 0
