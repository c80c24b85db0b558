"""Vectors and rotations of tuples, against numpy and scipy."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hv_policy.motor import vectors as v


def columns(matrix):
    return tuple(tuple(float(x) for x in column) for column in np.asarray(matrix).T)


def matrix(cols):
    return np.array(cols).T


@pytest.fixture
def rng():
    return np.random.default_rng(0)


def test_products_are_numpys(rng):
    for _ in range(20):
        a, b, x, y = rng.normal(size=(3, 3)), rng.normal(size=(3, 3)), *(tuple(rng.normal(size=3)) for _ in range(2))
        np.testing.assert_allclose(v.cross(x, y), np.cross(x, y))
        np.testing.assert_allclose(v.dot(x, y), np.dot(x, y))
        np.testing.assert_allclose(v.times(columns(a), x), a @ x)
        np.testing.assert_allclose(v.transposed_times(columns(a), x), a.T @ x)
        np.testing.assert_allclose(matrix(v.product(columns(a), columns(b))), a @ b)
        np.testing.assert_allclose(matrix(v.transposed_product(columns(a), columns(b))), a.T @ b)
        np.testing.assert_allclose(v.unit(x, 1e-6), x / np.linalg.norm(x))
    np.testing.assert_allclose(v.unit((1e-3, 0.0, 0.0), 0.05), (0.02, 0.0, 0.0))


def test_rotations_are_scipys(rng):
    for x, y, z in rng.uniform(-1.5, 1.5, (20, 3)):
        np.testing.assert_allclose(matrix(v.about_y(y)), Rotation.from_euler("Y", y).as_matrix(), atol=1e-12)
        np.testing.assert_allclose(matrix(v.about_z(z)), Rotation.from_euler("Z", z).as_matrix(), atol=1e-12)
        serial = Rotation.from_euler("XYZ", [x, y, z]).as_matrix()
        np.testing.assert_allclose(matrix(v.hinges_xyz(x, y, z)), serial, atol=1e-12)
        np.testing.assert_allclose(v.hinge_angles(columns(serial)), (x, y, z), atol=1e-9)


def test_rows_of_arrays(rng):
    points, rotations = rng.normal(size=(2, 3, 3)), rng.normal(size=(2, 3, 3, 3))
    np.testing.assert_array_equal(v.vector_at(points, 1, 2), points[1, 2])
    np.testing.assert_array_equal(matrix(v.columns_at(rotations, 1, 2)), rotations[1, 2])
    np.testing.assert_array_equal(v.column_at(rotations, 0, 1, 2), rotations[0, 1, :, 2])
