"""What the planner and the teachers look at: the routes that a world's robots follow, as batched tensors."""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor

from hv_policy.batch_invariant import atan2
from hv_policy.decision.view import Phase, TaskView
from hv_policy.motor import embodiment as body
from hv_sim.navigation import UPRIGHT
from hv_sim.observations import Heading
from hv_sim.world import RearrangeWorld

SPURNED = 6
TURNED = 0.97
"""Cosine of the angle (14 degrees) from which what rolled over is held otherwise."""
REACH_S, ALIGN_S = 9.0, 20.0
"""Who reaches or steps into place for longer will not get there from this side."""


class RouteViews:
    """Keeps, for every environment, the stands, the grasp and the ends of the route that its navigator follows."""

    def __init__(self, num_envs: int) -> None:
        self.num_envs = num_envs
        self._rows = torch.arange(num_envs)
        self._routes: list[object | None] = [None] * num_envs
        self.pick_stand = torch.zeros(num_envs, 3)
        """(N, 3) x, y, yaw where to stand when picking the object up; world frame."""
        self.place_stand = torch.zeros(num_envs, 3)
        """(N, 3) the same for putting it down."""
        self.grasp_o = torch.zeros(num_envs, 2, 3)
        """(N, 2, 3) where the right and the left hand should touch the object, in its frame."""
        self.depth_m = torch.zeros(num_envs)
        """(N,) the object's extent along the robot's view."""
        self.planned_rot_w = torch.eye(3).repeat(num_envs, 1, 1)
        """(N, 3, 3) how the object was turned when the route was planned."""
        self.rolls = torch.zeros(num_envs, dtype=torch.bool)
        """(N,) the object is round and lay on its side then: that it rolls makes no difference."""
        self._last = torch.zeros(num_envs, 2, dtype=torch.long)
        self.spurned_rad = torch.full((num_envs, SPURNED), torch.nan)
        """(N, SPURNED) from where the object was tried in vain, the newest first: see `plan_subtask`."""
        self.subtask = torch.full((num_envs,), -1)
        """(N,) whose object that is."""

    def reset(self, ids: Tensor) -> None:
        """Forgets the routes of environments `ids`, so that the next `follow` finds them new."""
        for i in ids.tolist():
            self._routes[i] = None
        self.subtask[ids] = -1

    def spurn(self, ids: Tensor) -> None:
        """In environments `ids` (n,) the object was tried in vain from the side of the present route."""
        self.spurned_rad[ids] = torch.cat([self.pick_stand[ids, 2:], self.spurned_rad[ids, :-1]], 1)

    def follow(self, world: RearrangeWorld) -> Tensor:
        """Takes over what was planned since the last call; returns the ids (n,) of environments with a new route."""
        pairs = enumerate(zip(world.navigator.routes, self._routes, strict=True))
        other = self.subtask != world.subtask_index
        self.spurned_rad[other] = torch.nan
        self.subtask = world.subtask_index.clone()
        changed = [i for i, (route, known) in pairs if route is not known and route is not None]
        for i in changed:
            route = world.navigator.routes[i]
            assert route is not None
            self._routes[i] = route
            self.pick_stand[i] = torch.as_tensor(route.pick_stand_xy_yaw, dtype=torch.float32)
            self.place_stand[i] = torch.as_tensor(route.place_stand_xy_yaw, dtype=torch.float32)
            self.grasp_o[i] = torch.tensor(np.asarray(route.grasp_o), dtype=torch.float32).flip(0)
            self.depth_m[i] = route.depth_m
            to_object = len(route.waypoints_to_object)
            k = int(world.object_index[i])
            self.planned_rot_w[i] = world.state.object_rot_w[i, k]
            lies = self.planned_rot_w[i, 2, 2].abs() < UPRIGHT
            self.rolls[i] = lies & world.scenes[i].built[k].rolls
            self._last[i, 0], self._last[i, 1] = to_object - 1, to_object + len(route.waypoints_to_goal) - 1
        return torch.tensor(changed, dtype=torch.long)

    def disturbed(self, world: RearrangeWorld, phase: Tensor) -> Tensor:
        """(N,) bool: before it was held in a phase (N,) the object was moved, or it rolled over, since the route was
        planned."""
        now, then = world.state.object_rot_w[self._rows, world.object_index], self.planned_rot_w
        whole = ((now * then).sum((1, 2)) - 1) / 2
        cosine = torch.where(self.rolls, (now[..., 2] * then[..., 2]).sum(1), whole)
        rolled = (cosine < TURNED) & (phase <= Phase.REACH) & (self.subtask == world.subtask_index)
        return rolled | (world.navigator.picked_up & (phase <= Phase.SQUEEZE))

    def _unrolled(self, rotation: Tensor) -> Tensor:
        """(N, 2, 3) where the hands should touch the object, in its frame, turned as (N, 3, 3) now: in a frame that did
        not roll, if it is round."""
        since = self.planned_rot_w.transpose(1, 2) @ rotation
        angle = atan2(since[:, 1, 0] - since[:, 0, 1], since[:, 0, 0] + since[:, 1, 1]) * self.rolls
        cos, sin = angle.cos()[:, None], angle.sin()[:, None]
        x, y, z = self.grasp_o.unbind(-1)
        return torch.stack([cos * x + sin * y, cos * y - sin * x, z], -1)

    def view(self, world: RearrangeWorld, heading: Heading | None = None) -> TaskView:
        """What there is to see now."""
        heading = world.heading if heading is None else heading
        state, rows = world.state, self._rows
        index = world.object_index
        position, rotation = state.object_pos_w[rows, index], state.object_rot_w[rows, index]
        grasp = (rotation[:, None] @ self._unrolled(rotation)[..., None])[..., 0] + position[:, None]
        navigator = world.navigator
        is_last = (navigator.waypoint_index[:, None] == self._last).any(-1)
        clearance, away = navigator.room(state.link_pos_w[:, 0])
        return TaskView(
            root_xy=state.link_pos_w[:, 0, :2],
            root_yaw=atan2(heading.sin, heading.cos),
            feet_xy=state.link_pos_w[:, body.FEET, :2].mean(1),
            hands=state.link_pos_w[:, body.HANDS],
            object_pos=position,
            grasp=grasp,
            depth_m=self.depth_m,
            goal_pos=world.goal_pos_w[rows, world.subtask_index],
            pick_stand=self.pick_stand,
            place_stand=self.place_stand,
            waypoint=navigator.current_waypoint[:, :2],
            waypoint_is_last=is_last,
            may_back=is_last | navigator.stepping_back,
            clearance_m=clearance,
            away=away,
        )


def replan_routes(world: RearrangeWorld, ids: Tensor, spurned_rad: Tensor | None = None) -> None:
    """Plans the routes of environments `ids` (n,) anew, from where robot and objects now are, rather not facing as in
    `spurned_rad` (N, M)."""
    if len(ids):
        state = world.state
        places = state.link_pos_w[:, 0], state.object_pos_w, state.object_rot_w
        world.navigator.plan(ids, world.subtask_index, *places, spurned_rad)


def gave_up(before: Tensor, phase: Tensor, clock_s: Tensor) -> Tensor:
    """(N,) bool: an object could not be reached, from phases (N,) before and after a step and the time in it (N,)."""
    reached_in_vain = (before == Phase.REACH) & (phase == Phase.ALIGN)
    stuck = ((phase == Phase.REACH) & (clock_s > REACH_S)) | ((phase == Phase.ALIGN) & (clock_s > ALIGN_S))
    return reached_in_vain | stuck
