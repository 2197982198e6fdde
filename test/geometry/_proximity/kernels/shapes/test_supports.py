import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles.forms import PARAMETERS, hull_of

from drake_geom_ros.cross_check.surfaces import height_of, support_value_of
from drake_geom_ros.geometry._proximity.kernels.shapes import supports
from drake_geom_ros.geometry._proximity.tolerances import RIGHT_ANGLE
from truth.bodies.random_bodies import random_rotation

KINDS = [supports.SPHERE, supports.BOX, supports.CAPSULE, supports.CYLINDER, supports.ELLIPSOID]
seeds = st.integers(0, 2**32 - 1)


def _case(kind, seed):
    rng = np.random.default_rng(seed)
    size = 10 ** rng.uniform(-3, 0, PARAMETERS[kind])
    n = rng.normal(size=3)
    return size, random_rotation(rng), n / np.linalg.norm(n), rng


@pytest.mark.parametrize('kind', KINDS)
@settings(max_examples=40)
@given(seed=seeds)
def test_core_and_its_ball_have_the_support_value_of_the_shape(kind, seed):
    size, R, n, _ = _case(kind, seed)
    point = np.array(supports.support(kind, size, R, tuple(n), RIGHT_ANGLE))
    value = point @ n + supports.core_radius(kind, size)
    assert value == pytest.approx(
        support_value_of((kind, size), R.T @ n), rel=1e-14, abs=1e-14 * size.sum()
    )


@pytest.mark.parametrize('kind', KINDS)
@settings(max_examples=40)
@given(seed=seeds)
def test_support_point_grown_by_the_ball_is_on_the_surface(kind, seed):
    size, R, n, _ = _case(kind, seed)
    point = np.array(supports.support(kind, size, R, tuple(n), RIGHT_ANGLE))
    surface = R.T @ (point + supports.core_radius(kind, size) * n)
    assert abs(height_of((kind, size), surface)) <= 1e-13 * size.sum()


@pytest.mark.parametrize('kind', KINDS)
@settings(max_examples=40)
@given(seed=seeds)
def test_no_support_point_is_beyond_the_plane_of_another(kind, seed):
    """The core is convex: that the ball of an ellipsoid may be taken off is a theorem."""
    size, R, n, rng = _case(kind, seed)
    plane = np.array(supports.support(kind, size, R, tuple(n), 0.0)) @ n
    for _ in range(20):
        m = n + 10 ** rng.uniform(-4, 1) * rng.normal(size=3)
        m /= np.linalg.norm(m)
        other = np.array(supports.support(kind, size, R, tuple(m), 0.0)) @ n
        assert other <= plane + 1e-14 * size.sum()


@pytest.mark.parametrize('kind', KINDS)
@settings(max_examples=40)
@given(seed=seeds)
def test_the_bounding_radius_holds_the_shape(kind, seed):
    size, R, n, _ = _case(kind, seed)
    point = np.array(supports.support(kind, size, R, tuple(n), 0.0))
    radius = supports.bounding_radius(kind, size)
    assert np.linalg.norm(point + supports.core_radius(kind, size) * n) <= radius * (1 + 1e-14)


def test_a_ball_is_a_point_with_a_radius():
    size = np.array([0.3, 0.3, 0.3])
    n = (0.6, 0.0, 0.8)
    assert np.allclose(
        supports.support(supports.ELLIPSOID, size, np.eye(3), n, 0.0), 0, rtol=0, atol=1e-16
    )
    assert supports.core_radius(supports.ELLIPSOID, size) == pytest.approx(0.3, rel=1e-15)


def test_right_angles_give_the_middle_only_when_asked():
    size, along = np.array([1.0, 2.0, 3.0]), (1.0, 0.0, 0.0)
    middle = supports.support(supports.BOX, size, np.eye(3), along, RIGHT_ANGLE)
    corner = supports.support(supports.BOX, size, np.eye(3), along, 0.0)
    assert tuple(middle) == (1.0, 0.0, 0.0)
    assert tuple(corner) == (1.0, 2.0, 3.0)
    up = (0.0, 0.0, 1.0)
    cap = supports.support(supports.CYLINDER, size[:2], np.eye(3), up, RIGHT_ANGLE)
    rim = supports.support(supports.CYLINDER, size[:2], np.eye(3), up, 0.0)
    assert tuple(cap) == (0.0, 0.0, 2.0)
    assert tuple(rim) == (1.0, 0.0, 2.0)


def test_a_hull_is_read_from_its_vertices():
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]])
    shape = hull_of(vertices)
    point = supports.support(supports.CONVEX, shape, np.eye(3), (0.0, 1.0, 0.0), 0.0)
    assert tuple(point) == (0.0, 2.0, 0.0)
    assert supports.bounding_radius(supports.CONVEX, shape) == 3.0
    assert supports.core_radius(supports.CONVEX, shape) == 0.0


def test_of_a_triangle_the_farthest_corner_is_told():
    rng = np.random.default_rng(1)
    for _ in range(30):
        corners, n = rng.normal(size=(3, 3)), rng.normal(size=3)
        shape, R = corners.ravel(), random_rotation(rng)
        n /= np.linalg.norm(n)
        point = supports.support(supports.TRIANGLE, shape, R, tuple(n), 0.0)
        turned = corners @ R.T
        assert point == pytest.approx(turned[np.argmax(turned @ n)], abs=1e-15)
