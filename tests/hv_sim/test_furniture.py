"""Furniture: sizes, and tops that hold things."""

import numpy as np
import pytest

from hv_sim.furniture import FURNITURE_KINDS, build_furniture
from hv_sim.parts import prisms, support_height_m
from hv_sim.rooms import FLOORS, ROOM_KINDS, build_room


@pytest.mark.parametrize("kind", sorted(FURNITURE_KINDS))
@pytest.mark.parametrize("scale", [0.8, 1.0, 1.3])
def test_colliding_parts_fill_the_footprint_and_no_more(kind, scale):
    spec = FURNITURE_KINDS[kind]
    size = tuple(s * scale for s in spec.size_m) if spec.solid else spec.size_m
    solids = prisms(build_furniture(kind, size))
    assert bool(solids) == spec.solid
    if not solids:
        return
    corners = np.concatenate([s.polygon_m for s in solids])
    assert (np.abs(corners) <= np.array(size[:2]) / 2 * 1.03 + 1e-9).all()  # a 16-gon is 2 % wider than its circle
    low, top = min(s.z_low_m for s in solids), max(s.z_high_m for s in solids)
    assert low >= -1e-9
    if kind not in ("tv_stand", "vanity", "sink_counter"):  # a screen, a mirror and a tap stand higher
        assert top == pytest.approx(size[2], abs=0.03)


@pytest.mark.parametrize("kind", sorted(k for k, spec in FURNITURE_KINDS.items() if spec.holds_objects))
def test_tops_hold_things_at_their_height(kind):
    size = FURNITURE_KINDS[kind].size_m
    solids = prisms(build_furniture(kind))
    _, front, right, left = FURNITURE_KINDS[kind].top
    edge = (size[0] * front - 0.12, size[1] * (right + left) / 2)
    assert support_height_m(edge, size[2] + 0.01, solids) == pytest.approx(size[2])
    assert 0.1 <= size[2] <= 0.95


def test_sizes_far_from_usual_are_refused():
    with pytest.raises(ValueError, match=r"size_m: .*depth, width, height"):
        build_furniture("sofa", (0.2, 2.0, 0.8))


@pytest.mark.parametrize("kind", ROOM_KINDS)
@pytest.mark.parametrize("floor", sorted(FLOORS))
def test_walls_enclose_the_room(kind, floor):
    size = (5.0, 7.0)
    solids = prisms(build_room(kind, size, floor, "beige"))
    inside = np.concatenate([s.polygon_m for s in solids])
    assert ((np.abs(inside) >= np.array(size) / 2 - 1e-9).any(-1)).all()
    for direction in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        at = np.array(direction) * (np.array(size) / 2 + 0.1)
        assert support_height_m(at, 3.0, solids) == pytest.approx(2.5)


@pytest.mark.parametrize("kind", sorted(FURNITURE_KINDS))
def test_it_can_be_named_and_painted(kind):
    spec = FURNITURE_KINDS[kind]
    assert spec.noun
    assert spec.rooms
    for color in spec.colors:
        assert build_furniture(kind, color=color)


def test_there_is_enough_to_choose_from():
    assert len(FURNITURE_KINDS) >= 50
    for room in ("bedroom", "kitchen", "living_room", "warehouse"):
        assert sum(room in spec.rooms for spec in FURNITURE_KINDS.values()) >= 10
