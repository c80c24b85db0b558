"""What keeps a student from doing its tasks: rollouts in which some of what it believes is replaced by the truth, and
how far the rest of it is off in each phase of the work."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from hv_policy.belief.acting import BeliefStudent
from hv_policy.belief.belief import BeliefConfig
from hv_policy.belief.floor_map import CELL_M, CELLS, ORIGIN_M
from hv_policy.belief.outline import compass_yaw_rad
from hv_policy.belief.places import GOAL, GROUPS, OBJECT, PICK, PLACE, to_frame, turned
from hv_policy.belief.student import Following
from hv_policy.belief.task_places import places_of
from hv_policy.decision.view import Phase
from hv_sim.metrics import SUCCESS_THRESHOLDS_M, EpisodeRecord
from hv_sim.physics_backends import make_renderer
from hv_sim.rendering import StepCamera
from hv_sim.task import Task
from hv_sim.world import RearrangeWorld
from hv_teachers.corrected_student import load_student, see_and_decide, true_pose
from hv_teachers.floor_labels import taken_floor
from hv_teachers.routes import RouteViews

TOLD = ("object", "goal", "floor")
"""What a student can be told: where the object is, where its goal is, which floor is taken (not by the robot)."""
_PLACES = {"object": OBJECT, "goal": GOAL, "stand": PICK, "place_stand": PLACE}
_CERTAIN_M = 0.01
_EVERY = 15


@dataclass
class Diagnosis:
    """What came of it."""

    records: list[EpisodeRecord]
    steps: dict[str, int] = field(default_factory=dict)
    """Control steps spent in each phase, of all episodes until they fell."""
    errors: dict[str, dict[str, float]] = field(default_factory=dict)
    """Phase -> median errors: places of `object`, `goal`, `stand`, `place_stand` and odometry's `pose` in m, `walls` in
    degrees."""
    fell_in: dict[str, int] = field(default_factory=dict)

    def success(self, subtask: int | None) -> float:
        """Share of episodes in which a sub-task, or every one, ends within the paper's threshold."""
        done = [record.succeeded(SUCCESS_THRESHOLDS_M[0]) for record in self.records]
        return float(np.mean([all(d) if subtask is None else subtask < len(d) and d[subtask] for d in done]))


@torch.no_grad()
def diagnose(
    folder: Path,
    tasks: Sequence[Task],
    seed: int,
    told: Sequence[str] = (),
    max_episode_steps: int | None = None,
    on_step: Callable[[int, int], None] | None = None,
) -> Diagnosis:
    """Lets a student of the form `belief` play.

    Args:
        folder: its checkpoint.
        tasks: all of them side by side.
        seed: of the episodes.
        told: some of `TOLD`.
        max_episode_steps: see `RearrangeWorld`.
        on_step: called with the number of each control step and of all there will be.

    Raises:
        ValueError: the folder holds no such policy, or there is nothing that `told` names.
    """
    unknown = [name for name in told if name not in TOLD]
    if unknown:
        raise ValueError(f"told: {unknown[0]!r} is not valid; valid: {', '.join(TOLD)}")
    student = load_student(Path(folder)).student
    assert isinstance(student, BeliefStudent)
    world = RearrangeWorld(tasks, max_episode_steps=max_episode_steps)
    world.reset(seeds=[seed * 1000 + i for i in range(world.num_envs)])
    routes, start = RouteViews(world.num_envs), true_pose(world)
    following = Following.begin(student.network, world.instructions(), BeliefConfig())
    floors: list[Tensor] = []
    result = Diagnosis([])
    errors: dict[str, list[list[float]]] = {}
    renderer = make_renderer("cpu", student.config.image_size, student.config.image_size)
    camera, step = StepCamera(renderer, world.physics, None), 0
    try:
        while not bool(world.done.all()):
            following.hear(world.instructions())
            state = world.observe().proprioception
            routes.follow(world)
            truth = places_of(routes.view(world))
            _tell(following, truth, told)
            if "floor" in told and step % _EVERY == 0:
                floors = [_true_floor(world, env, start[env]) for env in range(world.num_envs)]
            for env, floor in enumerate(floors):
                following.wayfinder.floor.evidence[env] = floor
            decided = see_and_decide(student, following, world, camera, state)
            live = (~world.done & ~world.fallen).nonzero()[:, 0].tolist()
            phases = [Phase(int(p)).name for p in following.memory.phase]
            for env in live:
                result.steps[phases[env]] = result.steps.get(phases[env], 0) + 1
            if step % _EVERY == 0:
                found = _errors(following, truth, start, true_pose(world))
                for env in live:
                    errors.setdefault(phases[env], []).append(found[env].tolist())
            before = world.fallen.clone()
            world.step(following.prior(state, decided))
            for env in (world.fallen & ~before).nonzero()[:, 0].tolist():
                result.fell_in[phases[env]] = result.fell_in.get(phases[env], 0) + 1
            camera.forget()
            step += 1
            if on_step is not None:
                on_step(step, world.max_episode_steps)
    finally:
        renderer.close()
    result.records = world.records()
    names = (*_PLACES, "pose", "walls")
    for phase, rows in errors.items():
        result.errors[phase] = dict(zip(names, np.median(np.array(rows), 0).tolist(), strict=True))
    return result


def _tell(following: Following, truth_h: Tensor, told: Sequence[str]) -> None:
    belief = following.belief
    truth = to_frame(truth_h, belief.pose)
    for name in set(told) & set(_PLACES):
        place = _PLACES[name]
        belief.places[:, place] = truth[:, place]
        groups = [i for i, group in enumerate(GROUPS) if place.start <= group.start < place.stop]
        belief.variance[:, groups] = _CERTAIN_M**2


def _true_floor(world: RearrangeWorld, env: int, start: Tensor) -> Tensor:
    """(X, Y) evidence of a `FloorMap` that knows the walls, the furniture and the things on the floor."""
    along = ORIGIN_M + (torch.arange(CELLS) + 0.5) * CELL_M
    points = torch.cartesian_prod(along, along)
    moved = turned(points, start[2:].cos()[None], start[2:].sin()[None]) + start[:2]
    taken = taken_floor(world, env, moved.double().numpy())
    return torch.where(torch.from_numpy(taken).view(CELLS, CELLS), 4.0, -4.0)


def _errors(following: Following, truth_h: Tensor, start: Tensor, now: Tensor) -> Tensor:
    """(N, 6) of what is believed, see `Diagnosis.errors`."""
    belief = following.belief
    believed = belief.now()
    away = [(believed - truth_h)[:, place][:, :2].norm(dim=1) for place in _PLACES.values()]
    counted = turned(belief.pose[:, :2], start[:, 2:].cos(), start[:, 2:].sin()) + start[:, :2]
    walls = compass_yaw_rad(belief.compass) - belief.pose[:, 2] + now[:, 2]
    quarter = torch.pi / 2
    askew = (torch.remainder(walls + quarter / 2, quarter) - quarter / 2).abs()
    return torch.stack([*away, (counted - now[:, :2]).norm(dim=1), torch.rad2deg(askew)], 1)
