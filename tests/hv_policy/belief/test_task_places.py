import torch

from hv_policy.belief.task_places import leg_is_done, places_of, view_of, way_of
from hv_policy.motor.proprioception import read_proprioception
from hv_sim.observations import proprioception
from hv_sim.suites import load_suite
from hv_sim.world import RearrangeWorld
from hv_teachers.routes import RouteViews


def test_a_view_can_be_put_together_again():
    world = RearrangeWorld(load_suite("seen")[:3], num_threads=1)
    routes = RouteViews(3)
    routes.follow(world)
    view = routes.view(world)
    done = world.navigator.leg_is_done
    body = read_proprioception(proprioception(world.state))
    pose = torch.cat([view.root_xy, view.root_yaw[:, None]], 1)
    again = view_of(places_of(view), way_of(view, done), body, pose)
    for name, value in vars(view).items():
        other = getattr(again, name)
        if name.endswith("stand"):  # headings may differ by a full turn
            turn = other[:, 2] - value[:, 2]
            torch.testing.assert_close(turn.cos(), torch.ones(3), atol=1e-5, rtol=0)
            value, other = value[:, :2], other[:, :2]
        torch.testing.assert_close(other, value, atol=2e-5, rtol=1e-5, msg=name)
    assert torch.equal(leg_is_done(way_of(view, done)), done)
