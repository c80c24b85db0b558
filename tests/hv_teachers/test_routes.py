"""What the planner and the teachers look at, against navigator and scenes, one environment at a time."""

import numpy as np
import torch

from hv_policy.decision.view import Phase
from hv_sim.task import load_task
from hv_sim.world import RearrangeWorld
from hv_teachers.routes import ALIGN_S, REACH_S, RouteViews, gave_up, replan_routes


def make():
    world = RearrangeWorld([load_task("living_room_3"), load_task("living_room_8")], num_threads=1)
    world.reset(seeds=[4, 5])
    routes = RouteViews(2)
    return world, routes


def test_views_are_the_routes():
    world, routes = make()
    assert routes.follow(world).tolist() == [0, 1]
    view = routes.view(world)
    for i, route in enumerate(world.navigator.routes):
        scene, k = world.scenes[i], int(world.object_index[i])
        position, rotation = (x[i, k].double().numpy() for x in (world.state.object_pos_w, world.state.object_rot_w))
        left, right = route.grasp_o
        np.testing.assert_allclose(view.grasp[i], [position + rotation @ right, position + rotation @ left], atol=1e-5)
        np.testing.assert_allclose(view.pick_stand[i], route.pick_stand_xy_yaw, atol=1e-6)
        np.testing.assert_allclose(view.place_stand[i], route.place_stand_xy_yaw, atol=1e-6)
        assert view.depth_m[i].item() == np.float32(route.depth_m)
        np.testing.assert_allclose(view.goal_pos[i], scene.goal_pos_w[0], atol=1e-6)
        # at the pick stand the robot faces the object, its right hand's grasp to its right
        yaw = route.pick_stand_xy_yaw[2]
        forward, left_of = np.array([np.cos(yaw), np.sin(yaw)]), np.array([-np.sin(yaw), np.cos(yaw)])
        assert (position[:2] - route.pick_stand_xy_yaw[:2]) @ forward > 0.2
        assert (view.grasp[i, 1, :2] - view.grasp[i, 0, :2]).numpy() @ left_of > 0.05
    torch.testing.assert_close(view.root_xy, world.state.link_pos_w[:, 0, :2])


def test_only_what_was_planned_anew_is_new():
    world, routes = make()
    routes.follow(world)
    assert len(routes.follow(world)) == 0
    replan_routes(world, torch.tensor([1]))
    assert routes.follow(world).tolist() == [1]
    routes.reset(torch.tensor([0]))
    assert routes.follow(world).tolist() == [0]
    replan_routes(world, torch.zeros(0, dtype=torch.long))
    assert len(routes.follow(world)) == 0


def test_what_was_tried_in_vain_is_tried_from_another_side():
    world, routes = make()
    routes.follow(world)
    everyone = torch.arange(2)
    first = routes.pick_stand[:, 2].clone()
    for tries in (1, 2, 3):
        routes.spurn(everyone)
        assert (~routes.spurned_rad.isnan()).sum(1).tolist() == [tries, tries]
        replan_routes(world, everyone, routes.spurned_rad)
        routes.follow(world)
    assert torch.equal(routes.spurned_rad[:, 2], first), "newest first; which side is next is tested with the ways"
    world.instructor.num_finished[0] = 1
    routes.follow(world)
    assert routes.spurned_rad[0].isnan().all(), "another object"
    assert not routes.spurned_rad[1].isnan().all()


def rotation(axis, angle):
    """Rodrigues' formula."""
    x, y, z = np.asarray(axis) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    turned = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return torch.tensor(turned, dtype=torch.float32)


def test_what_rolled_over_is_planned_anew_and_a_round_thing_is_held_as_before():
    world, routes = make()
    tipped = rotation([1, 0, 0], np.pi / 2)
    world.state.object_rot_w[[0, 1], world.object_index] = tipped
    replan_routes(world, torch.arange(2))
    routes.follow(world)
    routes.rolls[:] = torch.tensor([True, False])
    reaching = torch.full((2,), int(Phase.REACH))
    assert not routes.disturbed(world, reaching).any()
    held = routes.view(world).grasp - routes.view(world).object_pos[:, None]
    for angle in (0.4, 2.0, np.pi, -1.0):
        world.state.object_rot_w[[0, 1], world.object_index] = tipped @ rotation([0, 0, 1], angle)
        assert routes.disturbed(world, reaching).tolist() == [False, True]
        now = routes.view(world)
        torch.testing.assert_close((now.grasp - now.object_pos[:, None])[0], held[0], atol=1e-5, rtol=0)
        assert not torch.allclose((now.grasp - now.object_pos[:, None])[1], held[1], atol=1e-2)
    world.state.object_rot_w[[0, 1], world.object_index] = rotation([0, 0, 1], 0.4) @ tipped
    assert routes.disturbed(world, reaching).all(), "what is round may not turn round either"
    assert not routes.disturbed(world, torch.full((2,), int(Phase.SQUEEZE))).any(), "hands turn what they press"
    world.navigator.picked_up[0] = True
    assert routes.disturbed(world, torch.full((2,), int(Phase.SQUEEZE))).tolist() == [True, False]
    assert not routes.disturbed(world, torch.full((2,), int(Phase.LIFT))).any()


def test_who_reaches_in_vain_gives_up():
    cases = [
        (Phase.REACH, Phase.ALIGN, 0.0, True), (Phase.REACH, Phase.SQUEEZE, 0.0, False),
        (Phase.REACH, Phase.REACH, REACH_S - 1, False), (Phase.REACH, Phase.REACH, REACH_S + 1, True),
        (Phase.ALIGN, Phase.ALIGN, REACH_S + 1, False), (Phase.ALIGN, Phase.ALIGN, ALIGN_S + 1, True),
        (Phase.APPROACH, Phase.APPROACH, 99.0, False), (Phase.ALIGN, Phase.APPROACH, 0.0, False),
    ]  # fmt: skip
    before, phase = (torch.tensor([int(c[k]) for c in cases]) for k in (0, 1))
    assert gave_up(before, phase, torch.tensor([c[2] for c in cases])).tolist() == [c[3] for c in cases]


def test_the_last_waypoint_of_each_leg():
    world, routes = make()
    routes.follow(world)
    route, navigator = world.navigator.routes[0], world.navigator
    first_leg, whole = len(route.waypoints_to_object), len(route.waypoints_to_object) + len(route.waypoints_to_goal)
    found = []
    for index in range(whole):
        navigator.progress[0], navigator.picked_up[0] = index, index >= first_leg
        found.append(bool(routes.view(world).waypoint_is_last[0]))
    reaches = [int(route.ahead[i]) in (first_leg - 1, whole - 1) for i in range(whole)]
    assert found == reaches
    assert found[first_leg - 1]
    assert not found[first_leg]
    navigator.progress[0], navigator.picked_up[0] = first_leg - 1, False
    assert navigator.leg_is_done[0]
    navigator.picked_up[0] = True
    assert not navigator.leg_is_done[0]
    navigator.progress[0] = whole - 1
    assert navigator.leg_is_done[0]
