"""How wrong what `Perception` sees is, against what was so."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import torch
import torch.nn.functional as F
from torch import Tensor

from hv_policy.belief.absent_names import are_absent, draw_names, noun_at
from hv_policy.belief.boxes import can_be_carried, first_box_hit
from hv_policy.belief.faces_head import faces_loss
from hv_policy.belief.floor import POINTS_A_PICTURE, points_to_learn
from hv_policy.belief.labels import Landmarks
from hv_policy.belief.landmark_head import landmark_loss
from hv_policy.belief.other_tasks import choose_tasks, sentence
from hv_policy.belief.perception import (
    GOAL_QUERY,
    OBJECT_QUERY,
    POINTING_WEIGHT,
    Measurement,
    NamedSpots,
    Perception,
    Sight,
    measurement_loss,
    naming_error,
    outline_loss,
    pointing_error,
    pointing_loss,
    upright_loss,
)
from hv_policy.belief.places import GOAL, OBJECT, PICK, unsquash
from hv_policy.motor.proprioception import read_proprioception

THINGS_WEIGHT, SPOTS_WEIGHT, FLOOR_WEIGHT, OTHER_WEIGHT, PIECES_WEIGHT = 0.3, 0.2, 0.3, 0.7, 0.2
_OF_OTHERS = [0, 1, 2, 3, 4]
"""Of a place: what is known of another task's. How high its goal is depends on the object."""
THINGS_ASKED = 2
OUT_OF_VIEW_SHARE = 0.3
"""So many of the things that are not in a picture are asked for in it; those that are, all of them."""
PIECES_ASKED, HIDDEN_ASKED, FOREIGN_ASKED, LARGE_M = 4, 2, 2, 0.3
"""Pieces whose boxes are asked for in a picture: mostly such as are in view and large, such as are elsewhere in the
room, and such as are not in it."""
MOVABLE_WEIGHT = 0.2
NAMELESS = "nothing"
_NEAR_M = 1.5


@dataclass
class Truth:
    """What was so in B pictures."""

    places: Tensor  # (B, 21), zeros where nobody knew
    rotation_6d: Tensor  # (B, 6) how the object is turned
    half_extents_m: Tensor  # (B, 3) of it
    taken: Tensor | None = None  # (B, P) bool which floor is, `hv_policy.belief.floor_patch`
    floor_known: Tensor | None = None  # (B,) bool


@dataclass
class Shown:
    """Which things B pictures show, and which of them are asked for."""

    label: Tensor  # (B, R) int64, -1 for none
    in_view: Tensor  # (B, T) bool
    asked: Tensor  # (B, T) bool

    @staticmethod
    def of(perception: Perception, state: Tensor, boxes: Tensor, exists: Tensor) -> Shown:
        """Of things with boxes (B, T, 7) that there are where `exists` (B, T) bool."""
        label = first_box_hit(read_proprioception(state), perception.rays, boxes, exists)
        in_view = F.one_hot(label + 1, exists.shape[1] + 1)[..., 1:].any(1)
        return Shown(label, in_view, in_view | (torch.rand(exists.shape, device=state.device) < OUT_OF_VIEW_SHARE))


@dataclass
class Things:
    """T things and S spots in B pictures, and what they are called."""

    shown: Shown
    boxes: Tensor  # (B, T, 7), `hv_policy.belief.boxes`
    has_name: Tensor  # (B, T) bool: it is asked for, and there are words for it
    spots: Tensor  # (B, S, 3)
    spot_exists: Tensor  # (B, S) bool
    names: Tensor  # (D, L, dim), D different names, read by `Perception.text`
    is_word: Tensor  # (D, L) bool
    which: Tensor  # (B, T) int64, numbers of names of things,
    of_spots: Tensor  # (B, S) of spots
    foreign: Tensor  # (K,) and of things of other pictures
    is_absent: Tensor  # (B, K) bool: nothing here may be called so
    other: OtherTask


@dataclass
class OtherTask:
    """What else one might be asked to do in B pictures (`hv_policy.belief.other_tasks`)."""

    words: Tensor  # (B, L, dim), read by `Perception.text`
    is_word: Tensor  # (B, L) bool
    exists: Tensor  # (B,) bool
    box: Tensor  # (B, 7) of the object
    spot: Tensor  # (B, 3) the goal

    @property
    def rotation_6d(self) -> Tensor:
        """(B, 6) how the object is turned."""
        cos, sin, zero = self.box[:, 6].cos(), self.box[:, 6].sin(), torch.zeros_like(self.box[:, 6])
        return torch.stack([cos, sin, zero, -sin, cos, zero], 1)


def read_things(perception: Perception, state: Tensor, landmarks: Landmarks) -> Things:
    """Of the landmarks of B pictures, their names read."""
    device = state.device
    boxes, exists = landmarks.boxes.to(device), landmarks.exists.to(device)
    shown = Shown.of(perception, state, boxes, exists)
    asked = shown.asked.flatten().tolist()
    thing_names = [name if ask else "" for name, ask in zip(landmarks.names, asked, strict=True)]
    distinct = sorted({*thing_names, *landmarks.spot_names})
    number = {name: i for i, name in enumerate(distinct)}
    names, is_word = perception.text([name or NAMELESS for name in distinct])
    which = torch.tensor([number[name] for name in thing_names], device=device).view_as(exists)
    has_name = torch.tensor([bool(name) for name in thing_names], device=device).view_as(exists)
    of_spots = torch.tensor([number[name] for name in landmarks.spot_names], device=device).view(len(which), -1)
    foreign = draw_names(which, has_name)
    nouns = _nouns(perception, distinct).to(device)
    is_absent = are_absent(nouns[foreign], nouns[which], has_name)
    spots, there = landmarks.spots.to(device), landmarks.spot_exists.to(device)
    known = torch.tensor([bool(name) for name in landmarks.names], device=device).view_as(exists)
    thing, spot, another, shape, possible = choose_tasks(known, shown.in_view, boxes[..., 3:6], there)
    rows = torch.arange(len(exists), device=device)
    name_of = [landmarks.names[i] for i in (rows * exists.shape[1] + thing).tolist()]
    spot_of, other_of = (
        [landmarks.spot_names[i] for i in (rows * there.shape[1] + chosen).tolist()] for chosen in (spot, another)
    )
    texts = [
        sentence(k, thing=name, spot=at, other=elsewhere)
        for k, name, at, elsewhere in zip(shape.tolist(), name_of, spot_of, other_of, strict=True)
    ]
    words, is_told = perception.text(texts)
    other = OtherTask(words, is_told, possible, boxes[rows, thing], spots[rows, spot])
    return Things(shown, boxes, has_name, spots, there, names, is_word, which, of_spots, foreign, is_absent, other)


def _nouns(perception: Perception, names: Sequence[str]) -> Tensor:
    """(D, F) what the nouns of D names mean."""
    lines = perception.text.words_of(names)
    return torch.stack([perception.text.features.of(words)[noun_at(words)] for words in lines])


def perception_loss(
    perception: Perception,
    pictures: Tensor,
    state: Tensor,
    words: Tensor,
    is_word: Tensor,
    truth: Truth,
    things: Things | None,
) -> tuple[Tensor, dict[str, Tensor]]:
    """(B,) how wrong the places and the floor are that the network sees, and figures to watch, () each, m.

    Args:
        perception: the network.
        pictures, state, words, is_word: see `Perception`.
        truth: what was so.
        things: what else is to be seen.
    """
    sight = perception.look(pictures, state)
    seen, naming, of_pieces = _seen(perception, sight, state, words, is_word, things)
    places = truth.places
    seeing, pointing = measurement_loss(seen, places), pointing_loss(seen, state, places)
    outline = outline_loss(seen, truth.rotation_6d, truth.half_extents_m)
    upright = upright_loss(seen, truth.rotation_6d)
    at, where = unsquash(seen.places.detach())[:, OBJECT], places[:, OBJECT]
    turned = torch.zeros_like(seeing)
    if any(p.requires_grad for p in perception.faces.parameters()):  # else it costs a fifth of the time for nothing
        turned = faces_loss(perception.faces, pictures, read_proprioception(state), at, where, truth.rotation_6d)
    free, wrongly = _floor_loss(perception, sight, state, truth)
    labelled = (places != 0).any(1)  # frames without labels hold zeros
    with torch.no_grad():
        error = (unsquash(seen.places) - places).abs()
        near = places[:, :2].norm(dim=-1) < _NEAR_M
        figures = {
            "seeing_loss": seeing.mean(),
            "outline_loss": outline.mean(),
            "upright_loss": upright.mean(),
            "faces_loss": turned.mean(),
            "floor_loss": free.mean(),
            "floor_wrong": wrongly,
            "pointing_loss": pointing.mean(),
            "naming_loss": naming.mean(),
            "object_error_m": _median(error[:, OBJECT][:, :2].norm(dim=1)),
            "near_object_error_m": _median(error[near][:, OBJECT][:, :2].norm(dim=1)),
            "goal_error_m": _median(error[:, GOAL][:, :2].norm(dim=1)),
            "stand_error_m": _median(error[:, PICK].norm(dim=1)),
        }
    loss = (seeing + pointing + outline + upright + turned + naming) * labelled + FLOOR_WEIGHT * free
    if things is None:
        return loss, figures
    other, more = _other_loss(perception, sight, state, things.other)
    return loss + OTHER_WEIGHT * other, figures | of_pieces | more


def _other_loss(
    perception: Perception, sight: Sight, state: Tensor, task: OtherTask
) -> tuple[Tensor, dict[str, Tensor]]:
    """(B,) how wrong it is where object and goal of another task are, and figures to watch."""
    seen = perception.judge(sight, task.words, task.is_word)
    places = torch.zeros_like(seen.places)
    places[:, OBJECT], places[:, GOAL] = task.box[:, :3], task.spot
    loss = measurement_loss(seen, places, _OF_OTHERS) + outline_loss(seen, task.rotation_6d, task.box[:, 3:6])
    points = torch.stack([task.box[:, :3], task.spot], 1)
    loss = loss + POINTING_WEIGHT * pointing_error(seen.pointing[:, :2], state, points).mean(1)
    with torch.no_grad():
        error = (unsquash(seen.places) - places)[task.exists]
        figures = {
            "other_object_error_m": _median(error[:, OBJECT][:, :2].norm(dim=1)),
            "other_goal_error_m": _median(error[:, GOAL][:, :2].norm(dim=1)),
        }
    return loss * task.exists, figures


def _floor_loss(perception: Perception, sight: Sight, state: Tensor, truth: Truth) -> tuple[Tensor, Tensor]:
    """(B,) how wrong it is which floor is free (cross-entropy), and how often that is the wrong way about."""
    if truth.taken is None or truth.floor_known is None:
        return torch.zeros(len(state), device=state.device), torch.zeros((), device=state.device)
    body = read_proprioception(state)
    cells, points, in_view = points_to_learn(body, POINTS_A_PICTURE)
    logits = perception.floor(sight.tokens, sight.fine, body, points)
    taken, counts = truth.taken.gather(1, cells), in_view & truth.floor_known[:, None]
    loss = F.binary_cross_entropy_with_logits(logits, taken.to(logits), reduction="none")
    wrong = ((logits > 0) != taken) & counts
    return (loss * counts).sum(1) / counts.sum(1).clamp(min=1), wrong.sum() / counts.sum().clamp(min=1)


def _seen(
    perception: Perception, sight: Sight, state: Tensor, words: Tensor, is_word: Tensor, things: Things | None
) -> tuple[Measurement, Tensor, dict[str, Tensor]]:
    """What the pictures say; (B,) how wrong it is what their parts show, and where named spots are; and figures to
    watch."""
    if things is None:
        return perception.judge(sight, words, is_word), torch.zeros(len(state), device=state.device), {}
    shown, has_name, which = things.shown, things.has_name, things.which
    names = perception.named(things.names, things.is_word)
    foreign = names[things.foreign].expand(len(which), -1, -1)
    looked_for, asked = torch.cat([names[which], foreign], 1), torch.cat([has_name, things.is_absent], 1)
    named = naming_error(perception.name(sight, looked_for), shown.label, asked)
    # some of the things and of the spots are asked for as objects and goals are, and a thing that is not there:
    # whatever is near and in view is the object of most pictures of an attempt, but must not be for that
    number_asked = min(THINGS_ASKED, which.shape[1])
    drawn = torch.rand(which.shape, device=state.device)
    chosen = (drawn + shown.in_view + 2 * has_name).topk(number_asked, 1).indices
    one = (torch.rand(things.is_absent.shape, device=state.device) + things.is_absent).argmax(1, keepdim=True)
    asked_for = torch.cat([which.gather(1, chosen), things.foreign[one], things.of_spots], 1).flatten()
    queries = [OBJECT_QUERY] * (number_asked + 1) + [GOAL_QUERY] * things.spots.shape[1]
    named_spots = NamedSpots(queries, things.names[asked_for], things.is_word[asked_for])
    seen = perception.judge(sight, words, is_word, named_spots)
    there = torch.cat([has_name.gather(1, chosen), things.is_absent.gather(1, one), things.spot_exists], 1)
    middles = things.boxes[..., :3].gather(1, chosen[..., None].expand(-1, -1, 3))
    nowhere = middles.new_tensor([-10.0, 0.0, 0.0]).expand(len(which), 1, 3)
    wrong = pointing_error(seen.spots, state, torch.cat([middles, nowhere, things.spots], 1)) * there
    spots = wrong.sum(1) / there.sum(1).clamp(min=1)
    pieces, figures = pieces_loss(perception, sight, looked_for, things.boxes, shown.in_view, asked)
    movable, more = movable_loss(perception, sight, shown.label, things.boxes)
    loss = THINGS_WEIGHT * named + SPOTS_WEIGHT * spots + PIECES_WEIGHT * pieces + MOVABLE_WEIGHT * movable
    return seen, loss, figures | more


def pieces_loss(
    perception: Perception, sight: Sight, named: Tensor, boxes: Tensor, in_view: Tensor, asked: Tensor
) -> tuple[Tensor, dict[str, Tensor]]:
    """(B,) how wrong `Perception.find_pieces` is of a few things in each picture, and of some that are not there, and
    figures to watch. What things are called does not change by it.

    Args:
        perception, sight: the network and what it sees.
        named: (B, T + K, dim) what is looked for: T things of each picture, and K that it may not show.
        boxes: (B, T, 7) of things.
        in_view: (B, T) bool.
        asked: (B, T + K) bool; the others have no name, or may be there.
    """
    foreign = asked.shape[1] - in_view.shape[1]
    boxes, in_view = F.pad(boxes, (0, 0, 0, foreign)), F.pad(in_view, (0, foreign))
    is_here = torch.arange(asked.shape[1], device=asked.device) < boxes.shape[1] - foreign
    likely = torch.rand(asked.shape, device=asked.device) + 4 * asked
    large = 0.5 * (boxes[..., 3:6].amax(-1) > LARGE_M)
    chosen = torch.cat(
        [
            (likely + sign).topk(min(count, asked.shape[1]), 1).indices
            for sign, count in (
                (2 * in_view + large, PIECES_ASKED),
                (2 * (is_here & ~in_view) + large, HIDDEN_ASKED),
                (2 * ~is_here, FOREIGN_ASKED),
            )
        ],
        1,
    )

    def of(values: Tensor) -> Tensor:
        return values.gather(1, chosen.view(*chosen.shape, *[1] * (values.dim() - 2)).expand(-1, -1, *values.shape[2:]))

    shown, known, boxes = of(in_view), of(asked), of(boxes)
    found = perception.find_pieces(sight, of(named).detach())
    loss, apart = landmark_loss(found, boxes, shown, known)
    near = shown & known & (boxes[..., :2].norm(dim=-1) < 2 * _NEAR_M)
    believed = found.seen.detach() > 0
    figures = {
        "piece_error_m": _median(apart[near]),
        "pieces_missed": (~believed)[near].float().mean(),
        "pieces_imagined": believed[known & ~shown].float().mean(),
    }
    return loss, figures


def movable_loss(
    perception: Perception, sight: Sight, label: Tensor, boxes: Tensor
) -> tuple[Tensor, dict[str, Tensor]]:
    """(B,) cross-entropy of `Perception.find_movable`, and how often that is wrong of either kind of part.

    Args:
        perception, sight: the network and what it sees.
        label: (B, T) int64 which thing each part shows, -1 for none.
        boxes: (B, J, 7) of the things.
    """
    truth = can_be_carried(boxes).gather(1, label.clamp(min=0)) & (label >= 0)
    logits = perception.find_movable(sight)
    loss = F.binary_cross_entropy_with_logits(logits, truth.float(), reduction="none").mean(1)
    wrong = (logits.detach() > 0) != truth
    return loss, {"movable_missed": wrong[truth].float().mean(), "movable_imagined": wrong[~truth].float().mean()}


def _median(values: Tensor) -> Tensor:
    return values.median() if values.numel() else torch.tensor(float("nan"))
