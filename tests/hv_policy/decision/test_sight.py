"""What is shown to the networks that decide, against the same in plain NumPy, number by number."""

from types import SimpleNamespace

import numpy as np
import pytest
import torch

from hv_policy.decision.memory import VECTOR_DIM
from hv_policy.decision.sight import ANCHOR_DIM, NEAR_DIM, OBSERVATION_DIM, ROUTE_DIM, SIGHT_DIM, hand_anchors, sight
from hv_policy.decision.view import TaskView
from hv_policy.motor.intent import LEFT_HAND, RIGHT_HAND, neutral_intent

N = 40


@pytest.fixture(scope="module")
def scene():
    torch.manual_seed(3)

    def stand():
        return torch.cat([4 * torch.randn(N, 2), 7 * torch.rand(N, 1) - 3.5], 1)

    view = TaskView(
        root_xy=4 * torch.randn(N, 2),
        root_yaw=8 * torch.rand(N) - 4,
        feet_xy=torch.randn(N, 2),
        hands=torch.randn(N, 2, 3),
        object_pos=torch.randn(N, 3),
        grasp=torch.randn(N, 2, 3),
        depth_m=torch.rand(N),
        goal_pos=torch.randn(N, 3),
        pick_stand=stand(),
        place_stand=stand(),
        waypoint=torch.randn(N, 2),
        waypoint_is_last=torch.rand(N) < 0.5,
        may_back=torch.rand(N) < 0.5,
        clearance_m=torch.rand(N),
        away=torch.nn.functional.normalize(torch.randn(N, 2), dim=-1),
    )
    # near one another in half of the scenes, so that what is near is not all at its limit
    view.object_pos[::2, :2] = view.root_xy[::2] + 0.3 * torch.randn(N // 2, 2)
    view.hands[::2] = view.object_pos[::2, None] + 0.1 * torch.randn(N // 2, 2, 3)
    view.grasp[::2] = view.object_pos[::2, None] + 0.1 * torch.randn(N // 2, 2, 3)
    view.goal_pos[::2] = view.object_pos[::2] + 0.1 * torch.randn(N // 2, 3)
    view.pick_stand[::2, :2] = view.root_xy[::2] + 0.1 * torch.randn(N // 2, 2)
    sizes = {"proprioception": 223, "object": 15, "goal": 9, "waypoint": 3, "half_extents": 3}
    observation = SimpleNamespace(**{name: torch.randn(N, size) for name, size in sizes.items()})
    return view, observation, torch.rand(N) < 0.5, torch.rand(N) < 0.5, torch.randn(N, VECTOR_DIM)


def headed(view, i, point):
    """A point (2 or 3,) as the robot `i` sees it."""
    yaw = float(view.root_yaw[i])
    turn = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])
    point = np.asarray(point, dtype=float)
    return np.concatenate([turn @ (point[:2] - view.root_xy[i].double().numpy()), point[2:]])


def test_a_sight_is_observations_route_and_what_is_near(scene):
    view, observation, done, picked, _ = scene
    seen = sight(observation, view, done, picked)
    assert seen.shape == (N, SIGHT_DIM)
    assert seen.dtype == torch.float32
    for i in range(N):
        own = [v[i] for v in vars(observation).values()]
        obj, goal = headed(view, i, view.object_pos[i]), headed(view, i, view.goal_pos[i])
        grasp, hands = ([headed(view, i, p) for p in points[i]] for points in (view.grasp, view.hands))
        stands = []
        for x, y, yaw in (view.pick_stand[i].tolist(), view.place_stand[i].tolist()):
            turn = yaw - float(view.root_yaw[i])
            stands.append(np.array([*headed(view, i, (x, y)), np.cos(turn), np.sin(turn)]))
        route = [*grasp, *stands, [view.depth_m[i], done[i], picked[i]]]
        walk = observation.waypoint[i, :2].double().numpy()
        far = np.linalg.norm(walk)
        near = [
            (np.concatenate(grasp) - np.concatenate(hands)) / 0.15,
            (obj - goal) / 0.2,
            *(np.array([*stand[:2], np.arctan2(stand[3], stand[2])]) / 0.3 for stand in stands),
            [*walk / far, min(far, 1.0)],
            (obj - (hands[0] + hands[1]) / 2) / 0.25,
            [(np.linalg.norm(obj[:2]) - 1.15) / 0.3, (obj[2] - goal[2]) / 0.05],
            [(float(view.clearance_m[i]) - 0.34) / 0.12],
            headed(view, i, view.root_xy[i] + view.away[i]),
            [float(view.may_back[i])],
        ]
        wanted = np.concatenate([*own, *route, np.clip(np.concatenate(near), -2.0, 2.0)])
        assert len(wanted) == OBSERVATION_DIM + ROUTE_DIM + NEAR_DIM
        np.testing.assert_allclose(seen[i], wanted, atol=2e-5, rtol=1e-5)


def test_hands_may_go_to_seven_places(scene):
    view, _, _, _, memory = scene
    anchors = hand_anchors(view, memory)
    assert anchors.shape == (N, ANCHOR_DIM)
    neutral = neutral_intent(1)[0].numpy()
    rest = np.stack([neutral[RIGHT_HAND], neutral[LEFT_HAND]])
    for i in range(N):
        m = memory[i].double().numpy()
        begun, offset, picked = m[2:8].reshape(2, 3), m[8:14].reshape(2, 3), m[14:17]
        sideways = offset - np.array([*offset[:, :2].mean(0), 0.0])
        height = max(m[17], float(view.goal_pos[i, 2])) + 0.12
        chest = np.array([max(0.2 + float(view.depth_m[i]) / 2, 0.34), 0.0, max(height, 1.0)]) + sideways
        grasp, hands = ([headed(view, i, p) for p in points[i]] for points in (view.grasp, view.hands))
        wanted = [rest, hands, grasp, begun, headed(view, i, view.goal_pos[i]) + offset, picked + offset, chest]
        np.testing.assert_allclose(anchors[i].reshape(7, 2, 3), np.stack(wanted), atol=2e-5, rtol=1e-5)


def test_company_does_not_matter(scene):
    view, observation, done, picked, memory = scene
    one = TaskView(**{name: value[7:8] for name, value in vars(view).items()})
    own = SimpleNamespace(**{name: value[7:8] for name, value in vars(observation).items()})
    assert torch.equal(sight(own, one, done[7:8], picked[7:8]), sight(observation, view, done, picked)[7:8])
    assert torch.equal(hand_anchors(one, memory[7:8]), hand_anchors(view, memory)[7:8])
