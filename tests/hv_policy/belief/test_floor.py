import torch

from hv_policy.belief.camera import camera_position, pixel_rays, project, ray_directions
from hv_policy.belief.floor import FloorHead, _sampled, floor_in_view, points_to_learn
from hv_policy.belief.floor_patch import patch_points
from hv_policy.motor.proprioception import BodyState, read_proprioception
from hv_sim.suites import load_suite
from hv_sim.world import RearrangeWorld


def bodies() -> BodyState:
    return read_proprioception(RearrangeWorld(load_suite("seen")[:2], num_threads=1).observe().proprioception)


def test_a_point_of_the_floor_reads_the_token_whose_ray_meets_it():
    body = bodies()
    rays, eye = ray_directions(body, pixel_rays(16)), camera_position(body)
    cell = 14 * 16 + 3  # low in the picture, on the left
    ray = rays[:, cell]
    point = eye[:, :2] + ray[:, :2] * (eye[:, 2:] / -ray[:, 2:])
    tokens = torch.randn(2, 256, 5)
    at, _ = project(body, torch.cat([point, torch.zeros(2, 1)], -1)[:, None])
    read = _sampled(tokens.transpose(1, 2).unflatten(2, (16, 16)), at)
    torch.testing.assert_close(read[:, 0], tokens[:, cell], atol=1e-3, rtol=1e-3)


def test_points_to_learn_from_are_in_view_all_different_and_rather_near():
    torch.manual_seed(0)
    body = bodies()
    cells, points, in_view = points_to_learn(body, 96)
    torch.testing.assert_close(points, patch_points()[cells])
    assert in_view.all()
    assert floor_in_view(body, points).all()
    assert all(len(row.unique()) == 96 for row in cells)
    everything = patch_points()[floor_in_view(body, patch_points().expand(2, -1, -1))[0]]
    assert points.norm(dim=-1).mean() < everything.norm(dim=-1).mean() - 0.2


def test_robots_and_points_are_judged_alone():
    torch.manual_seed(0)
    head, body = FloorHead(8, 4, 16), bodies()
    tokens, fine, points = torch.randn(2, 64, 8), torch.randn(2, 4, 16, 16), torch.rand(2, 5, 2) + 1
    together = head(tokens, fine, body, points)
    second = BodyState(body.pos[1:], body.rot[1:], body.lin_vel[1:], body.ang_vel[1:])
    alone = head(tokens[1:], fine[1:], second, points[1:, 2:3])
    torch.testing.assert_close(alone[0, 0], together[1, 2])
