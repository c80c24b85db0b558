"""A practice world as plain tensors, so that a training that was killed goes on with the very same numbers.

Putting a state back gives up what MuJoCo's solver remembers from the step before. A training therefore puts its own
state back right after saving it: whoever goes on from the file and whoever was never killed then step alike.
"""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
import torch

from hv_policy.decision.memory import TaskMemory
from hv_policy.motor.prior import MotorPrior
from hv_policy.motor.reference import ReferenceState
from hv_sim.navigation import SubTaskRoute
from hv_sim.world import RearrangeWorld
from hv_teachers.planner import ScriptedPlanner
from hv_teachers.planner_memory import lend_memory, memory_of
from hv_teachers.teacher_env import TeacherEnv

_WORLD = ("episode_step", "fallen", "_distance_at_instruction_m")
_INSTRUCTOR = ("num_finished", "steps_since_instruction", "steps_held")
_NAVIGATOR = ("progress", "picked_up", "_object_start_w")
_ROUTE = ("pick_stand_xy_yaw", "place_stand_xy_yaw", "waypoints_to_object", "waypoints_to_goal", "grasp_o")
_ROUTE_NUMBERS = ("depth_m", "steps_back", "steps_off")
_ENV = ("episodes", "start_height", "_height_of")


def save_env(env: TeacherEnv) -> dict[str, Any]:
    """Everything that decides how the practice goes on: tensors, numbers and lists of them."""
    senses = env.senses
    return {
        "world": _save_world(env.world),
        "prior": _save_prior(env.prior),
        "planner": _tensors(memory_of(env.planner)) | {"lost": env.planner.lost.clone()},
        "memory": _tensors(senses.memory),
        "last_action": senses.last_action.clone(),
        "lost": senses.lost.clone(),
        "gave_up": senses.gave_up.clone(),
        "rising": {"left_s": senses.rising.left_s.clone(), "intent": senses.rising.intent.clone()},
        "risen_from": senses._risen_from.clone(),
        "spurned": senses.routes.spurned_rad.clone(),
        "subtask": senses.routes.subtask.clone(),
        "planned_rot": senses.routes.planned_rot_w.clone(),
        "rolls": senses.routes.rolls.clone(),
        "frames": env.history.frames.clone(),
        "fresh": env.history.fresh.clone(),
        "env": {name: getattr(env, name).clone() for name in _ENV},
    }


def restore_env(env: TeacherEnv, saved: dict[str, Any]) -> None:
    """Puts back what `save_env` gave, into an environment of the same tasks and configuration."""
    _restore_world(env.world, saved["world"])
    _restore_prior(env.prior, saved["prior"])
    _restore_planner(env.planner, saved["planner"])
    senses = env.senses
    senses.memory = TaskMemory(**{k: v.clone() for k, v in saved["memory"].items()})
    senses.last_action, senses.lost = saved["last_action"].clone(), saved["lost"].clone()
    senses.routes.reset(torch.arange(env.num_envs))
    senses.routes.follow(env.world)  # taken over without starting the memory anew
    senses.routes.planned_rot_w, senses.routes.rolls = saved["planned_rot"].clone(), saved["rolls"].clone()
    senses.gave_up = saved["gave_up"].clone()
    senses.rising.left_s, senses.rising.intent = (saved["rising"][name].clone() for name in ("left_s", "intent"))
    senses._risen_from = saved["risen_from"].clone()
    senses.routes.spurned_rad, senses.routes.subtask = saved["spurned"].clone(), saved["subtask"].clone()
    env.forget_sight()
    env.history.frames, env.history.fresh = saved["frames"].clone(), saved["fresh"].clone()
    for name in _ENV:
        setattr(env, name, saved["env"][name].clone())


def _save_world(world: RearrangeWorld) -> dict[str, Any]:
    physics = [world.physics.data(i) for i in range(world.num_envs)]
    routes = []
    for route in world.navigator.routes:
        assert route is not None
        arrays = {name: torch.as_tensor(np.array(getattr(route, name), dtype=np.float64)) for name in _ROUTE}
        numbers: dict[str, Any] = {name: getattr(route, name) for name in _ROUTE_NUMBERS}
        routes.append(arrays | numbers | {"ahead": torch.as_tensor(route.ahead)})
    return {
        "qpos": [torch.tensor(data.qpos) for data in physics],
        "qvel": [torch.tensor(data.qvel) for data in physics],
        "world": {name: getattr(world, name).clone() for name in _WORLD},
        "episode_seed": list(world.episode_seed),
        "episodes_begun": torch.tensor(world._episodes_begun),
        "instructor": {name: getattr(world.instructor, name).clone() for name in _INSTRUCTOR},
        "navigator": {name: getattr(world.navigator, name).clone() for name in _NAVIGATOR},
        "routes": routes,
    }


def _restore_world(world: RearrangeWorld, saved: dict[str, Any]) -> None:
    everyone = list(range(world.num_envs))
    world.physics.reset(everyone, [q.numpy() for q in saved["qpos"]], [v.numpy() for v in saved["qvel"]])
    for name, value in saved["world"].items():
        setattr(world, name, value.clone())
    world.episode_seed = list(saved["episode_seed"])
    world._episodes_begun = saved["episodes_begun"].numpy().copy()
    for name, value in saved["instructor"].items():
        setattr(world.instructor, name, value.clone())
    for name, value in saved["navigator"].items():
        setattr(world.navigator, name, value.clone())
    for i, route in enumerate(saved["routes"]):
        arrays = {name: route[name].numpy() for name in _ROUTE}
        numbers = {name: route[name] for name in _ROUTE_NUMBERS}
        world.navigator.take(i, SubTaskRoute(**arrays, **numbers, ahead=route["ahead"].numpy()))
    world._look()


def _save_prior(prior: MotorPrior) -> dict[str, Any]:
    if prior.memory is None:
        return {}
    assert prior._last_residual is not None
    assert prior._fresh is not None
    return {
        "memory": _tensors(prior.memory),
        "last_residual": prior._last_residual.clone(),
        "fresh": prior._fresh.clone(),
        "getting_up": {} if prior.getting_up is None else prior.getting_up.state(),
    }


def _restore_prior(prior: MotorPrior, saved: dict[str, Any]) -> None:
    prior.reset()
    if saved:
        prior.memory = ReferenceState(**{k: v.clone() for k, v in saved["memory"].items()})
        prior._last_residual, prior._fresh = saved["last_residual"].clone(), saved["fresh"].clone()
        if prior.getting_up is not None:
            prior.getting_up.restore(saved["getting_up"])


def _restore_planner(planner: ScriptedPlanner, saved: dict[str, Any]) -> None:
    rows = {k: v.clone() for k, v in saved.items() if k != "lost"}
    lend_memory(TaskMemory(**rows), planner)
    planner.lost = saved["lost"].clone()


def _tensors(state: Any) -> dict[str, torch.Tensor]:
    return {f.name: getattr(state, f.name).clone() for f in fields(state)}
