"""Learning to mark sentences, for a moment."""

import pytest
import torch

from hv_policy.rewording import load_rewording
from hv_scripts.thesaurus import THINGS
from hv_scripts.train_rewording import lexicon, main, train
from hv_sim.lexicon import object_nouns
from hv_sim.objects import OBJECT_KINDS


def test_it_learns_and_the_same_seed_learns_the_same():
    first, wrong = train(1000, 12, seed=1)
    again, _ = train(1000, 12, seed=1)
    _, at_first = train(1000, 1, seed=1)
    assert wrong < 0.7 * at_first
    assert all(torch.equal(a, b) for a, b in zip(first.state_dict().values(), again.state_dict().values(), strict=True))


def test_known_words_keep_their_names_and_others_get_the_first_one():
    known = lexicon()
    for kind, more in THINGS.items():
        nouns = object_nouns(kind)
        assert known.things[nouns[0]] == nouns[0]
        assert all(word in known.things for word in more.split("|"))
    assert known.things["dustbin"] == "trash bin"
    assert known.landmarks["chesterfield"] == "sofa"
    held_out = {noun for kind, spec in OBJECT_KINDS.items() if spec.held_out for noun in object_nouns(kind)}
    assert not held_out & set(known.things)


def test_the_shipped_one_knows_these_words():
    shipped, known = load_rewording().lexicon, lexicon()
    assert shipped.things.keys() <= known.things.keys() | {""}
    assert shipped.colors.items() <= known.colors.items()


@pytest.mark.parametrize("option", [["--sentences", "10"], ["--epochs", "0"]])
def test_too_little_is_refused(option, capsys):
    with pytest.raises(SystemExit) as refused:
        main(option)
    assert refused.value.code == 2
    assert "valid: at least" in capsys.readouterr().err
