"""The network that sees, believes and decides; and one that acts with it, step by step, in many environments."""

from __future__ import annotations

import contextlib
import copy
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path

import numba
import numpy as np
import torch
from torch import Tensor, nn

from hv_policy.belief.attitude import STANDS, lies
from hv_policy.belief.belief import Belief, BeliefConfig
from hv_policy.belief.camera import project
from hv_policy.belief.closer_look import Found, look_closer
from hv_policy.belief.compass import compass
from hv_policy.belief.fallen import as_it_lies, measured_standing
from hv_policy.belief.floor import floor_in_view
from hv_policy.belief.labels import Landmarks
from hv_policy.belief.landmark_head import OFFSETS
from hv_policy.belief.odometry import Odometry, load_odometry
from hv_policy.belief.perception import GOAL_QUERY, OBJECT_QUERY, Measurement, Perception, Sight
from hv_policy.belief.perception_loss import Truth, perception_loss, read_things
from hv_policy.belief.places import (
    AWAY,
    GOAL,
    GOAL_XY,
    IS_LAST,
    MIDDLE,
    OBJECT,
    PICK,
    PLACE,
    PLACES_DIM,
    PRIOR_SPREAD,
    SPAN,
    WAYPOINT,
    stretch,
    unsquash,
)  # fmt: skip
from hv_policy.belief.refusals import Refusals
from hv_policy.belief.regrip import LEVELS, as_wide_as_felt, closed_on_little, next_try, regripped, still_held
from hv_policy.belief.room_middle import room_middle
from hv_policy.belief.stands import LOW_M
from hv_policy.belief.task_places import leg_is_done, view_of
from hv_policy.belief.wayfinder import Wayfinder
from hv_policy.decision.memory import TaskMemory
from hv_policy.decision.network import DecisionConfig, DecisionNetwork
from hv_policy.decision.rising import Rising
from hv_policy.decision.sight import hand_anchors, sight
from hv_policy.decision.view import Phase
from hv_policy.decision.weights import load_decision
from hv_policy.half_precision import in_half
from hv_policy.motor.embodiment import CONTROL_DT_S
from hv_policy.motor.intent import GAZE, VELOCITY
from hv_policy.motor.kinematics import Array, as_arrays
from hv_policy.motor.prior import MotorPrior, load_shipped_motor_prior
from hv_policy.motor.proprioception import BodyState, read_proprioception
from hv_policy.motor.vectors import turned_xy
from hv_policy.rewording import Reworder, load_rewording

DECISION = DecisionConfig(sees="places", geometry=0)
SHIPPED_DECISION = Path(__file__).resolve().parents[1] / "weights" / "decision.safetensors"
ARRIVED_M = 0.35
TOUCHED, TOUCHED_HEIGHT, BEHIND, BEFORE_GOAL, BEFORE_GOAL_M = 3.0, 10.0, 2.0, 20.0, 1.3
"""By how much more than is said a picture errs in where a thing is, and how high it is, while arms reach round it: it
seems nearer than it is, and higher, for where arms do so it mostly hangs. And in where the goal is, of which the thing
in the hands hides a part, and nearly all from so near."""
_WAYPOINT, _AWAY, _PICK, _PLACE = WAYPOINT.start, AWAY.start, PICK.start, PLACE.start
_LIFT, _LOWER = int(Phase.LIFT), int(Phase.LOWER)
SEEN_PIECE, SURE_OF_PIECE_M, PIECE_DOUBT, OBJECT_HALF_M = 0.95, 0.55, 1.5, (0.1, 0.22)
"""What a picture says of a piece of furniture counts where that is in it as surely as this, and up to this deviation
(two thirds of the others in rooms never seen are over a metre off); by how much more it is off there than it says; and
what half of an object's width may be."""
_HALF = math.log(0.5)
_AT_FEET_M = 0.5
CLOSER_M = 0.35
"""What is known to this deviation is looked at closer where it should be, also in a picture that does not point at
it."""
MIDDLE_SPREAD_M = 0.2
"""Deviation of the middle of the room from what the map shows."""
SEARCHING_TURN_RAD_S, CARRYING_TURN_RAD_S = 1.0, 0.6
LIFTED_S = 4.0
"""A lift takes half as long. Who has something between the hands after that, and believes that it has not risen, lets
go."""


class BeliefNetwork(nn.Module):
    """All weights of a student: rewording, perception, odometry, decisions (`DECISION`) and motor prior.

    Args:
        perception: see `Perception`.
        from_scratch: take the shipped odometry and decisions; else they come with a checkpoint.
    """

    def __init__(self, perception: Perception, from_scratch: bool) -> None:
        super().__init__()
        self.perception = perception
        self.prior: MotorPrior = load_shipped_motor_prior()
        self.decision: DecisionNetwork = load_decision(SHIPPED_DECISION) if from_scratch else DecisionNetwork(DECISION)
        self.odometry: Odometry = load_odometry() if from_scratch else Odometry()
        self.rewording = load_rewording()
        self.reworder = Reworder(self.rewording, perception.text.features)
        for part in (self.decision, self.prior, self.odometry, self.rewording):
            part.requires_grad_(False)

    def loss(
        self,
        pictures: Tensor,
        state: Tensor,
        words: Tensor,
        is_word: Tensor,
        known: dict[str, Tensor],
        landmarks: Landmarks | None = None,
        floor: tuple[Tensor, Tensor] | None = None,
    ) -> tuple[Tensor, dict[str, float]]:
        """(B,) how wrong the places and the floor are that the network sees, and figures to watch (m).

        Args:
            pictures, state, words, is_word: see `Perception`.
            known: what was so: `places` (B, 21), zeros where nobody knew, and of the `object` (B, 15) and its
                `half_extents` (B, 3) what `hv_sim.observations` says.
            landmarks: what else is to be seen.
            floor: (B, P) bool what is taken, (B,) bool whether that is known (`hv_policy.belief.floor_patch`).
        """
        device = state.device
        taken, floor_known = (None, None) if floor is None else (x.to(device) for x in floor)
        truth = Truth(known["places"], known["object"][:, 3:9], known["half_extents"], taken, floor_known)
        things = None if landmarks is None else read_things(self.perception, state, landmarks)
        with in_half(device.type) if self.training else contextlib.nullcontext():
            loss, figures = perception_loss(self.perception, pictures, state, words, is_word, truth, things)
        return loss, {name: value.item() for name, value in figures.items()}


@dataclass
class _Observed:
    """`hv_policy.decision.network.Observed` without what cannot be seen."""

    proprioception: Tensor
    object: Tensor
    goal: Tensor
    waypoint: Tensor
    half_extents: Tensor


@dataclass
class Following:
    """Everything that a student carries from one control step to the next, for N environments."""

    belief: Belief
    memory: TaskMemory
    prior: MotorPrior
    instructions: list[str]
    blind_steps: Tensor
    """(N,) control steps since the last look at a picture."""
    wayfinder: Wayfinder
    """What is known of the floor, and the way over it."""
    searching: Tensor
    """(N,) bool: it looks for something (`_searches`)."""
    searched_rad: Tensor
    """(N,) how far the robot has turned round, looking for something."""
    rounds: Tensor
    """(N,) how often it has turned all round since the instruction."""
    exploring_s: Tensor
    """(N,) how long it has been walking to another place to look from; 0 while it is not."""
    vantage: Tensor
    """(N, 2) that place, in the frame of the belief's pose."""
    slips: Tensor
    """(N,) int64 how often the object slipped out of the hands."""
    hesitates_s: Tensor
    """(N,) how long it has stood where the object should be without being sure of it; 0 while it does not."""
    refusals: Refusals
    """What has turned out not to be meant."""
    rising: Rising
    """Stands up before it walks, having given up reaching or holding."""
    lay: Tensor
    """(N,) bool: it lay on the floor, or was getting up, before the last step."""
    touched: Tensor
    """(N,) bool: it has had its hands on the object since the instruction."""
    stood_m: Tensor
    """(N, 3) half extents of the object before that (`hv_policy.belief.fallen`)."""
    pieces: dict[str, Tensor] = field(default_factory=dict)
    """Words for pieces of furniture -> what is looked for to find them."""
    felt: Tensor | None = None
    """(N, 223) the last proprioception."""

    @staticmethod
    def begin(network: BeliefNetwork, instructions: Sequence[str], config: BeliefConfig) -> Following:
        """Nothing has been seen yet."""
        n = len(instructions)
        prior = network.prior.copied()
        prior.reset()
        blind = torch.full((n,), config.look_every)
        memory, wayfinder, belief = TaskMemory.of(n), Wayfinder(n), Belief(n, config)
        no, zero, none = torch.zeros(n, dtype=torch.bool), torch.zeros(n), torch.zeros(n, dtype=torch.long)
        search = no, zero.clone(), zero.clone(), zero.clone(), torch.zeros(n, 2)
        told = list(instructions)
        work = none, zero.clone(), Refusals(n), Rising(n)
        body = {"lay": no.clone(), "touched": no.clone(), "stood_m": torch.zeros(n, 3)}
        return Following(belief, memory, prior, told, blind, wayfinder, *search, *work, **body)

    def copy(self) -> Following:
        """The same, from where another future may begin."""
        kept = {f.name: getattr(self, f.name) for f in fields(self)}
        tensors = {name: value.clone() for name, value in kept.items() if isinstance(value, Tensor)}
        return replace(
            self,
            belief=copy.deepcopy(self.belief),
            memory=self.memory.clone(),
            prior=self.prior.copied(),
            instructions=list(self.instructions),
            wayfinder=self.wayfinder.copy(),
            refusals=copy.deepcopy(self.refusals),
            rising=copy.deepcopy(self.rising),
            **tensors,
        )

    def hear(self, instructions: Sequence[str]) -> None:
        """Begins anew where the instruction is another one, and there alone."""
        changed = [i for i, (new, old) in enumerate(zip(instructions, self.instructions, strict=True)) if new != old]
        if changed:
            self._begin_anew(torch.tensor(changed))
            self.touched[changed] = False
            self.instructions = list(instructions)

    def _begin_anew(self, ids: Tensor) -> None:
        """Environments `ids` (n,) begin what they are told, as if they had not been told it before."""
        self.belief.forget(ids)
        self.memory.reset(ids)
        self.blind_steps[ids] = self.belief.config.look_every
        self.searching[ids] = False
        self.searched_rad[ids] = self.rounds[ids] = self.exploring_s[ids] = 0.0
        self.rising.reset(ids)
        self.slips[ids], self.hesitates_s[ids] = 0, 0.0
        for env in ids.tolist():
            self.wayfinder.forget(env)
            self.refusals.forget(env)

    def _lose_bearings(self) -> None:
        """Who has just got up from the floor does not know where it is, nor which way it looks: the odometry knows
        steps, not falls."""
        getting_up = self.prior.getting_up
        if getting_up is None or len(getting_up.active) != len(self.lay):
            return
        stood_up = (self.lay & ~getting_up.active).nonzero()[:, 0]
        self.lay = getting_up.active.clone()
        if len(stood_up):
            self._begin_anew(stood_up)
            self.belief.turn_unknown(stood_up)
            for env in stood_up.tolist():
                self.wayfinder.floor.forget(env)

    @property
    def looks(self) -> Tensor:
        """(n,) the environments that will look at their picture in the coming step; the others need none. Who lies on
        the floor does not: having got up it would forget what it saw."""
        return ((self.blind_steps >= self.belief.config.look_every) & ~self.lay).nonzero()[:, 0]

    def act(self, network: BeliefNetwork, pictures: Tensor, state: Tensor, words: Tensor, is_word: Tensor) -> Tensor:
        """(N, 28) servo targets in rad for this control step; for the arguments see `decide`."""
        return self.prior(state, self.decide(network, pictures, state, words, is_word))

    def decide(self, network: BeliefNetwork, pictures: Tensor, state: Tensor, words: Tensor, is_word: Tensor) -> Tensor:
        """(N, 14) intents for this control step, which then has to be done with `prior`.

        Args:
            network: who acts.
            pictures: (n, 3, H, W), 0..1, of the environments `looks`.
            state: (N, 223) proprioception, on the CPU, where all but the perception happens.
            words, is_word: (N, L, dim) and (N, L) bool, from `Perception.text`.
        """
        body = read_proprioception(state)
        looks = self.looks  # whose pictures these are
        self._lose_bearings()
        phase = self.memory.phase
        turn_rad = torch.zeros(len(state)) if self.felt is None else _at_its_place(network.odometry, self.felt, state)
        self.felt = state
        self.belief.move(body, turn_rad, (phase >= Phase.LIFT) & (phase <= Phase.LOWER))
        if len(looks):
            self._look(network, looks, pictures, state[looks], body, words[looks], is_word[looks])
            self._find_middle(network.reworder, looks)
        self.blind_steps += 1
        self.blind_steps[looks] = 1
        places_h = self.belief.now()
        searches = self._searches(places_h) & ~self.wayfinder.steps_back
        places_h = as_wide_as_felt(regripped(places_h, self.slips, lies(self._attitude)), body, phase)
        remembered = self.memory.clone()
        intent = self._decide(network.decision, state, body, places_h, self._way_now(places_h))
        return self.rising(self._turn_round(searches, intent, remembered))

    def _searches(self, places_h: Tensor) -> Tensor:
        """(N,) bool: it is not known where the object or, once that is carried, its goal is, and the robot turns round
        on the spot to see. Having turned all round it walks to another place first (`vantage`)."""
        c, phase = self.belief.config, self.memory.phase
        to_object, carries = phase <= Phase.REACH, phase == Phase.CARRY
        of_object, of_goal = (self.belief.deviation_m(place) / _far(places_h[:, place]) for place in (OBJECT, GOAL))
        spread = torch.where(carries, of_goal, of_object)
        unknown = spread > torch.where(self.searching, c.found, c.searching)
        wants = self.searching = (to_object | carries) & unknown & ~self._given_up
        seen_all = wants & (self.searched_rad >= c.search_rad)
        begins = seen_all & (self.exploring_s == 0)
        for env in begins.nonzero()[:, 0].tolist():
            self.vantage[env] = self.wayfinder.place_to_look_from(env, self.belief.pose[env], c.explore_m)
        self.exploring_s = torch.where(seen_all, self.exploring_s + CONTROL_DT_S, torch.zeros_like(self.exploring_s))
        near = (self.vantage - self.belief.pose[:, :2]).norm(dim=-1) < ARRIVED_M
        arrived = seen_all & (near | (self.exploring_s > c.explore_s))
        self.rounds = self.rounds + begins
        self.searched_rad, self.exploring_s = self.searched_rad * ~arrived, self.exploring_s * ~arrived
        return wants & (self.searched_rad < c.search_rad)

    @property
    def _given_up(self) -> Tensor:
        """(N,) bool: it goes by its best guess."""
        return self.rounds >= self.belief.config.search_rounds

    def _turn_round(self, searches: Tensor, intent: Tensor, remembered: TaskMemory) -> Tensor:
        """(N, 14) the intent, but where it `searches` (N,) that of turning; that is not remembered as work."""
        if not bool(searches.any()):
            return intent
        carries = remembered.phase == Phase.CARRY
        rate = torch.where(carries, CARRYING_TURN_RAD_S, SEARCHING_TURN_RAD_S)
        self.searched_rad = self.searched_rad + rate * CONTROL_DT_S * searches
        self.hesitates_s = self.hesitates_s * ~searches
        looking = intent.clone()
        looking[:, VELOCITY] = torch.stack([torch.zeros_like(rate), torch.zeros_like(rate), rate], -1)
        looking[:, GAZE] = torch.tensor([0.0, 0.4])
        bent = searches & (remembered.phase == Phase.REACH)
        self.rising.begin(bent)
        reaches = (remembered.phase == Phase.ALIGN) | (remembered.phase == Phase.REACH)
        remembered.phase = torch.where(reaches, torch.zeros_like(remembered.phase), remembered.phase)
        self.memory = remembered.where(searches, self.memory)
        return torch.where(searches[:, None], looking, intent)

    def _look(
        self,
        network: BeliefNetwork,
        ids: Tensor,
        pictures: Tensor,
        state: Tensor,
        everybody: BodyState,
        words: Tensor,
        is_word: Tensor,
    ) -> None:
        """Takes in the pictures of environments `ids` (n,); all arguments but the bodies are theirs."""
        body, perception = everybody.rows(ids), network.perception
        shown = perception.look(pictures, state.to(pictures.device))
        seen = perception.judge(shown, words, is_word)
        seen = Measurement(*(getattr(seen, f.name).cpu() for f in fields(seen)))
        self.belief.measure_compass(ids, compass(pictures, body))
        places = unsquash(seen.places)
        # what the network knows without looking must not count anew with every picture
        known = (-2 * PRIOR_SPREAD.log()).exp() * ~self._given_up[ids][:, None]
        told = ((-2 * seen.log_spread).exp() - known).clamp(min=1e-4)
        spread = told.rsqrt() * stretch(places) * self._doubtful(seen)
        closer = self._look_closer(perception, ids, pictures, body, seen, places, spread)
        self._beside_pieces(network, ids, shown, seen, places, spread)
        in_view = 1 - seen.pointing[:, :2, 0].exp()
        self.refusals.see(ids, in_view, self.memory.phase[ids])
        spread = self.refusals.applied(ids, self.belief.pose[ids], places, spread)
        to_goal_m = (self.belief.places[ids, GOAL_XY] - self.belief.pose[ids, :2]).norm(dim=1)
        self.belief.measure(ids, places, spread * _hidden(self.memory.phase[ids], to_goal_m))
        places_h = self.belief.now()[ids]
        self._miss(ids, seen, body, places_h)
        distance = places[:, OBJECT][:, :2].norm(dim=-1)
        near = self.memory.phase[ids] <= Phase.REACH
        weight = near * in_view[:, 0] / (0.3 + distance) ** 2
        at_h = places_h[:, OBJECT].to(pictures)
        faces = perception.faces(pictures, body.to(pictures), at_h, torch.zeros_like(at_h[:, 0])).cpu()
        outline, attitude = seen.outline, torch.cat([faces, seen.upright], 1)
        outline[closer.rows], attitude[closer.rows] = closer.outline, closer.attitude
        self.belief.measure_shape(ids, outline, attitude, weight)
        self._lie_as_before(ids)
        self._find_ways(perception, shown, ids, body)

    def _look_closer(
        self,
        perception: Perception,
        ids: Tensor,
        pictures: Tensor,
        body: BodyState,
        seen: Measurement,
        places: Tensor,
        spread: Tensor,
    ) -> Found:
        """Takes a closer look at what slipped out of the hands of `ids` (n,), lies anyhow and will be reached for:
        changes places and spread (n, 21). For the other arguments see `_look`."""
        wanted = self.touched[ids] & (self.memory.phase[ids] <= Phase.REACH)
        pointed = seen.pointing[:, OBJECT_QUERY, 0] < _HALF
        believed, known = self.belief.now()[ids, OBJECT], self.belief.deviation_m(OBJECT)[ids] < CLOSER_M
        at_h = torch.where(pointed[:, None], places[:, OBJECT], believed)
        found = look_closer(perception.closer, pictures, body, at_h, wanted & (pointed | known))
        places[found.rows, OBJECT], spread[found.rows, OBJECT] = found.at_h, found.deviation_m
        seen.pointing[found.rows, OBJECT_QUERY, 0] += _HALF
        return found

    def _lie_as_before(self, ids: Tensor) -> None:
        """Whose object, of `ids` (n,), has slipped out of the hands believes that it is as large as it was."""
        height_m = self.belief.places[:, OBJECT.stop - 1]
        before = self.touched & (self.memory.phase <= Phase.REACH) & (self.slips > 0) & (height_m < LOW_M)
        rows = ids[before[ids] & (self.belief.shape_weight[ids] > 0)]
        if len(rows):
            belief = self.belief
            seen = belief.outline[rows], belief.attitude[rows], height_m[rows]
            belief.outline[rows], belief.attitude[rows], height_m[rows] = as_it_lies(self.stood_m[rows], *seen)

    def _find_ways(self, perception: Perception, shown: Sight, ids: Tensor, body: BodyState) -> None:
        """Takes in which floor is free in the pictures of environments `ids` (n,), and finds their ways over it."""
        finder, belief = self.wayfinder, self.belief
        for row, env in enumerate(ids.tolist()):
            points, one = finder.floor.points_to_look_at(env), slice(row, row + 1)
            own = body.rows(one)
            there = points[floor_in_view(own, points[None])[0]]
            at = own.to(shown.fine), there[None].to(shown.fine)
            logits = perception.floor(shown.tokens[one], shown.fine[one], *at)[0]
            finder.floor.see(env, belief.pose[env], there, logits.cpu())
            look_at = self.vantage[env] if self.exploring_s[env] > 0 else None
            phase = int(self.memory.phase[env])
            shape = belief.outline[env], self._attitude[env], belief.compass[env]
            known = finder.settle(env, belief.pose[env], belief.places[env], *shape, phase)
            belief.places[env] = known
            finder.go_on(env, belief.pose[env], known, phase, look_at)

    def _beside_pieces(
        self, network: BeliefNetwork, ids: Tensor, shown: Sight, seen: Measurement, places: Tensor, spread: Tensor
    ) -> None:
        """Who of `ids` (n,) has to bring something beside or onto a piece of furniture finds that piece, too: joins
        what follows from it to the goals in places and spread (n, 21). Where it is sure of the piece, it counts less
        that a goal is not recognised (`seen`)."""
        told = [network.reworder.goal(self.instructions[env]) for env in ids.tolist()]
        chosen = [row for row, (relation, noun) in enumerate(told) if relation in OFFSETS and noun]
        if not chosen:
            return
        rows = torch.tensor(chosen)
        named = torch.stack([self._named(network, told[row][1]) for row in chosen])[:, None]
        piece = network.perception.find_pieces(shown.of(rows.to(named.device)), named)
        offsets = named.new_tensor([OFFSETS[told[row][0]] for row in chosen])[:, None]
        half = self.belief.places[ids[rows], SPAN].norm(dim=-1).clamp(*OBJECT_HALF_M)
        spot = piece.spot(offsets, half.to(named)[:, None])[:, 0].cpu()
        deviation, there = piece.log_spread[:, :1].exp().cpu(), piece.seen[:, 0].sigmoid().cpu() > SEEN_PIECE
        sure = there & (deviation[:, 0] < SURE_OF_PIECE_M)
        share = sure[:, None] / (1 + (PIECE_DOUBT * deviation / spread[rows, GOAL_XY]).square())
        places[rows, GOAL_XY] += share * (spot - places[rows, GOAL_XY])
        spread[rows, GOAL_XY] *= (1 - share).sqrt()
        seen.pointing[rows, GOAL_QUERY, 0] += torch.where(sure, _HALF, 0.0)

    def _named(self, network: BeliefNetwork, noun: str) -> Tensor:
        """(dim,) what is looked for to find a piece of furniture."""
        if noun not in self.pieces:
            self.pieces[noun] = network.perception.named(*network.perception.text([f"the {noun}"]))[0]
        return self.pieces[noun]

    def _find_middle(self, reworder: Reworder, ids: Tensor) -> None:
        """Who of `ids` (n,) has to bring something into the middle of the room knows that from the map, once that shows
        all sides of it."""
        for env in ids.tolist():
            if reworder.goal(self.instructions[env])[0] == "room_middle":
                middle = room_middle(self.wayfinder.floor.evidence[env], self.belief.compass[env])
                if middle is not None:
                    self.belief.know_goal(env, middle, MIDDLE_SPREAD_M)

    def _doubtful(self, seen: Measurement) -> Tensor:
        """(n, 21) by how much more the places err than is said, because they are not in the picture."""
        missing = seen.pointing[..., 0].exp() * self.belief.config.unseen
        doubtful = torch.ones_like(seen.places)
        for query, place in enumerate((OBJECT, GOAL)):
            doubtful[:, place] += missing[:, query : query + 1]
        return doubtful

    def _miss(self, ids: Tensor, seen: Measurement, body: BodyState, places_h: Tensor) -> None:
        """What should be in the pictures of environments `ids`, at places (n, 21), and is not, is believed less.

        Without it one wrong sight is believed for ever: a hundred pictures that show nothing say nothing of a place.
        """
        c, phase = self.belief.config, self.memory.phase[ids]
        looked_for = (phase <= Phase.REACH, phase == Phase.CARRY)
        at, visible = project(body, torch.stack([places_h[:, OBJECT], places_h[:, GOAL]], 1))
        inside = visible & (at.abs() < 1 - c.absent).all(-1)
        for query, (place, matters) in enumerate(zip((OBJECT, GOAL), looked_for, strict=True)):
            distance = places_h[:, place][:, :2].norm(dim=-1)
            is_near = (distance > c.absent_beyond_m) & (distance < c.absent_within_m)
            absent = inside[:, query] & is_near & (seen.pointing[:, query, 0].exp() > c.absent_share)
            missed = ids[(absent | (distance < c.inside_m)) & matters]
            if len(missed):
                self.belief.disbelieve(missed, place)

    @property
    def _attitude(self) -> Tensor:
        """(N, 3) of the objects (`hv_policy.belief.attitude`): what nobody has touched stands, as the walls do."""
        return torch.where(self.touched[:, None], self.belief.attitude, STANDS)

    def _way_now(self, places_h: Tensor) -> Tensor:
        """(N, 8) the way in the present heading frame; where the waypoint is a stand, the one that is believed in."""
        way, phase = self.wayfinder.way.clone(), self.memory.phase
        _turn_way(way.numpy(), *as_arrays(self.belief.pose, places_h, phase))
        return way

    def _decide(
        self, decision: DecisionNetwork, state: Tensor, body: BodyState, places_h: Tensor, way: Tensor
    ) -> Tensor:
        """(N, 14) intents; the memory moves on."""
        view = view_of(places_h, way, body, self.belief.pose)
        root = torch.zeros_like(places_h[:, :3])
        root[:, 2] = state[:, 0]
        nothing = torch.zeros_like(places_h[:, :12])
        observed = _Observed(
            proprioception=state,
            object=torch.cat([places_h[:, OBJECT] - root, nothing], 1),
            goal=torch.cat([places_h[:, GOAL] - root, nothing[:, :6]], 1),
            waypoint=torch.cat([way[:, WAYPOINT], -root[:, 2:]], 1),
            half_extents=nothing[:, :3],
        )
        sights = sight(observed, view, leg_is_done(way), self.memory.phase > Phase.LIFT)
        geometry = state.new_zeros(len(state), 600)
        before = self.memory.vector(view)
        logits = _at_its_place(decision, sights, geometry, before, ask=decision.phase_logits)
        phase = self._sure_of(logits.argmax(-1), places_h)
        phase = self._elsewhere(phase)
        before_this = self.memory.phase
        phase, closed = self._felt(body, phase)
        self._take_hold(phase >= Phase.SQUEEZE)
        self.rising.begin_where_given_up(before_this, phase)
        stuck = (before_this == Phase.RETREAT) & (phase == Phase.RETREAT)
        stuck &= self.memory.clock_s > self.belief.config.patience_s
        phase = torch.where(stuck, int(Phase.APPROACH), phase)
        for env in stuck.nonzero()[:, 0].tolist():
            self.wayfinder.walk_away(env, self.belief.pose[env], self.belief.config.explore_m)
        lost = self.memory.advance(phase, view) & ~stuck
        slipped = closed | (lost & (before_this >= Phase.LIFT) & (before_this <= Phase.ALIGN_PLACE))
        if bool(slipped.any()):
            self.slips = next_try(self.slips, slipped, slipped & (before_this >= Phase.CARRY))
        for env in slipped.nonzero()[:, 0].tolist():
            self.wayfinder.step_back(env)
            if self.slips[env] % LEVELS == 0:
                self.wayfinder.fail(env)
        c = self.belief.config
        self._look_again(lost & slipped, c.doubt_at_feet)
        refused = lost & (before_this == Phase.IDLE)
        self._look_again(refused, c.doubt_put_down)
        self._look_again(lost & ~slipped & ~refused, c.doubt)
        self._think_again(refused)
        vector = self.memory.vector(view)
        action = _at_its_place(decision, sights, hand_anchors(view, vector), geometry, vector)
        self.memory.tick()
        return _at_its_place(decision, action, ask=decision.from_units)

    def _take_hold(self, holds: Tensor) -> None:
        """Who has its hands on the object (N,) for the first time remembers how large it was, standing."""
        first = (holds & ~self.touched).nonzero()[:, 0]
        if len(first):
            belief, places = self.belief, self.belief.places[first]
            known = places[:, OBJECT.stop - 1], places[:, MIDDLE.stop - 1]
            self.stood_m[first] = measured_standing(belief.outline[first], belief.compass[first], *known)
        self.touched = self.touched | holds

    def _felt(self, body: BodyState, phase: Tensor) -> tuple[Tensor, Tensor]:
        """(N,) the phase that comes next, but who has nothing between the hands starts anew, and who has something goes
        on; and (N,) bool who closed them on next to nothing."""
        now = self.memory.phase
        if not bool(((now >= Phase.SQUEEZE) & (now <= Phase.ALIGN_PLACE)).any()):
            return phase, torch.zeros_like(now, dtype=torch.bool)
        width_m = 2 * self.belief.places[:, SPAN].norm(dim=-1)
        closed = closed_on_little(body, now, phase, width_m) & (self.slips < LEVELS)
        empty, held = still_held(body, now, self.memory.from_hands)
        held &= (now != Phase.LIFT) | (self.memory.clock_s < LIFTED_S)  # what is too heavy is not tried for ever
        phase = torch.where(held & (phase == Phase.APPROACH), now, phase)
        return torch.where(closed | empty, int(Phase.APPROACH), phase), closed

    def _elsewhere(self, phase: Tensor) -> Tensor:
        """(N,) the phase that comes next, but who could not reach the object from a side, twice, goes to another one.

        Something that the map does not show is in the way there: to align with the same stand again ends the same way.
        """
        now = self.memory.phase
        impatient = self.memory.clock_s > self.belief.config.patience_s
        failed = (now == Phase.REACH) & (phase < Phase.REACH)
        failed |= (now == Phase.ALIGN) & (phase == Phase.APPROACH) & impatient
        for env in failed.nonzero()[:, 0].tolist():
            if self.wayfinder.fail(env) > 1:
                phase[env] = int(Phase.APPROACH)
                self.wayfinder.step_back(env)
        return phase

    def _give_up_hesitating(self, hesitates: Tensor, phase: Tensor) -> None:
        """Who `hesitates` (N,) bool to reach for the object, again and again, stands where it is not: it steps back and
        looks for it as at the beginning. `phase` (N,) comes next."""
        stays = (self.hesitates_s > 0) & (phase <= Phase.ALIGN)
        self.hesitates_s = torch.where(hesitates | stays, self.hesitates_s + CONTROL_DT_S, 0.0)
        given_up = self.hesitates_s > self.belief.config.hesitation_s
        for env in given_up.nonzero()[:, 0].tolist():
            self.wayfinder.fail(env)
            self.wayfinder.step_back(env)
        self._look_again(given_up, self.belief.config.doubt)
        self.hesitates_s = self.hesitates_s * ~given_up

    def _look_again(self, lost: Tensor, deviation_m: float) -> None:
        """Where the object is `lost` (N,) bool it may be so far away, and may be looked for as at the beginning."""
        if bool(lost.any()):
            self.belief.doubt(lost.nonzero()[:, 0], deviation_m)
            self.searched_rad, self.rounds = self.searched_rad * ~lost, self.rounds * ~lost

    def _think_again(self, refused: Tensor) -> None:
        """Who was done and hears the same instruction still, `refused` (N,) bool, took the wrong thing, or brought it
        to the wrong place."""
        for env in refused.nonzero()[:, 0].tolist():
            place = self.refusals.refuse(env, self.belief.places[env])
            if place is not None:
                self.belief.forget(torch.tensor([env]), place)
                self.searched_rad[env] = self.rounds[env] = self.slips[env] = 0

    def _sure_of(self, phase: Tensor, places_h: Tensor) -> Tensor:
        """(N,) the phase that comes next, but nothing is reached for that may be elsewhere, and nothing for ever; and
        what turns out to be far away is walked to, round what is in the way."""
        c, now = self.belief.config, self.memory.phase
        reaches = (now == Phase.ALIGN) | (now == Phase.REACH)
        impatient = reaches & (phase == now) & (self.memory.clock_s > c.patience_s)
        self._look_again(impatient, c.doubt)
        unsure = self.belief.deviation_m(OBJECT) > c.sure_m
        would_reach = (phase == Phase.REACH) | (phase == Phase.SQUEEZE)
        hesitates = unsure & (now <= Phase.REACH) & would_reach
        back = impatient | hesitates
        self._give_up_hesitating(hesitates, phase)
        for walks, aligns, stand in ((Phase.APPROACH, Phase.ALIGN, PICK), (Phase.CARRY, Phase.ALIGN_PLACE, PLACE)):
            is_far = (phase == aligns) & (places_h[:, stand].norm(dim=-1) > c.align_within_m)
            phase = torch.where(is_far, torch.full_like(phase, int(walks)), phase)
        return torch.where(back, torch.full_like(phase, int(Phase.APPROACH)), phase)


def _far(place_h: Tensor) -> Tensor:
    """(N,) distance of places (N, 3) on the floor, m; half a metre of what is at the robot's feet."""
    return (place_h[:, :2].square().sum(1) + _AT_FEET_M**2).sqrt()


def _hidden(phase: Tensor, to_goal_m: Tensor) -> Tensor:
    """(n, 21) by how much more than is said pictures of robots in phases (n,), so far (n,) from their goals, err."""
    factor = torch.ones(len(phase), PLACES_DIM)
    touches, holds = ((phase >= begin) & (phase <= Phase.LOWER) for begin in (Phase.REACH, Phase.LIFT))
    of_goal = torch.where(to_goal_m < BEFORE_GOAL_M, BEFORE_GOAL, BEHIND)[:, None]
    for numbers, doubts, more in (
        (OBJECT, touches, TOUCHED),
        ([OBJECT.stop - 1, MIDDLE.stop - 1], touches, TOUCHED_HEIGHT),
        (GOAL, holds, of_goal),
    ):
        factor[:, numbers] = torch.where(doubts[:, None], more, factor[:, numbers])
    return factor


def _at_its_place(
    network: Odometry | DecisionNetwork, *inputs: Tensor, ask: Callable[..., Tensor] | None = None
) -> Tensor:
    """What a network makes of tensors on the CPU, there again, wherever its weights are."""
    device = network.mean.device
    return (ask or network)(*(value.to(device) for value in inputs)).cpu()


@numba.njit(cache=True)
def _turn_way(way: Array, pose: Array, places_h: Array, phase: Array) -> None:
    """`Following._way_now`: changes ways (N, 8) in the frame of odometry."""
    for i in range(len(way)):
        x, y, yaw = np.float64(pose[i, 0]), np.float64(pose[i, 1]), np.float64(pose[i, 2])
        way[i, _WAYPOINT], way[i, _WAYPOINT + 1] = turned_xy(-yaw, way[i, _WAYPOINT] - x, way[i, _WAYPOINT + 1] - y)
        way[i, _AWAY], way[i, _AWAY + 1] = turned_xy(-yaw, np.float64(way[i, _AWAY]), np.float64(way[i, _AWAY + 1]))
        if way[i, IS_LAST] > 0.5 and phase[i] <= _LOWER:
            stand = _PLACE if phase[i] >= _LIFT else _PICK
            way[i, _WAYPOINT], way[i, _WAYPOINT + 1] = places_h[i, stand], places_h[i, stand + 1]
