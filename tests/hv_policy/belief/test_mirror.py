import re

import torch

from hv_policy.belief import mirror
from hv_policy.belief.boxes import first_box_hit
from hv_policy.belief.camera import pixel_rays, project
from hv_policy.belief.floor_patch import patch_points
from hv_policy.belief.labels import Landmarks
from hv_policy.belief.outline import outline_of
from hv_policy.belief.places import OBJECT, PICK, PICK_TURN, SPAN
from hv_policy.motor.proprioception import read_proprioception
from hv_sim.suites import load_suite
from hv_sim.world import RearrangeWorld
from hv_teachers.glances import glance_around

ALL = torch.tensor([True, True])
TASKS = load_suite("seen")[:2]


def glances() -> list[tuple[torch.Tensor, torch.Tensor]]:
    return [(state_of(world), known.places.clone()) for world, known in glance_around(TASKS, [5, 6], 4)]


def state_of(world: RearrangeWorld) -> torch.Tensor:
    return world.observe().proprioception.clone()


def test_words_change_hands_and_back():
    text = "The right place for the cup is to the left of the sink, on your Right."
    assert mirror.mirrored_text(text) == "The right place for the cup is to the right of the sink, on your left."
    assert mirror.mirrored_text("leftovers upright") == "leftovers upright"
    for task in load_suite("seen")[:40]:
        for subtask in task.subtasks:
            line = subtask.instruction
            assert mirror.mirrored_text(mirror.mirrored_text(line)).lower() == line.lower()
            assert bool(re.search("left|right(?! place)", line.lower())) == (mirror.mirrored_text(line) != line)


def test_what_is_seen_left_of_the_middle_is_seen_right_of_it():
    for state, places in glances():
        mirrored_state, mirrored = mirror.STATE(state), mirror.PLACES(places)
        torch.testing.assert_close(mirror.PLACES(mirrored), places)
        at, visible = project(read_proprioception(state), places[:, None, OBJECT])
        other, still = project(read_proprioception(mirrored_state), mirrored[:, None, OBJECT])
        torch.testing.assert_close(other, at * torch.tensor([-1.0, 1.0]), atol=1e-4, rtol=1e-4)
        assert torch.equal(visible, still)
        assert torch.equal(mirrored[:, PICK], places[:, PICK] * torch.tensor([1.0, -1.0]))
        angle, turned = (torch.atan2(*p[:, PICK_TURN].flip(1).unbind(1)) for p in (places, mirrored))
        torch.testing.assert_close(turned, -angle)
        # hands at middle -+ span: mirrored, the right one is where the left one was
        left, right = places[:, SPAN], -mirrored[:, SPAN]
        torch.testing.assert_close(right, left * torch.tensor([1.0, -1.0, 1.0]))


def test_boxes_are_met_by_the_mirrored_rays():
    (state, _), *_ = glances()
    boxes = torch.tensor([[[2.0, 0.6, 0.4, 0.5, 0.2, 0.4, 0.4], [1.5, -0.7, 0.3, 0.2, 0.6, 0.3, -0.9]]] * 2)
    exists = torch.ones(2, 2, dtype=torch.bool)
    rays = pixel_rays(16)
    shown = first_box_hit(read_proprioception(state), rays, boxes, exists).view(2, 16, 16)
    mirrored = first_box_hit(read_proprioception(mirror.STATE(state)), rays, mirror.BOX(boxes), exists)
    assert torch.equal(mirrored.view(2, 16, 16).flip(2), shown)
    assert (shown >= 0).any()


def test_floor_outlines_landmarks_and_pictures_follow():
    points = patch_points()
    taken = (points[:, 1] > 0.5)[None].expand(2, -1)
    assert torch.equal(mirror.mirrored_floor(taken, ALL)[0], points[:, 1] < -0.5)
    assert torch.equal(mirror.mirrored_floor(taken, ~ALL), taken)
    angle = torch.tensor(0.3)
    zero = torch.zeros(())
    six = torch.stack([angle.cos(), angle.sin(), zero, -angle.sin(), angle.cos(), zero])[None]
    back = torch.stack([angle.cos(), -angle.sin(), zero, angle.sin(), angle.cos(), zero])[None]
    half = torch.tensor([[0.1, 0.3, 0.2]])
    torch.testing.assert_close(outline_of(mirror.ROTATION_6D(six), half), outline_of(back, half))
    landmarks = Landmarks(
        torch.ones(2, 1, 7),
        torch.ones(2, 1, dtype=torch.bool),
        ["the left lamp", "the sink"],
        torch.ones(2, 1, 3),
        torch.ones(2, 1, dtype=torch.bool),
        ["left of the sofa", "right of the bed"],
    )
    other = mirror.mirrored_landmarks(landmarks, torch.tensor([True, False]))
    assert other.names == ["the right lamp", "the sink"]
    assert other.spot_names == ["right of the sofa", "right of the bed"]
    assert other.spots[:, 0, 1].tolist() == [-1.0, 1.0]
    assert other.boxes[0, 0].tolist() == [1, -1, 1, 1, 1, 1, -1]
    pictures = torch.arange(24.0).view(2, 1, 3, 4)
    flipped = mirror.mirrored_pictures(pictures, torch.tensor([True, False]))
    assert flipped[0, 0, 0].tolist() == [3, 2, 1, 0]
    assert torch.equal(flipped[1], pictures[1])


def test_other_colours_are_still_pictures_of_the_same():
    torch.manual_seed(0)
    pictures = torch.rand(8, 3, 16, 16) * 0.6 + 0.2
    other = mirror.recoloured(pictures)
    assert 0 <= float(other.min()) <= float(other.max()) <= 1
    assert (other.mean((2, 3)) - pictures.mean((2, 3))).abs().mean() > 0.01
    for before, after in zip(pictures, other, strict=True):
        both = torch.stack([before.flatten(), after.flatten()])
        assert float(torch.corrcoef(both)[0, 1]) > 0.9
