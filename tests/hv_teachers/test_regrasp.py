"""Taking boxes that lie on any of their sides."""

import numpy as np
import torch
from scipy.spatial.transform import Rotation

from hv_teachers.regrasp import WIDEST_M, grip_ahead, regrasp


def test_hands_touch_opposite_upright_faces_left_and_right_of_the_robot():
    rng = np.random.default_rng(0)
    n = 200
    half = torch.tensor(rng.uniform(0.08, 0.24, (n, 3)), dtype=torch.float32)
    sides = [Rotation.from_euler("xyz", e) for e in ([0, 0, 0], [np.pi / 2, 0, 0], [0, np.pi / 2, 0], [np.pi, 0, 0])]
    turned = [Rotation.from_euler("z", a) * sides[i % 4] for i, a in enumerate(rng.uniform(-np.pi, np.pi, n))]
    rot = torch.tensor(np.stack([t.as_matrix() for t in turned]), dtype=torch.float32)
    pos = torch.tensor(rng.uniform(-2, 2, (n, 3)), dtype=torch.float32)
    pos[:, 2] = (rot.abs() @ half[..., None])[:, 2, 0]
    robot = pos[:, :2] + torch.tensor(rng.uniform(-2, 2, (n, 2)), dtype=torch.float32)
    way = regrasp(pos, rot, half, torch.full((n,), 0.04), robot)
    touch = (rot[:, None] @ way.local[..., None])[..., 0] + pos[:, None]
    facing = torch.stack([way.stand[:, 2].cos(), way.stand[:, 2].sin()], -1)
    left = torch.stack([-facing[:, 1], facing[:, 0]], -1)
    right_hand, left_hand = touch[:, 0, :2] - pos[:, :2], touch[:, 1, :2] - pos[:, :2]
    # opposite each other across the view, as high as each other and not below the centre
    beyond = (left_hand * facing).sum(-1)
    middle = beyond[:, None] * facing
    torch.testing.assert_close(right_hand - middle, middle - left_hand, atol=1e-4, rtol=0)
    assert ((left_hand * left).sum(-1) > 0.07).all()
    # a little beyond the middle, so that the box does not lean away
    torch.testing.assert_close(beyond, grip_ahead(way.depth_m / 2), atol=1e-4, rtol=0)
    assert (beyond > 0.04).all()
    assert beyond.max() <= 0.055 + 1e-4
    assert (touch[:, :, 2] >= pos[:, None, 2] - 1e-5).all()
    assert (2 * (left_hand * left).sum(-1) <= WIDEST_M + 1e-5).all()
    # the robot stands before the box and looks at it
    ahead = ((pos[:, :2] - way.stand[:, :2]) * facing).sum(-1)
    assert (ahead > 0.35).all()
    assert ((pos[:, :2] - way.stand[:, :2]) - ahead[:, None] * facing).norm(dim=-1).max() < 1e-4
    # of the four sides it is one that it need not walk around the box for
    toward = torch.nn.functional.normalize(pos[:, :2] - robot, dim=-1)
    assert ((toward * facing).sum(-1) > 0.7).all()
