"""Capsule against capsule and box against capsule."""

import numpy as np
import pytest
from numba import config
from oracles.forms import ALIGNED
from oracles.pairs import check, check_kernel, evaluate, feature_pairs, pair_of, turned

from drake_geom_ros.geometry._proximity.kernels.closed_forms import segments
from drake_geom_ros.geometry._proximity.kernels.closed_forms.segments import (
    box_capsule,
    capsule_capsule,
    nearest_parameter,
)
from drake_geom_ros.geometry._proximity.kinds import BOX, CAPSULE
from truth.bodies.random_bodies import random_rotation

SAMPLES = 2 if config.DISABLE_JIT else 18
ALONG_X = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
ALONG_Y = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


def _capsules(p_AB_W, R_WB=ALIGNED, size_A=(0.1, 0.5), size_B=(0.1, 0.5)):
    return pair_of(CAPSULE, size_A, np.eye(3), CAPSULE, size_B, R_WB, p_AB_W)


def _box_capsule(p_AB_W, R_WB=ALIGNED, size_A=(0.5, 0.5, 0.5), size_B=(0.1, 0.5)):
    return pair_of(BOX, size_A, np.eye(3), CAPSULE, size_B, R_WB, p_AB_W)


@pytest.mark.parametrize(
    ('kernel', 'kinds'), [(capsule_capsule, (3, 3)), (box_capsule, (2, 3))], ids=['33', '23']
)
def test_truth_and_laws(kernel, kinds):
    check_kernel(kernel, kinds, seed=sum(kinds), samples=SAMPLES)


@pytest.mark.parametrize(
    ('kernel', 'kinds'), [(capsule_capsule, (3, 3)), (box_capsule, (2, 3))], ids=['33', '23']
)
def test_cores_that_meet_at_their_features(kernel, kinds):
    rng = np.random.default_rng(sum(kinds))
    for pair in feature_pairs(rng, kinds, 10 * SAMPLES):
        check(kernel, pair)


@pytest.mark.parametrize('gap', [0.2, 1e-3, 1e-9, 0.0, -1e-9, -1e-3, -0.05])
def test_crossing_capsules_meet_where_they_cross(gap):
    row = check(capsule_capsule, _capsules([0.0, 0.2 + gap, 0.0], ALONG_X))
    assert row.distance == pytest.approx(gap, abs=1e-15)
    np.testing.assert_array_equal(row.nhat, [0.0, -1.0, 0.0])
    np.testing.assert_allclose(row.p_ACa, [0.0, 0.1, 0.0], rtol=0, atol=1e-15)


@pytest.mark.parametrize('angle', [np.pi / 2, 1.0, 1e-3, 1e-9, 1e-15, 0.0])
def test_capsules_with_crossing_axes_part_across_both(angle):
    """Peers report a depth of 0.735 for 0.2."""
    R_WB = np.array(
        [
            [1.0, 0.0, 0.0],
            [0.0, np.cos(angle), -np.sin(angle)],
            [0.0, np.sin(angle), np.cos(angle)],
        ]
    )
    row = check(capsule_capsule, _capsules([0.0, 0.0, 0.0], R_WB))
    assert row.distance == pytest.approx(-0.2, rel=1e-14)
    assert not row.unique
    assert abs(row.nhat[2]) <= 1e-15
    assert abs(row.nhat @ R_WB[:, 2]) <= 1e-15


@pytest.mark.parametrize('gap', [1e-3, 1e-6, 1e-13])
def test_the_normal_of_axes_almost_touching_is_across_both(gap):
    """The gap vector itself has few digits left."""
    rng = np.random.default_rng(2)
    for _ in range(20):
        R = random_rotation(rng)
        row = check(capsule_capsule, turned(_capsules([0.0, gap, 0.0], ALONG_X), R))
        np.testing.assert_allclose(R.T @ row.nhat, [0, -1, 0], rtol=0, atol=1e-14)
        assert row.unique


@pytest.mark.parametrize(('gap', 'shift'), [(1e-3, 0.0), (0.0, 0.25), (-1e-3, -0.5)])
def test_parallel_capsules_meet_in_the_middle_of_what_they_share(gap, shift):
    row = check(capsule_capsule, _capsules([0.2 + gap, 0.0, shift]))
    assert row.distance == pytest.approx(gap, abs=1e-15)
    assert row.unique
    assert row.p_ACa[2] == pytest.approx(shift / 2, abs=1e-15)


@pytest.mark.parametrize('gap', [1e-6, 0.0, -1e-6, -0.1])
def test_collinear_capsules(gap):
    row = check(capsule_capsule, _capsules([0.0, 0.0, 1.2 + gap]))
    assert row.distance == pytest.approx(gap, abs=1e-15)
    np.testing.assert_array_equal(row.nhat, [0.0, 0.0, -1.0])


@pytest.mark.parametrize('shift', [0.0, 0.3, 1.0])
def test_capsules_sharing_their_axis_part_sideways(shift):
    row = check(capsule_capsule, _capsules([0.0, 0.0, shift]))
    assert row.distance == pytest.approx(-0.2, rel=1e-15)
    assert not row.unique
    assert row.nhat[2] == 0.0


@pytest.mark.parametrize('angle', [1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14, 1e-16])
@pytest.mark.parametrize('gap', [0.0, 1e-9, 1e-3])
def test_nearly_parallel_long_capsules(angle, gap):
    """The textbook's determinant is angle^2: it has no digits below 1e-8."""
    rng = np.random.default_rng(5)
    for _ in range(2 if config.DISABLE_JIT else 12):
        R = random_rotation(rng)
        c, s = np.cos(angle), np.sin(angle)
        tilt = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
        p = [rng.uniform(-angle, angle), gap, rng.uniform(-1.0, 1.0)]
        pair = _capsules(p, tilt, size_A=(1e-3, 1.0), size_B=(1e-3, 2.0))
        row = check(capsule_capsule, turned(pair, R))
        if angle <= 1e-9:
            assert row.distance == pytest.approx(gap - 2e-3, abs=2 * angle + 1e-14)


def test_capsules_of_vanishing_length_are_spheres():
    for length in (1e-9, 1e-300, 0.0):
        row = check(capsule_capsule, _capsules([0.201, 0.0, 0.0], size_B=(0.1, length)))
        assert row.distance == pytest.approx(1e-3, rel=1e-12)
        row = check(box_capsule, _box_capsule([0.601, 0.0, 0.0], size_B=(0.1, length)))
        assert row.distance == pytest.approx(1e-3, rel=1e-12)


def test_micrometre_capsules():
    pair = _capsules([0.0, 2.1, 0.0], ALONG_X, (1.0, 2.0), (1.0, 2.0)).scaled(1e-6)
    assert check(capsule_capsule, pair).distance == pytest.approx(1e-7, rel=1e-9)


@pytest.mark.parametrize('gap', [0.1, 1e-3, 0.0, -1e-3, -0.05])
def test_capsule_lying_on_a_box_meets_it_in_the_middle_of_what_they_share(gap):
    row = check(box_capsule, _box_capsule([0.3, 0.0, 0.6 + gap], ALONG_X))
    assert row.distance == pytest.approx(gap, abs=1e-15)
    np.testing.assert_array_equal(row.nhat, [0.0, 0.0, -1.0])
    np.testing.assert_allclose(row.p_ACa, [0.15, 0.0, 0.5], rtol=0, atol=1e-15)
    assert row.unique


@pytest.mark.parametrize(
    ('p_AB_W', 'R_WB', 'size_A', 'size_B', 'distance', 'nhat', 'unique'),
    [
        # inside, 0.3 from the middle; in the middle, along y: x and z faces are as near
        ([0.0, 0.0, 0.3], ALONG_X, (1.0, 1.0, 1.0), (0.1, 0.5), -0.8, [0, 0, -1], True),
        ([0.0, 0.0, 0.0], ALONG_Y, (1.0, 1.0, 1.0), (0.1, 0.5), -1.1, [-1, 0, 0], False),
        # two faces equally near, off the middle; the nearer of two
        ([0.3, 0.3, 0.0], ALIGNED, (1.0, 1.0, 1.0), (0.1, 0.5), -0.8, [-1, 0, 0], False),
        ([0.2, 0.3, 0.0], ALIGNED, (1.0, 1.0, 1.0), (0.1, 0.5), -0.8, [0, -1, 0], True),
        # a plate with a capsule's end through it: out along the axis; lengthwise: sideways
        ([0.0, 0.0, 0.46], ALIGNED, (0.5, 0.5, 5e-5), (0.01, 0.5), -0.05005, [0, 0, -1], True),
        ([0.0, 0.0, 0.0], ALONG_X, (0.5, 0.5, 5e-5), (0.01, 0.3), -0.01005, [0, 0, -1], False),
        # both ends outside, the middle inside a bar: over its edge, by the crossed axes
        (
            [0.09, 0.0, 0.09],
            ALONG_X @ np.array([[0.6, 0.0, 0.8], [0.0, 1.0, 0.0], [-0.8, 0.0, 0.6]]),
            (0.1, 5.0, 0.1),
            (0.02, 1.0),
            None,
            None,
            True,
        ),
    ],
)
def test_capsule_that_cuts_a_box(p_AB_W, R_WB, size_A, size_B, distance, nhat, unique):
    row = check(box_capsule, _box_capsule(p_AB_W, R_WB, size_A, size_B))
    assert row.unique == unique
    if distance is None:
        # Neither a face's normal nor along the capsule.
        assert np.abs(row.nhat).max() < 0.99
        assert abs(row.nhat @ R_WB[:, 2]) <= 1e-15
    else:
        assert row.distance == pytest.approx(distance, rel=1e-14)
        np.testing.assert_allclose(row.nhat, nhat, rtol=0, atol=1e-15)


def test_capsule_on_a_plain_ten_kilometres_wide():
    box = _box_capsule([30.0, -4e3, 5e3 + 0.601], ALIGNED, (5e3, 5e3, 5e3))
    row = check(box_capsule, box)
    assert row.distance == pytest.approx(1e-3, abs=1e-11)


def test_nearest_parameter_is_a_minimum():
    """No other place on the segment is nearer to the box, and equal stretches are halved."""
    rng = np.random.default_rng(8)
    for _ in range(5 if config.DISABLE_JIT else 300):
        h = tuple(rng.uniform(0, 1, 3) * (rng.random(3) < 0.8))
        c, d = rng.normal(size=3), rng.normal(size=3) * (rng.random(3) < 0.7)
        d = d / (np.linalg.norm(d) or 1.0)
        t = nearest_parameter(h, tuple(c), tuple(d), 1.5)
        ts = np.append(np.linspace(-1.5, 1.5, 301), t)
        points = c + ts[:, None] * d
        distances = np.linalg.norm(points - np.clip(points, np.negative(h), h), axis=1)
        assert abs(t) <= 1.5
        assert distances[-1] <= distances.min() + 1e-15
        level = ts[:-1][distances[:-1] <= distances.min() + 1e-15]
        if len(level) > 1:
            assert t == pytest.approx((level.min() + level.max()) / 2, abs=0.011)


def test_contact_far_from_a_long_capsules_middle():
    """Witness points do not depend on where on a long capsule the contact is."""
    for along in (-4e3, 0.0, 3e3):
        pair = _capsules([0.0, 0.2, along], ALONG_X, size_A=(0.1, 5e3))
        assert evaluate(capsule_capsule, pair).p_ACa[2] == pytest.approx(along, abs=1e-11)


@pytest.mark.parametrize('turn', range(3))
@pytest.mark.parametrize('side', [1.0, -1.0])
def test_a_short_gap_beside_an_edge_is_at_right_angles_to_the_segment_again(turn, side):
    """Of the segment only what is across the edge counts: along it the point is between faces."""
    d = np.roll([0.6, -0.64 * side, 0.48], turn)
    h = np.roll([1.0, 2.0, 3.0], turn)
    p = np.roll([1.0, 2.0 * side, 0.3], turn)
    across = np.roll([0.64, 0.6 * side, 0.0], turn) * 1e-9
    gap = across + 1e-16 * np.roll([0.6, -0.64 * side, 0.0], turn)
    found = segments._across(tuple(gap), tuple(p), tuple(h), tuple(d), 1e-15)
    assert found == pytest.approx(across, abs=1e-24)


@pytest.mark.parametrize('turn', range(3))
@pytest.mark.parametrize('side', [1.0, -1.0])
@pytest.mark.parametrize(('way', 'flat'), [(1.0, False), (-1.0, False), (1.0, True), (-1.0, True)])
def test_on_a_face_but_for_rounding_a_short_gap_may_turn_outwards_alone(turn, side, way, flat):
    """A plane of a point has a thickness of 0, where either way is outwards."""
    d = np.array([0.48, 0.6, 0.64])
    h = np.array([1.0, 2.0, 1e-16 if flat else 3.0])
    p = np.array([way, -2.0 * way, side * h[2]])
    gap = way * 1e-9 * np.array([0.6, -0.48, 0.0]) + way * 1e-16 * d * [1, 1, 0]
    turned = gap - (gap @ d) * d  # square to d, by a step along z too
    assert abs(turned[2]) > 1e-17
    if not flat and turned[2] * side < 0.0:
        o = d * [1, 1, 0]
        turned = gap - (gap @ o) / (o @ o) * o
    given = (tuple(np.roll(each, turn).tolist()) for each in (gap, p, h, d))
    found = segments._across(*given, 1e-15)
    assert found == pytest.approx(np.roll(turned, turn), abs=1e-23)


@pytest.mark.parametrize('roundings', [1.0, 1.25, 2.0, 8.0, 100.0, 1e4])
def test_a_normal_is_unique_only_where_rounding_leaves_it_one(roundings):
    """Hunted: parallel capsules whose axes are 2e-15 m apart, across both axes of the section."""
    for angle in np.linspace(0.0, np.pi, 7):
        gap = roundings * 8.0 * np.finfo(float).eps * 1.2
        p_AB_W = gap * np.array([np.cos(angle), np.sin(angle), 0.0]) + [0.0, 0.0, 4e-15]
        row = evaluate(capsule_capsule, _capsules(p_AB_W, size_A=(1e-3, 0.7)))
        truth = -p_AB_W[:2] / np.hypot(*p_AB_W[:2])
        assert not row.unique or row.nhat[:2] @ truth > 0.99
        assert row.unique or roundings < 1e3
