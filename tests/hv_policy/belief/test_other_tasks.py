import torch

from hv_policy.belief.other_tasks import SHAPES, choose_tasks, sentence


def test_sentences_name_the_thing_and_the_spot_and_nothing_twice():
    told = [sentence("the red bin", "to the left of the sofa", k) for k in range(len(SHAPES))]
    assert len(set(told)) == len(SHAPES)
    for line in told:
        assert line.count("the red bin") == line.count("to the left of the sofa") == 1
        assert "  " not in line


def test_only_what_has_a_name_is_asked_for_and_mostly_what_is_small_and_in_view():
    torch.manual_seed(0)
    has_name = torch.tensor([True, True, True, False]).expand(2000, -1)
    in_view = torch.tensor([True, False, False, True]).expand(2000, -1)
    half = torch.tensor([0.1, 0.1, 1.0, 0.1])[:, None].expand(2000, 4, 3)
    spots = torch.tensor([True, False]).expand(2000, -1)
    thing, spot, shape, exists = choose_tasks(has_name, in_view, half, spots)
    share = torch.bincount(thing, minlength=4) / 2000
    assert share[3] == 0
    assert share[0] > 0.5 > share[1] > share[2] >= 0
    assert (spot == 0).all()
    assert exists.all()
    assert len(shape.unique()) == len(SHAPES)
    assert not choose_tasks(has_name, in_view, half, torch.zeros_like(spots))[3].any()
    assert not choose_tasks(torch.zeros_like(has_name), in_view, half, spots)[3].any()
