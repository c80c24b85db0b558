"""What is said in other words is said again in known ones, judged by the grammar that instructions are written with."""

import pytest
import torch

from hv_policy.belief.mirror import mirrored_text
from hv_policy.rewording import (
    RELATIONS,
    SHIPPED_REWORDING,
    Lexicon,
    Reworder,
    Rewording,
    RewordingConfig,
    load_rewording,
    save_rewording,
)
from hv_policy.word_features import load_word_features
from hv_sim.grounding import ground
from hv_sim.lexicon import PLACE_WORDS
from hv_sim.objects import OBJECT_KINDS
from hv_sim.places import layout_at
from hv_sim.suites import load_suite


@pytest.fixture(scope="module")
def reworder() -> Reworder:
    return Reworder(load_rewording())


def understood(reworder: Reworder, suite: str, count: int) -> tuple[float, float]:
    """How often what is said again means the object, of kinds that seen tasks have, and the goal."""
    objects, goals = [], []
    for task in load_suite(suite)[:count]:
        kinds = {o.name: OBJECT_KINDS[o.kind] for o in task.objects}
        for i, subtask in enumerate(task.subtasks):
            layout = layout_at(task, i)
            for text in subtask.phrasings:
                meant = ground(reworder.say(text), layout)
                goals.append(any(layout.is_goal(p, subtask.object, subtask.goal_position_m) for p in meant.goals))
                if not kinds[subtask.object].held_out:
                    objects.append(subtask.object in meant.objects)
    return sum(objects) / len(objects), sum(goals) / len(goals)


def test_seen_instructions_mean_what_they_meant(reworder):
    objects, goals = understood(reworder, "seen", 80)
    assert objects > 0.96
    assert goals > 0.96


def test_unseen_instructions_are_understood_in_words_and_shapes_that_were_never_taught(reworder):
    objects, goals = understood(reworder, "unseen", 66)
    assert objects > 0.9
    assert goals > 0.82


@pytest.mark.parametrize(
    ("said", "wanted"),
    [
        (
            "hey robot, could you grab that blue suitcase over there and stick it right in front of the wardrobe?",
            "put the blue suitcase just in front of the wardrobe.",
        ),
        ("the plant should live on the right end of the sofa", "put the plant on the right side of the sofa."),
        ("the old radio, not the speaker, goes on the bookshelf", "put the radio on the bookshelf."),
        (
            "Take the kettle from the stove and set it down on the left side of the countertop.",
            "put the kettle on the left side of the countertop.",
        ),
        ("please carry my luggage to the middle of the room", "put the suitcase exactly in the middle of the room."),
        (
            "bring the vase from the right of the sofa to the left of the sofa",
            "put the vase just to the left of the sofa.",
        ),
        (
            "bring the vase from the left of the sofa to the right of the sofa",
            "put the vase just to the right of the sofa.",
        ),
        ("Would you kindly pop the cushion on the armchair?", "put the cushion on the armchair."),
    ],
)  # fmt: skip
def test_typed_by_hand(reworder, said, wanted):
    assert reworder.say(said) == wanted


@pytest.mark.parametrize("text", ["", "hello", "what time is it?", "mettez la lampe sur la table", "x" * 10_000])
def test_what_asks_for_nothing_stays_as_it_is(reworder, text):
    assert reworder.say(text) == text


def test_said_again_it_stays(reworder):
    once = [reworder.say(task.subtasks[0].instruction) for task in load_suite("unseen")]
    assert sum(reworder.say(text) == text for text in once) >= 0.9 * len(once)


def test_left_is_left_and_right_is_right(reworder):
    told = [task.subtasks[0].instruction for task in load_suite("seen")[:60]]
    same = [reworder.say(mirrored_text(text)) == mirrored_text(reworder.say(text)) for text in told]
    assert sum(same) >= 0.95 * len(same)


def test_places_are_said_as_seen_instructions_say_them():
    assert set(RELATIONS) == set(PLACE_WORDS)
    for relation, phrase in RELATIONS.items():
        assert phrase in PLACE_WORDS[relation][0]


def test_it_says_the_same_while_the_student_trains(reworder):
    text = "it would be nice to have the grey footstool on the left-hand end of the couch"
    said = reworder.say(text)
    again = Reworder(load_rewording().train())
    assert all(again._say(text) == said for _ in range(5))


def test_unknown_things_keep_their_names(reworder):
    assert reworder.say("Put the red xylophone on the desk.") == "put the red xylophone on the desk."


def test_a_file_holds_all_of_it(tmp_path):
    torch.manual_seed(0)
    lexicon = Lexicon({"bin": "bin"}, {"desk": "desk"}, {"red": "red"}, {"big": "large"}, ("the", "on"))
    network = Rewording(RewordingConfig(2, dim=16, heads=2, layers=1), lexicon).eval()
    network.look_up(load_word_features())
    save_rewording(network, tmp_path / "small.safetensors")
    again = load_rewording(tmp_path / "small.safetensors")
    assert again.lexicon == lexicon
    assert Reworder(again)._adjective(["big"], "sizes") == "large"
    assert again.number(["on", "of", "the"]) == [2, 0, 1]
    features, numbers = torch.randn(2, 5, 96), torch.zeros(2, 5, dtype=torch.long)
    is_word = torch.ones(2, 5, dtype=torch.bool)
    before = network.float()(features, numbers, is_word)
    for found, wanted in zip(again(features, numbers, is_word), before, strict=True):
        torch.testing.assert_close(found, wanted)


def test_another_file_is_refused():
    with pytest.raises(ValueError, match="format is"):
        load_rewording(SHIPPED_REWORDING.with_name("words.safetensors"))


def test_where_something_shall_go_is_known_by_itself(reworder):
    told = {
        "Put the lamp exactly in the middle of the room.": ("room_middle", ""),
        "Would you mind transferring the grey footstool to the exact centre of the room?": ("room_middle", ""),
        "Take the lamp that is exactly in the middle of the room and put it on the desk.": ("on", "desk"),
        "Put the lamp just to the left of the white sofa.": ("left_of", "sofa"),
        "Shift the lamp to a spot immediately in front of the centre of the couch.": ("front_middle", "couch"),
        "Put the lamp directly to the right of the suitcase.": ("right_of", ""),
        "Hello there.": ("", ""),
    }
    assert {text: reworder.goal(text) for text in told} == told
