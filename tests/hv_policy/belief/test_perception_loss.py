"""What is learned besides the places of the task: what can be carried, and what is not there."""

from types import SimpleNamespace

import pytest
import torch

from hv_policy.belief.boxes import MOVABLE_HALF_M
from hv_policy.belief.landmark_head import Piece
from hv_policy.belief.perception_loss import movable_loss, pieces_loss


def boxes_of(*rows: list[float]) -> torch.Tensor:
    return torch.tensor([rows])


def test_what_can_be_carried_is_narrow_however_high_it_is():
    lamp, fridge = [1.0, 0, 0.8, 0.15, 0.15, 0.8, 0.0], [2.0, 0, 0.9, 0.3, 0.3, 0.9, 0.0]
    label = torch.tensor([[0, 1, -1, 0]])
    for logits, missed, imagined in (([9.0, -9, -9, 9], 0, 0), ([-9.0, -9, -9, 9], 0.5, 0), ([9.0, 9, -9, 9], 0, 0.5)):
        perception = SimpleNamespace(find_movable=lambda sight, logits=logits: torch.tensor([logits]))
        loss, figures = movable_loss(perception, None, label, boxes_of(lamp, fridge))
        assert float(figures["movable_missed"]) == missed
        assert float(figures["movable_imagined"]) == imagined
        assert float(loss) == pytest.approx(9.0 / 4 * (missed > 0 or imagined > 0), abs=1e-3)
    assert 0.15 < MOVABLE_HALF_M < 0.3


def test_names_of_what_is_elsewhere_are_asked_for_and_teach_that_it_is_not_there():
    torch.manual_seed(0)
    boxes, seen = boxes_of([1.0, 0, 0.4, 0.4, 0.4, 0.4, 0.0]), []

    def find_pieces(sight, named):
        seen.append(named[0, :, 0].tolist())
        n = named.shape[1]
        logit = torch.where(named[..., 0] < 1, 20.0, -20.0)  # 0 is the thing that is there
        front = torch.tensor([1.0, 0.0]).expand(1, n, 2)
        return Piece(torch.tensor([1.0, 0.0]).expand(1, n, 2), torch.full((1, n, 3), 0.4), front, 0 * logit - 4, logit)

    perception, names = SimpleNamespace(find_pieces=find_pieces), torch.arange(4.0)[None, :, None]
    in_view, asked = torch.tensor([[True]]), torch.tensor([[True, True, False, True]])
    _, figures = pieces_loss(perception, SimpleNamespace(), names, boxes, in_view, asked)
    assert {0.0, 1.0, 3.0} <= set(seen[0])
    assert float(figures["pieces_missed"]) == float(figures["pieces_imagined"]) == 0.0
    _, figures = pieces_loss(perception, SimpleNamespace(), names - 3, boxes, in_view, asked)
    assert float(figures["pieces_imagined"]) == 1.0
