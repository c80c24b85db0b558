"""How well a motor prior goes where it is told, carries and takes a push: unassisted, every fall and miss counted."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import torch
from torch import Tensor
from tqdm import tqdm

from hv_policy.batch_invariant import atan2
from hv_policy.motor import embodiment as body
from hv_policy.motor.intent import HEIGHT, PITCH, VELOCITY, neutral_intent, split_hands
from hv_policy.motor.prior import MotorPrior
from hv_sim.metrics import is_fallen
from hv_sim.observations import Heading
from hv_teachers.motor_env import MotorEnv, MotorEnvConfig
from hv_teachers.motor_scenes import LoadRange
from hv_teachers.planner import PlannerConfig

INTENT_S, CARRY_S, PUSH_S = 20.0, 60.0, 8.0
PUSH_N_S = 30.0
CARRY_RADIUS_M = 0.2
STANDING_AFTER_S = 3.0
AVERAGED_STEPS = 26
"""Over which velocity and turning are averaged, .87 s: one and a half strides, in which the sway cancels out."""
SETTLED_STEPS = 45
"""How long an intent has been in force before the hands are measured."""
LOADS = LoadRange(walk_m=(2.0, 2.5))
"""At least 2 m between the stands."""


@dataclass(frozen=True)
class MotorBenchmark:
    """What a run is made of."""

    episodes: int = 512
    seed: int = 0
    physics_hz: int = 120
    batch: int = 256
    planner: PlannerConfig = field(default_factory=PlannerConfig)


def run_motor_benchmark(prior: MotorPrior, config: MotorBenchmark) -> dict[str, float]:
    """All three tests; the keys are those of `motor.json`.

    Returns:
        intent_survival, carry_success, push_survival (shares), velocity_rmse (m/s), yaw_rate_rmse (rad/s),
        hand_error_standing, hand_error_walking (median, m), carry_lifted, carry_fall_rate, physics_hz, episodes, seed.
    """
    totals: list[dict[str, Tensor]] = []
    sizes = [min(config.batch, config.episodes - i) for i in range(0, config.episodes, config.batch)]
    steps = len(sizes) * int(30 * (INTENT_S + CARRY_S + PUSH_S))
    with tqdm(total=steps, desc="motor benchmark", unit="step", mininterval=2) as bar:
        for i, size in enumerate(sizes):
            base = MotorEnvConfig(
                num_envs=size, randomize=False, push_n_s=0.0, auto_reset=False, physics_hz=config.physics_hz,
                bent_share=0.0, start_shares=(1.0, 0.0, 0.0, 0.0, 0.0, 0.0), planner=config.planner, load=LOADS,
            )  # fmt: skip
            seed = config.seed * 1000 + i
            totals.append(
                {
                    **_intents(MotorEnv(prior, replace(base, load_share=0.0), seed), bar),
                    **_carry(MotorEnv(prior, replace(base, load_share=1.0), seed + 333), bar),
                    **_push(MotorEnv(prior, replace(base, load_share=0.0), seed + 666), seed, bar),
                }
            )
    merged = {k: torch.cat([t[k] for t in totals]) for k in totals[0]}
    return {
        "intent_survival": float(merged["intent_stood"].float().mean()),
        "velocity_rmse": float(merged["velocity_error"].square().mean().sqrt()),
        "yaw_rate_rmse": float(merged["yaw_error"].square().mean().sqrt()),
        "hand_error_standing": float(merged["hand_standing"].nanmedian()),
        "hand_error_walking": float(merged["hand_walking"].nanmedian()),
        "carry_success": float(merged["carried"].float().mean()),
        "carry_lifted": float(merged["lifted"].float().mean()),
        "carry_fall_rate": float(merged["carry_fell"].float().mean()),
        "push_survival": float(merged["push_stood"].float().mean()),
        "physics_hz": float(config.physics_hz),
        "episodes": float(config.episodes),
        "seed": float(config.seed),
    }


@torch.no_grad()
def _advance(env: MotorEnv) -> None:
    env.step(env.prior.residual(env.features))


def _intents(env: MotorEnv, bar: tqdm) -> dict[str, Tensor]:
    """Velocity and turning are compared with the rate-limited command, averaged over `AVERAGED_STEPS` so that sway
    does not count; hands with the intent itself. A robot is measured until it falls."""
    fallen = torch.zeros(env.num_envs, dtype=torch.bool)
    velocity, yaw, standing, walking = [], [], [], []
    window: list[tuple[Tensor, Tensor]] = []
    before, since = env.command.clone(), torch.zeros(env.num_envs)
    last_yaw = _yaw(Heading.of(env.physics.state()))
    for step in range(int(INTENT_S * 30)):
        command = env.intent.clone()
        since = torch.where((command != before).any(-1), 0.0, since + 1.0)
        before = command
        _advance(env)
        bar.update()
        state = env.physics.state()
        fallen |= is_fallen(state)
        heading = Heading.of(state)
        now_yaw = _yaw(heading)
        turned = torch.remainder(now_yaw - last_yaw + torch.pi, 2 * torch.pi) - torch.pi
        last_yaw = now_yaw
        memory = env.prior.memory
        assert memory is not None
        planar = heading.rotate(state.link_lin_vel_w[:, 0])[:, :2]
        window.append((torch.cat([planar, turned[:, None] / body.CONTROL_DT_S], -1), memory.velocity.clone()))
        window = window[-AVERAGED_STEPS:]
        moves = command[:, VELOCITY].abs().amax(-1) > 0.1
        if step > 30 and len(window) == AVERAGED_STEPS:
            error = torch.stack([m for m, _ in window]).mean(0) - torch.stack([c for _, c in window]).mean(0)
            walks = command[:, VELOCITY][:, :2].abs().amax(-1) > 0.1
            velocity.append(error[walks & ~fallen, :2].norm(dim=-1))
            yaw.append(error[moves & ~fallen, 2])
        origin = heading.origin_w[:, None] * torch.tensor([1.0, 1.0, 0.0])
        hands = heading.rotate(state.link_pos_w[:, body.HANDS] - origin)
        hand_error = (hands - split_hands(command)).norm(dim=-1).mean(-1)
        settled = since >= SETTLED_STEPS
        standing.append(hand_error[settled & ~moves & ~fallen])
        walking.append(hand_error[settled & moves & ~fallen])
    return {
        "intent_stood": ~fallen,
        "velocity_error": torch.cat(velocity),
        "yaw_error": torch.cat(yaw),
        "hand_standing": torch.cat(standing),
        "hand_walking": torch.cat(walking),
    }


def _yaw(heading: Heading) -> Tensor:
    return atan2(heading.sin, heading.cos)


def _carry(env: MotorEnv, bar: tqdm) -> dict[str, Tensor]:
    n = env.num_envs
    fallen, lifted = torch.zeros(n, dtype=torch.bool), torch.zeros(n, dtype=torch.bool)
    idle_for = torch.zeros(n)
    success = torch.zeros(n, dtype=torch.bool)
    for _ in range(int(CARRY_S * 30)):
        _advance(env)
        bar.update()
        state = env.physics.state()
        fallen |= is_fallen(state)
        lifted |= state.object_pos_w[:, 0, 2] > env.start_pos[:, 2] + 0.1
        placed = (env.object_goal_distance() < CARRY_RADIUS_M) & (env.idle_steps > 0) & ~fallen
        idle_for = torch.where(placed, idle_for + 1, torch.zeros_like(idle_for))
        success |= idle_for >= STANDING_AFTER_S * 30
    return {"carried": success & ~fallen, "lifted": lifted, "carry_fell": fallen}


def _push(env: MotorEnv, seed: int, bar: tqdm) -> dict[str, Tensor]:
    n = env.num_envs
    rng = np.random.default_rng(seed + 999)
    walk = neutral_intent(n)
    # half of them stand, half walk
    walk[: n // 2, 0] = torch.tensor(rng.uniform(0.3, 0.9, n // 2), dtype=torch.float32)
    walk[:, HEIGHT], walk[:, PITCH] = 0.84, 0.05
    env.command = walk
    env.command_left[:] = 10**6
    fallen = torch.zeros(n, dtype=torch.bool)
    when = rng.integers(75, 105, n)
    angle = rng.uniform(-np.pi, np.pi, n)
    for step in range(int(PUSH_S * 30)):
        due = np.nonzero(when == step)[0]
        if len(due):
            impulse = PUSH_N_S * np.stack([np.cos(angle[due]), np.sin(angle[due]), 0 * angle[due]], -1)
            env.shove(due, impulse)
        _advance(env)
        bar.update()
        fallen |= is_fallen(env.physics.state())
    return {"push_stood": ~fallen}
