"""PPO with an adversarial motion prior (AMP, Peng et al. 2021) on rsl_rl; class_name: hv_teachers.amp:AmpPPO.

A discriminator learns to tell windows of ten frames of the motion set from the agent's; the agent is paid for passing:
r_style = -log(max(1 - D, .01)), at most max(r_task, .4) (HumanVLA), added to the task's reward 1 : 1.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import torch
from rsl_rl.algorithms import PPO
from rsl_rl.modules import EmpiricalNormalization
from rsl_rl.storage import RolloutStorage
from tensordict import TensorDict
from torch import Tensor, nn

from hv_teachers.ranks import Ranks
from hv_teachers.style import FRAME_DIM, WINDOW_FRAMES, MotionSet

WINDOW_DIM = WINDOW_FRAMES * FRAME_DIM


@dataclass(frozen=True)
class StyleConfig:
    """The discriminator, its training and its reward. Penalties as in public AMP code."""

    weight: float = 1.0
    """Of r_style beside the task's reward; 0 switches the discriminator off."""
    floor: float = 0.4
    """r_style is at most max(r_task, floor)."""
    hidden: tuple[int, ...] = (512, 256)
    learning_rate: float = 1e-4
    batches: int = 4
    """Discriminator steps an iteration."""
    batch_size: int = 512
    """Windows of each kind (motion set, agent now, agent before) in a step."""
    gradient_penalty: float = 5.0
    logit_regularization: float = 0.01
    replay_size: int = 200_000
    replay_keep: int = 1024
    """Windows of an iteration that go into the replay."""


class Discriminator(nn.Module):
    """Windows (N, 1310) -> logits (N,); the normaliser is shared by motion set and agent."""

    def __init__(self, hidden: tuple[int, ...]) -> None:
        super().__init__()
        self.normalizer = EmpiricalNormalization(WINDOW_DIM)
        layers: list[nn.Module] = []
        for i, o in itertools.pairwise([WINDOW_DIM, *hidden]):
            layers += [nn.Linear(i, o), nn.ReLU()]
        self.body = nn.Sequential(*layers)
        self.last = nn.Linear(hidden[-1], 1)

    def forward(self, windows: Tensor) -> Tensor:
        return self.score(self.normalizer(windows))

    def score(self, normalized: Tensor) -> Tensor:
        """Logits (N,) of windows that are normalised already."""
        return self.last(self.body(normalized))[:, 0]


def style_reward(logits: Tensor, task_reward: Tensor, floor: float) -> Tensor:
    """(N,) -log(max(1 - D, .01)) with D = sigmoid(logits), at most max(task_reward, floor)."""
    reward = -torch.log((1.0 - torch.sigmoid(logits)).clamp(min=0.01))
    return torch.minimum(reward, task_reward.clamp(min=floor))


def discriminator_loss(
    model: Discriminator, good: Tensor, agent: Tensor, config: StyleConfig
) -> tuple[Tensor, dict[str, float]]:
    """Binary cross-entropy with gradient penalties on both kinds and logit regularisation.

    Args:
        model: the discriminator.
        good: (B, 1310) windows of the motion set.
        agent: (C, 1310) windows of the agent.
        config: weights of the penalties.

    Returns:
        The loss, and what to log: `style_good` and `style_agent`, the mean D of each kind.
    """
    normalized = model.normalizer(torch.cat([good, agent])).detach().requires_grad_(True)
    logits = model.score(normalized)
    wanted = torch.zeros_like(logits)
    wanted[: len(good)] = 1.0
    each = nn.functional.binary_cross_entropy_with_logits(logits, wanted, reduction="none")
    loss = 0.5 * (each[: len(good)].mean() + each[len(good) :].mean())
    gradient = torch.autograd.grad(logits.sum(), normalized, create_graph=True)[0]
    squared = gradient.square().sum(-1)
    penalty = 0.5 * (squared[: len(good)].mean() + squared[len(good) :].mean())
    loss = loss + config.gradient_penalty * penalty
    loss = loss + config.logit_regularization * model.last.weight.square().sum()
    with torch.no_grad():
        d = torch.sigmoid(logits)
        shown = {"style_good": float(d[: len(good)].mean()), "style_agent": float(d[len(good) :].mean())}
    return loss, shown


class WindowReplay:
    """A ring of the agent's windows, half precision: 2.6 kB each."""

    def __init__(self, size: int) -> None:
        self.size = size
        self.windows = torch.empty(0, WINDOW_DIM, dtype=torch.float16)
        self.cursor = 0

    def add(self, windows: Tensor) -> None:
        """Adds (n, 1310); the oldest make room."""
        new = windows[-self.size :].to(torch.float16)
        free = self.size - len(self.windows)
        if free > 0:
            self.windows = torch.cat([self.windows, new[:free]])
            new = new[free:]
        if len(new):
            at = (self.cursor + torch.arange(len(new))) % self.size
            self.windows[at] = new
            self.cursor = int(self.cursor + len(new)) % self.size

    def sample(self, num: int) -> Tensor:
        """(num, 1310) float32, drawn with replacement."""
        return self.windows[torch.randint(len(self.windows), (num,))].float()


class MaskedRolloutStorage(RolloutStorage):
    """A storage that leaves some transitions out of the mini-batches: those in which somebody else acted.

    Mini-batches are drawn from the transitions of all processes; each yields its own of them.
    """

    def __init__(self, *args: Any, ranks: Ranks, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.ranks = ranks
        self.share = 1.0
        """Of the present mini-batch, what is here."""
        self.valid = torch.ones(self.num_transitions_per_env, self.num_envs, dtype=torch.bool)

    def mini_batch_generator(self, num_mini_batches: int, num_epochs: int = 8) -> Iterator[RolloutStorage.Batch]:
        """Shuffled mini-batches of the valid transitions.

        Where nothing of one is here, any row comes instead, and `share` is 0.
        """
        valid = self.ranks.gather(self.valid, 1).flatten().nonzero()[:, 0]
        size = max(1, len(valid) // num_mini_batches)
        flat = {name: getattr(self, name).flatten(0, 1) for name in ("observations", "actions", "values", "returns")}
        log_prob, advantages = self.actions_log_prob.flatten(0, 1), self.advantages.flatten(0, 1)
        assert self.distribution_params is not None
        parameters = [p.flatten(0, 1) for p in self.distribution_params]
        for _ in range(num_epochs):
            order = valid[torch.randperm(len(valid))]
            for i in range(num_mini_batches):
                numbers = order[i * size : (i + 1) * size]
                if len(numbers):
                    rows = self._here(numbers)
                    self.share = len(rows) / len(numbers)
                    rows = rows if len(rows) else torch.zeros(1, dtype=torch.int64)
                    yield RolloutStorage.Batch(
                        **{name: value[rows] for name, value in flat.items()},
                        advantages=advantages[rows],
                        old_actions_log_prob=log_prob[rows],
                        old_distribution_params=tuple(p[rows] for p in parameters),
                    )

    def _here(self, numbers: Tensor) -> Tensor:
        """Rows of this process among transitions `numbers` (B,) of all of them."""
        step = numbers // (self.ranks.count * self.num_envs)
        env = numbers % (self.ranks.count * self.num_envs) - self.ranks.rank * self.num_envs
        mine = (env >= 0) & (env < self.num_envs)
        return (step * self.num_envs + env)[mine]


class AmpPPO(PPO):
    """rsl_rl's PPO with a style reward.

    `extras` of `process_env_step` may hold `style_windows` (N, 1310), ending with the frame before any reset, and
    `valid` (N,) bool, the environments in which this policy acted (default: all).

    Args:
        motion_set: what good style looks like; None switches the style reward off.
        style: see `StyleConfig`.
        critic_learning_rate: the critic's own; None: as the actor's.
        reward_scale: of the sum of both rewards. rsl_rl's critic moves by at most its clip an update: returns must not
            be much larger than a few units, and rewards of .7 a step make returns of 70.
        ranks: the processes that train it, each with its own environments. Gradients are summed over them, weighed
            with their shares of a mini-batch; the discriminator sees the same windows in every process.
        others: rsl_rl's PPO.
    """

    def __init__(
        self,
        actor: nn.Module,
        critic: nn.Module,
        storage: RolloutStorage,
        motion_set: MotionSet | None = None,
        style: StyleConfig | None = None,
        critic_learning_rate: float | None = None,
        reward_scale: float = 1.0,
        ranks: Ranks | None = None,
        **others: Any,
    ) -> None:
        masked = MaskedRolloutStorage(
            "rl",
            storage.num_envs,
            storage.num_transitions_per_env,
            storage.observations[0],
            storage.actions_shape,
            storage.device,
            ranks=ranks or Ranks(),
        )
        self.ranks = masked.ranks
        super().__init__(actor, critic, masked, **others)
        if critic_learning_rate is not None:
            own = {"params": list(self.critic.parameters()), "lr": critic_learning_rate}
            self.optimizer = torch.optim.Adam([{"params": list(self.actor.parameters())}, own], lr=self.learning_rate)
        self.style = style or StyleConfig()
        self.reward_scale = reward_scale
        self.motion_set = motion_set if self.style.weight > 0 else None
        self.discriminator = Discriminator(self.style.hidden).to(self.device)
        self.style_optimizer = torch.optim.Adam(self.discriminator.parameters(), lr=self.style.learning_rate)
        self.replay = WindowReplay(self.style.replay_size)
        self._windows: list[Tensor] = []
        self.last_style_reward = torch.zeros(storage.num_envs)
        """(N,) what style was worth at the last step, before its weight."""

    def process_env_step(self, obs: TensorDict, rewards: Tensor, dones: Tensor, extras: dict[str, Tensor]) -> None:
        valid = extras.get("valid", torch.ones_like(dones, dtype=torch.bool))
        self.storage.valid[self.storage.step] = valid  # type: ignore[attr-defined]
        if self.motion_set is not None and "style_windows" in extras:
            windows = extras["style_windows"]
            with torch.no_grad():
                self.last_style_reward = style_reward(self.discriminator(windows), rewards, self.style.floor)
            rewards = rewards + self.style.weight * self.last_style_reward
            self._windows.append(windows[valid])
        super().process_env_step(obs, self.reward_scale * rewards, dones, extras)

    def compute_returns(self, obs: TensorDict) -> None:
        super().compute_returns(obs)
        if not self.normalize_advantage_per_mini_batch:
            # the mean and spread of those that count
            st = self.storage
            valid = self.ranks.gather(st.valid, 1)  # type: ignore[attr-defined]
            chosen = self.ranks.gather(st.returns - st.values, 1)[valid]
            if len(chosen) > 1:
                st.advantages = ((st.returns - st.values) - chosen.mean()) / (chosen.std() + 1e-8)

    def update(self) -> dict[str, float]:
        shown = self._update_discriminator() if self.motion_set is not None and self._windows else {}
        if not self.ranks.gather(self.storage.valid, 1).any():  # type: ignore[attr-defined]
            self.storage.clear()
            return {"value": 0.0, "surrogate": 0.0, "entropy": 0.0, **shown}
        return {**self.ranks.means(super().update()), **shown}

    def reduce_parameters(self) -> None:
        parameters = [*self.actor.parameters(), *self.critic.parameters()]
        for parameter in parameters:
            if parameter.grad is not None:
                parameter.grad *= self.storage.share  # type: ignore[attr-defined]
        self.ranks.sum_gradients(parameters)

    def _update_discriminator(self) -> dict[str, float]:
        assert self.motion_set is not None
        current, ranks = torch.cat(self._windows), self.ranks
        numbers, total = ranks.numbers(self.storage.valid)  # type: ignore[attr-defined]
        self._windows = []
        totals: dict[str, float] = {}
        if not total:
            return totals
        config = self.style
        for _ in range(config.batches):
            agent = ranks.rows(current, numbers, total, torch.randint(total, (config.batch_size,)))
            if len(self.replay.windows):
                agent = torch.cat([agent, self.replay.sample(config.batch_size)])
            good = self.motion_set.sample(config.batch_size).to(agent)
            self.discriminator.normalizer.train()
            self.discriminator.normalizer.update(torch.cat([good, agent[: config.batch_size]]))
            loss, shown = discriminator_loss(self.discriminator, good, agent, config)
            self.style_optimizer.zero_grad()
            loss.backward()
            self.style_optimizer.step()
            shown["style_loss"] = float(loss.detach())
            for name, value in shown.items():
                totals[name] = totals.get(name, 0.0) + value / config.batches
        kept = torch.randperm(total)[: config.replay_keep]
        self.replay.add(ranks.rows(current, numbers, total, kept))
        return totals

    def train_mode(self) -> None:
        super().train_mode()
        self.discriminator.train()

    def eval_mode(self) -> None:
        super().eval_mode()
        self.discriminator.eval()

    def save(self) -> dict:
        return {
            **super().save(),
            "discriminator_state_dict": self.discriminator.state_dict(),
            "style_optimizer_state_dict": self.style_optimizer.state_dict(),
            "style_replay": self.replay.windows,
            "style_replay_cursor": self.replay.cursor,
        }

    def load(self, loaded_dict: dict, load_cfg: dict | None, strict: bool) -> bool:
        again = super().load(loaded_dict, load_cfg, strict)
        if load_cfg is None or load_cfg.get("style", False):
            self.discriminator.load_state_dict(loaded_dict["discriminator_state_dict"], strict=strict)
            self.style_optimizer.load_state_dict(loaded_dict["style_optimizer_state_dict"])
            self.replay.windows = loaded_dict["style_replay"].clone()
            self.replay.cursor = int(loaded_dict["style_replay_cursor"])
        return again

    def broadcast_parameters(self) -> None:
        super().broadcast_parameters()
        self.ranks.copy_from_first(self.discriminator)
