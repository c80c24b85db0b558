import pytest
from lerobot.configs import NormalizationMode, PreTrainedConfig

from hv_policy.configuration_hv import ARCHITECTURES, HVConfig


def test_memory_frames_are_read_from_the_dataset():
    direct = HVConfig(device="cpu", form="direct", memory_frames=2, memory_stride=6)
    assert direct.observation_delta_indices == [-12, -6, 0]
    assert HVConfig(device="cpu", memory_frames=0).observation_delta_indices is None
    assert HVConfig(device="cpu").action_delta_indices is None


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"form": "spiral"}, "form: 'spiral' is none of belief, direct"),
        ({"size": "huge"}, "size: 'huge' is none of small, base"),
        ({"image_size": 100}, "image_size: 100 is not a multiple of 16 from 32 on"),
        ({"memory_stride": 0}, "memory_stride: 0 is less than 1"),
        ({"word_dropout": 1.0}, "word_dropout: 1.0 is not in"),
        ({"n_obs_steps": 2}, "n_obs_steps: 2 is not 1"),
        ({"min_std": 0.0}, "min_std, clip_state"),
        ({"normalization_mapping": {"STATE": NormalizationMode.MEAN_STD}}, "normalization_mapping: hv normalises"),
    ],
)
def test_bad_values_are_named_in_one_line(changes: dict, line: str):
    with pytest.raises(ValueError, match=line) as error:
        HVConfig(device="cpu", **changes)
    assert "\n" not in str(error.value)


def test_survives_saving(tmp_path):
    config = HVConfig(device="cpu", size="base", vocabulary=["box", "the"], memory_frames=1)
    config._save_pretrained(tmp_path)
    loaded = PreTrainedConfig.from_pretrained(tmp_path)
    assert isinstance(loaded, HVConfig)
    assert loaded == config
    assert loaded.architecture is ARCHITECTURES["base"]


def test_features_must_hold_camera_state_and_action():
    with pytest.raises(ValueError, match="no camera among none"):
        HVConfig(device="cpu").validate_features()
