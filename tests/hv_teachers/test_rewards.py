"""The rewards against slow, obvious arithmetic on one environment at a time, and in situations where they must rise."""

import math
from dataclasses import replace

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation

from hv_sim.basis_point_set import basis_point_set, nearest_surface_points
from hv_sim.task import built_object, load_task
from hv_sim.world import RearrangeWorld
from hv_teachers.rewards import (
    TASK_TERMS,
    RetreatRewardConfig,
    RewardInputs,
    TaskRewardConfig,
    read_world,
    retreat_rewards,
    surface_points,
    task_rewards,
    task_terms,
)

CONFIG = TaskRewardConfig()


def random_inputs(num: int, seed: int) -> RewardInputs:
    """Robots, objects and goals about a metre apart: every branch of every term occurs."""
    rng = np.random.default_rng(seed)

    def normal(*shape, scale=0.5):
        return torch.tensor(rng.normal(0, scale, (num, *shape)), dtype=torch.float32)

    root = normal(3) + torch.tensor([0, 0, 0.8])
    obj = normal(3)
    rotation = [torch.tensor(Rotation.random(num, rng=rng).as_matrix(), dtype=torch.float32) for _ in range(2)]
    return RewardInputs(
        root_pos=root,
        root_vel=normal(3),
        hands=obj[:, None] + normal(2, 3, scale=0.3),
        object_pos=obj,
        object_rot=rotation[0],
        object_vel=normal(3),
        object_points=normal(7, 3, scale=0.1),
        object_start_height=normal().abs(),
        goal_pos=obj + normal(3, scale=0.3),
        goal_rot=rotation[1],
        robot_guide=normal(2),
        object_guide=normal(2),
    )


def slow_task_rewards(x: RewardInputs, i: int) -> dict[str, float]:
    """Tables 6 and 7 for environment `i`, with the saturations, in plain Python."""

    def get(name):
        return getattr(x, name)[i].double().numpy()

    def distance(a, b):
        return math.sqrt(sum((p - q) ** 2 for p, q in zip(a, b, strict=True)))

    def speed_toward(velocity, here, there):
        away = distance(here[:2], there[:2])
        return sum(velocity[k] * (there[k] - here[k]) / away for k in range(2))

    root, obj, goal = get("root_pos"), get("object_pos"), get("goal_pos")
    points = get("object_points") @ get("object_rot").T + obj
    placed = distance(obj, goal) < 0.3
    there = placed or distance(root[:2], obj[:2]) < 0.5
    toward = speed_toward(get("root_vel"), root, get("robot_guide"))
    nearest = [min(distance(hand, p) for p in points) for hand in get("hands")]
    start = float(x.object_start_height[i])
    target = max(start, goal[2]) + 0.1
    pushed = speed_toward(get("object_vel"), obj, get("object_guide"))
    turn = Rotation.from_matrix(get("object_rot")).inv() * Rotation.from_matrix(get("goal_rot"))
    return {
        "robot2object_vel": 0.1 * (1 if there else math.exp(-2 * (1.5 - toward) ** 2)),
        "robot2object_pos": 0.1 * (1 if there else math.exp(-0.5 * distance(root[:2], get("robot_guide")) ** 2)),
        "hand2object": 0.1 * (1 if placed else sum(math.exp(-5 * d) for d in nearest) / 2),
        "height": 0.1 * (1 if placed else max(0.0, (min(obj[2], target) - start) / (target - start))),
        "object2goal_vel": 0.2 * (1 if placed else math.exp(-2 * (1.5 - pushed) ** 2)),
        "object2goal_pos_far": 0.2 * (1 if placed else math.exp(-distance(obj[:2], get("object_guide")))),
        "object2goal_pos_near": 0.1 * math.exp(-5 * distance(obj, goal)),
        "object2goal_rot": 0.1 * math.exp(-2 * turn.magnitude()),
    }


def test_task_rewards_are_tables_6_and_7():
    x = random_inputs(300, 0)
    fast = task_rewards(x, CONFIG)
    assert list(fast) == list(TASK_TERMS)
    for i in range(300):
        for name, value in slow_task_rewards(x, i).items():
            assert float(fast[name][i]) == pytest.approx(value, abs=2e-5), (name, i)
    placed = x.object_goal_m < CONFIG.near_goal_m
    assert 10 < int(placed.sum()) < 290  # both branches were seen


def test_weights_sum_to_one():
    assert sum(getattr(CONFIG, name) for name in TASK_TERMS) == pytest.approx(1.0)


def test_retreat_rewards_are_algorithm_2():
    x = random_inputs(300, 1)
    fast = retreat_rewards(x, RetreatRewardConfig())
    branches = set()
    for i in range(300):
        obj, root, goal = (getattr(x, n)[i].double() for n in ("object_pos", "root_pos", "goal_pos"))
        points = x.object_points[i].double() @ x.object_rot[i].double().T + obj
        hand = min(float((h - p).norm()) for h in x.hands[i].double() for p in points)
        robot = float((root - obj)[:2].norm())
        r_robot, r_hand = 1 - math.exp(-0.5 * robot), 1 - math.exp(-0.5 * hand)
        if robot > 1.0:
            r_robot = 1
        if hand > 0.5:
            r_hand = 1
        if float((obj - goal).norm()) >= 0.4:
            r_robot = r_hand = 0
        branches.add((r_robot in (0, 1), r_hand in (0, 1)))
        assert float(fast["retreat_robot2object"][i]) == pytest.approx(0.5 * r_robot, abs=1e-5)
        assert float(fast["retreat_hand2object"][i]) == pytest.approx(0.5 * r_hand, abs=1e-5)
    assert len(branches) >= 3


def scene(**changes) -> RewardInputs:
    """One robot 2 m before a box that shall go 3 m farther, hands hanging, nothing moving."""
    corners = torch.tensor([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * 0.15
    values = {
        "root_pos": torch.tensor([[0.0, 0.0, 0.85]]),
        "root_vel": torch.zeros(1, 3),
        "hands": torch.tensor([[[0.1, -0.24, 0.85], [0.1, 0.24, 0.85]]]),
        "object_pos": torch.tensor([[2.0, 0.0, 0.15]]),
        "object_rot": torch.eye(3)[None],
        "object_vel": torch.zeros(1, 3),
        "object_start_height": torch.tensor([0.15]),
        "goal_pos": torch.tensor([[5.0, 0.0, 0.15]]),
        "goal_rot": torch.eye(3)[None],
        "robot_guide": torch.tensor([[2.0, 0.0]]),
        "object_guide": torch.tensor([[5.0, 0.0]]),
    }
    values |= {name: torch.as_tensor(value, dtype=torch.float32)[None] for name, value in changes.items()}
    values["object_points"] = corners[None]
    return RewardInputs(**values)


ASIDE = {"robot_guide": [0, 2]}
TURNED = Rotation.from_euler("z", 60, degrees=True).as_matrix()


@pytest.mark.parametrize(
    ("term", "before", "after"),
    [
        ("robot2object_vel", {}, {"root_vel": [1.0, 0, 0]}),  # walks toward the object
        ("robot2object_vel", {"root_vel": [1.0, 0, 0]} | ASIDE, {"root_vel": [0, 1.0, 0]} | ASIDE),
        ("robot2object_pos", {}, {"root_pos": [1.0, 0, 0.85]}),
        ("robot2object_pos", {"root_pos": [1.0, 0, 0.85]}, {"root_pos": [1.6, 0, 0.85]}),
        ("hand2object", {}, {"hands": [[2.0, -0.2, 0.2], [2.0, 0.2, 0.2]]}),  # both hands at the box
        ("hand2object", {"hands": [[2, -0.2, 0.2], [0, 0.2, 0.8]]}, {"hands": [[2, -0.2, 0.2], [2, 0.2, 0.2]]}),
        ("height", {}, {"object_pos": [2.0, 0, 0.2]}),  # lifted
        ("height", {"object_pos": [2.0, 0, 0.2]}, {"object_pos": [2.0, 0, 0.25]}),
        ("object2goal_vel", {}, {"object_vel": [1.0, 0, 0]}),
        ("object2goal_vel", {"object_vel": [-1.0, 0, 0]}, {}),
        ("object2goal_pos_far", {}, {"object_pos": [3.0, 0, 0.15]}),
        ("object2goal_pos_near", {"object_pos": [4.8, 0, 0.15]}, {"object_pos": [4.9, 0, 0.15]}),
        ("object2goal_rot", {"object_rot": TURNED}, {}),
    ],
)  # fmt: skip
def test_each_term_rises_when_it_must(term, before, after):
    lower, higher = (float(task_terms(scene(**s), CONFIG)[term]) for s in (before, after))
    assert 0 <= lower < higher <= 1


def test_terms_saturate():
    placed = task_rewards(scene(object_pos=[4.9, 0, 0.15]), CONFIG)
    for name in (
        "robot2object_vel",
        "robot2object_pos",
        "hand2object",
        "height",
        "object2goal_vel",
        "object2goal_pos_far",
    ):
        assert float(placed[name]) == pytest.approx(getattr(CONFIG, name)), name
    beside = task_rewards(scene(root_pos=[1.6, 0, 0.85]), CONFIG)
    assert float(beside["robot2object_vel"]) == pytest.approx(0.1)
    assert float(beside["height"]) < 0.01


def test_stepping_back_pays_only_when_the_object_is_placed():
    def total(**changes):
        return float(sum(retreat_rewards(scene(**changes), RetreatRewardConfig()).values()))

    holding = {"object_pos": [5.0, 0, 0.15], "root_pos": [4.6, 0, 0.6], "hands": [[5, -0.19, 0.2], [5, 0.19, 0.2]]}
    released = holding | {"hands": [[4.9, -0.4, 0.5], [4.9, 0.4, 0.5]]}
    away = {"object_pos": [5.0, 0, 0.15], "root_pos": [3.9, 0, 0.85], "hands": [[4.0, -0.3, 0.8], [4.0, 0.3, 0.8]]}
    assert total(**holding) < total(**released) < total(**away) == pytest.approx(1.0)
    assert total() == 0.0  # far from everything, but nothing has been brought anywhere


def test_surface_points_have_the_objects_size():
    task = load_task("living_room_1")
    for placement in task.objects:
        built = built_object(placement)
        bps = torch.tensor(basis_point_set(built.parts))[None]
        half = torch.tensor(built.half_extents_m, dtype=torch.float32)[None]
        points = surface_points(bps, half)[0].double().numpy()
        on_surface = nearest_surface_points(points, [p for p in built.parts if p.collides])
        assert np.abs(points - on_surface).max() < 6e-3


def test_reads_a_world():
    world = RearrangeWorld([load_task("living_room_1"), load_task("living_room_8")], num_threads=1)
    observation = world.observe()
    points = surface_points(observation.bps, observation.half_extents)
    start = world.state.object_pos_w[torch.arange(2), world.object_index, 2]
    x = read_world(world, points, start)
    assert x.object_points.norm(dim=-1).amin() > 0.02
    # nobody carries anything yet: the robot's guide is its waypoint, the object's its goal
    torch.testing.assert_close(x.object_guide, x.goal_pos[:, :2])
    away = ~world.navigator.leg_is_done
    torch.testing.assert_close(x.robot_guide[away], world.navigator.current_waypoint[away, :2])
    values = task_rewards(x, CONFIG)
    assert all(v.shape == (2,) and torch.isfinite(v).all() for v in values.values())


def test_a_negative_weight_is_refused():
    with pytest.raises(ValueError, match=r"reward\.height: -1.* valid: a number >= 0"):
        replace(CONFIG, height=-1.0)
