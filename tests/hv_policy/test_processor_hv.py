import torch
from lerobot.policies.factory import make_pre_post_processors
from policy_samples import HEAD, STATE, make_config

STATS = {
    STATE: {"mean": torch.ones(223), "std": torch.ones(223) * 3},
    "action": {"mean": torch.ones(28), "std": torch.ones(28)},
}


def test_observations_pass_in_their_own_units_and_the_instruction_with_them():
    before, after = make_pre_post_processors(make_config(), dataset_stats=STATS)
    frame = {HEAD: torch.rand(3, 64, 64), STATE: torch.randn(223), "task": "Put the box down."}
    batch = before(dict(frame))
    torch.testing.assert_close(batch[STATE], frame[STATE].unsqueeze(0))
    torch.testing.assert_close(batch[HEAD], frame[HEAD].unsqueeze(0))
    assert batch["task"] == ["Put the box down."]
    torch.testing.assert_close(after(torch.full((1, 28), 0.2)), torch.full((1, 28), 0.2))


def test_the_steps_have_the_names_that_lerobot_overrides(tmp_path):
    before, after = make_pre_post_processors(make_config(), dataset_stats=STATS)
    before.save_pretrained(tmp_path)
    after.save_pretrained(tmp_path)
    overrides = {"device_processor": {"device": "cpu"}, "rename_observations_processor": {"rename_map": {}}}
    norm = {"stats": STATS, "features": make_config().input_features, "norm_map": make_config().normalization_mapping}
    before, after = make_pre_post_processors(
        make_config(),
        pretrained_path=str(tmp_path),
        preprocessor_overrides={**overrides, "normalizer_processor": norm},
        postprocessor_overrides={"unnormalizer_processor": norm},
    )
    state = torch.randn(2, 223)
    torch.testing.assert_close(before({STATE: state, "task": ["a", "b"]})[STATE], state)
