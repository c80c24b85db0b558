"""Trains the networks of the motor prior with rsl_rl's PPO: resumable after a kill at any moment, curves as CSV.

The residual that follows intents, or what gets up from the floor (`skill`).
"""

from __future__ import annotations

import csv
import math
import os
import time
from contextlib import redirect_stdout
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import torch
from rsl_rl.algorithms import PPO
from tensordict import TensorDict
from tqdm import tqdm

from hv_policy.motor.get_up import GetUpNetwork
from hv_policy.motor.prior import (
    SHIPPED_MOTOR_PRIOR,
    MotorPrior,
    MotorPriorConfig,
    ResidualNetwork,
    load_shipped_motor_prior,
    motor_prior_notes,
    save_motor_prior,
)
from hv_teachers.curriculum import practice_tasks, share_of_tasks
from hv_teachers.curves import plot_curve
from hv_teachers.get_up_practice import GetUpConfig, GetUpPractice
from hv_teachers.motor_env import MotorEnv, MotorEnvConfig
from hv_teachers.motor_practice import Practice, Practices
from hv_teachers.motor_rooms import MotorRooms, RoomsConfig
from hv_teachers.teacher import load_shipped_teacher

SKILLS = ("follow", "get_up")
CURVES = {
    "follow": (
        "reward", "free_failures_per_s", "load_failures_per_s", "drops_per_s", "placed_share", "steps_per_s",
    ),
    "get_up": ("reward", "free_up", "pulled_up", "pull_share", "stand", "steps_per_s"),
}  # fmt: skip


@dataclass(frozen=True)
class MotorTrainingConfig:
    """PPO and its schedule. `samples` are control steps over all environments."""

    skill: str = "follow"
    """What is learned: to follow intents, or to get up."""
    samples: int = 50_000_000
    steps_per_iteration: int = 12
    epochs: int = 2
    mini_batches: int = 4
    mixed_precision: bool = True
    """Actor and critic compute in bfloat16."""
    learning_rate: float = 5e-4
    desired_kl: float | None = 0.08
    """The actor's step follows from it; None: it stays, and so does the noise, and the critic has a step of its own."""
    critic_learning_rate: float = 5e-4
    """Without `desired_kl`."""
    critic_warmup: int = 0
    """Iterations in which only the critic learns; without `desired_kl`."""
    gamma: float = 0.98
    lam: float = 0.95
    noise: float = 0.12
    noise_range: tuple[float, float] = (0.05, 0.3)
    worlds_every: int = 300
    """Iterations after which boxes, grounds and rooms are drawn anew."""
    reward_scale: float = 0.05
    """rsl_rl's critic moves by 0.2 an update at most: too little for returns of 50."""
    seed: int = 0
    checkpoint_minutes: float = 3.0
    update_threads: int = 2
    init: str = ""
    """State of another training (`resume.pt`) whose networks to begin with; empty: new ones."""
    prior: MotorPriorConfig = field(default_factory=MotorPriorConfig)
    env: MotorEnvConfig = field(default_factory=MotorEnvConfig)
    rooms: RoomsConfig = field(default_factory=RoomsConfig)
    get_up: GetUpConfig = field(default_factory=GetUpConfig)

    def __post_init__(self) -> None:
        if self.skill not in SKILLS:
            raise ValueError(f"skill: {self.skill!r} is not valid; valid: {', '.join(SKILLS)}")


def getting_up(config: MotorTrainingConfig) -> MotorTrainingConfig:
    """The same for getting up: more noise, as nothing but a network stands between it and the servos."""
    return replace(
        config, skill="get_up", noise=0.35, noise_range=(0.08, 0.6), desired_kl=0.03, epochs=3, gamma=0.97,
        steps_per_iteration=24, reward_scale=0.1,
    )  # fmt: skip


def fine_tuning(config: MotorTrainingConfig) -> MotorTrainingConfig:
    """The same in small steps, for networks that are good already; where they shall be good at something else, their
    critic has to learn first what that is worth."""
    return replace(
        config, desired_kl=None, learning_rate=3e-5, noise=0.06, critic_warmup=25, steps_per_iteration=24
    )  # fmt: skip


def build_ppo(observations: TensorDict, num_envs: int, config: MotorTrainingConfig) -> PPO:
    """rsl_rl's PPO with an actor on the features and a critic that also sees the load."""
    network = {
        "class_name": "rsl_rl.models:MLPModel",
        "hidden_dims": list(config.prior.hidden if config.skill == "follow" else config.prior.get_up_hidden),
        "activation": "elu",
        "obs_normalization": True,
    }
    noise = {
        "class_name": "rsl_rl.modules.distribution:GaussianDistribution",
        "init_std": config.noise,
        "std_type": "log",
        "std_range": list(config.noise_range),
    }
    cfg = {
        "algorithm": {
            "class_name": "rsl_rl.algorithms:PPO",
            "num_learning_epochs": config.epochs,
            "num_mini_batches": config.mini_batches,
            "learning_rate": config.learning_rate,
            "desired_kl": config.desired_kl,
            "schedule": "fixed" if config.desired_kl is None else "adaptive",
            "gamma": config.gamma,
            "lam": config.lam,
            "entropy_coef": 0.0,
            "use_mixed_precision": config.mixed_precision,
        },
        "actor": {**network, "distribution_cfg": noise},
        "critic": dict(network),
        "obs_groups": {"actor": ["features"], "critic": ["features", "load"]},
        "num_steps_per_env": config.steps_per_iteration,
        "multi_gpu": None,
        "torch_compile_mode": None,
    }
    with open(os.devnull, "w") as quiet, redirect_stdout(quiet):
        ppo = PPO.construct_algorithm(observations, SimpleNamespace(num_actions=28, num_envs=num_envs), cfg, "cpu")
    with torch.no_grad():
        last = [m for m in ppo.actor.mlp if isinstance(m, torch.nn.Linear)][-1]
        last.weight.mul_(0.01)
        last.bias.zero_()
    if config.desired_kl is None:
        _deviation(ppo).requires_grad_(False)
        actor = [p for p in ppo.actor.parameters() if p.requires_grad]
        critic = {"params": list(ppo.critic.parameters()), "lr": config.critic_learning_rate}
        ppo.optimizer = torch.optim.Adam([{"params": actor}, critic], lr=config.learning_rate)
    return ppo


def _read_state(path: Path) -> dict[str, Any]:
    try:
        state = torch.load(path, weights_only=True)
        needed = {key: state[key] for key in ("ppo", "iteration", "samples", "minutes", "learning_rate")}
        return needed | {"pull_share": state.get("pull_share", 0.0)}  # younger than the first states
    except Exception as error:  # what is read may be anything
        reason = " ".join(str(error).split())[:100]
        raise ValueError(f"{path}: cannot be read ({reason}); valid: the resume.pt of a training") from None


def _load(ppo: PPO, state: dict[str, Any], path: Path, parts: dict[str, bool] | None) -> None:
    try:
        ppo.load(state, parts, strict=True)
    except (ValueError, RuntimeError, KeyError) as error:
        reason = " ".join(str(error).split())[:200]
        raise ValueError(
            f"{path}: is of another training ({reason}); valid: the settings it was made with"
        ) from None


def _deviation(ppo: PPO) -> torch.nn.Parameter:
    return ppo.actor.distribution.log_std_param  # type: ignore[union-attr, return-value]


class MotorTraining:
    """Practice worlds and PPO, an iteration at a time.

    Args:
        config: of the training.
        iteration: how many there were before; what is drawn follows from it.
    """

    def __init__(self, config: MotorTrainingConfig, iteration: int = 0) -> None:
        self.config = config
        torch.set_num_threads(1)  # small operations: more threads only wait for each other
        self.prior = MotorPrior(config.prior)
        shipped = load_shipped_motor_prior()  # what is not learned stays what it is
        if config.skill == "get_up":
            self.prior.residual = shipped.residual
        elif self.prior.get_up is not None and config.prior.get_up_hidden == shipped.config.get_up_hidden:
            assert shipped.get_up is not None
            self.prior.get_up.load_state_dict(shipped.get_up.state_dict())
        self.env = _practice(self.prior, config, iteration)
        self.ppo = build_ppo(_observations(self.env), self.env.num_envs, config)
        self.ppo.train_mode()
        self.samples_per_iteration = self.env.num_envs * config.steps_per_iteration
        self._iterations = self._worlds_since = iteration

    @property
    def network(self) -> ResidualNetwork | GetUpNetwork:
        """The one that is learned."""
        if self.config.skill == "follow":
            return self.prior.residual
        assert self.prior.get_up is not None
        return self.prior.get_up

    @property
    def pull_share(self) -> float:
        """How hard those who shall get up are pulled; 0 where nobody is."""
        return self.env.pull_share if isinstance(self.env, GetUpPractice) else 0.0

    @pull_share.setter
    def pull_share(self, share: float) -> None:
        if isinstance(self.env, GetUpPractice):
            self.env.pull_share = share

    def begin_with(self, path: Path) -> None:
        """The networks of another training (its `resume.pt`), with this one's noise."""
        _load(self.ppo, _read_state(path)["ppo"], path, {"actor": True, "critic": True})
        with torch.no_grad():
            _deviation(self.ppo).fill_(math.log(self.config.noise))

    def iterate(self) -> dict[str, float]:
        """One rollout and one update; returns a row of the curve."""
        begun = time.time()
        if self._iterations > self._worlds_since and self._iterations % self.config.worlds_every == 0:
            pull_share, self._worlds_since = self.pull_share, self._iterations
            self.env = _practice(self.prior, self.config, self._iterations)
            self.pull_share = pull_share
        if self.config.desired_kl is None:
            learns = self._iterations >= self.config.critic_warmup
            self.ppo.learning_rate = self.ppo.optimizer.param_groups[0]["lr"] = self.config.learning_rate * learns
        self._iterations += 1
        row = _rollout(self.ppo, self.env, self.config)
        simulated = time.time() - begun
        torch.set_num_threads(self.config.update_threads)
        losses = self.ppo.update()
        torch.set_num_threads(1)
        elapsed = time.time() - begun
        if isinstance(self.env, GetUpPractice):
            row |= {name: round(share, 4) for name, share in self.env.shares().items()}
        return row | {
            "steps_per_s": round(self.samples_per_iteration / elapsed),
            "simulation_share": round(simulated / elapsed, 3),
            "value_loss": round(losses["value"], 4),
            "learning_rate": round(self.ppo.learning_rate, 6),
            "noise": round(float(self.ppo.actor.output_std.detach().mean()), 3),
        }


def train_motor(config: MotorTrainingConfig, output: Path) -> Path:
    """Trains, or goes on training, in the folder `output`; returns the path of the exported weights.

    Leaves `resume.pt` (everything needed to go on), `curve.csv`, `curve.png` and `motor_prior.safetensors`.

    Raises:
        ValueError: the folder or `init` holds networks of another shape, or another kind of training.
    """
    output = Path(output)
    output.mkdir(parents=True, exist_ok=True)
    torch.manual_seed(config.seed)
    resume = output / "resume.pt"
    saved = _read_state(resume) if resume.exists() else None
    iteration, samples, minutes = (saved["iteration"], saved["samples"], saved["minutes"]) if saved else (0, 0, 0.0)
    training = MotorTraining(config, iteration)
    if saved:
        _load(training.ppo, saved["ppo"], resume, None)
        training.ppo.learning_rate, training.pull_share = saved["learning_rate"], saved["pull_share"]
        torch.manual_seed(config.seed + iteration)
    elif config.init:
        training.begin_with(Path(config.init))
    curve = _Curve(output / "curve.csv", samples)
    started, last_save = time.time() - 60 * minutes, time.time()
    with tqdm(
        total=config.samples, initial=samples, unit="step", unit_scale=True, desc="motor prior", mininterval=5
    ) as bar:
        while samples < config.samples:
            row = training.iterate()
            iteration, samples = iteration + 1, samples + training.samples_per_iteration
            row |= {"samples": samples, "minutes": round((time.time() - started) / 60, 2)}
            curve.add(row)
            bar.update(training.samples_per_iteration)
            shown = "free_failures_per_s" if config.skill == "follow" else "free_up"
            bar.set_postfix({"reward": f"{row['reward']:.3f}", shown: f"{row[shown]:.3f}"}, refresh=False)
            if time.time() - last_save > 60 * config.checkpoint_minutes or samples >= config.samples:
                curve.flush()  # first: rows beyond the state are cut off again, missing ones would stay missing
                _save(output, training, iteration, samples, (time.time() - started) / 60)
                plot_curve(output / "curve.csv", output / "curve.png", CURVES[config.skill])
                last_save = time.time()
    return output / "motor_prior.safetensors"


def export_actor(ppo: PPO, network: ResidualNetwork | GetUpNetwork) -> None:
    """Copies the actor's mean network and its normalisation into a network of the prior."""
    linear = [m for m in ppo.actor.mlp if isinstance(m, torch.nn.Linear)]
    target = [m for m in network.layers if isinstance(m, torch.nn.Linear)]
    with torch.no_grad():
        for source, sink in zip(linear, target, strict=True):
            sink.weight.copy_(source.weight)
            sink.bias.copy_(source.bias)
        normalizer = ppo.actor.obs_normalizer
        network.mean.copy_(normalizer.mean)
        network.std.copy_(normalizer.std + normalizer.eps)


def _practice(prior: MotorPrior, config: MotorTrainingConfig, iteration: int) -> Practice:
    seed, rooms = config.seed + 1000 * iteration, config.rooms
    if config.skill == "get_up":
        return GetUpPractice(config.get_up, seed)
    ground = MotorEnv(prior, config.env, seed)
    if not rooms.num_envs:
        return ground
    tasks = share_of_tasks(practice_tasks(rooms.tasks), rooms.num_envs, config.seed, iteration)
    network = load_shipped_teacher().networks[0]
    return Practices([ground, MotorRooms(MotorPrior(config.prior), network, tasks, rooms, seed)])


def _observations(env: Practice) -> TensorDict:
    return TensorDict({"features": env.features, "load": env.critic_extra}, batch_size=[env.num_envs])


def _rollout(ppo: PPO, env: Practice, config: MotorTrainingConfig) -> dict[str, float]:
    totals: dict[str, float] = {}
    steps = config.steps_per_iteration
    free, loaded = ~env.has_load, env.has_load
    counts = {"free_failures": 0, "load_failures": 0, "drops": 0, "placed": 0, "load_ends": 0}
    with torch.inference_mode(False), torch.no_grad():
        for _ in range(steps):
            # as PPO judges the same actions later
            with torch.autocast("cpu", torch.bfloat16, enabled=config.mixed_precision):
                residual = ppo.act(_observations(env)).float()
            reward, failed, timed_out, terms = env.step(residual)
            counts["free_failures"] += int((failed & free).sum())
            counts["load_failures"] += int((failed & loaded).sum())
            counts["drops"] += int(env.dropped.sum())
            counts["placed"] += int((terms["placed"] > 0).sum()) if "placed" in terms else 0
            counts["load_ends"] += int(((failed | timed_out) & loaded).sum())
            for name, value in terms.items():
                totals[name] = totals.get(name, 0.0) + float(value.mean()) / steps
            totals["reward"] = totals.get("reward", 0.0) + float(reward.mean()) / steps
            dones = (failed | timed_out).to(torch.long)
            extras = {"time_outs": timed_out.float()}
            ppo.process_env_step(_observations(env), config.reward_scale * reward, dones, extras)
        ppo.compute_returns(_observations(env))
    seconds = steps / 30.0
    row = {k: round(v, 4) for k, v in totals.items()}
    row["free_failures_per_s"] = round(counts["free_failures"] / max(1, int(free.sum())) / seconds, 4)
    row["load_failures_per_s"] = round(counts["load_failures"] / max(1, int(loaded.sum())) / seconds, 4)
    row["drops_per_s"] = round(counts["drops"] / max(1, int(loaded.sum())) / seconds, 4)
    row["placed_share"] = round(counts["placed"] / max(1, counts["load_ends"]), 3)
    return row


def _save(output: Path, training: MotorTraining, iteration: int, samples: int, minutes: float) -> None:
    ppo, prior = training.ppo, training.prior
    state = {
        "ppo": ppo.save(),
        "iteration": iteration,
        "samples": samples,
        "minutes": minutes,
        "learning_rate": ppo.learning_rate,
        "pull_share": training.pull_share,
    }
    temporary = output / "resume.tmp"
    torch.save(state, temporary)
    temporary.replace(output / "resume.pt")
    export_actor(ppo, training.network)
    which = "" if training.config.skill == "follow" else "get_up_"
    about = {f"{which}samples": str(samples), f"{which}seed": str(training.config.seed)}
    save_motor_prior(prior, output / "motor_prior.safetensors", motor_prior_notes(SHIPPED_MOTOR_PRIOR) | about)


class _Curve:
    """Rows of the training curve; what a killed run had written beyond its checkpoint is cut off on resuming."""

    def __init__(self, path: Path, samples: int) -> None:
        self.path = path
        self.rows: list[dict[str, float]] = []
        self.old: list[dict[str, str]] = []
        if samples and path.exists():
            with path.open() as file:
                self.old = [r for r in csv.DictReader(file) if int(r["samples"]) <= samples]

    def add(self, row: dict[str, float]) -> None:
        self.rows.append(row)

    def flush(self) -> None:
        rows: list[dict] = [*self.old, *self.rows]
        temporary = self.path.with_suffix(".tmp")
        with temporary.open("w", newline="") as file:
            writer = csv.DictWriter(file, fieldnames=list(rows[-1]), restval="", extrasaction="ignore")
            writer.writeheader()
            writer.writerows(rows)
        temporary.replace(self.path)
