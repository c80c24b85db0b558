"""Prisms: overlap and support against brute force over sampled points."""

import numpy as np
import pytest

from hv_sim.parts import (
    Part,
    bounding_half_extents_m,
    box,
    cylinder,
    inside_polygon,
    moved,
    overlap_m,
    prism,
    prisms,
    rod,
    support_height_m,
    tilt,
)

GRAY = (0.5, 0.5, 0.5)


def _inside(part, points):
    yaw = 2 * np.arctan2(part.quat[3], part.quat[0])
    c, s = np.cos(yaw), np.sin(yaw)
    local = (points - part.pos_m) @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    return (np.abs(local) <= part.size_m).all(-1)


def test_overlap_agrees_with_sampling():
    rng = np.random.default_rng(0)
    for _ in range(60):
        a, b = (
            moved(
                [box((0, 0, 0), tuple(rng.uniform(0.2, 1.0, 3)), GRAY, collides=True)], rng.uniform(-0.5, 0.5, 3), yaw
            )[0]
            for yaw in rng.uniform(-3, 3, 2)
        )
        points = rng.uniform(-1.3, 1.3, (20000, 3))
        common = (_inside(a, points) & _inside(b, points)).any()
        depth = overlap_m(prism(a), prism(b))
        if common:
            assert depth > 0
        if depth > 0.25:
            assert common


def test_overlap_is_the_shortest_way_apart():
    a = prism(box((0, 0, 0), (1, 1, 1), GRAY, collides=True))
    b = prism(box((0.9, 0.2, 0), (1, 1, 1), GRAY, collides=True))
    assert overlap_m(a, b) == pytest.approx(0.1)
    assert overlap_m(a, prism(box((0, 0, 1.3), (1, 1, 1), GRAY, collides=True))) == pytest.approx(-0.3)


def test_support_is_the_highest_top_below():
    solids = prisms(
        [
            box((0, 0, 0.2), (1, 1, 0.4), GRAY, collides=True),
            cylinder((0, 0, 0.5), 0.2, 0.2, GRAY, collides=True),
            box((0, 0, 2.0), (1, 1, 0.1), GRAY, collides=True),
            box((0, 0, 0.7), (1, 1, 0.1), GRAY),  # only to look at
        ]
    )
    assert support_height_m((0.0, 0.1), 1.0, solids) == pytest.approx(0.6)
    assert support_height_m((0.4, 0.4), 1.0, solids) == pytest.approx(0.4)
    assert support_height_m((0.0, 0.0), 0.5, solids) == pytest.approx(0.4)
    assert support_height_m((3.0, 0.0), 1.0, solids) == 0.0


def test_polygon_margin_grows_it():
    square = prism(box((0, 0, 0), (1, 1, 1), GRAY, collides=True)).polygon_m
    points = np.array([[0.0, 0.0], [0.55, 0.0], [0.7, 0.0]])
    assert inside_polygon(points, square).tolist() == [True, False, False]
    assert inside_polygon(points, square, 0.1).tolist() == [True, True, False]


def test_bounding_box_follows_yaw():
    parts = moved([box((0.5, 0, 0), (0.4, 0.2, 0.6), GRAY, collides=True)], (0, 0, 0), np.pi / 2)
    np.testing.assert_allclose(bounding_half_extents_m(parts), [0.1, 0.7, 0.3], atol=1e-12)


def test_rod_ends_where_it_should():
    part = rod((0, 0, 0), (1, 2, -2), 0.1, GRAY)
    w, x, y, z = part.quat
    axis = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])  # the rotated z axis
    np.testing.assert_allclose(np.array(part.pos_m) + axis * part.size_m[1], [1, 2, -2], atol=1e-9)


def test_colliding_parts_are_upright_boxes_and_cylinders():
    with pytest.raises(ValueError, match="upright"):
        Part("ellipsoid", (1, 1, 1), (0, 0, 0), GRAY, collides=True)
    with pytest.raises(ValueError, match="upright"):
        box((0, 0, 0), (1, 1, 1), GRAY, quat=tilt(0.3, 0), collides=True)
    with pytest.raises(ValueError, match="cone"):
        Part("cone", (1, 1, 1), (0, 0, 0), GRAY)
