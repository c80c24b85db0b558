"""What is believed about the places of a task, one row per environment: carried along by odometry, corrected by sight.

A Kalman filter with one variance for each group of numbers. What stands still is kept in the frame in which odometry
counts, so that walking and turning do not change it; an object that is being carried goes where the hands go.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numba
import numpy as np
import torch
from torch import Tensor

from hv_policy.belief.attitude import STANDS, turned_attitude
from hv_policy.belief.outline import COMPASS_DIM, OUTLINE_DIM, turned_outline
from hv_policy.belief.places import (
    GOAL,
    GOAL_XY,
    GROUPS,
    MIDDLE,
    OBJECT,
    PLACES_DIM,
    SPAN,
    from_frame,
    to_frame,
)
from hv_policy.motor import embodiment
from hv_policy.motor.embodiment import CONTROL_DT_S
from hv_policy.motor.kinematics import Array, as_arrays
from hv_policy.motor.proprioception import BodyState
from hv_policy.motor.vectors import turned_xy

UNKNOWN = 1e4
"""Variance, m^2, of what was never seen."""
_GROUP_OF = torch.zeros(PLACES_DIM, dtype=torch.long)
for _number, _group in enumerate(GROUPS):
    _GROUP_OF[_group] = _number
_OF_OBJECT = [i for i, g in enumerate(GROUPS) if g.start in (0, 2, 6, 8, 9, 11, 12, 14)]
"""Groups that are settled anew when the object was lost: the object, how to hold it, and where to stand for that."""
_HELD_STARTS = (SPAN.start, MIDDLE.start)
_LEVEL_GROUP = {place.start: GROUPS.index(slice(place.start, place.start + 2)) for place in (OBJECT, GOAL)}
_OF_GOAL = [i for i, g in enumerate(GROUPS) if g.start in (3, 5)]


def _groups_of(place: slice | None) -> list[int]:
    """Of `OBJECT` or `GOAL`, and what hangs together with it; or of both."""
    groups = {OBJECT.start: _OF_OBJECT, GOAL.start: _OF_GOAL}
    return list(range(len(GROUPS))) if place is None else groups[place.start]


@dataclass(frozen=True)
class BeliefConfig:
    """How much is trusted.

    Args:
        look_every: control steps from one picture that is looked at to the next.
        correlation: pictures that follow each other err alike: the variance of one counts so many times,
        looks: and however many there are of them, together they tell no more than so many that do not.
        unseen: where a thing is out of the picture, its deviation counts this much more (times 1 + this): on views that
            it was not trained with a network is that much more certain than it should be.
        drift: error of odometry, m for each m.
        searching: an object or goal is looked for by turning round if its deviation is a larger share of its distance
            than this (at the robot's feet, of half a metre). Until it is smaller than
        found: (between the two, who walks goes on walking and who turns goes on turning).
        search_rad: how far the robot turns for that at most; then it walks to a place that is so far away,
        explore_m: and for
        explore_s: at most, and turns round there.
        search_rounds: having turned round so many times for one instruction it goes by its best guess.
        sure_m: an object is not reached for while its deviation is larger,
        align_within_m: a stand that is farther away is walked to, not aligned with.
        patience_s: nor any longer than this: then it is taken for lost.
        hesitation_s: who stands so long where the object should be, and is not sure of it, looks for it anew.
        inside_m: an object cannot be so near to the middle of the robot.
        unrest: deviation by which everything may change in one control step, m.
        doubt: deviation of an object that was lost, m;
        doubt_put_down: of one that was put down where it should be, and nobody was content: it lies before the robot;
        doubt_at_feet: and of one that slipped out of the hands: it lies before the robot, who steps back to see it.
        absent: where something should be in the picture, and this far from its edge at least (share of half its width),
        absent_beyond_m: and not so near that the arms may hide it,
        absent_within_m: and so near at most,
        absent_share: and it is not in the picture as likely as that, then each look makes it less certain:
        absent_growth: its variance by this factor, and
        absent_m: by this deviation, m.
        shape_looks: most that looks from before count against one more of the object's shape, from 0.7 m.
        compass_looks: looks that tell where the walls are; after them
        compass_gain: is the share of a look's difference by which the heading is corrected, if edges agree by at least
        compass_agrees: (0..1).
    """

    look_every: int = 5
    correlation: float = 4.0
    looks: float = 8.0
    unseen: float = 1.5
    searching: float = 0.45
    found: float = 0.3
    search_rad: float = 7.0
    explore_m: float = 1.5
    explore_s: float = 6.0
    search_rounds: int = 3
    sure_m: float = 0.25
    align_within_m: float = 0.8
    patience_s: float = 8.0
    hesitation_s: float = 5.0
    inside_m: float = 0.25
    drift: float = 0.03
    unrest: float = 0.003
    doubt: float = 0.7
    doubt_put_down: float = 0.1
    doubt_at_feet: float = 0.3
    absent: float = 0.2
    absent_beyond_m: float = 0.6
    absent_within_m: float = 2.0
    absent_share: float = 0.8
    absent_growth: float = 1.55
    absent_m: float = 0.065
    shape_looks: float = 3.6
    compass_looks: int = 6
    compass_agrees: float = 0.3
    compass_gain: float = 0.16


class Belief:
    """See the module's docstring."""

    def __init__(self, num: int, config: BeliefConfig | None = None) -> None:
        self.config = config or BeliefConfig()
        self.pose = torch.zeros(num, 3)
        """(N, 3) x, y, yaw of the robot since the start, by odometry."""
        self.places = torch.zeros(num, PLACES_DIM)
        """(N, 21) in the frame of `pose`."""
        self.variance = torch.full((num, len(GROUPS)), UNKNOWN)
        """(N, 13) of each of `GROUPS`."""
        self.outline = torch.zeros(num, OUTLINE_DIM)
        """(N, 3) of the object (`hv_policy.belief.outline`), in the frame of `pose`."""
        self.compass = torch.zeros(num, COMPASS_DIM)
        """(N, 2) which way the walls run, in the same frame."""
        self.compass_looks = torch.zeros(num)
        """(N,) looks that it rests on."""
        self.attitude = STANDS.repeat(num, 1)
        """(N, 3) of the object (`hv_policy.belief.attitude`), in the same frame."""
        self.shape_weight = torch.zeros(num)
        """(N,) how much speaks for outline and attitude."""
        self._velocity: Tensor | None = None
        self._hands: Tensor | None = None

    def forget(self, ids: Tensor, place: slice | None = None) -> None:
        """Environments `ids` have something else to do: nothing is known of it yet; or nothing of one `place`,
        `OBJECT` or `GOAL`."""
        rows = self.variance[ids]
        rows[:, _groups_of(place)] = UNKNOWN
        self.variance[ids] = rows
        if place != GOAL:
            self.shape_weight[ids], self.attitude[ids] = 0.0, STANDS

    def turn_unknown(self, ids: Tensor) -> None:
        """Environments `ids` (n,) no longer know which way the walls run in the frame of `pose`."""
        self.compass[ids], self.compass_looks[ids] = 0.0, 0.0

    def doubt(self, ids: Tensor, deviation_m: float) -> None:
        """In environments `ids` (n,) the object was lost: it may be so far away from where it was."""
        rows = self.variance[ids]
        rows[:, _OF_OBJECT] = rows[:, _OF_OBJECT].clamp(min=deviation_m**2)
        self.variance[ids] = rows
        self.shape_weight[ids] = 0.0

    def know_goal(self, env: int, xy: Tensor, deviation_m: float) -> None:
        """Environment `env` knows where its goal is, (2,) in the frame of `pose`."""
        self.places[env, GOAL_XY] = xy
        self.variance[env, _LEVEL_GROUP[GOAL.start]] = deviation_m**2

    def disbelieve(self, ids: Tensor, place: slice) -> None:
        """Environments `ids` (n,) looked where `place` (`OBJECT` or `GOAL`) should be, and it was not there."""
        groups = _groups_of(place)
        rows = self.variance[ids]
        rows[:, groups] = (rows[:, groups] * self.config.absent_growth + self.config.absent_m**2).clamp(max=UNKNOWN)
        self.variance[ids] = rows

    def move(self, body: BodyState, turn_rad: Tensor, carries: Tensor) -> None:
        """A control step has passed: counts the robot's own motion, of which `turn_rad` (N,) is known
        (`hv_policy.belief.odometry`), and takes along what it `carries` (N,) bool."""
        velocity = body.lin_vel[:, embodiment.PELVIS, :2].clone()
        before = velocity if self._velocity is None else self._velocity
        began = self._velocity is not None
        hands = torch.empty(len(velocity), 3) if self._hands is None else self._hands.clone()
        self.pose, self.places, self.variance = self.pose.clone(), self.places.clone(), self.variance.clone()
        arrays = as_arrays(velocity, before, turn_rad, body.pos[:, embodiment.HANDS], carries)
        own = (value.numpy() for value in (self.pose, self.places, self.variance, hands))
        c = self.config
        _count_motion(*arrays, *own, began, c.drift, c.unrest)
        self._velocity, self._hands = velocity, hands

    def measure(self, ids: Tensor, places_h: Tensor, spread_h: Tensor) -> None:
        """Takes in what pictures of environments `ids` (n,) say: places (n, 21), heading frame, and their deviations
        (n, 21), m."""
        seen = to_frame(places_h, self.pose[ids])
        squared = spread_h * spread_h
        noise = torch.stack([squared[:, g].mean(1) for g in GROUPS], 1)
        places, variance = self.places[ids], self.variance[ids]
        gain = variance / (variance + self.config.correlation * noise)
        # a hundred pictures of an empty wall are one picture of an empty wall
        certain = torch.maximum((1 - gain) * variance, torch.minimum(variance, noise / self.config.looks))
        self.places = self.places.index_copy(0, ids, places + gain[:, _GROUP_OF] * (seen - places))
        self.variance = self.variance.index_copy(0, ids, certain)

    def measure_shape(self, ids: Tensor, outline_h: Tensor, attitude_h: Tensor, weight: Tensor) -> None:
        """Takes in what pictures of environments `ids` (n,) say of the object's outline (n, 3) and attitude (n, 3),
        heading frame, with weights (n,): a running mean, in which what was seen long ago counts less and less."""
        yaw, before = self.pose[ids, 2], self.shape_weight[ids]
        share = (weight / (before + weight).clamp(min=1e-6))[:, None]
        self.outline[ids] = (1 - share) * self.outline[ids] + share * turned_outline(outline_h, yaw)
        self.attitude[ids] = (1 - share) * self.attitude[ids] + share * turned_attitude(attitude_h, yaw)
        self.shape_weight[ids] = (before + weight).clamp(max=self.config.shape_looks)

    def measure_compass(self, ids: Tensor, compass_h: Tensor) -> None:
        """Takes in which way the walls run in pictures of environments `ids` (n,), (n, 2), heading frame: the first
        looks tell where they are, the later ones how far odometry has drifted."""
        c = self.config
        self.pose = self.pose.clone()
        own = (value.numpy() for value in (self.pose, self.compass, self.compass_looks))
        _count_compass(*as_arrays(ids, compass_h), *own, c.compass_looks, c.compass_agrees, c.compass_gain)

    def now(self) -> Tensor:
        """(N, 21) the places in the present heading frame."""
        return from_frame(self.places, self.pose)

    def deviation_m(self, place: slice) -> Tensor:
        """(N,) of where `place` (`OBJECT` or `GOAL`) is on the floor."""
        return self.variance[:, _LEVEL_GROUP[place.start]].sqrt()


@numba.njit(cache=True)
def _count_motion(
    velocity: Array,
    velocity_before: Array,
    turn: Array,
    hands_h: Array,
    carries: Array,
    pose: Array,
    places: Array,
    variance: Array,
    hands: Array,
    began: bool,
    drift: float,
    unrest: float,
) -> None:
    """`Belief.move`: changes pose (N, 3), places (N, 21), variance (N, 13) and the point between the hands (N, 3); not
    `began`: it is the first step, of which no motion is known."""
    for i in range(len(pose)):
        angle, way = 0.0, 0.0
        if began:
            angle = np.float64(turn[i])
            middle = pose[i, 2] + angle / 2
            ahead = (np.float64(velocity[i, 0]) + velocity_before[i, 0]) / 2 * CONTROL_DT_S
            aside = (np.float64(velocity[i, 1]) + velocity_before[i, 1]) / 2 * CONTROL_DT_S
            x, y = turned_xy(middle, ahead, aside)
            pose[i, 0] += x
            pose[i, 1] += y
            pose[i, 2] += angle
            way = math.hypot(x, y)
        x = (np.float64(hands_h[i, 0, 0]) + hands_h[i, 1, 0]) / 2
        y = (np.float64(hands_h[i, 0, 1]) + hands_h[i, 1, 1]) / 2
        x, y = turned_xy(pose[i, 2], x, y)
        x, y, z = x + pose[i, 0], y + pose[i, 1], (np.float64(hands_h[i, 0, 2]) + hands_h[i, 1, 2]) / 2
        if began and carries[i]:
            from_x, from_y = turned_xy(angle, places[i, 0] - hands[i, 0], places[i, 1] - hands[i, 1])
            places[i, 2] += z - hands[i, 2]
            places[i, 0], places[i, 1] = x + from_x, y + from_y
            for at in _HELD_STARTS:
                places[i, at], places[i, at + 1] = turned_xy(angle, places[i, at], places[i, at + 1])
        hands[i, 0], hands[i, 1], hands[i, 2] = x, y, z
        growth = unrest**2 + (drift * way) ** 2
        for k in range(variance.shape[1]):
            variance[i, k] = min(variance[i, k] + growth, UNKNOWN)


@numba.njit(cache=True)
def _count_compass(
    ids: Array, compass_h: Array, pose: Array, compass: Array, count: Array, most: int, agrees: float, gain: float
) -> None:
    """`Belief.measure_compass`: changes poses (N, 3), compasses (N, 2) and how many looks they rest on (N,)."""
    for row in range(len(ids)):
        env = ids[row]
        yaw = np.float64(pose[env, 2])
        x, y = turned_xy(4 * yaw, np.float64(compass_h[row, 0]), np.float64(compass_h[row, 1]))
        if count[env] >= most:
            across, along = turned_xy(-math.atan2(compass[env, 1], compass[env, 0]), x, y)
            if math.hypot(x, y) > agrees:
                pose[env, 2] = yaw - gain * math.atan2(along, across) / 4
        else:
            share = 1 / (count[env] + 1)
            compass[env, 0] += share * (x - compass[env, 0])
            compass[env, 1] += share * (y - compass[env, 1])
        count[env] += 1
