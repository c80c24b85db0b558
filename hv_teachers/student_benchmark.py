"""How fast a policy that sees is beside LeRobot's stock ACT, on the same pictures and in the same run."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import torch
from lerobot.configs.types import FeatureType, PolicyFeature
from lerobot.policies.act.configuration_act import ACTConfig
from lerobot.policies.act.modeling_act import ACTPolicy
from lerobot.policies.pretrained import PreTrainedPolicy
from lerobot.utils.constants import ACTION, OBS_STATE
from torch import Tensor
from tqdm import tqdm

from hv_policy.modeling_hv import HVPolicy
from hv_sim.looks import NO_LOOKS
from hv_sim.rendering import CameraRenderer
from hv_sim.task import Task
from hv_sim.world import RearrangeWorld
from hv_teachers.frames import HEAD_IMAGE, glance_frames

STEPS_IN_TURN = 40
"""The first so many are not counted."""


def stock_act(policy: HVPolicy) -> ACTPolicy:
    """LeRobot's ACT with its default sizes, weights random, for what `policy` takes in and gives out."""
    size = policy.config.image_size
    inputs = {
        HEAD_IMAGE: PolicyFeature(FeatureType.VISUAL, (3, size, size)),
        OBS_STATE: policy.config.robot_state_feature,
    }
    config = ACTConfig(
        input_features=inputs,
        output_features={ACTION: policy.config.action_feature},
        pretrained_backbone_weights=None,
        n_action_steps=1,
        device="cpu",
    )
    return ACTPolicy(config).eval()


def benchmark_latency(policy: HVPolicy, task: Task, steps: int, progress: bool = False) -> dict[str, float]:
    """Milliseconds that `select_action` takes, for the policy at work on a task and, every `STEPS_IN_TURN` steps, for
    stock ACT on what the policy saw last; ACT is asked for an action at every step. One thread.

    Args:
        policy: who acts.
        task: what is to be done.
        steps: control steps that are timed.
        progress: show a bar.
    """
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    world, act = RearrangeWorld([task], num_threads=1), stock_act(policy)
    renderer = CameraRenderer(policy.config.image_size, policy.config.image_size)
    times: dict[str, list[float]] = {"student": [], "act": []}

    def timed(name: str, chosen: PreTrainedPolicy, batch: dict[str, Any]) -> Tensor:
        start = time.perf_counter()
        action = chosen.select_action(batch)
        times[name].append(time.perf_counter() - start)
        return action

    try:
        policy.reset()
        for step in tqdm(range(STEPS_IN_TURN + steps), "latency", unit="step", disable=not progress, mininterval=1):
            picture = torch.from_numpy(renderer.render_batch(world.physics)[0]).permute(2, 0, 1)[None].float() / 255
            state, words = world.observe().proprioception.float(), world.instructions()
            batch = {HEAD_IMAGE: picture, OBS_STATE: state, "task": words}
            world.step(timed("student", policy, batch))
            if step % STEPS_IN_TURN == STEPS_IN_TURN - 1:
                for _ in range(STEPS_IN_TURN // 4):
                    timed("act", act, batch)
    finally:
        renderer.close()
        torch.set_num_threads(threads)
    student = 1e3 * np.array(times["student"][STEPS_IN_TURN:])
    of_act = 1e3 * float(np.mean(times["act"][STEPS_IN_TURN // 4 :]))
    return {
        "student_mean_ms": float(student.mean()),
        "student_median_ms": float(np.median(student)),
        "student_p95_ms": float(np.quantile(student, 0.95)),
        "act_mean_ms": of_act,
        "times_as_fast_as_act": of_act / float(student.mean()),
    }


def benchmark_training(policy: HVPolicy, tasks: list[Task], batch_size: int, seconds: float) -> dict[str, float]:
    """Samples a second through forward, backward and optimiser of the policy and of stock ACT, in turn, on one batch of
    glances (their reading and decoding left out).

    Args:
        policy: who is trained; its weights are changed.
        tasks: whose rooms the pictures show.
        batch_size: pictures of the batch.
        seconds: how long each of them is trained.
    """
    rows = _some_rows(tasks, batch_size, policy.config.image_size)
    batch = _collated(rows)
    act = stock_act(policy).train()
    chunk = torch.zeros(batch_size, act.config.chunk_size, batch[ACTION].shape[-1])
    padding = torch.zeros(batch_size, act.config.chunk_size, dtype=torch.bool)
    for_act = {HEAD_IMAGE: batch[HEAD_IMAGE], OBS_STATE: batch[OBS_STATE], ACTION: chunk, "action_is_pad": padding}
    policy.train()
    steps = {"student": _training_step(policy, batch), "act": _training_step(act, for_act)}
    done, spent = dict.fromkeys(steps, 0), dict.fromkeys(steps, 0.0)
    for step in steps.values():
        step()
    while min(spent.values()) < seconds:
        for name, step in steps.items():
            until = spent[name] + seconds / 3
            while spent[name] < until:
                start = time.perf_counter()
                step()
                spent[name] += time.perf_counter() - start
                done[name] += 1
    figures = {f"{name}_samples_per_s": batch_size * done[name] / spent[name] for name in steps}
    return figures | {"trains_times_as_fast_as_act": figures["student_samples_per_s"] / figures["act_samples_per_s"]}


def _training_step(policy: PreTrainedPolicy, batch: dict[str, Any]) -> Callable[[], None]:
    optimizer = torch.optim.AdamW([p for p in policy.parameters() if p.requires_grad], lr=1e-6)

    def step() -> None:
        loss, _ = policy.forward(dict(batch))
        loss.backward()
        optimizer.step()
        optimizer.zero_grad()

    return step


def _some_rows(tasks: list[Task], count: int, image_size_px: int) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = []
    glances = -(-count // len(tasks))
    for _, frames in glance_frames(tasks, list(range(len(tasks))), glances, image_size_px, NO_LOOKS):
        rows += frames
    return rows[:count]


def _collated(rows: list[dict[str, Any]]) -> dict[str, Any]:
    batch: dict[str, Any] = {}
    for key, first in rows[0].items():
        values = [row[key] for row in rows]
        batch[key] = values if isinstance(first, str) else torch.from_numpy(np.stack(values))
    batch[HEAD_IMAGE] = batch[HEAD_IMAGE].permute(0, 3, 1, 2).float() / 255
    return batch
