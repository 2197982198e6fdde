"""Kernels of many points against the pair kernels of spheres without radius."""

import math

import numpy as np
import pytest
from oracles.kernel_calls import call_for_pair

from drake_geom_ros.geometry._proximity.kernels import pair_table
from drake_geom_ros.geometry._proximity.kernels.calling import (
    pairs as calling,
)
from drake_geom_ros.geometry._proximity.kernels.calling import (
    points as calling_points,
)
from drake_geom_ros.geometry._proximity.kernels.pair_table import POINT_KERNELS, load_kernel
from drake_geom_ros.geometry._proximity.kinds import ITERATIVE, SPHERE
from drake_geom_ros.geometry._proximity.tolerances import CLOSED_FORM_ROUNDING, EPS
from truth.bodies.random_bodies import random_rotation

CLOSED_FORMS = {
    pair_table.SPHERE: [0.3],
    pair_table.BOX: [0.1, 0.2, 0.3],
    pair_table.CAPSULE: [0.1, 0.3],
    pair_table.CYLINDER: [0.2, 0.3],
    pair_table.ELLIPSOID: [0.1, 0.3, 0.2],
    pair_table.HALF_SPACE: [],
}


def answers(kind, R_WG, p_WG, p_WQs, threshold=math.inf, geometries=1, g=0, rounding=(0.0, 0.0)):
    """Return rows, which are found, and the counts, of one geometry among some."""
    m, shape = len(p_WQs), np.array(CLOSED_FORMS[kind])
    rows = np.full((m * geometries, calling_points.POINT_WIDTH), np.nan)
    found, counts = np.zeros(m * geometries, dtype=np.bool_), np.zeros(5, dtype=np.int64)
    outer = math.inf if kind == pair_table.HALF_SPACE else 0.4
    body = calling_points.PointedBody(shape, R_WG, p_WG, outer, *rounding)
    span = calling_points.Span(0, m, g, geometries)
    written = calling_points.PointAnswers(rows, found, counts)
    load_kernel(POINT_KERNELS[kind])(0, kind, body, p_WQs, threshold, span, written)
    return rows, found, counts


@pytest.mark.parametrize('kind', CLOSED_FORMS)
@pytest.mark.parametrize('place', [0.0, 1e3, 1e6])
def test_as_a_sphere_without_radius(kind, place):
    rng = np.random.default_rng(kind)
    R_WG = random_rotation(rng)
    p_WG = place * np.ones(3) + rng.normal(size=3)
    p_WQs = p_WG + 0.4 * rng.normal(size=(40, 3))
    rows, found, _ = answers(kind, R_WG, p_WG, p_WQs)
    assert found.all()
    assert np.isfinite(rows).all()
    number = pair_table.ROW_OF_TYPES[SPHERE * pair_table.TYPE_COUNT + kind]
    pair_kernel = pair_table.ALL_ROWS[number].load_kernel()
    for p_WQ, answer in zip(p_WQs, rows, strict=True):
        out = np.zeros(calling.PAIR_WIDTH)
        shape = np.array(CLOSED_FORMS[kind])
        pair = SPHERE, np.zeros(1), np.eye(3), kind, shape, R_WG, p_WG - p_WQ
        call_for_pair(pair_kernel, *pair, 0.0, math.inf, out)
        assert answer[calling_points.POINT_DISTANCE] == pytest.approx(out[0], abs=1e-15)
        np.testing.assert_allclose(answer[1:4], out[1:4], rtol=0, atol=1e-14)
        p_QN_W = R_WG @ answer[4:7] + (p_WG - p_WQ)
        np.testing.assert_allclose(p_QN_W, out[7:10], rtol=0, atol=1e-15)
        assert answer[calling_points.POINT_UNIQUE] == out[calling.UNIQUE]
        assert answer[calling_points.POINT_ERROR_BOUND] >= out[calling.ERROR_BOUND]


@pytest.mark.parametrize('kind', CLOSED_FORMS)
def test_only_what_is_within_the_threshold_and_only_its_own_rows(kind):
    rng = np.random.default_rng(7)
    p_WQs = 2.0 * rng.normal(size=(50, 3))
    every, _, _ = answers(kind, np.eye(3), np.zeros(3), p_WQs)
    some, found, counts = answers(kind, np.eye(3), np.zeros(3), p_WQs, 0.5, geometries=3, g=1)
    expected = every[:, calling_points.POINT_DISTANCE] <= 0.5
    assert 0 < expected.sum() < 50
    np.testing.assert_array_equal(found[1::3], expected)
    assert not found[0::3].any()
    assert not found[2::3].any()
    np.testing.assert_array_equal(some[1::3][expected], every[expected])
    assert np.isnan(some[1::3][~expected]).all()
    assert counts.tolist() == [0, expected.sum(), 0, 0, 0]


@pytest.mark.parametrize('kind', CLOSED_FORMS)
@pytest.mark.parametrize('threshold', [math.inf, 0.3])
def test_no_digit_depends_on_the_points_asked_beside_it(kind, threshold):
    """Deep ones, on planes of symmetry and far away too: they take steps together."""
    rng = np.random.default_rng(11)
    p_WQs = rng.normal(size=(150, 3)) * 10.0 ** rng.uniform(-9, 2, (150, 1))
    p_WQs[::5, rng.integers(3)] = 0.0
    p_WQs[:3] = [[0.0, 0.0, 0.0], [0.05, 0.0, 0.0], [0.0, 0.0, 0.2]]
    turned = random_rotation(rng), rng.normal(size=3)
    together, found, _ = answers(kind, *turned, turned[1] + p_WQs, threshold)
    for k in range(len(p_WQs)):
        alone, was_found, _ = answers(kind, *turned, turned[1] + p_WQs[k : k + 1], threshold)
        assert found[k] == was_found[0]
        np.testing.assert_array_equal(together[k], alone[0])


@pytest.mark.parametrize('kind', CLOSED_FORMS)
@pytest.mark.parametrize('p_WQ', [[0.0, 0.0, 0.0], [3.0, 4.0, 12.0]])
def test_the_bound_counts_the_geometry_and_the_way_to_it(kind, p_WQ):
    """Both are added up, so neither of them can take from what the other rounds off."""
    rows, _, _ = answers(kind, np.eye(3), np.zeros(3), np.array([p_WQ]))
    bound = rows[0, calling_points.POINT_ERROR_BOUND]
    largest, size = max(CLOSED_FORMS[kind], default=0.0), sum(CLOSED_FORMS[kind])
    way = np.linalg.norm(p_WQ)
    assert CLOSED_FORM_ROUNDING * (largest + way) <= bound
    assert bound <= CLOSED_FORM_ROUNDING * (size + way) + 8 * EPS * max(p_WQ)


@pytest.mark.parametrize('kind', CLOSED_FORMS)
@pytest.mark.parametrize('power', [2.0**-30, 2.0**30])
def test_a_power_of_two_changes_no_digit(kind, power, monkeypatch):
    p_WQs = np.random.default_rng(kind).normal(size=(20, 3)) * [0.2, 0.2, 1e-6]
    rows, _, _ = answers(kind, np.eye(3), np.zeros(3), p_WQs)
    shape = power * np.array(CLOSED_FORMS[kind])
    monkeypatch.setitem(CLOSED_FORMS, kind, shape)
    scaled, _, _ = answers(kind, np.eye(3), np.zeros(3), power * p_WQs)
    lengths = [0, 4, 5, 6, calling_points.POINT_ERROR_BOUND]
    rows[:, lengths] *= power
    np.testing.assert_array_equal(scaled, rows)


def test_a_hull_is_answered_by_its_pair_kernel_into_its_own_rows():
    """A cuboid as a hull, beside two other geometries, against the closed form of the box."""
    h = np.array(CLOSED_FORMS[pair_table.BOX])
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * h
    shape = np.concatenate([[8.0], corners.T.ravel()])
    rng = np.random.default_rng(1)
    R_WG, p_WG = random_rotation(rng), rng.normal(size=3)
    p_WQs = p_WG + rng.normal(size=(6, 3)) * 0.4
    expected, near, _ = answers(pair_table.BOX, R_WG, p_WG, p_WQs, 0.3, geometries=3, g=2)
    number = pair_table.ROW_OF_TYPES[SPHERE * pair_table.TYPE_COUNT + pair_table.CONVEX]
    address = calling.compiled_address(pair_table.ALL_ROWS[number].load_kernel())
    rows, found = np.full_like(expected, np.nan), np.zeros_like(near)
    counts = np.zeros(5, dtype=np.int64)
    load_kernel(POINT_KERNELS[pair_table.CONVEX])(
        address,
        pair_table.CONVEX,
        calling_points.PointedBody(shape, R_WG, p_WG, np.linalg.norm(h), 1e-9, 0.0),
        p_WQs,
        0.3,
        calling_points.Span(0, 6, 2, 3),
        calling_points.PointAnswers(rows, found, counts),
    )
    np.testing.assert_array_equal(found, near)
    assert 0 < near.sum() < 6
    assert counts.sum() == counts[ITERATIVE] == near.sum()
    np.testing.assert_allclose(rows[:, :7], expected[:, :7], rtol=0, atol=1e-13)
    assert (rows[found, calling_points.POINT_ERROR_BOUND] >= 1e-9).all()


@pytest.mark.parametrize('kind', CLOSED_FORMS)
def test_the_rounding_of_the_pose_is_in_the_bound(kind):
    rng = np.random.default_rng(8)
    p_WQs = 2.0 * rng.normal(size=(20, 3))
    arguments = kind, np.eye(3), np.zeros(3), p_WQs
    tilt = 1e-12 if kind == pair_table.HALF_SPACE else 0.0
    exact, rounded = (answers(*arguments, rounding=r)[0] for r in ((0.0, 0.0), (1e-9, tilt)))
    more = rounded[:, calling_points.POINT_ERROR_BOUND]
    more -= exact[:, calling_points.POINT_ERROR_BOUND]
    np.testing.assert_allclose(more, 1e-9 + tilt * np.linalg.norm(p_WQs, axis=1), rtol=1e-5)


def test_every_shape_has_a_kernel_for_points():
    assert set(POINT_KERNELS) == set(pair_table.SHAPE_NAMES)
