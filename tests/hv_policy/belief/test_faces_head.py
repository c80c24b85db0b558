import math

import numpy as np
import pytest
import torch

from hv_policy.belief.camera import camera_position, pixel_rays, ray_directions
from hv_policy.belief.faces_head import CELLS, FARTHEST_M, WIDE_M, FacesHead, faces_loss, plan_view
from hv_policy.motor.proprioception import BodyState, read_proprioception
from hv_sim.observations import proprioception
from hv_sim.suites import load_suite
from hv_sim.world import RearrangeWorld

HEIGHT_M = 0.2


@pytest.fixture(scope="module")
def body() -> BodyState:
    """Of two robots that stand."""
    world = RearrangeWorld(load_suite("seen")[:2], num_threads=1)
    return read_proprioception(proprioception(world.state))


def painted(body: BodyState, size: int = 128) -> torch.Tensor:
    """(2, 3, size, size): each pixel says where its ray meets the level plane, ahead and aside."""
    directions, origin = ray_directions(body, pixel_rays(size)), camera_position(body)[:, None]
    far = (HEIGHT_M - origin[..., 2:]) / directions[..., 2:].clamp(max=-1e-3)
    met = (origin + far * directions)[..., :2].clamp(-5, 5)
    return torch.cat([met, torch.zeros_like(met[..., :1])], -1).mT.unflatten(2, (size, size))


@pytest.mark.parametrize("turn", [0.0, 0.5, -2.0])
def test_a_plan_shows_what_the_rays_of_the_picture_meet(body, turn):
    at = torch.tensor([[1.2, 0.1, HEIGHT_M], [1.5, -0.3, HEIGHT_M]])
    plan = plan_view(painted(body), body, at, torch.full((2,), turn))
    along = ((np.arange(CELLS) + 0.5) / CELLS - 0.5) * WIDE_M
    for env in range(2):
        for i, j in ((0, 0), (5, 20), (16, 16), (31, 3)):
            x = at[env, 0] + math.cos(turn) * along[i] - math.sin(turn) * along[j]
            y = at[env, 1] + math.sin(turn) * along[i] + math.cos(turn) * along[j]
            found, shown = plan[env, :2, i, j] + 0.5, plan[env, 3, i, j]
            if shown:
                torch.testing.assert_close(found, torch.tensor([x, y]).float(), atol=0.05, rtol=0)
    assert (plan[:, 3] > 0).float().mean() > 0.5
    behind = plan_view(painted(body), body, torch.tensor([[-2.0, 0.0, 0.0]]).repeat(2, 1), torch.zeros(2))
    assert (behind[:, :4] == 0).all()


def test_plans_say_where_upright_lines_lead(body):
    at, turn = torch.tensor([[1.0, 0.4, 0.3]]).repeat(2, 1), torch.tensor([0.0, 0.7])
    away = plan_view(painted(body), body, at, turn)[:, 4:, CELLS // 2, CELLS // 2]
    expected = at[:, :2] - camera_position(body)[:, :2]
    yaw = torch.atan2(expected[:, 1], expected[:, 0]) - turn
    torch.testing.assert_close(away, torch.stack([yaw.cos(), yaw.sin()], 1), atol=0.04, rtol=0)


def test_what_is_far_away_or_out_of_view_is_not_learned_from(body):
    head, pictures = FacesHead().eval(), torch.rand(2, 3, 64, 64)
    six = torch.tensor([[0.0, 1.0, 0.0, -1.0, 0.0, 0.0]]).repeat(2, 1)
    for where, counts in (([1.0, 0.0, 0.1], True), ([FARTHEST_M + 0.2, 0.0, 0.1], False), ([-1.0, 0.0, 0.1], False)):
        at = torch.tensor([where]).repeat(2, 1)
        loss = faces_loss(head, pictures, body, at, at, six)
        assert bool((loss > 0).all()) == counts
