"""What is believed about the places of a task, one row per environment: carried along by odometry, corrected by sight.

A Kalman filter with one variance for each group of numbers. What stands still is kept in the frame in which odometry
counts, so that walking and turning do not change it; an object that is being carried goes where the hands go.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from hv_policy.belief.outline import COMPASS_DIM, OUTLINE_DIM, compass_yaw_rad, turned_compass, turned_outline
from hv_policy.belief.places import GROUPS, MIDDLE, OBJECT, PLACES_DIM, SPAN, from_frame, stretch, to_frame, turned
from hv_policy.motor import embodiment
from hv_policy.motor.embodiment import CONTROL_DT_S
from hv_policy.motor.proprioception import BodyState

UNKNOWN = 1e4
"""Variance, m^2, of what was never seen."""
_GROUP_OF = torch.zeros(PLACES_DIM, dtype=torch.long)
for _number, _group in enumerate(GROUPS):
    _GROUP_OF[_group] = _number
_OF_OBJECT = [i for i, g in enumerate(GROUPS) if g.start in (0, 2, 6, 8, 9, 11, 12, 14)]
"""Groups that are settled anew when the object was lost: the object, how to hold it, and where to stand for that."""
_OF_GOAL = [i for i, g in enumerate(GROUPS) if g.start in (3, 5)]


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
        searching: an object or goal is looked for by turning round if its squashed deviation is larger than this; far
            away that is the deviation as a share of the distance.
        search_rad: how far the robot turns for that at most; then it walks to a place that is so far away,
        explore_m: and for
        explore_s: at most, and turns round there.
        search_rounds: having turned round so many times for one instruction it goes by its best guess.
        sure_m: an object is not reached for while its deviation is larger,
        align_within_m: a stand that is farther away is walked to, not aligned with.
        patience_s: nor any longer than this: then it is taken for lost.
        inside_m: an object cannot be so near to the middle of the robot.
        unrest: deviation by which everything may change in one control step, m.
        doubt: deviation of an object that was lost, m;
        doubt_at_feet: and of one that slipped out of the hands: it lies before the robot, who steps back to see it.
        absent: where something should be in the picture, and this far from its edge at least (share of half its width),
        absent_beyond_m: and not so near that the arms may hide it,
        absent_within_m: and so near at most,
        absent_share: and it is not in the picture as likely as that, then each look makes it less certain:
        absent_growth: its variance by this factor, and
        absent_m: by this deviation, m.
        outline_looks: most that looks from before count against one more of the object's outline, from 0.7 m.
        compass_looks: looks that tell where the walls are; after them
        compass_gain: is the share of a look's difference by which the heading is corrected, if edges agree by at least
        compass_agrees: (0..1).
    """

    look_every: int = 3
    correlation: float = 3.0
    looks: float = 2.0
    unseen: float = 1.5
    searching: float = 0.35
    search_rad: float = 7.0
    explore_m: float = 1.5
    explore_s: float = 6.0
    search_rounds: int = 3
    sure_m: float = 0.25
    align_within_m: float = 0.8
    patience_s: float = 8.0
    inside_m: float = 0.25
    drift: float = 0.03
    unrest: float = 0.003
    doubt: float = 0.7
    doubt_at_feet: float = 0.3
    absent: float = 0.2
    absent_beyond_m: float = 0.6
    absent_within_m: float = 2.0
    absent_share: float = 0.8
    absent_growth: float = 1.3
    absent_m: float = 0.05
    outline_looks: float = 6.0
    compass_looks: int = 10
    compass_agrees: float = 0.3
    compass_gain: float = 0.1


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
        self.outline_weight = torch.zeros(num)
        """(N,) how much speaks for it."""
        self._velocity: Tensor | None = None
        self._hands: Tensor | None = None

    def forget(self, ids: Tensor) -> None:
        """Environments `ids` have something else to do: nothing is known of it yet."""
        self.variance[ids] = UNKNOWN
        self.outline_weight[ids] = 0.0

    def doubt(self, ids: Tensor, deviation_m: float) -> None:
        """In environments `ids` (n,) the object was lost: it may be so far away from where it was."""
        rows = self.variance[ids]
        rows[:, _OF_OBJECT] = rows[:, _OF_OBJECT].clamp(min=deviation_m**2)
        self.variance[ids] = rows
        self.outline_weight[ids] = 0.0

    def disbelieve(self, ids: Tensor, place: slice) -> None:
        """Environments `ids` (n,) looked where `place` (`OBJECT` or `GOAL`) should be, and it was not there."""
        groups = _OF_OBJECT if place == OBJECT else _OF_GOAL
        rows = self.variance[ids]
        rows[:, groups] = (rows[:, groups] * self.config.absent_growth + self.config.absent_m**2).clamp(max=UNKNOWN)
        self.variance[ids] = rows

    def move(self, body: BodyState, turn_rad: Tensor, carries: Tensor) -> None:
        """A control step has passed: counts the robot's own motion, of which `turn_rad` (N,) is known
        (`hv_policy.belief.odometry`), and takes along what it `carries` (N,) bool."""
        velocity = body.lin_vel[:, embodiment.PELVIS, :2]
        before = self.pose
        if self._velocity is not None:
            mean = (velocity + self._velocity) / 2 * CONTROL_DT_S
            middle = before[:, 2:] + turn_rad[:, None] / 2
            xy = before[:, :2] + turned(mean, middle.cos(), middle.sin())
            self.pose = torch.cat([xy, before[:, 2:] + turn_rad[:, None]], -1)
        self._velocity = velocity
        cos, sin = self.pose[:, 2:].cos(), self.pose[:, 2:].sin()
        held = body.pos[:, embodiment.HANDS].mean(1)
        hands = torch.cat([self.pose[:, :2] + turned(held[:, :2], cos, sin), held[:, 2:]], -1)
        if self._hands is not None and bool(carries.any()):
            turn = self.pose[:, 2:] - before[:, 2:]
            cos, sin = turn.cos(), turn.sin()

            def with_hands(vector: Tensor) -> Tensor:
                return torch.cat([turned(vector[:, :2], cos, sin), vector[:, 2:]], -1)

            moved = self.places.clone()
            moved[:, OBJECT] = hands + with_hands(self.places[:, OBJECT] - self._hands)
            moved[:, SPAN] = with_hands(self.places[:, SPAN])
            moved[:, MIDDLE] = with_hands(self.places[:, MIDDLE])
            self.places = torch.where(carries[:, None], moved, self.places)
        self._hands = hands
        way = (self.pose[:, :2] - before[:, :2]).norm(dim=-1, keepdim=True)
        c = self.config
        self.variance = (self.variance + c.unrest**2 + (c.drift * way) ** 2).clamp(max=UNKNOWN)

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
        self.places = self.places.index_copy(0, ids, places + gain[:, _GROUP_OF.to(gain.device)] * (seen - places))
        self.variance = self.variance.index_copy(0, ids, certain)

    def measure_outline(self, ids: Tensor, outline_h: Tensor, weight: Tensor) -> None:
        """Takes in what pictures of environments `ids` (n,) say of the object's outline (n, 3), heading frame, with
        weights (n,): a running mean, in which what was seen long ago counts less and less."""
        seen = turned_outline(outline_h, self.pose[ids, 2])
        before = self.outline_weight[ids]
        share = (weight / (before + weight).clamp(min=1e-6))[:, None]
        self.outline[ids] = (1 - share) * self.outline[ids] + share * seen
        self.outline_weight[ids] = (before + weight).clamp(max=self.config.outline_looks)

    def measure_compass(self, ids: Tensor, compass_h: Tensor) -> None:
        """Takes in which way the walls run in pictures of environments `ids` (n,), (n, 2), heading frame: the first
        looks tell where they are, the later ones how far odometry has drifted."""
        c, seen = self.config, turned_compass(compass_h, self.pose[ids, 2])
        looks = self.compass_looks[ids]
        astray = torch.atan2(*(turned_compass(seen, -compass_yaw_rad(self.compass[ids])).flip(1).unbind(1))) / 4
        knows = looks >= c.compass_looks
        self.pose[ids, 2] -= c.compass_gain * astray * (knows & (seen.norm(dim=1) > c.compass_agrees))
        share = (~knows / (looks + 1))[:, None]
        self.compass[ids] += share * (seen - self.compass[ids])
        self.compass_looks[ids] = looks + 1

    def now(self) -> tuple[Tensor, Tensor]:
        """(N, 21) the places in the present heading frame, and (N, 21) the logarithm of their squashed deviation."""
        places_h = from_frame(self.places, self.pose)
        spread = self.variance.sqrt()[:, _GROUP_OF.to(self.variance.device)]
        return places_h, (spread / stretch(places_h)).log()
