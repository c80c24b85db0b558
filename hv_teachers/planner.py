"""The scripted planner: from the privileged state to intents, for every environment at once.

approach -> align -> reach -> squeeze -> lift -> carry -> align at the goal -> lower -> release -> retreat -> idle.
Where the object, the hands and the robot are decides what comes next; only pressing, raising, letting go and giving up
take their time by the clock. So it can also tell what to do from a state that it did not bring about: an object that
slipped away, or was put down in the wrong place, is approached again.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from hv_policy.batch_invariant import atan2
from hv_policy.decision.view import Phase, TaskView
from hv_policy.motor.embodiment import CONTROL_DT_S, HAND_RADIUS_M
from hv_policy.motor.intent import GAZE, HEIGHT, LEFT_HAND, PITCH, RIGHT_HAND, SQUEEZE, VELOCITY, neutral_intent
from hv_teachers.postures import reach_posture


@dataclass(frozen=True)
class PlannerConfig:
    """Speeds (m/s, rad/s), distances (m), durations (s) of the script."""

    walk_speed: float = 1.0
    carry_speed: float = 0.75
    turn_rate: float = 1.4
    align_distance_m: float = 0.45
    stand_tolerance_m: float = 0.045
    stand_tolerance_rad: float = 0.06
    pre_grasp_m: float = 0.08
    squeeze_in_m: float = 0.02
    blocked_s: float = 5.0
    """Who has not turned to a stand's heading by then turns round to the left, then to the right, and so on."""
    turn_round_s: float = 8.0
    """For so long each."""
    settle_s: float = 0.4
    """The feet come to rest before the body bends."""
    reach_s: float = 1.4
    reach_tolerance_m: float = 0.02
    """An object that is gripped so far before or behind its centre of mass hangs askew."""
    squeeze_s: float = 0.6
    grip_down_m: float = 0.017
    """Hands press so far below the route's grasp points, as long as that is over `least_grip_m`."""
    least_grip_m: float = 0.1
    lift_s: float = 2.0
    lower_s: float = 1.5
    lower_s_per_m: float = 1.6
    touch_m: float = 0.028
    """An object that stays so far above where it was lowered to has touched something: its support."""
    open_m: float = 0.12
    """Gap between hand and object when it is let go."""
    release_s: float = 0.7
    carry_height_m: float = 1.0
    clearance_m: float = 0.15
    lost_m: float = 0.25
    missed_m: float = 0.3
    """Farther than this from its goal an object that was let go is fetched again."""
    clear_s: float = 1.6
    """The hands stay apart until they are past the object."""
    retreat_m: float = 1.15
    retreat_speed: float = 0.35


class ScriptedPlanner:
    """Keeps each environment's phase; call it once per control step with what is to be seen."""

    def __init__(self, num_envs: int, config: PlannerConfig | None = None) -> None:
        self.config = config or PlannerConfig()
        self.num_envs = num_envs
        self.phase = torch.zeros(num_envs, dtype=torch.long)
        """(N,) `Phase` of each environment."""
        self.clock_s = torch.zeros(num_envs)
        """(N,) time in the phase."""
        self.lost = torch.zeros(num_envs, dtype=torch.bool)
        """(N,) the object slipped away at the last step: a new route to it is needed."""
        self.object_target = torch.zeros(num_envs, 3)
        """(N, 3) where the object should be now, world frame; meaningful from LIFT to LOWER."""
        self._from_hands = torch.zeros(num_envs, 2, 3)  # heading frame, when SQUEEZE, LIFT, LOWER or RELEASE began
        self._offset = torch.zeros(num_envs, 2, 3)  # hands relative to the object when it was grasped, heading frame
        self._from_object = torch.zeros(num_envs, 3)
        self._start_height = torch.zeros(num_envs)

    def reset(self, ids: Tensor | None = None, phase: Tensor | int = Phase.APPROACH) -> None:
        """Starts anew in environments `ids` (default: all), in the given phase."""
        ids = torch.arange(self.num_envs) if ids is None else torch.as_tensor(ids)
        self.phase[ids] = torch.as_tensor(phase, dtype=torch.long)
        self.clock_s[ids] = 0.0
        self.lost[ids] = False
        self._start_height[ids] = -1.0

    def __call__(self, view: TaskView) -> Tensor:
        """(N, 14) intents for this control step."""
        c = self.config
        hands = _to_heading(view, view.hands)
        grasp = self._gripped(_to_heading(view, view.grasp))
        obj = _to_heading(view, view.object_pos[:, None])[:, 0]
        self._advance(view, hands, grasp, obj)
        phase, clock = self.phase, self.clock_s
        intent = neutral_intent(self.num_envs)

        def during(*phases: Phase) -> Tensor:
            return torch.stack([phase == p for p in phases]).any(0)

        # where to go
        pick, pick_distance = _hold(view, view.pick_stand, (clock - c.blocked_s) / c.turn_round_s)
        place, place_distance = _hold(view, view.place_stand, (clock - c.blocked_s) / c.turn_round_s)
        carrying = during(Phase.CARRY)
        speed = torch.where(carrying, c.carry_speed, c.walk_speed)
        stand_distance = torch.where(carrying, place_distance, pick_distance)
        push_h = _push(view, torch.where(during(Phase.RETREAT), torch.ones_like(clock), stand_distance))
        walking = _walk(view, speed, c.turn_rate, stand_distance, push_h)
        retreat = torch.zeros_like(walking)
        retreat[:, 0] = -c.retreat_speed
        velocity = torch.zeros_like(walking)
        velocity = torch.where(during(Phase.APPROACH, Phase.CARRY)[:, None], walking, velocity)
        velocity = torch.where(during(Phase.ALIGN)[:, None], pick, velocity)
        velocity = torch.where(during(Phase.ALIGN_PLACE)[:, None], place, velocity)
        velocity = torch.where((during(Phase.RETREAT) & (clock > 0.4))[:, None], retreat + push_h, velocity)
        intent[:, VELOCITY] = velocity

        # where the hands go: right, left
        neutral = torch.stack([intent[:, RIGHT_HAND], intent[:, LEFT_HAND]], 1)
        outward = grasp - grasp.mean(1, keepdim=True)
        outward = outward / outward.norm(dim=-1, keepdim=True).clamp(min=1e-3)
        pre_grasp = grasp + outward * (HAND_RADIUS_M + c.pre_grasp_m)
        # pressed along the line on which the hands have come: hands that followed an object's sides as it turns would
        # turn it further
        line = self._from_hands - self._from_hands.mean(1, keepdim=True)
        line = line / line.norm(dim=-1, keepdim=True).clamp(min=1e-3)
        half_width = (grasp[:, 0] - grasp[:, 1]).norm(dim=-1)[:, None, None] / 2
        contact = grasp.mean(1, keepdim=True) + line * (half_width + HAND_RADIUS_M - c.squeeze_in_m)
        carry = self._carry_hands(view)
        lift_share = _smooth(clock / c.lift_s)
        lifted = self._from_hands + (carry - self._from_hands) * lift_share[:, None, None]
        lowered_object, lower_share = self._lowered(view)
        lowered = _to_heading(view, lowered_object[:, None])
        correction = lowered[:, 0] - obj
        correction = correction.clamp(-0.06, 0.06) * (during(Phase.LOWER).float() * lower_share)[:, None]
        lowered = lowered + self._offset + correction[:, None] * 0.5
        opened = self._from_hands + line * c.open_m
        hand = neutral
        hand = torch.where(during(Phase.REACH)[:, None, None], pre_grasp, hand)
        hand = torch.where(during(Phase.SQUEEZE)[:, None, None], contact, hand)
        hand = torch.where(during(Phase.LIFT)[:, None, None], lifted, hand)
        hand = torch.where(during(Phase.CARRY, Phase.ALIGN_PLACE)[:, None, None], carry, hand)
        hand = torch.where(during(Phase.LOWER)[:, None, None], lowered, hand)
        hand = torch.where(during(Phase.RELEASE)[:, None, None], opened, hand)
        hand = torch.where((during(Phase.RETREAT) & (clock < c.clear_s))[:, None, None], opened, hand)
        intent[:, RIGHT_HAND], intent[:, LEFT_HAND] = hand[:, 0], hand[:, 1]
        intent[:, SQUEEZE] = during(Phase.SQUEEZE, Phase.LIFT, Phase.CARRY, Phase.ALIGN_PLACE, Phase.LOWER).float()

        # how the body bends for it
        feet = _to_heading(view, torch.cat([view.feet_xy, torch.zeros_like(view.feet_xy[:, :1])], -1)[:, None])[:, 0]

        def bent_to(hands: Tensor) -> tuple[Tensor, Tensor]:
            apart = (hands[:, 0] - hands[:, 1]).norm(dim=-1)
            return reach_posture(hands[..., 2].mean(-1), hands[..., 0].mean(-1) - feet[:, 0], apart)

        low_height, low_pitch = end_height, end_pitch = bent_to(grasp)
        place_height, place_pitch = bent_to(lowered)
        height, pitch = intent[:, HEIGHT], torch.full_like(clock, 0.05)
        settling = during(Phase.REACH) & (clock < c.settle_s)
        low_height, low_pitch = torch.where(settling, height, low_height), torch.where(settling, pitch, low_pitch)
        for phases, h, p in (
            ((Phase.REACH, Phase.SQUEEZE), low_height, low_pitch),
            ((Phase.LIFT,), *bent_to(lifted)),
            ((Phase.LOWER,), place_height, place_pitch),
            ((Phase.RELEASE,), end_height, end_pitch),
        ):
            chosen = during(*phases)
            height, pitch = torch.where(chosen, h, height), torch.where(chosen, p, pitch)
        intent[:, HEIGHT], intent[:, PITCH] = height, pitch

        # what the head looks at
        look = torch.where(during(Phase.CARRY, Phase.ALIGN_PLACE, Phase.LOWER)[:, None], view.goal_pos, view.object_pos)
        look = _to_heading(view, look[:, None])[:, 0]
        distance = look[:, :2].norm(dim=-1)
        intent[:, GAZE.start] = atan2(look[:, 1], look[:, 0]).clamp(-0.7, 0.7) * (distance > 0.2)
        intent[:, GAZE.start + 1] = atan2(1.5 - look[:, 2], distance.clamp(min=0.3)).clamp(0.0, 0.9)

        target = torch.where(during(Phase.LOWER)[:, None], lowered_object, view.object_pos)
        held = (hand - self._offset).mean(1)
        self.object_target = torch.where(
            during(Phase.LIFT, Phase.CARRY, Phase.ALIGN_PLACE)[:, None], _to_world(view, held), target
        )
        self.clock_s = self.clock_s + CONTROL_DT_S
        return intent

    def _advance(self, view: TaskView, hands: Tensor, grasp: Tensor, obj: Tensor) -> None:
        """Goes on to the next phase where the state says so."""
        c, phase, clock = self.config, self.phase, self.clock_s
        unset = self._start_height < 0
        untouched = unset | (phase <= Phase.REACH)
        self._start_height = torch.where(untouched, view.object_pos[:, 2], self._start_height)
        held = unset & (phase > Phase.LIFT) & (phase < Phase.RELEASE)
        if held.any():  # begun in the middle of a carry; below, of taking or letting go
            self._remember(held, view, hands, obj)
        pressing = unset & ((phase == Phase.SQUEEZE) | (phase == Phase.RELEASE))
        self._from_hands = torch.where(pressing[:, None, None], hands, self._from_hands)
        _, pick_error = _hold(view, view.pick_stand)
        _, place_error = _hold(view, view.place_stand)
        pick_turn = _wrap(view.pick_stand[:, 2] - view.root_yaw).abs()
        place_turn = _wrap(view.place_stand[:, 2] - view.root_yaw).abs()
        outward = grasp - grasp.mean(1, keepdim=True)
        outward = outward / outward.norm(dim=-1, keepdim=True).clamp(min=1e-3)
        pre_grasp = grasp + outward * (HAND_RADIUS_M + c.pre_grasp_m)
        pre_error = (hands - pre_grasp).norm(dim=-1).amax(-1)
        slack = 1.0 + (clock - 2.5).clamp(0, 3.0)  # ever less exacting where it does not get better
        away = (view.object_pos[:, :2] - view.root_xy).norm(dim=-1)
        between = (hands - self._offset).mean(1)
        far = (obj - between).norm(dim=-1) > c.lost_m
        above_goal = view.object_pos[:, 2] - view.goal_pos[:, 2]

        aligned = (pick_error < c.stand_tolerance_m * slack) & (pick_turn < c.stand_tolerance_rad * slack)
        placed_aligned = (place_error < c.stand_tolerance_m * slack) & (place_turn < c.stand_tolerance_rad * slack)
        next_phase = phase.clone()

        def go(origin: Phase, condition: Tensor, to: Phase) -> None:
            next_phase[(phase == origin) & condition] = to

        go(Phase.APPROACH, view.waypoint_is_last & (pick_error < c.align_distance_m), Phase.ALIGN)
        go(Phase.ALIGN, aligned & (clock > 0.3), Phase.REACH)
        go(Phase.ALIGN, pick_error > 2.5 * c.align_distance_m, Phase.APPROACH)
        go(Phase.REACH, (clock > c.reach_s) & (pre_error < c.reach_tolerance_m * slack), Phase.SQUEEZE)
        go(Phase.REACH, (clock > 6.0) | (pick_error > 0.35), Phase.ALIGN)
        go(Phase.SQUEEZE, clock > c.squeeze_s, Phase.LIFT)
        go(Phase.LIFT, clock > c.lift_s + 0.3, Phase.CARRY)
        go(Phase.CARRY, view.waypoint_is_last & (place_error < c.align_distance_m), Phase.ALIGN_PLACE)
        go(Phase.ALIGN_PLACE, placed_aligned & (clock > 0.3), Phase.LOWER)
        go(Phase.ALIGN_PLACE, place_error > 2.5 * c.align_distance_m, Phase.CARRY)
        lowered, _ = self._lowered(view)
        touched = (above_goal < 0.12) & (view.object_pos[:, 2] - lowered[:, 2] > c.touch_m)
        lower_s = self._lower_s(view)
        down = ((clock > lower_s) & (above_goal < 0.03)) | (clock > lower_s + 1.0)
        go(Phase.LOWER, down | (touched & (clock > 0.5)), Phase.RELEASE)
        go(Phase.RELEASE, clock > c.release_s, Phase.RETREAT)
        go(Phase.RETREAT, away > c.retreat_m, Phase.IDLE)
        holding = (phase >= Phase.LIFT) & (phase <= Phase.LOWER)
        lost = holding & far & ~((phase == Phase.LIFT) & (clock < 0.2))
        rose = view.object_pos[:, 2] > self._start_height + 0.05
        lost = lost | ((phase == Phase.LIFT) & (next_phase == Phase.CARRY) & ~rose)
        missed = (view.object_pos - view.goal_pos).norm(dim=-1) > c.missed_m
        self.lost = lost | ((phase == Phase.IDLE) & (clock > 1.0) & missed)
        next_phase[self.lost] = Phase.APPROACH
        self._start_height = torch.where(self.lost, -torch.ones_like(clock), self._start_height)

        changed = next_phase != phase
        begun = changed & ((next_phase == Phase.LIFT) | (next_phase == Phase.LOWER))
        if begun.any():
            self._remember(begun, view, hands, obj)
        pressed = changed & ((next_phase == Phase.SQUEEZE) | (next_phase == Phase.RELEASE))
        self._from_hands = torch.where(pressed[:, None, None], hands, self._from_hands)
        self.phase = next_phase
        self.clock_s = torch.where(changed, torch.zeros_like(clock), clock)

    def _remember(self, chosen: Tensor, view: TaskView, hands: Tensor, obj: Tensor) -> None:
        self._from_hands = torch.where(chosen[:, None, None], hands, self._from_hands)
        self._offset = torch.where(chosen[:, None, None], hands - obj[:, None], self._offset)
        self._from_object = torch.where(chosen[:, None], view.object_pos, self._from_object)

    def _lower_s(self, view: TaskView) -> Tensor:
        """(N,) how long the lowering takes: the farther down, the longer."""
        c = self.config
        return c.lower_s + c.lower_s_per_m * (self._from_object[:, 2] - view.goal_pos[:, 2]).clamp(min=0.0)

    def _lowered(self, view: TaskView) -> tuple[Tensor, Tensor]:
        """(N, 3) where the object should be by now while it is lowered, world frame, and the share of the way (N,)."""
        time = self.clock_s / self._lower_s(view)
        across, down = _smooth(time / 0.4), _smooth((time - 0.3) / 0.7)
        goal = view.goal_pos.clone()
        goal[:, 2] -= 0.01
        share = torch.stack([across, across, down], -1)
        return self._from_object + (goal - self._from_object) * share, across

    def _gripped(self, grasp: Tensor) -> Tensor:
        """Where hands shall press (N, 2, 3), heading frame: somewhat below a route's grasp points."""
        height = grasp[..., 2]
        lower = torch.maximum(height - self.config.grip_down_m, height.clamp(max=self.config.least_grip_m))
        return torch.cat([grasp[..., :2], lower[..., None]], -1)

    def _carry_hands(self, view: TaskView) -> Tensor:
        """(N, 2, 3) hands that hold the object before the chest, heading frame."""
        c = self.config
        ahead = (0.2 + view.depth_m / 2).clamp(min=0.34)
        height = torch.maximum(self._start_height, view.goal_pos[:, 2]) + c.clearance_m
        centre = torch.stack([ahead, torch.zeros_like(ahead), height.clamp(min=c.carry_height_m)], -1)
        offset = self._offset.clone()
        offset[..., :2] = offset[..., :2] - offset[..., :2].mean(1, keepdim=True)
        return centre[:, None] + offset


def _smooth(share: Tensor) -> Tensor:
    share = share.clamp(0, 1)
    return share * share * (3 - 2 * share)


def _wrap(angle: Tensor) -> Tensor:
    return torch.remainder(angle + torch.pi, 2 * torch.pi) - torch.pi


def _to_heading(view: TaskView, points_w: Tensor) -> Tensor:
    """(N, P, 3) world points -> heading frame with its origin on the floor under the pelvis."""
    c, s = view.root_yaw.cos()[:, None], view.root_yaw.sin()[:, None]
    x, y = (points_w[..., :2] - view.root_xy[:, None]).unbind(-1)
    return torch.stack([c * x + s * y, c * y - s * x, points_w[..., 2]], -1)


def _to_world(view: TaskView, point_h: Tensor) -> Tensor:
    """(N, 3) heading frame -> world."""
    c, s = view.root_yaw.cos(), view.root_yaw.sin()
    x, y, z = point_h.unbind(-1)
    return torch.stack([view.root_xy[:, 0] + c * x - s * y, view.root_xy[:, 1] + s * x + c * y, z], -1)


def _push(view: TaskView, stand_distance: Tensor) -> Tensor:
    """(N, 3) velocities away from furniture that is too near; not near a stand, where a table is meant to be near."""
    near = ((0.34 - view.clearance_m) / 0.12).clamp(0, 1) * ((stand_distance - 0.4) / 0.3).clamp(0, 1)
    c, s = view.root_yaw.cos(), view.root_yaw.sin()
    x, y = (0.22 * near[:, None] * view.away).unbind(-1)
    return torch.stack([c * x + s * y, c * y - s * x, torch.zeros_like(x)], -1)


def _walk(view: TaskView, speed: Tensor, turn_rate: float, stand_distance: Tensor, push_h: Tensor) -> Tensor:
    """(N, 3) velocities toward the waypoint: turn to it, then go, more slowly where it is narrow."""
    point = torch.cat([view.waypoint, torch.zeros_like(view.waypoint[:, :1])], -1)
    x, y, _ = _to_heading(view, point[:, None])[:, 0].unbind(-1)
    distance = torch.sqrt(x * x + y * y)
    bearing = atan2(y, x)
    backward = view.may_back & (bearing.abs() > 1.9) & (distance < 1.2)
    facing = torch.where(backward, _wrap(bearing + torch.pi), bearing)
    turn = (1.8 * facing).clamp(-turn_rate, turn_rate)
    left = torch.where(view.waypoint_is_last, distance, stand_distance.clamp(min=0.5))
    pace = torch.minimum(speed * (view.clearance_m / 0.45).clamp(0.6, 1.0), 0.15 + 0.6 * left)
    pace = pace * (1.3 * facing.cos() - 0.3).clamp(0, 1)
    pace = torch.where(backward, -pace.clamp(max=0.35), pace)
    return torch.stack([pace, torch.zeros_like(pace), turn], -1) + push_h * ~backward[:, None]


def _hold(view: TaskView, stand: Tensor, blocked: Tensor | None = None) -> tuple[Tensor, Tensor]:
    """(N, 3) velocities that bring the robot to a stand pose without turning away from it, and the distance left (N,).

    Where `blocked` (N,) is above 0 and it has far to turn it turns to the left while that is below 1, to the right
    below 2, and so on; not the longer way, which on half of it would be the shorter one.
    """
    point = torch.cat([stand[:, :2], torch.zeros_like(stand[:, :1])], -1)
    x, y, _ = _to_heading(view, point[:, None])[:, 0].unbind(-1)
    distance = torch.sqrt(x * x + y * y)
    turn = _wrap(stand[:, 2] - view.root_yaw)
    if blocked is not None:
        to_left = torch.remainder(turn, 2 * torch.pi)
        forced = torch.where(torch.remainder(blocked, 2) < 1, to_left, to_left - 2 * torch.pi)
        turn = torch.where((blocked > 0) & (turn.abs() > 0.6), forced, turn)
    near = ((x.abs() < 0.035) & (y.abs() < 0.025) & (turn.abs() < 0.05)).float()
    # gently: a toe that strides into the furniture in front of the stand trips the robot
    forward = (1.1 * x).clamp(-0.25, 0.25)
    left = (1.2 * y).clamp(-0.25, 0.25)
    # slower turns than this are not begun
    rate = (1.6 * turn).clamp(-0.8, 0.8) + 0.1 * turn.sign() * (turn.abs() > 0.04)
    return torch.stack([forward, left, rate], -1) * (1 - near[:, None]), distance
