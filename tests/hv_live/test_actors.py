import pytest
import torch
from policy_samples import HEAD, STATE, make_policy

from hv_live import actors
from hv_live.actors import Cast
from hv_live.simulation import Simulation


@pytest.fixture(scope="module")
def checkpoint(tmp_path_factory):
    """An untrained `hv` policy as LeRobot saves it."""
    from lerobot.configs import FeatureType, PolicyFeature

    from hv_policy.processor_hv import make_hv_pre_post_processors

    folder = tmp_path_factory.mktemp("hv") / "my_policy"
    seen = {HEAD: PolicyFeature(FeatureType.VISUAL, (3, 128, 128)), STATE: PolicyFeature(FeatureType.STATE, (223,))}
    policy = make_policy(input_features=seen)
    policy.save_pretrained(folder)
    before, after = make_hv_pre_post_processors(policy.config)
    before.save_pretrained(folder)
    after.save_pretrained(folder)
    return folder


def test_without_the_students_weights_the_teacher_plays_and_it_is_said(monkeypatch, tmp_path):
    monkeypatch.setattr(actors, "SHIPPED_STUDENT", tmp_path)
    cast = Cast("student")
    assert cast.first == "teacher"
    assert "student" in cast.warning
    assert cast.missing == ["student"]
    assert cast.names == ["teacher", "planner"]
    assert Cast("planner").warning == ""


def test_the_students_weights_are_taken_where_they_are(monkeypatch, checkpoint):
    monkeypatch.setattr(actors, "SHIPPED_STUDENT", checkpoint)
    cast = Cast("student")
    assert (cast.first, cast.warning, cast.missing) == ("student", "", [])


def test_a_checkpoint_plays_through_select_action(monkeypatch, checkpoint):
    """It is asked once a control step, with its camera, its state and the words in force."""
    asked = []
    cast = Cast(str(checkpoint))
    assert cast.first == "my_policy"
    assert cast.names == ["my_policy", "student", "teacher", "planner"]
    policy = cast.get("my_policy")._policy.policy
    select_action = policy.select_action
    monkeypatch.setattr(policy, "select_action", lambda batch: asked.append(batch) or select_action(batch))
    with Simulation("living_room_1", cast) as live:
        live.step()
        live.instruct("please wave at me")
        live.step()
    first, second = asked
    assert first[HEAD].shape == (1, 3, 128, 128)
    assert float(first[HEAD].std()) > 0.02
    assert first[STATE].shape == (1, 223)
    assert list(second["task"]) == ["please wave at me"]
    assert not torch.equal(first[STATE], second[STATE])


def test_what_is_wrong_is_said_at_once(tmp_path):
    with pytest.raises(ValueError, match="nobody"):
        Cast("nobody")
    with pytest.raises(ValueError, match="policy"):
        Cast(str(tmp_path))
    with pytest.raises(ValueError, match="valid: student, teacher, planner"):
        Cast("teacher").get("somebody")
