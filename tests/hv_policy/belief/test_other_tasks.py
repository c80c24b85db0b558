import torch

from hv_policy.belief.mirror import mirrored_text
from hv_policy.belief.other_tasks import ALL_SHAPES, FROM_SHAPES, FROM_SHARE, SHAPES, choose_tasks, parts_of, sentence
from hv_policy.rewording import Reworder, load_rewording
from hv_policy.text_encoder import split_words


def filled(shape: int) -> str:
    return sentence(shape, thing="the red bin", spot="to the left of the sofa", other="on the desk")


def test_sentences_name_the_thing_and_the_spot_and_nothing_twice():
    told = [filled(k) for k in range(len(ALL_SHAPES))]
    assert len(set(told)) == len(ALL_SHAPES)
    for k, line in enumerate(told):
        assert line.count("the red bin") == line.count("to the left of the sofa") == 1
        assert line.count("on the desk") == (ALL_SHAPES[k] in FROM_SHAPES)
        assert "  " not in line
        assert not set("{}") & set(line)


def test_shapes_are_taken_apart_as_they_are_put_together():
    assert parts_of("put {thing} {spot}, not {other}.") == (["put", "", ", not", "."], ["thing", "spot", "other"])
    assert parts_of("{thing} goes {spot}.") == (["", "goes", "."], ["thing", "spot"])


def test_they_are_what_instructions_are_reworded_to():
    reworder = Reworder(load_rewording())
    for k in range(len(ALL_SHAPES)):
        told = sentence(k, thing="the red trash bin", spot="just to the left of the sofa", other="on the desk")
        assert split_words(reworder.say(told)) == split_words(told)


def test_shapes_are_the_same_in_the_mirror():
    for k in range(len(ALL_SHAPES)):
        told = sentence(k, thing="the bin", spot="on the desk", other="in front of the sofa")
        assert mirrored_text(told) == told


def test_only_what_has_a_name_is_asked_for_and_mostly_what_is_small_and_in_view():
    torch.manual_seed(0)
    has_name = torch.tensor([True, True, True, False]).expand(2000, -1)
    in_view = torch.tensor([True, False, False, True]).expand(2000, -1)
    half = torch.tensor([0.1, 0.1, 1.0, 0.1])[:, None].expand(2000, 4, 3)
    spots = torch.tensor([True, True, False]).expand(2000, -1)
    thing, spot, other, shape, exists = choose_tasks(has_name, in_view, half, spots)
    share = torch.bincount(thing, minlength=4) / 2000
    assert share[3] == 0
    assert share[0] > 0.5 > share[1] > share[2] >= 0
    assert torch.bincount(spot, minlength=3)[2] == 0
    assert ((spot + other) == 1).all()  # the two that there are
    assert exists.all()
    assert len(shape.unique()) == len(ALL_SHAPES)
    assert abs(shape.float().mean() - FROM_SHARE) < 0.05
    one = spots & torch.tensor([True, False, False])
    assert (choose_tasks(has_name, in_view, half, one)[3] < len(SHAPES)).all()
    assert not choose_tasks(has_name, in_view, half, torch.zeros_like(spots))[4].any()
    assert not choose_tasks(torch.zeros_like(has_name), in_view, half, spots)[4].any()
