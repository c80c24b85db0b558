"""Finds the robot's way: to where the object is taken, back from there, on to its goal; or to where there is more to
see. What the decisions are told of it is what the teachers are told of their routes (`hv_policy.belief.places`)."""

from __future__ import annotations

import copy
from enum import IntEnum

import numpy as np
import torch
from torch import Tensor

from hv_policy.belief.attitude import face_yaw_rad
from hv_policy.belief.floor_map import FloorMap
from hv_policy.belief.outline import half_extent_m
from hv_policy.belief.places import (
    DEPTH,
    GOAL,
    MIDDLE,
    OBJECT,
    PICK,
    PICK_TURN,
    PLACE,
    PLACE_TURN,
    SPAN,
    WAY_DIM,
)
from hv_policy.belief.stands import Stand, choose_stand, is_same_side
from hv_policy.belief.ways import Reach, Way, Window, place_to_look_from, room_here, step_back, way_to, way_to_stand
from hv_policy.decision.view import Phase

LOOKS_A_PLAN = 3
"""A path is planned anew after so many looks, or when the stand that it leads to has moved by more than:"""
MOVED_M, MOVED_RAD = 0.15, 0.4
KEEP_OFF_M = 0.3
"""Ways to an object do not lead nearer past it than this, when its sides are compared."""
BACK_M = 0.12
"""Short of its end by this, the way back counts as done."""
AWAY_M = 0.35
"""So near to where it walks away to it has got there."""
LET_LIE_M, LOOKS_BACK = 0.5, 21
"""From what slipped out of its hands the robot walks back so far, for so many looks at most."""


class Leg(IntEnum):
    """Where a way leads."""

    TO_OBJECT = 0
    BACK = 1
    TO_GOAL = 2
    TO_LOOK = 3


class Wayfinder:
    """Maps and ways of N environments."""

    def __init__(self, num: int) -> None:
        self.floor = FloorMap(num)
        self.way = torch.zeros(num, WAY_DIM)
        """(N, 8) as `hv_policy.belief.places` has it, but in the frame of odometry."""
        self._legs: list[Leg | None] = [None] * num
        self._paths: list[Way | None] = [None] * num
        self._stands = np.zeros((num, 3))
        self._ages = [0] * num
        self._back_to = np.zeros((num, 3))
        self._picks: list[Stand | None] = [None] * num
        self._places: list[Stand | None] = [None] * num
        self._failed_rad: list[list[float]] = [[] for _ in range(num)]
        self._looked_from: list[list[np.ndarray]] = [[] for _ in range(num)]
        self._reaches: list[tuple[Reach, np.ndarray, int] | None] = [None] * num
        self._looks_back = [0] * num
        self._away_to: list[Tensor | None] = [None] * num

    def copy(self) -> Wayfinder:
        """The same, sharing nothing that changes."""
        return copy.deepcopy(self)

    def forget(self, env: int) -> None:
        """Environment `env` has something else to do; the floor is still the same."""
        self._legs[env] = self._paths[env] = None
        self._looked_from[env], self._failed_rad[env] = [], []
        self._picks[env] = self._places[env] = self._reaches[env] = None
        self._looks_back[env], self._away_to[env] = 0, None

    def walk_away(self, env: int, pose: Tensor, reach_m: float) -> None:
        """Environment `env`, at `pose` (3,), cannot step back from what it has put down: it shall walk to where the way
        is open, so far away."""
        self._away_to[env] = self.place_to_look_from(env, pose, reach_m)

    def _away(self, env: int, pose: Tensor) -> Tensor | None:
        """(2,) where it still has to walk away to, if it has to."""
        place = self._away_to[env]
        if place is not None and float((place - pose[:2]).norm()) < AWAY_M:
            place = self._away_to[env] = None
        return place

    def step_back(self, env: int) -> None:
        """Environment `env` shall walk straight back before it goes on to the object: what slipped out of its hands
        lies at its feet, where it does not see it and trips over it."""
        self._looks_back[env], self._legs[env] = LOOKS_BACK, None

    @property
    def steps_back(self) -> Tensor:
        """(N,) bool who does."""
        return torch.tensor(self._looks_back) > 0

    def fail(self, env: int) -> int:
        """The object could not be taken from where environment `env` stands; how often that was so on this side."""
        pick, failed = self._picks[env], self._failed_rad[env]
        if pick is None:
            return 0
        failed.append(pick.yaw_rad)
        return sum(is_same_side(pick.yaw_rad, other) for other in failed)

    def place_to_look_from(self, env: int, pose: Tensor, reach_m: float) -> Tensor:
        """(2,) where environment `env` goes next, having looked all round at `pose` (3,) in vain."""
        xy, before = pose[:2].double().numpy(), self._looked_from[env]
        place = place_to_look_from(self.floor.evidence[env].numpy(), xy, reach_m, before)
        before.append(xy)
        return torch.from_numpy(place).float()

    def go_on(self, env: int, pose: Tensor, places: Tensor, phase: int, look_at: Tensor | None) -> None:
        """Finds `way` of an environment after it has looked.

        Args:
            env: its number.
            pose: (3,) x, y, yaw of the robot in the frame of odometry, which all is in.
            places: (21,) what is believed.
            phase: of the work.
            look_at: (2,) a place to go to and look round from, instead of the work.
        """
        look_at = self._away(env, pose) if look_at is None else look_at
        self.floor.stand(env, pose[:2])
        robot, known = pose.double().numpy(), places.double().numpy()
        evidence = self.floor.evidence[env].numpy()
        clearance, away = room_here(evidence, robot[:2])
        leg = self._leg(env, phase, robot, evidence, look_at is not None)
        if leg != self._legs[env]:
            self._paths[env] = None
        self._legs[env] = leg
        if leg == Leg.BACK:
            waypoint, is_last, may_back = self._back_to[env, :2], False, True
        elif leg == Leg.TO_LOOK:
            assert look_at is not None
            place = np.append(look_at.double().numpy(), 0.0)
            waypoint, _ = self._path(env, evidence, robot[:2], place, leg, None).waypoint(robot[:2])
            is_last = may_back = False
        else:
            of_object = leg == Leg.TO_OBJECT
            at, turn = (PICK, PICK_TURN) if of_object else (PLACE, PLACE_TURN)
            cos, sin = known[turn]
            stand = np.array([*known[at], np.arctan2(sin, cos)])
            if phase in (Phase.APPROACH, Phase.CARRY):
                thing = known[OBJECT][:2] if of_object else None
                waypoint, is_last = self._path(env, evidence, robot[:2], stand, leg, thing).waypoint(robot[:2])
            else:
                waypoint, is_last = stand[:2], True
            may_back = is_last
        row = np.concatenate([waypoint, away, [clearance, is_last, may_back, is_last]])
        self.way[env] = torch.from_numpy(row).float()

    def settle(
        self,
        env: int,
        pose: Tensor,
        places: Tensor,
        outline: Tensor,
        attitude: Tensor,
        compass: Tensor,
        phase: int,
    ) -> Tensor:
        """(21,) the places that are believed, in which where to stand and how to hold the object follow from where
        things are and what the map says.

        Args:
            env, pose, places, phase: as in `go_on`.
            outline, attitude, compass: (3,) and (3,) of the object, (2,) of the room, frame of odometry
                (`hv_policy.belief.outline`, `hv_policy.belief.attitude`).
        """
        settled = places.clone()
        robot, evidence = pose.double().numpy(), self.floor.evidence[env].numpy()
        if phase <= Phase.REACH:
            yaws = face_yaw_rad(attitude[None], compass[None]) + torch.arange(4) * torch.pi / 2
            sides = outline.expand(4, -1)
            depths, widths = 2 * half_extent_m(sides, yaws), 2 * half_extent_m(sides, yaws + torch.pi / 2)
            hint = float(torch.atan2(*places[PICK_TURN].flip(0)))
            before = self._picks[env]
            aligns = phase >= Phase.ALIGN and before is not None
            if aligns and before is not None:  # no other side any more
                keep = int((yaws - before.yaw_rad).cos().argmax())
                yaws, depths, widths = yaws[keep : keep + 1], depths[keep : keep + 1], widths[keep : keep + 1]
            at = places[OBJECT].double().numpy()
            extents = yaws.double().numpy(), depths.numpy(), widths.numpy()
            reach = self._reach(env, evidence, robot[:2], at[:2], KEEP_OFF_M)
            failed = self._failed_rad[env]
            pick = self._picks[env] = choose_stand(reach, at, *extents, hint, before, aligns, failed)
            _put(settled, PICK, PICK_TURN, pick.xy_yaw)
            left = torch.tensor([-np.sin(pick.yaw_rad), np.cos(pick.yaw_rad)]).float()
            settled[SPAN] = torch.cat([widths[pick.number] / 2 * left, torch.zeros(1)])
            settled[MIDDLE][:2] = 0.0
            settled[DEPTH] = depths[pick.number]
        before = self._places[env]
        if Phase.LIFT <= phase <= Phase.CARRY:
            facings, aligns = np.linspace(0.0, 2 * np.pi, 16, endpoint=False), False
            hint = float(torch.atan2(*places[PLACE_TURN].flip(0)))
        elif before is not None and phase <= Phase.LOWER:
            facings, hint, aligns = np.array([before.yaw_rad]), before.yaw_rad, True
        else:
            return settled
        goal, none = places[GOAL].double().numpy(), np.zeros(len(facings))
        reach = self._reach(env, evidence, robot[:2], goal[:2], 0.0)
        place = choose_stand(reach, goal, facings, none + float(places[DEPTH]), none, hint, before, aligns)
        self._places[env] = place
        _put(settled, PLACE, PLACE_TURN, place.xy_yaw)
        return settled

    def _reach(self, env: int, evidence: np.ndarray, xy: np.ndarray, at: np.ndarray, keep_off_m: float) -> Reach:
        """How far it is to what is around `at`, worked out anew where that is old or was for elsewhere."""
        known = self._reaches[env]
        if known is None or known[2] >= LOOKS_A_PLAN or np.linalg.norm(at - known[1]) > MOVED_M:
            known = Reach.of(evidence, xy, at, keep_off_m), at, 0
        self._reaches[env] = known[0], known[1], known[2] + 1
        return known[0]

    def _leg(self, env: int, phase: int, robot: np.ndarray, evidence: np.ndarray, looks: bool) -> Leg:
        """Which leg comes now; having lifted something, the robot first walks straight back to where it has room."""
        if looks:
            return Leg.TO_LOOK
        if phase < Phase.LIFT or phase == Phase.IDLE:
            if self._looks_back[env]:
                if self._legs[env] != Leg.BACK:
                    self._plan_back(env, robot, evidence, LET_LIE_M)
                self._looks_back[env] = self._looks_back[env] - 1 if self._is_before(env, robot) else 0
            return Leg.BACK if self._looks_back[env] else Leg.TO_OBJECT
        if phase == Phase.LIFT:
            if self._legs[env] != Leg.BACK:
                self._plan_back(env, robot, evidence)
            return Leg.BACK
        if phase == Phase.CARRY and self._legs[env] == Leg.BACK:
            return Leg.BACK if self._is_before(env, robot) else Leg.TO_GOAL
        return Leg.TO_GOAL

    def _plan_back(self, env: int, robot: np.ndarray, evidence: np.ndarray, least_m: float = 0.0) -> None:
        """Chooses where environment `env` walks straight back to, and remembers which way it looks."""
        window = Window.around(evidence, robot[None, :2])
        self._back_to[env] = *step_back(window, robot, least_m), robot[2]

    def _is_before(self, env: int, robot: np.ndarray) -> bool:
        """Whether environment `env` still has to walk back."""
        ahead = np.array([np.cos(self._back_to[env, 2]), np.sin(self._back_to[env, 2])])
        left = robot[:2] - self._back_to[env, :2]
        return bool(left @ ahead > BACK_M and np.linalg.norm(left) > 1.5 * BACK_M)

    def _path(
        self, env: int, evidence: np.ndarray, xy: np.ndarray, stand: np.ndarray, leg: Leg, thing: np.ndarray | None
    ) -> Way:
        """The path that an environment follows, planned anew where it is old or leads elsewhere."""
        path, moved = self._paths[env], stand - self._stands[env]
        turned = abs((moved[2] + np.pi) % (2 * np.pi) - np.pi)
        self._ages[env] += 1
        if (
            path is None
            or self._ages[env] >= LOOKS_A_PLAN
            or np.linalg.norm(moved[:2]) > MOVED_M
            or turned > MOVED_RAD
        ):
            path = way_to(evidence, xy, stand[:2]) if leg == Leg.TO_LOOK else way_to_stand(evidence, xy, stand, thing)
            self._paths[env], self._stands[env], self._ages[env] = path, stand, 0
        return path


def _put(places: Tensor, at: slice, turn: slice, stand: np.ndarray) -> None:
    """Writes a stand (3,) x, y, yaw into places (21,)."""
    places[at] = torch.from_numpy(stand[:2]).float()
    places[turn] = torch.tensor([np.cos(stand[2]), np.sin(stand[2])]).float()
