"""Trains a teacher: behaviour cloning and DAgger from the planner, then PPO with task and style reward.

Resumable after a kill at any moment with the same curve: a checkpoint holds everything, the practice worlds included,
and the training that wrote it goes on from it as well (`hv_teachers.world_snapshot`).

Several processes (`hv_teachers.ranks`) share the environments of the configuration and learn what one would. Each
keeps its own worlds and samples; the first one writes everything else.
"""

from __future__ import annotations

import copy
import math
import time
from collections import defaultdict
from pathlib import Path
from typing import Any

import torch
import yaml
from tensordict import TensorDict
from tqdm import tqdm

from hv_policy.decision.network import DecisionNetwork
from hv_policy.decision.view import Phase
from hv_policy.decision.weights import load_decision, save_decision
from hv_policy.motor.prior import MotorPrior, load_motor_prior, load_shipped_motor_prior
from hv_teachers.amp import AmpPPO
from hv_teachers.curriculum import practice_tasks, share_of_tasks
from hv_teachers.imitation import ImitationBuffer, Samples, SharedSamples, imitation_loss
from hv_teachers.mocap import motion_clips, wheel_motions
from hv_teachers.ranks import Ranks, places
from hv_teachers.style import MotionSet, record_motion_set
from hv_teachers.teacher import Decision
from hv_teachers.teacher_config import TeacherTrainingConfig, differences, plain, training_config
from hv_teachers.teacher_curve import TrainingCurve, episode_means
from hv_teachers.teacher_env import Outcome, TeacherEnv
from hv_teachers.teacher_ppo import build_ppo, network_of, observations
from hv_teachers.world_snapshot import restore_env, save_env

ITERATIONS_PER_TURN = 12
"""PPO iterations that count as one round for checkpoints and for the tasks' turns."""


def train_teacher(
    config: TeacherTrainingConfig, output: Path, *, ranks: Ranks | None = None, progress: bool = True
) -> Path:
    """Trains, or goes on training, in the folder `output`; returns the path of the weights.

    Leaves `config.yaml`, `teacher.safetensors`, `curve.csv`, `curve_*.png`, `tensorboard/`, `motion_set.safetensors`
    and what is needed to go on (`resume.pt`, `data/`; of every further process `resume_rank1_SAMPLES.pt`,
    `data/rank1/`).

    Args:
        config: of the whole: `env.num_envs` are shared out among the processes.
        output: the folder, the same for every process.
        ranks: the processes that train (default: this one alone).
        progress: show bars.

    Raises:
        ValueError: the folder holds a training of another configuration or of another number of processes, the
            environments cannot be shared out evenly, or a file that is named cannot be read.
    """
    trainer = _Trainer(config, Path(output), ranks or Ranks(), progress)
    trainer.run()
    return trainer.weights


class _Trainer:
    def __init__(self, config: TeacherTrainingConfig, output: Path, ranks: Ranks, progress: bool) -> None:
        self.config, self.output, self.ranks = config, output, ranks
        self.progress = progress and ranks.is_first
        self.share = ranks.share(config.env.num_envs)
        self.weights = output / "teacher.safetensors"
        resume = output / "resume.pt"
        if resume.exists():
            _check_same(config, output / "config.yaml")
        torch.set_num_threads(1)  # small operations: more threads only wait for each other
        torch.manual_seed(config.seed)
        self.tasks = practice_tasks(config.tasks, config.part)
        self.prior: MotorPrior = load_motor_prior(Path(config.prior)) if config.prior else load_shipped_motor_prior()
        self.first = load_decision(Path(config.first_teacher)) if config.first_teacher else None
        self.network = load_decision(Path(config.init)) if config.init else DecisionNetwork(config.teacher)
        if self.network.config != config.teacher:
            raise ValueError(f"init: {config.init} is another network; teacher must be {plain(self.network.config)}")
        if self.first is not None and self.first.config.memory != config.teacher.memory:
            raise ValueError(f"first_teacher: {config.first_teacher} has memory {self.first.config.memory!r}; "
                             f"valid: {config.teacher.memory!r}")  # fmt: skip
        if self.first is not None and self.first.config.action != config.teacher.action:
            raise ValueError(f"first_teacher: {config.first_teacher} says {self.first.config.action!r}; "
                             f"valid: {config.teacher.action!r}")  # fmt: skip
        if config.mocap_wheel and not Path(config.mocap_wheel).is_file():
            raise ValueError(f"mocap_wheel: {config.mocap_wheel} is not a file; valid: an isaaclab wheel")
        output.mkdir(parents=True, exist_ok=True)
        saved = torch.load(resume, weights_only=True) if resume.exists() else None
        own = self._own(saved)
        if ranks.is_first:
            _write_yaml(config, output / "config.yaml")
        ranks.copy_from_first(self.network)
        self.network.train()
        self.optimizer = torch.optim.Adam(self.network.parameters(), lr=config.dagger.learning_rate)
        data = output / "data" / ("" if ranks.is_first else f"rank{ranks.rank}")
        self.buffer = ImitationBuffer(data, config.dagger.buffer)
        self.round, self.iteration, self.samples, self.turn, minutes = 0, 0, 0, 0, 0.0
        self.ppo: AmpPPO | None = None
        if saved is not None:
            self.round, self.iteration, self.samples = saved["round"], saved["iteration"], saved["samples"]
            self.turn, minutes = saved["turn"], saved["minutes"]
            self.network.load_state_dict(saved["network"])
            self.buffer.restore(own["buffer"])
        self.env = self._make_env()
        if saved is not None:
            try:
                restore_env(self.env, own["env"])
            except KeyError as missing:
                raise ValueError(f"output: {resume} lacks {missing}, it was written by other code; "
                                 "valid: a new folder, with init= what was learned there") from missing  # fmt: skip
            if saved["ppo"]:
                self._begin_ppo()
                assert self.ppo is not None
                self.ppo.load(saved["ppo"], None, strict=True)
            self.optimizer.load_state_dict(saved["optimizer"])  # of imitation; PPO begins with a new one
            torch.set_rng_state(saved["rng"])
        self.curve = TrainingCurve(output, self.samples) if ranks.is_first else None
        self.started = time.time() - 60 * minutes

    def run(self) -> None:
        config = self.config
        with tqdm(
            total=config.samples, initial=self.samples, unit="step", unit_scale=True, desc=config.name,
            mininterval=5, disable=not self.progress,
        ) as bar:  # fmt: skip
            while self.samples < config.samples:
                begun, before = time.time(), self.samples
                dagger = self.samples < config.dagger.samples
                if not dagger and self.ppo is None:
                    self._begin_ppo()
                row = self._dagger_round() if dagger else self._ppo_iteration()
                elapsed = time.time() - begun
                row |= {
                    "samples": self.samples,
                    "minutes": round((time.time() - self.started) / 60, 2),
                    "steps_per_s": round((self.samples - before) / elapsed),
                    "simulation_share": round(row.pop("simulated_s") / elapsed, 3),
                }
                if self.curve is not None:
                    self.curve.add("dagger" if dagger else "ppo", row)
                bar.update(self.samples - before)
                bar.set_postfix(success=row.get("success"), refresh=False)
                at_turn = dagger or self.iteration % ITERATIONS_PER_TURN == 0
                rounds = self.round + self.iteration // ITERATIONS_PER_TURN
                if at_turn and rounds % config.new_tasks_every == 0 and len(self.tasks) > config.env.num_envs:
                    self.turn += 1
                    self.env = self._make_env()
                if (at_turn and rounds % config.checkpoint_every == 0) or self.samples >= config.samples:
                    self._save()

    # imitation

    def _dagger_round(self) -> dict[str, float]:
        config, env = self.config.dagger, self.env
        begun = time.time()
        beta = config.beta_decay**self.round
        sums: dict[str, float] = defaultdict(float)
        parts: list[Samples] = []
        taken: list[torch.Tensor] = []
        shapes = _Shapes(self.buffer, env)
        self.network.eval()
        with torch.no_grad():
            for step in range(config.round_steps):
                if step % config.expert_steps == 0:
                    expert = (torch.rand(self.config.env.num_envs) < beta)[self.share]
                seen = env.look()
                label = env.label(seen)
                chosen = env.learning & self._taught(label.phase)
                parts.append(Samples.of(seen, label, shapes.rows(seen.geometry), chosen))
                taken.append(chosen)
                decision = env.decide(self.network, seen)
                action = env.follow(label, expert & env.learning, decision)
                _count(sums, env.act(seen, action), env)
        samples = SharedSamples(Samples.join(parts), *self.ranks.numbers(torch.stack(taken)))
        simulated = time.time() - begun
        self.round += 1
        self.samples += max(1, len(samples))
        row = {"beta": round(beta, 4), **self._episodes(sums, config.round_steps), "simulated_s": simulated}
        if not len(samples):
            return row  # the first teacher was never done
        self.buffer.add(self.round, samples)
        if not self.network.normalized:
            self.network.set_moments(*self.ranks.moments(samples.here.sights.float()))
        data = self.buffer.all()
        batches = max(1, round(config.replays * len(samples) / config.batch_size))
        share = min(1.0, self.samples / max(1, config.samples))
        rate = config.learning_rate * (config.final_learning_rate / config.learning_rate) ** share
        return row | self._imitate(data, batches, rate)

    def _taught(self, phase: torch.Tensor) -> torch.Tensor:
        """Which labels are learned, by their phase: of a stage that ends when the object is placed, none after that."""
        return phase < (Phase.RELEASE if self.config.env.end_when_placed else len(Phase))

    def _imitate(self, data: SharedSamples, batches: int, rate: float, actions: bool = True) -> dict[str, float]:
        """Some mini-batches of imitation; what to log."""
        config, network, optimizer = self.config.dagger, self.network, self.optimizer
        if not actions and network.config.memory != "phase":
            return {}  # nothing to imitate: no phases, and actions are left to PPO
        network.train()
        for group in optimizer.param_groups:
            group["lr"] = rate
        totals: dict[str, float] = defaultdict(float)
        for _ in range(batches):
            rows = torch.randint(len(data), (min(config.batch_size, len(data)),))
            batch = data.at(rows)
            share = len(batch) / len(rows)
            optimizer.zero_grad()
            if len(batch):
                geometry = self.buffer.geometry[batch.shape.long()]
                loss, shown = imitation_loss(network, batch, geometry, config.transition_weight, actions)
                (share * loss).backward()
                for name, value in shown.items():
                    totals[name] += share * value / batches
            self.ranks.sum_gradients(network.parameters())
            torch.nn.utils.clip_grad_norm_(network.parameters(), 5.0)
            optimizer.step()
        return {name: round(value, 5) for name, value in self.ranks.sums(totals).items()}

    # reinforcement

    def _begin_ppo(self) -> None:
        config = self.config
        motion = self._motion_set() if config.style.weight > 0 else None
        with torch.no_grad():
            if not self.network.normalized:
                self.network.set_moments(*self.ranks.moments(self.env.look().sights))
            n = self.env.num_envs
            memory = 18 if config.teacher.memory == "phase" else config.teacher.num_actions
            label = config.ppo.imitation_batches > 0
            shapes = {"sights": len(self.network.mean), "anchors": 42, "geometry": 600, "memory": memory, "critic": 13}
            if label:
                shapes |= {"label_anchors": 42, "label_memory_before": 18, "label_memory": memory, "label_phase": 1}
                shapes["label_action"] = config.teacher.num_actions
            empty = TensorDict({k: torch.zeros(n, v) for k, v in shapes.items()}, batch_size=[n])
        self.ppo = build_ppo(self.network, empty, config.ppo, config.style, motion, self.ranks)
        if self.ranks.count > 1:
            self.ppo.broadcast_parameters()
        self.network = network_of(self.ppo)
        self.ppo.train_mode()
        self.optimizer = torch.optim.Adam(self.network.parameters(), lr=config.ppo.imitation_learning_rate)

    def _ppo_iteration(self) -> dict[str, float]:
        config, env, ppo = self.config.ppo, self.env, self.ppo
        assert ppo is not None
        begun = time.time()
        sums: dict[str, float] = defaultdict(float)
        warming = self.iteration < config.critic_warmup
        for parameter in self.network.parameters():
            parameter.requires_grad_(not warming)
        learned = 0
        with torch.no_grad():
            for _ in range(config.steps_per_iteration):
                seen = env.look()
                label = env.label(seen) if config.imitation_batches else None
                decision = env.decide(self.network, seen)
                learning = env.learning
                obs = observations(env, seen, decision, label)
                action = torch.where(learning[:, None], ppo.act(obs), decision.action)
                outcome = env.act(seen, action)
                reward = torch.stack(list(outcome.terms.values())).sum(0) - config.fall_penalty * outcome.failed
                dones = (outcome.failed | outcome.timed_out).long()
                extras = {
                    "time_outs": outcome.timed_out.float(),
                    "style_windows": outcome.style_windows,
                    "valid": learning,
                }
                ppo.process_env_step(obs, torch.nan_to_num(reward), dones, extras)
                learned += int(learning.sum())
                _count(sums, outcome, env)
                sums["style_reward"] += float(ppo.last_style_reward.mean())
                sums["reward"] += float(reward.mean())
            seen = env.look()
            unmoved = Decision(*env.senses.inputs(seen), env.senses.last_action)
            ppo.compute_returns(observations(env, seen, unmoved, label))
        simulated = time.time() - begun
        stored, learning = ppo.storage.observations.flatten(0, 1), ppo.storage.valid  # type: ignore[attr-defined]
        losses = ppo.update()
        shown = {f"{name}_loss" if name in ("value", "surrogate") else name: round(v, 5) for name, v in losses.items()}
        if config.imitation_batches and not warming:
            shown |= self._imitate_stored(stored, learning)
        self.iteration += 1
        self.samples += max(1, int(self.ranks.sums({"learned": learned})["learned"]))
        return {**shown, **self._episodes(sums, config.steps_per_iteration), "simulated_s": simulated}

    def _imitate_stored(self, stored: Any, valid: torch.Tensor) -> dict[str, float]:
        """Imitation on what PPO has just seen, (T, n) where `valid`, so that the phases stay what they are."""
        valid = valid & self._taught(stored["label_phase"][:, 0]).view_as(valid)
        numbers, total = self.ranks.numbers(valid)
        if not total:
            return {}
        count = self.config.ppo.imitation_batches * self.config.dagger.batch_size
        at = places(numbers, total)[torch.randint(total, (count,))]
        here = (at >= 0).nonzero()[:, 0]
        rows = valid.flatten().nonzero()[:, 0][at[here]]
        buffer = self.buffer
        samples = Samples(
            stored["sights"][rows],
            stored["label_anchors"][rows],
            buffer.shape_rows(stored["geometry"][rows]),
            stored["label_memory_before"][rows],
            stored["label_memory"][rows],
            stored["label_phase"][rows, 0].long(),
            stored["label_action"][rows],
        )
        config, data = self.config.ppo, SharedSamples(samples, here, count)
        return self._imitate(data, config.imitation_batches, config.imitation_learning_rate, config.imitate_actions)

    def _motion_set(self) -> MotionSet:
        path = self.output / "motion_set.safetensors"
        if not path.exists() and self.ranks.is_first:
            config = self.config
            generator_state = torch.get_rng_state()
            tasks = share_of_tasks(self.tasks, config.motion_tasks, config.seed, 0)
            motion = record_motion_set(
                tasks, seed=config.seed, prior=copy.deepcopy(self.prior), num_threads=config.env.num_threads,
                progress=self.progress,
            )  # fmt: skip
            if config.mocap_wheel:
                clips = motion_clips(list(wheel_motions(Path(config.mocap_wheel)).values()), seed=config.seed)
                motion = motion.joined(clips)
            motion.save(path)
            torch.set_rng_state(generator_state)
        self.ranks.wait()
        return MotionSet.load(path)

    # keeping

    def _make_env(self) -> TeacherEnv:
        config = self.config
        tasks = share_of_tasks(self.tasks, config.env.num_envs, config.seed, self.turn)
        seed = config.seed + 1_000_003 * (self.turn + 1)
        return TeacherEnv(
            tasks[self.share], config.env, config.teacher, self.prior, seed, self.first,
            number=self.share.start, total=config.env.num_envs,
        )  # fmt: skip

    def _episodes(self, sums: dict[str, float], steps: int) -> dict[str, float]:
        """What to log of all processes' environments."""
        means = self.ranks.means({k: v for k, v in sums.items() if not k.startswith("n_")})
        return episode_means(means | self.ranks.sums({k: v for k, v in sums.items() if k.startswith("n_")}), steps)

    def _own(self, saved: dict[str, Any] | None) -> dict[str, Any]:
        """What a checkpoint holds of this process alone."""
        if saved is None:
            return {}
        if saved.get("ranks", 1) != self.ranks.count:
            raise ValueError(
                f"{self.output}: holds a training by {saved.get('ranks', 1)} processes, not {self.ranks.count}; "
                "valid: as many as before, or another output"
            )
        return saved if self.ranks.is_first else torch.load(self._own_path(saved["samples"]), weights_only=True)

    def _own_path(self, samples: int | str) -> Path:
        return self.output / f"resume_rank{self.ranks.rank}_{samples}.pt"

    def _save(self) -> None:
        env_state = save_env(self.env)
        restore_env(self.env, env_state)
        own = {"buffer": self.buffer.state(), "env": env_state}
        if not self.ranks.is_first:
            _write(own, self._own_path(self.samples))
        self.ranks.wait()  # resume.pt says which of the others' files belong to it, so these come first
        if self.ranks.is_first:
            self._save_common(own)
        self.ranks.wait()
        self.buffer.forget_files()
        if not self.ranks.is_first:
            for path in self.output.glob(self._own_path("*").name):
                if path != self._own_path(self.samples):
                    path.unlink()

    def _save_common(self, own: dict[str, Any]) -> None:
        state = {
            "round": self.round,
            "iteration": self.iteration,
            "samples": self.samples,
            "turn": self.turn,
            "minutes": (time.time() - self.started) / 60,
            "network": self.network.state_dict(),
            "optimizer": self.optimizer.state_dict(),
            "ranks": self.ranks.count,
            "ppo": self.ppo.save() if self.ppo is not None else {},
            "rng": torch.get_rng_state(),
        }
        _write(state | own, self.output / "resume.pt")
        about = {"samples": str(self.samples), "seed": str(self.config.seed), "name": self.config.name}
        save_decision(self.network, self.weights, about)
        assert self.curve is not None
        self.curve.flush()


class _Shapes:
    """Rows of the environments' shapes in the buffer's table, looked up again only where a shape changed."""

    def __init__(self, buffer: ImitationBuffer, env: TeacherEnv) -> None:
        self.buffer = buffer
        self.known = torch.full((env.num_envs, 600), math.nan)
        self.row = torch.zeros(env.num_envs, dtype=torch.int32)

    def rows(self, geometry: torch.Tensor) -> torch.Tensor:
        changed = (geometry != self.known).any(-1).nonzero()[:, 0]
        if len(changed):
            self.row[changed] = self.buffer.shape_rows(geometry[changed])
            self.known[changed] = geometry[changed]
        return self.row.clone()


def _count(sums: dict[str, float], outcome: Outcome, env: TeacherEnv) -> None:
    for name, value in outcome.terms.items():
        sums[name] += float(value.mean())
    for name, value in env.ended.items():
        sums["n_" + name] += value


def _check_same(config: TeacherTrainingConfig, path: Path) -> None:
    """Refuses to go on with another configuration; sample counts and threads may differ."""
    # a field that is younger than that training has its default there
    theirs = plain(training_config(yaml.safe_load(path.read_text(encoding="utf-8")))) if path.exists() else {}
    free = {"dagger.samples", "ppo.samples", "env.num_threads", "checkpoint_every", "name"}
    other = [name for name in differences(plain(config), theirs) if name not in free]
    if other:
        raise ValueError(f"{path.parent}: holds a training with another {', '.join(other)}; choose another output")


def _write(state: dict[str, Any], path: Path) -> None:
    temporary = path.with_suffix(".tmp")
    torch.save(state, temporary)
    temporary.replace(path)


def _write_yaml(config: TeacherTrainingConfig, path: Path) -> None:
    temporary = path.with_suffix(".tmp")
    temporary.write_text(yaml.safe_dump(plain(config), sort_keys=False), encoding="utf-8")
    temporary.replace(path)
