import json

import pytest
import torch
from lerobot.configs import FeatureType, PolicyFeature, PreTrainedConfig
from lerobot.policies.factory import get_policy_class
from policy_samples import HEAD, STATE, TASKS, make_config, make_frames, make_policy
from safetensors.torch import load_file, save_file

from hv_policy.modeling_hv import CheckpointError, HVPolicy


def act(policy: HVPolicy, frame: dict, tasks: list[str]) -> torch.Tensor:
    return policy.select_action({**frame, "task": tasks})


def roll(policy: HVPolicy, frames: list[dict], tasks: list[list[str]]) -> list[torch.Tensor]:
    policy.reset()
    return [act(policy, frame, task) for frame, task in zip(frames, tasks, strict=True)]


def only(frame: dict, env: int) -> dict:
    return {key: value[env : env + 1] for key, value in frame.items()}


def test_lerobot_finds_the_policy_by_its_name():
    assert get_policy_class("hv") is HVPolicy


def test_learns_which_part_of_the_picture_an_instruction_is_about():
    """Two lamps, each on or off: the instruction says which one decides the first action, the state the second."""
    policy = make_policy(memory_frames=0, with_stats=False)
    policy.train()
    optimizer = torch.optim.AdamW(policy.get_optim_params(), lr=policy.config.optimizer_lr)
    generator = torch.Generator().manual_seed(1)

    def sample(count: int) -> dict:
        asked, left, right, turn = torch.randint(2, (4, count), generator=generator)
        pictures = 0.2 * torch.rand(count, 3, 64, 64, generator=generator)
        pictures[left == 1, :, 32:48, 0:16] += 0.7
        pictures[right == 1, :, 16:32, 32:48] += 0.7
        state = 0.1 * torch.randn(count, 223, generator=generator)
        state[:, 200] = turn * 2.0 - 1
        action = torch.zeros(count, 28)
        action[:, 0] = torch.where(asked == 1, left, right) * 2.0 - 1
        action[:, 1] = turn * 2.0 - 1
        return {HEAD: pictures, STATE: state, "action": action, "task": [TASKS[i] for i in asked]}

    for _ in range(130):
        loss, _ = policy(sample(32))
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
    policy.eval()
    batch = sample(200)
    predicted = policy.predict_action_chunk(batch)[:, 0]
    right = predicted[:, :2].sign() == batch["action"][:, :2].sign()
    assert right.float().mean(0).min() > 0.9


def test_memory_is_what_training_showed(trained_like_policy: HVPolicy):
    """Acting step by step and the training view with past frames give the same action."""
    policy, frames = trained_like_policy, make_frames(envs=2, steps=7)
    acted = roll(policy, frames, [TASKS] * 7)
    for now in (2, 3, 6):
        steps = [now - 4, now - 2, now]
        batch = {key: torch.stack([frames[max(step, 0)][key] for step in steps], 1) for key in (HEAD, STATE)}
        batch[f"{STATE}_is_pad"] = torch.tensor([[step < 0 for step in steps]] * 2)
        batch |= {"task": TASKS, "action": acted[now]}
        _, info = policy(batch)
        assert info["action_error"] < 1e-5
    batch[f"{STATE}_is_pad"][:, 0] = True  # and the memory does matter
    assert policy(batch)[1]["action_error"] > 1e-4


def test_environments_do_not_see_each_other(trained_like_policy: HVPolicy):
    frames = make_frames(envs=3, steps=8)
    tasks = [[TASKS[0], TASKS[step >= 4], TASKS[1]] for step in range(8)]
    together = roll(trained_like_policy, frames, tasks)
    for env in range(3):
        alone = roll(trained_like_policy, [only(f, env) for f in frames], [[t[env]] for t in tasks])
        for step in range(8):
            torch.testing.assert_close(together[step][env], alone[step][0], atol=1e-5, rtol=1e-5)


def test_a_new_instruction_flushes_that_environment_alone(trained_like_policy: HVPolicy):
    frames = make_frames(envs=2, steps=8)
    kept = roll(trained_like_policy, frames, [[TASKS[0]] * 2] * 8)
    switched = roll(trained_like_policy, frames, [[TASKS[0], TASKS[step >= 4]] for step in range(8)])
    fresh = roll(trained_like_policy, frames[4:], [[TASKS[0], TASKS[1]]] * 4)
    for step in range(4, 8):
        torch.testing.assert_close(switched[step][0], kept[step][0], atol=1e-5, rtol=1e-5)
        torch.testing.assert_close(switched[step][1], fresh[step - 4][1], atol=1e-5, rtol=1e-5)


def test_nothing_leaks_over_a_reset(trained_like_policy: HVPolicy):
    frames = make_frames(envs=1, steps=5)
    first = roll(trained_like_policy, frames, [TASKS[:1]] * 5)
    roll(trained_like_policy, make_frames(envs=1, steps=9, seed=5), [TASKS[:1]] * 9)
    again = roll(trained_like_policy, frames, [TASKS[:1]] * 5)
    for before, after in zip(first, again, strict=True):
        torch.testing.assert_close(before, after, atol=0, rtol=0)


def test_instruction_read_while_training_is_read_again_after(trained_like_policy: HVPolicy):
    policy, frame = make_policy().eval(), make_frames(1, 1)[0]
    before = act(policy, frame, TASKS[:1])
    policy.train()
    with torch.no_grad():
        policy.network.text.word.weight.mul_(-1.0)
    policy.eval()
    assert not torch.allclose(before, act(policy, frame, TASKS[:1]))


def test_single_frames_and_uint8_pictures_will_do():
    policy, frame = make_policy().eval(), make_frames(2, 1)[0]
    frame[HEAD] = (frame[HEAD] * 255).round() / 255
    as_bytes = {**frame, HEAD: (frame[HEAD] * 255).round().byte()}
    policy.reset()
    torch.testing.assert_close(
        policy.predict_action_chunk({**frame, "task": TASKS}), policy.predict_action_chunk({**as_bytes, "task": TASKS})
    )
    loss, _ = policy({**frame, "task": TASKS, "action": torch.zeros(2, 28)})
    assert loss.isfinite()


def test_loss_per_sample_averages_to_the_loss(trained_like_policy: HVPolicy):
    batch = {**make_frames(4, 1)[0], "task": TASKS * 2, "action": torch.randn(4, 28)}
    per_sample, _ = trained_like_policy(batch, reduction="none")
    assert per_sample.shape == (4,)
    torch.testing.assert_close(per_sample.mean(), trained_like_policy(batch)[0])


def test_entries_that_never_vary_do_not_blow_up(trained_like_policy: HVPolicy):
    units = trained_like_policy.network.state_units
    assert units.std.min() == trained_like_policy.config.min_std  # the data's first deviation is 0
    assert units.std[-1] == 2


def test_every_weight_is_trained_but_those_of_the_word_features():
    policy = make_policy(memory_dropout=0.0)
    frames = make_frames(4, 3)
    batch = {key: torch.stack([f[key] for f in frames], 1) for key in (HEAD, STATE)}
    batch |= {"action": torch.randn(4, 28), "task": TASKS * 2}
    policy.train()
    policy(batch)[0].backward()
    frozen = {name for name, _ in policy.named_parameters() if name.startswith("network.text.features.")}
    unused = {name for name, p in policy.named_parameters() if p.grad is None or not p.grad.any()}
    assert unused == frozen != set()
    groups = policy.get_optim_params()
    assert sum(len(group["params"]) for group in groups) == len(list(policy.parameters())) - len(frozen)


def test_saved_and_loaded_policy_acts_the_same(tmp_path):
    policy = make_policy().eval()
    policy.save_pretrained(tmp_path)
    # the next dataset's statistics and words must not replace those of the checkpoint
    other = {"action": {"mean": torch.ones(28), "std": torch.ones(28)}}
    config = PreTrainedConfig.from_pretrained(tmp_path)
    config.pretrained_path = tmp_path
    loaded = HVPolicy.from_pretrained(tmp_path, config=config, dataset_stats=other)
    assert loaded.config.vocabulary == policy.config.vocabulary != []
    frames = make_frames(2, 4)
    for before, after in zip(roll(policy, frames, [TASKS] * 4), roll(loaded, frames, [TASKS] * 4), strict=True):
        torch.testing.assert_close(before, after, atol=0, rtol=0)


@pytest.mark.parametrize(
    ("damage", "line"),
    [
        ("missing", r"network\.join\.bias is missing; it was made with another configuration"),
        ("unexpected", r"extra is not part of this policy"),
        ("shape", r"network\.join\.bias has shape \(3,\) instead of \(512,\)"),
    ],
)
def test_a_checkpoint_that_does_not_fit_is_refused_in_one_line(tmp_path, damage: str, line: str):
    make_policy().save_pretrained(tmp_path)
    weights = load_file(tmp_path / "model.safetensors")
    if damage == "missing":
        del weights["network.join.bias"]
    elif damage == "unexpected":
        weights["extra"] = torch.zeros(1)
    else:
        weights["network.join.bias"] = torch.zeros(3)
    save_file(weights, tmp_path / "model.safetensors")
    with pytest.raises(CheckpointError, match=line) as error:
        HVPolicy.from_pretrained(tmp_path)
    assert "\n" not in str(error.value)


def test_a_checkpoint_of_another_size_is_refused(tmp_path):
    make_policy().save_pretrained(tmp_path)
    settings = json.loads((tmp_path / "config.json").read_text())
    (tmp_path / "config.json").write_text(json.dumps(settings | {"size": "base"}))
    with pytest.raises(CheckpointError, match=r"and \d+ more\); it was made with another configuration"):
        HVPolicy.from_pretrained(tmp_path)


@pytest.mark.parametrize("content", [None, b"", b"not safetensors at all"])
def test_a_broken_file_is_refused_in_one_line(tmp_path, content: bytes | None):
    make_policy().save_pretrained(tmp_path)
    (tmp_path / "model.safetensors").unlink()
    if content is not None:
        (tmp_path / "model.safetensors").write_bytes(content)
    with pytest.raises(CheckpointError, match="cannot be read") as error:
        HVPolicy.from_pretrained(tmp_path)
    assert "\n" not in str(error.value)


def test_a_missing_camera_is_named(trained_like_policy: HVPolicy):
    frame = {STATE: torch.zeros(1, 223), "task": TASKS[:1]}
    with pytest.raises(ValueError, match=r"observation: observation\.images\.head is missing"):
        trained_like_policy.select_action(frame)


def test_several_cameras_of_different_sizes():
    features = {
        HEAD: PolicyFeature(FeatureType.VISUAL, (3, 64, 64)),
        "observation.images.wrist": PolicyFeature(FeatureType.VISUAL, (3, 48, 80)),
        STATE: PolicyFeature(FeatureType.STATE, (7,)),
    }
    policy = HVPolicy(make_config(input_features=features)).eval()
    frame = {HEAD: torch.rand(2, 3, 64, 64), "observation.images.wrist": torch.rand(2, 3, 48, 80)}
    assert policy.select_action({**frame, STATE: torch.zeros(2, 7), "task": TASKS}).shape == (2, 28)
