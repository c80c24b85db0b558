"""The first privileged controller: the scripted planner says what to do, the motor prior does it."""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor

from hv_policy.motor import embodiment as body
from hv_policy.motor.prior import MotorPrior, load_shipped_motor_prior
from hv_sim.observations import Heading, proprioception
from hv_sim.world import RearrangeWorld
from hv_teachers.planner import Phase, PlannerConfig, PlannerView, ScriptedPlanner


class PlannerExpert:
    """Plays any number of sub-tasks in every environment of a world: `intent, joint_targets = expert(world)`.

    It follows the world's own bookkeeping: a new episode or a new instruction starts the script anew, and an object
    that
    slipped away is fetched again along a new route.

    Args:
        num_envs: environments of the worlds it will be shown.
        prior: the controller below it (default: the shipped one).
        planner: speeds and distances of the script.
    """

    def __init__(self, num_envs: int, prior: MotorPrior | None = None, planner: PlannerConfig | None = None) -> None:
        self.prior = prior or load_shipped_motor_prior()
        self.planner = ScriptedPlanner(num_envs, planner)
        self._rows = torch.arange(num_envs)
        self._routes: list[object | None] = [None] * num_envs
        self._pick_stand = torch.zeros(num_envs, 3)
        self._place_stand = torch.zeros(num_envs, 3)
        self._grasp_o = torch.zeros(num_envs, 2, 3)
        self._depth_m = torch.zeros(num_envs)
        self._last = torch.zeros(num_envs, 2, dtype=torch.long)

    def reset(self, ids: Tensor | None = None) -> None:
        """Forgets environments `ids` (default: all); needed only between worlds, a new episode is noticed."""
        rows = self._rows if ids is None else torch.as_tensor(ids)
        self.planner.reset(rows)
        self.prior.reset(None if ids is None else rows)
        for i in rows.tolist():
            self._routes[i] = None

    def __call__(self, world: RearrangeWorld) -> tuple[Tensor, Tensor]:
        """Intents (N, 14) and servo targets (N, 28) in rad for the world's present state."""
        begun = (world.episode_step == 0).nonzero()[:, 0]
        if len(begun):
            self.reset(begun if len(begun) < world.num_envs else None)
        # an object that slipped away, or was kicked before it was lifted, needs a new way to it
        kicked = world.navigator.picked_up & (self.planner.phase <= Phase.SQUEEZE)
        ids = ((self.planner.lost | kicked) & ~world.done).nonzero()[:, 0]
        if len(ids):
            state = world.state
            world.navigator.plan(
                ids, world.subtask_index, state.link_pos_w[:, 0], state.object_pos_w, state.object_rot_w
            )
        self._follow_routes(world)
        heading = Heading.of(world.state)
        intent = self.planner(self._view(world, heading))
        return intent, self.prior(proprioception(world.state, heading), intent)

    def _follow_routes(self, world: RearrangeWorld) -> None:
        for i, route in enumerate(world.navigator.routes):
            if route is self._routes[i] or route is None:
                continue
            replanned_after_loss = self._routes[i] is not None and bool(self.planner.lost[i])
            self._routes[i] = route
            self._pick_stand[i] = torch.as_tensor(route.pick_stand_xy_yaw, dtype=torch.float32)
            self._place_stand[i] = torch.as_tensor(route.place_stand_xy_yaw, dtype=torch.float32)
            scene, index = world.scenes[i], int(world.object_index[i])
            left_right = torch.as_tensor(np.asarray(scene.grasps_o[index, route.grasp_index]), dtype=torch.float32)
            self._grasp_o[i] = left_right.flip(0)
            half = scene.half_extents_m[index]
            self._depth_m[i] = 2.0 * float(half[route.grasp_index % 2])
            to_object = len(route.waypoints_to_object)
            self._last[i, 0], self._last[i, 1] = to_object - 1, to_object + len(route.waypoints_to_goal) - 1
            if not replanned_after_loss:
                self.planner.reset(self._rows[i : i + 1])

    def _view(self, world: RearrangeWorld, heading: Heading) -> PlannerView:
        state, rows = world.state, self._rows
        index = world.object_index
        position, rotation = state.object_pos_w[rows, index], state.object_rot_w[rows, index]
        grasp = (rotation[:, None] @ self._grasp_o[..., None])[..., 0] + position[:, None]
        waypoint_index = world.navigator.waypoint_index
        return PlannerView(
            root_xy=state.link_pos_w[:, 0, :2],
            root_yaw=torch.atan2(heading.sin, heading.cos),
            hands=state.link_pos_w[:, body.HANDS],
            object_pos=position,
            grasp=grasp,
            depth_m=self._depth_m,
            goal_pos=world.goal_pos_w[rows, world.subtask_index],
            pick_stand=self._pick_stand,
            place_stand=self._place_stand,
            waypoint=world.navigator.current_waypoint[:, :2],
            waypoint_is_last=(waypoint_index[:, None] == self._last).any(-1),
        )
