"""What is said of a piece of furniture says where the goals beside it are, as tasks mean them."""

import pytest
import torch

from hv_policy.belief.landmark_head import OFFSETS, LandmarkHead, Piece, landmark_loss
from hv_policy.rewording import RELATIONS
from hv_sim.furniture import FURNITURE_KINDS
from hv_sim.furniture_kinds.kind import WHOLE_TOP
from hv_sim.places import BESIDE, BY_THE_MIDDLE, ON, Place, layout_at
from hv_sim.suites import load_suite


def piece_of(boxes: torch.Tensor) -> Piece:
    nothing = torch.zeros(boxes.shape[:-1])
    front = torch.stack([boxes[..., 6].cos(), boxes[..., 6].sin()], -1)
    return Piece(boxes[..., :2], boxes[..., 3:6], front, nothing, nothing)


def test_spots_are_those_that_tasks_mean():
    checked = dict.fromkeys(OFFSETS, 0)
    for task in load_suite("seen")[::40]:
        layout, name = layout_at(task, 0), task.subtasks[0].object
        half = float(max(layout.half_extents_m[name][:2]))
        for placed in task.furniture:
            kind = FURNITURE_KINDS[placed.kind]
            depth, width, height = placed.size_m or kind.size_m
            row = [*placed.position_m, height / 2, depth / 2, width / 2, height / 2, placed.yaw_rad]
            piece = piece_of(torch.tensor([[row]], dtype=torch.float64))
            for relation in (*ON, *BESIDE, *BY_THE_MIDDLE):
                meant = layout.spot_m(Place(relation, placed.name), name)
                if meant is None or (relation in ON and kind.top != WHOLE_TOP):
                    continue
                offset = torch.tensor(OFFSETS[relation], dtype=torch.float64)
                spot = piece.spot(offset, torch.tensor(half, dtype=torch.float64))[0, 0]
                assert spot.tolist() == pytest.approx(meant, abs=1e-6), (placed.kind, relation)
                checked[relation] += 1
    assert all(count > 2 for relation, count in checked.items() if relation != "behind"), checked
    assert set(OFFSETS) <= set(RELATIONS)


def test_the_loss_is_least_for_the_truth():
    boxes = torch.tensor([[[2.0, 0.5, 0.4, 0.3, 0.6, 0.4, 0.7], [1.0, -1.0, 0.5, 0.2, 0.5, 0.5, -2.0]]])
    known = torch.ones(1, 2, dtype=torch.bool)
    truth = piece_of(boxes)
    least, apart = landmark_loss(truth, boxes, known, known)
    assert float(apart.max()) < 2e-3
    for change in ([0.5, 0, 0, 0, 0, 0, 0], [0, 0, 0, 0.2, 0, 0, 0], [0, 0, 0, 0, 0.3, 0, 0], [0, 0, 0, 0, 0, 0, 1.6]):
        wrong, off = landmark_loss(piece_of(boxes + torch.tensor(change)), boxes, known, known)
        assert float(wrong) > float(least) + 0.05, change
        assert float(off.mean()) > 0.05, change


def test_pieces_without_a_name_and_out_of_view_teach_nothing_of_where_they_are():
    boxes = torch.rand(1, 3, 7) + 0.2
    in_view, has_name = torch.tensor([[True, False, True]]), torch.tensor([[True, True, False]])
    losses = []
    for far in (0.0, 5.0):
        piece = piece_of(boxes + far * torch.tensor([0.0, 1.0, 1.0])[None, :, None] * torch.eye(7)[0])
        losses.append(float(landmark_loss(piece, boxes, in_view, has_name)[0]))
    assert losses[0] == losses[1]


def test_a_few_pieces_are_learned():
    torch.manual_seed(0)
    head = LandmarkHead(16)
    tokens, rays, named = torch.randn(4, 64, 16), torch.randn(4, 64, 10), torch.randn(4, 2, 16)
    shows = torch.randn(4, 2, 64) * 3
    boxes = torch.rand(4, 2, 7) * torch.tensor([3.0, 3.0, 1.0, 0.5, 0.8, 0.8, 3.0]) + 0.1
    known = torch.ones(4, 2, dtype=torch.bool)
    optimizer = torch.optim.Adam(head.parameters(), lr=3e-3)
    for _ in range(300):
        loss, apart = landmark_loss(head(tokens, rays, named, shows), boxes, known, known)
        optimizer.zero_grad()
        loss.mean().backward()
        optimizer.step()
    assert float(apart.median()) < 0.15
