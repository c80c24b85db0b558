"""Basis point sets against dense sampling of the surface and MuJoCo-free geometry."""

import numpy as np
import pytest

from hv_sim.basis_point_set import BASIS_POINTS, basis_point_set, nearest_surface_points
from hv_sim.objects import OBJECT_KINDS, build_object
from hv_sim.parts import box, cylinder, moved

GRAY = (0.5, 0.5, 0.5)


def _sampled_surface(parts, n, rng):
    """Random points on the surface of the union: on each part's surface, unless inside another part."""
    points, owner = [], np.repeat(np.arange(len(parts)), n)
    for part in parts:
        if part.shape == "box":
            p = rng.uniform(-1, 1, (n, 3))
            axis = rng.integers(0, 3, n)
            p[np.arange(n), axis] = np.sign(p[np.arange(n), axis])
            p = p * part.size_m
        else:
            angle, u = rng.uniform(0, 2 * np.pi, n), rng.uniform(-1, 1, n)
            cap = rng.random(n) < 0.5
            radius = np.where(cap, np.sqrt(rng.random(n)), 1.0) * part.size_m[0]
            z = np.where(cap, np.sign(u), u) * part.size_m[1]
            p = np.stack([radius * np.cos(angle), radius * np.sin(angle), z], -1)
        yaw = 2 * np.arctan2(part.quat[3], part.quat[0])
        c, s = np.cos(yaw), np.sin(yaw)
        points.append(p @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) + part.pos_m)
    points = np.concatenate(points)
    hidden = np.zeros(len(points), dtype=bool)
    for i, part in enumerate(parts):
        local = points - part.pos_m
        if part.shape == "box":
            inner = (np.abs(local) < np.array(part.size_m) + 1e-6).all(-1)
        else:
            inner = np.hypot(local[:, 0], local[:, 1]) < part.size_m[0] + 1e-6
            inner &= np.abs(local[:, 2]) < part.size_m[1] + 1e-6
        hidden |= inner & (owner != i)
    return points[~hidden]


def test_basis_points_fill_the_unit_ball_evenly():
    assert BASIS_POINTS.shape == (200, 3)
    radius = np.linalg.norm(BASIS_POINTS, axis=-1)
    assert radius.max() <= 1.0
    np.testing.assert_allclose(np.sort(radius**3), (np.arange(200) + 0.5) / 200, atol=1e-9)
    assert np.abs(BASIS_POINTS.mean(0)).max() < 0.03
    gaps = np.linalg.norm(BASIS_POINTS[:, None] - BASIS_POINTS[None], axis=-1) + 9 * np.eye(200)
    assert gaps.min() > 0.05


def test_box_by_hand():
    part = box((0, 0, 0), (2, 4, 6), GRAY, collides=True)
    points = np.array([[5.0, 0, 0], [5, 5, 5], [0.9, 0, 0], [0, -1.9, 0.3]])
    expected = [[1, 0, 0], [1, 2, 3], [1, 0, 0], [0, -2, 0.3]]
    np.testing.assert_allclose(nearest_surface_points(points, [part]), expected)


def test_cylinder_by_hand():
    part = cylinder((1, 0, 0), 1.0, 4.0, GRAY, collides=True)
    points = np.array([[4.0, 0, 0], [1, 0, 5], [1, 3, 3], [1.9, 0, 0], [1.2, 0, 1.9]])
    expected = [[2, 0, 0], [1, 0, 2], [1, 1, 2], [2, 0, 0], [1.2, 0, 2]]
    np.testing.assert_allclose(nearest_surface_points(points, [part]), expected, atol=1e-12)


@pytest.mark.parametrize("kind", sorted(OBJECT_KINDS))
def test_against_dense_sampling(kind):
    parts = [p for p in build_object(kind).parts if p.collides]
    surface = _sampled_surface(parts, 30000, np.random.default_rng(0))
    bps = basis_point_set(parts)
    assert bps.shape == (200, 3)
    assert bps.dtype == np.float32
    scale = np.linalg.norm(surface, axis=-1).max()
    targets = (BASIS_POINTS + bps) * scale
    ours = np.linalg.norm(bps, axis=-1) * scale
    sampled = np.array([np.linalg.norm(surface - p, axis=-1).min() for p in BASIS_POINTS * scale])
    np.testing.assert_allclose(ours, sampled, atol=0.012)
    off = np.array([np.linalg.norm(surface - t, axis=-1).min() for t in targets])
    assert off.max() < 0.012  # what we point at is on the surface


def test_size_is_lost_and_turning_is_not():
    small = basis_point_set([box((0, 0, 0), (0.2, 0.3, 0.4), GRAY, collides=True)])
    large = basis_point_set([box((0, 0, 0), (0.4, 0.6, 0.8), GRAY, collides=True)])
    np.testing.assert_allclose(small, large, atol=1e-6)
    turned = basis_point_set(moved([box((0, 0, 0), (0.2, 0.3, 0.4), GRAY, collides=True)], (0, 0, 0), 0.5))
    assert np.abs(turned - small).max() > 0.05


def test_no_surface_is_refused():
    with pytest.raises(ValueError, match="parts"):
        basis_point_set([box((0, 0, 0), (1, 1, 1), GRAY)])
