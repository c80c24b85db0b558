"""What is pointed at as an object is something that can be carried."""

import torch
from policy_samples import make_config

from hv_policy.belief.perception import GOAL_QUERY, OBJECT_QUERY, NamedSpots, Perception
from hv_policy.belief.perception_size import PERCEPTIONS


def test_objects_are_not_pointed_at_where_nothing_can_be_carried_and_goals_are_as_before():
    torch.manual_seed(0)
    config = make_config(form="belief")
    perception = Perception(
        PERCEPTIONS[config.size], config.image_size, config.vocabulary, config.max_words, 0.0
    ).eval()
    words, is_word = perception.text(["put the box on the table.", "put the vase on the sofa."])
    named = NamedSpots([OBJECT_QUERY, GOAL_QUERY], *perception.text(["the box", "the sofa"] * 2))

    def pointing(shows_movable: torch.Tensor) -> torch.Tensor:
        perception.find_movable = lambda sight: shows_movable.expand(len(sight.tokens), -1)  # type: ignore[method-assign]
        with torch.no_grad():
            sight = perception.look(pictures, state)
            seen = perception.judge(sight, words, is_word, named)
        return torch.cat([seen.pointing, seen.spots], 1).exp()

    pictures, state = torch.rand(2, 3, config.image_size, config.image_size), torch.zeros(2, 223)
    with torch.no_grad():
        count = perception.look(pictures, state).tokens.shape[1]
    everywhere, left = torch.full((count,), 30.0), torch.where(torch.arange(count) % 2 == 0, 30.0, -30.0)
    all_of_it, half = pointing(everywhere), pointing(left)
    objects, goals = [OBJECT_QUERY, -2], [GOAL_QUERY, -1]
    assert (half[:, objects, 2::2] < 1e-6).all()
    assert (all_of_it[:, objects, 2::2] > 1e-6).any()
    ratio = half[:, objects, 1::2] / half[:, objects, :1]
    torch.testing.assert_close(ratio, all_of_it[:, objects, 1::2] / all_of_it[:, objects, :1])
    torch.testing.assert_close(half[:, goals], all_of_it[:, goals])
