import pytest
import torch

from hv_sim.observations import Heading
from hv_sim.suites import load_suite
from hv_sim.world import RearrangeWorld
from hv_teachers.routes import RouteViews
from hv_teachers.sight_noise import SightNoise, SightNoiseConfig


def test_errors_belong_to_the_episode_whoever_else_is_there():
    step = torch.tensor([3, 40, 500])
    together = SightNoise(3, SightNoiseConfig(0.1)).errors([7, 8, 9], step)
    for env, seed in enumerate((7, 8, 9)):
        alone = SightNoise(1, SightNoiseConfig(0.1)).errors([seed], step[env : env + 1])
        torch.testing.assert_close(alone[0], together[env], atol=0, rtol=0)


def test_errors_are_of_unit_size_slow_and_drawn_anew():
    noise = SightNoise(400, SightNoiseConfig(0.1))
    first = noise.errors(list(range(400)), torch.zeros(400))
    soon = noise.errors(list(range(400)), torch.ones(400))
    other = noise.errors(list(range(400, 800)), torch.zeros(400))
    assert 0.8 < first.std() < 1.5
    assert (soon - first).abs().mean() < 0.15
    assert (other - first).abs().mean() > 0.5


def test_what_is_far_is_seen_worse_and_nothing_without_noise():
    world = RearrangeWorld(load_suite("seen")[:2], num_threads=1)
    world.reset(seeds=[1, 2])
    routes = RouteViews(2)
    routes.follow(world)
    view, seen = routes.view(world), world.observe()
    heading = Heading.of(world.state)
    step = torch.zeros(2, dtype=torch.long)
    same, observed = SightNoise(2, SightNoiseConfig())([1, 2], step, view, seen, heading)
    torch.testing.assert_close(same.object_pos, view.object_pos)
    torch.testing.assert_close(observed.object, seen.object)
    near, _ = SightNoise(2, SightNoiseConfig(0.01, 0.0))([1, 2], step, view, seen, heading)
    far, moved = SightNoise(2, SightNoiseConfig(0.01, 0.1))([1, 2], step, view, seen, heading)
    grew = (far.object_pos - view.object_pos).norm(dim=-1) / (near.object_pos - view.object_pos).norm(dim=-1)
    distance = (view.object_pos[:, :2] - view.root_xy).norm(dim=-1)
    torch.testing.assert_close(grew, 1 + 10 * distance, rtol=1e-4, atol=0)
    # view and observation tell the same story
    error_w = far.object_pos - view.object_pos
    torch.testing.assert_close(moved.object[:, :3] - seen.object[:, :3], heading.rotate(error_w))
    torch.testing.assert_close(moved.object[:, 3:], seen.object[:, 3:])


def test_negative_noise_is_refused():
    with pytest.raises(ValueError, match=r"env.noise.per_m: -1 is not valid"):
        SightNoiseConfig(0.1, -1)
