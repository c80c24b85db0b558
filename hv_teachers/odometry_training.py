"""Trains the student's odometry (`hv_policy.belief.odometry`) on what robots feel while they work and while they walk
about."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import torch
import torch.nn.functional as F
from torch import Tensor
from tqdm import tqdm

from hv_policy.batch_invariant import atan2
from hv_policy.belief.odometry import CORRECTION_UNIT_RAD, Odometry, features, rate_turn
from hv_policy.motor.intent import HEIGHT, VELOCITY, neutral_intent
from hv_policy.motor.prior import load_shipped_motor_prior
from hv_sim.task import Task
from hv_sim.world import RearrangeWorld
from hv_teachers.teacher import load_shipped_teacher

_NEW_INTENT_STEPS = 60
_NEW_START_STEPS = 150
"""How long a robot walks about before it starts anew: the first three steps lose as much as the next fifty."""
_FASTEST = (0.9, 0.25, 1.3)
_STANDS_SHARE, _TURNS_SHARE = 0.15, 0.35
_BATCH, _LR = 512, 3e-3


@dataclass(frozen=True)
class Felt:
    """Pairs of proprioceptions a control step apart, and how far the robot turned in between."""

    before: Tensor  # (B, 223)
    now: Tensor  # (B, 223)
    turn_rad: Tensor  # (B,)
    env: Tensor  # (B,) int64 whose it was


@torch.no_grad()
def feel(tasks: Sequence[Task], seed: int, steps: int) -> Felt:
    """Lets robots play: every second one does its task as the teachers do, the others walk and turn at random and
    start anew every five seconds.

    Args:
        tasks: one for each environment.
        seed: decides everything.
        steps: control steps.
    """
    world = RearrangeWorld(tasks)
    world.reset(seeds=[seed + i for i in range(world.num_envs)])
    generator = torch.Generator().manual_seed(seed)
    teacher, prior = load_shipped_teacher(), load_shipped_motor_prior()
    prior.reset()
    wanders = torch.arange(world.num_envs) % 2 == 1
    intent = neutral_intent(world.num_envs)
    rows: list[list[Tensor]] = []
    last = None
    ids = torch.arange(world.num_envs)
    for step in tqdm(range(steps), desc="robots walk", disable=None):
        starting = wanders & ((step + ids) % _NEW_START_STEPS == 0) & (step > 0)
        if starting.any():
            world.reset(ids[starting], seeds=(seed + world.num_envs * step + ids[starting]).tolist())
            prior.reset(ids[starting])
        if step % _NEW_INTENT_STEPS == 0:
            intent = _random_intents(world.num_envs, generator)
        heading, state = world.heading, world.observe().proprioception
        yaw = atan2(heading.sin, heading.cos)
        is_up = ~(world.fallen | world.done)
        if last is not None:
            turn = yaw - last[1]
            both = is_up & last[2] & ~starting
            pair = (last[0], state, atan2(turn.sin(), turn.cos()), ids)
            rows.append([x[both].clone() for x in pair])
        last = state.clone(), yaw, is_up
        world.step(torch.where(wanders[:, None], prior(state, intent), teacher(world)))
    return Felt(*(torch.cat(column) for column in zip(*rows, strict=True)))


def train_odometry(felt: Felt, seed: int, steps: int) -> tuple[Odometry, dict[str, float]]:
    """A network that was trained on three quarters of the robots, and how it does with the others: what
    a second adds to the error (degrees), without the network (`rate_deg`) and with it (`deg`)."""
    torch.manual_seed(seed)
    kept_aside = felt.env % 8 >= 6
    inputs, rate = features(felt.before, felt.now), rate_turn(felt.before, felt.now)
    wanted = (felt.turn_rad - rate) / CORRECTION_UNIT_RAD
    network = Odometry()
    network.set_moments(inputs[~kept_aside])
    shown, told = inputs[~kept_aside], wanted[~kept_aside]
    optimizer = torch.optim.AdamW(network.parameters(), lr=_LR, weight_decay=1e-3)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, _LR, total_steps=steps)
    for _ in tqdm(range(steps), desc="odometry learns", disable=None):
        batch = torch.randint(len(shown), (_BATCH,))
        loss = F.smooth_l1_loss(network.correction(shown[batch]), told[batch], beta=0.5)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        schedule.step()
    network.eval()
    with torch.no_grad():
        missed = wanted[kept_aside]
        left = missed - network.correction(inputs[kept_aside])
    envs = felt.env[kept_aside]
    return network, {"rate_deg": _error_a_second(missed, envs), "deg": _error_a_second(left, envs)}


def _error_a_second(errors: Tensor, envs: Tensor) -> float:
    """Sums of 30 errors in a row of the same robot, degrees; two thirds are smaller (some robots are about to fall)."""
    sums = []
    for env in envs.unique().tolist():
        own = errors[envs == env]
        sums.append(own[: len(own) // 30 * 30].view(-1, 30).sum(1))
    return float(torch.rad2deg(CORRECTION_UNIT_RAD * torch.cat(sums)).abs().quantile(0.68))


def _random_intents(num: int, generator: torch.Generator) -> Tensor:
    """(num, 14): walk, turn on the spot, or stand."""
    intent = neutral_intent(num)
    speed = (2 * torch.rand(num, 3, generator=generator) - 1) * torch.tensor(_FASTEST)
    kind = torch.rand(num, 1, generator=generator)
    turns = speed * torch.tensor([0.0, 0.0, 1.0])
    speed = torch.where(kind < _STANDS_SHARE + _TURNS_SHARE, turns, speed)
    intent[:, VELOCITY] = torch.where(kind < _STANDS_SHARE, torch.zeros_like(speed), speed)
    intent[:, HEIGHT] -= 0.15 * torch.rand(num, generator=generator) * (kind[:, 0] < _STANDS_SHARE)
    return intent
