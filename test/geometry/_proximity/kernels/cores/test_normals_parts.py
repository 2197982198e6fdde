"""Newton's method on a normal, part by part, on terms whose answer is known."""

import math

import numpy as np
import pytest

from drake_geom_ros.geometry._proximity.kernels.cores import normals, settling, sums

X, Y, Z = np.eye(3)


def _terms(*segments):
    """Return the terms of segments (half vectors) and of no ellipsoid, all of them held."""
    terms = np.zeros((sums.ROWS, 5))
    for k, segment in enumerate(segments, start=sums.SEGMENT):
        terms[k, :3] = segment
        terms[k, sums.LENGTH] = np.linalg.norm(segment)
    return terms, sums.SEGMENT + len(segments)


def _with_disk(terms, axes, radius, turn):
    """Add a disk, its axis being the last row of the orthogonal ``turn``."""
    terms[axes : axes + 2, :3] = radius * np.array(turn)[:2]
    terms[axes : axes + 2, sums.LENGTH] = radius
    return terms


@pytest.mark.parametrize('power', [2.0**-40, 1.0])
def test_segments_at_right_angles_are_held_at_any_size(power):
    terms, last = _terms(power * 3 * X, power * Y, -power * 2 * Z)
    tilted = np.array([2e-16, 1e-14, 1.0])
    normals.set_shares(terms, last, tuple(tilted / np.linalg.norm(tilted)))
    assert terms[1:4, sums.SHARE].tolist() == [0.0, 1.0, -1.0]
    assert normals.held_line(terms, last) == ((1.0, 0.0, 0.0), power * 3.0, False)
    assert tuple(normals.held_sum(terms, last)) == (0.0, power, power * 2.0)


def test_held_segments_are_one_line_or_a_face():
    terms, last = _terms(0.1 * X, -0.2 * X, 0.05 * X)
    assert normals.held_line(terms, last) == ((1.0, 0.0, 0.0), pytest.approx(0.35), False)
    normals.share_out(terms, last, tuple(X), 0.25)
    assert terms[1:4, sums.SHARE].tolist() == [0.25, -0.25, 0.25]
    terms, last = _terms(0.1 * X, 0.2 * X, 0.3 * (X + 1e-12 * Y))
    assert normals.held_line(terms, last)[2]


@pytest.mark.parametrize(('slope', 'shares'), [(0.5, [-1.0, 1.0]), (-0.5, [1.0, -1.0])])
def test_segments_are_released_downhill(slope, shares):
    terms, last = _terms(0.1 * X, -0.2 * X)
    normals.free_segments(terms, last, tuple(X), slope)
    assert terms[1:3, sums.SHARE].tolist() == shares


def test_a_step_ends_at_its_first_kink_and_holds_all_that_kink_there():
    terms, last = _terms(0.5 * X, 2.0 * (X - Y), -0.25 * X)
    n = np.array([0.6, 0.0, 0.8])
    normals.set_shares(terms, last, tuple(n))
    assert normals.part_before_kink(terms, last, tuple(n), (-0.5, -0.2, 0.0)) == (1.0, False)
    # n + t (-2, 1, 0): x vanishes at t = 0.3, x - y at t = 0.2.
    part, crossed = normals.part_before_kink(terms, last, tuple(n), (-2.0, 1.0, 0.0))
    assert (part, crossed) == (pytest.approx(0.2, rel=1e-15), True)
    assert terms[1:4, sums.SHARE].tolist() == [1.0, 0.0, -1.0]
    normals.set_shares(terms, last, tuple(n))
    part, crossed = normals.part_before_kink(terms, last, tuple(n), (-2.0, -2.0, 0.0))
    assert (part, crossed) == (pytest.approx(0.3, rel=1e-15), True)
    assert terms[1:4, sums.SHARE].tolist() == [0.0, 1.0, 0.0]


@pytest.mark.parametrize('power', [2.0**-40, 1.0])
def test_a_direction_is_along_the_axis_of_a_disk_to_rounding(power):
    terms, _ = _terms()
    _with_disk(terms, sums.AXES_A, power, (X, Y))
    assert normals.at_disk(terms, tuple(Z), sums.AXES_A)
    assert normals.at_disk(terms, (1e-15, 0.0, -1.0), sums.AXES_A)
    assert not normals.at_disk(terms, (0.0, 1e-14, 1.0), sums.AXES_A)
    assert not normals.at_disk(terms, tuple(Z), sums.AXES_B)


def test_the_normal_of_a_face_is_that_of_the_widest_angle_and_on_the_side_asked_for():
    terms, last = _terms(1e-3 * X, 5.0 * (X + 1e-3 * Z), 1e-3 * Y)
    assert normals.face_normal(terms, last, (0.0, 0.6, 0.8)) == pytest.approx(Z, abs=2e-3)
    assert normals.face_normal(terms, last, (0.0, 0.6, -0.8)) == pytest.approx(-Z, abs=2e-3)
    for axes in (sums.AXES_A, sums.AXES_B):
        terms, last = _terms(0.5 * X)
        _with_disk(terms, axes, 0.25, (Y, Z))
        for n in (X, -X):
            assert normals.face_normal(terms, last, tuple(n)) == tuple(n)


@pytest.mark.parametrize(
    ('x', 'shares', 'margin'),
    [
        ((0.1, -0.05, 0.0), [-1 / 3, 0.25], 0.15),
        ((-0.25, 0.01, 0.0), [5 / 6, -0.05], 0.05),
        ((0.3, 0.2, 0.0), [-1.0, -1.0], 0.0),
        ((0.4, 0.1, 0.0), [-1.0, 0.0], -1.0),
        ((-0.4, 0.3, 0.0), [0.0, -1.0], -1.0),
        ((0.1, -0.5, 0.0), [0.0, 1.0], -1.0),
        ((-0.9, 0.1, 0.0), [1.0, 0.0], -1.0),
    ],
)
@pytest.mark.parametrize('power', [2.0**-40, 1.0, 2.0**20])
def test_two_segments_balance_what_is_in_their_rectangle(x, shares, margin, power):
    """x + u s + v t = 0 has the solution (u, v), and the nearest side of the rectangle is told."""
    terms, last = _terms(power * 0.3 * X, power * 0.2 * Y)
    found = normals.shares_on_face(terms, last, tuple(Z), tuple(power * np.array(x)))
    expected = power * margin if margin >= 0 else margin
    assert found == pytest.approx(expected, rel=1e-14, abs=power * 1e-16)
    assert terms[1:3, sums.SHARE] == pytest.approx(shares, rel=1e-15)


def test_the_margin_counts_every_held_segment_and_one_alone_has_none():
    terms, last = _terms(0.3 * X, 0.2 * Y, 0.5 * X)
    x = (0.05, -0.05, 0.0)
    assert normals.shares_on_face(terms, last, tuple(Z), x) == pytest.approx(0.15, rel=1e-14)
    assert terms[1:4, sums.SHARE] == pytest.approx([0.0, 0.25, -0.1], rel=1e-14)
    terms, last = _terms(0.3 * X)
    assert normals.shares_on_face(terms, last, tuple(Z), x) == -1.0


def test_without_a_disk_nothing_leans_and_what_is_left_over_is_told():
    terms, _ = _terms()
    for x, margin in ((0.0, 0.0, 0.0), 0.0), ((3.0, 4.0, 0.0), -5.0):
        assert normals.lean_on_disks(terms, tuple(Z), x) == margin
        assert not terms[[sums.LEAN_A, sums.LEAN_B], :3].any()


@pytest.mark.parametrize('radii', [(0.3, 0.1), (0.3, 0.0), (0.0, 0.1), (0.0, 0.0)])
@pytest.mark.parametrize('x', [(0.05, 0.0, 0.0), (0.0, -0.35, 0.0), (0.3, 0.3, 0.0)])
def test_disks_lean_by_their_share_of_what_they_balance(radii, x):
    terms, _ = _terms()
    for axes, radius in zip((sums.AXES_A, sums.AXES_B), radii, strict=True):
        _with_disk(terms, axes, radius, (X, Y))
    margin = normals.lean_on_disks(terms, tuple(Z), x)
    assert margin == pytest.approx(sum(radii) - np.linalg.norm(x), rel=1e-14)
    leans = terms[sums.LEAN_A, :3], terms[sums.LEAN_B, :3]
    if margin >= 0:
        assert np.add(*leans) == pytest.approx(np.negative(x), rel=1e-14)
        assert np.linalg.norm(leans[0]) * radii[1] == pytest.approx(
            np.linalg.norm(leans[1]) * radii[0], rel=1e-14
        )
    else:
        assert not np.any(leans)


@pytest.mark.parametrize(
    ('x', 'shares'),
    [
        (0.1, [-1 / 3, 0.0]),
        (0.45, [-1.0, -0.75]),
        (-0.45, [1.0, 0.75]),
        (0.7, [-1.0, -1.0]),  # more than both can balance
    ],
)
def test_parallel_segments_balance_by_turns_and_are_held_still(x, shares):
    """Of no area, so none are solved for together; a share of 1 would say that one is not held."""
    terms, last = _terms(0.3 * X, 0.2 * X)
    terms[0, :3] = -x * X
    settling.settle_by_turns((terms, last, last, 0.0, 0.0), tuple(Z), 0.0)
    assert terms[1:3, sums.SHARE] == pytest.approx(shares, abs=1e-15)
    assert (abs(terms[1:3, sums.SHARE]) < 1.0).all()


def test_an_edge_as_high_at_both_ends_is_free_and_a_disk_takes_the_rest():
    """The edge of a box that lies on the cap of a cylinder, but for rounding."""
    terms, last = _terms(1250.0 * X + 1e-11 * Z)
    terms[sums.AXES_A : sums.AXES_A + 2, :3] = 5533.0 * np.eye(3)[:2]
    terms[sums.AXES_A : sums.AXES_A + 2, sums.LENGTH] = 5533.0
    terms[0, :3] = -2523.0 * X - 5000.0 * np.array([0.0, 1.0, 0.0])
    difference = sums.Difference(terms, last, last, 0.0, 0.0)
    for noise, aside in ((0.0, math.hypot(3773.0, 5000.0)), (1e-10, 0.0)):
        settling.settle_by_turns(difference, tuple(Z), noise)
        a, b = sums.witness_points(difference, tuple(Z))
        assert math.hypot(a[0] - b[0], a[1] - b[1]) == pytest.approx(aside, abs=1e-9)


def test_a_minimum_whose_width_is_another_than_its_terms_say_is_none(monkeypatch):
    """Shares that rounding spoilt would tell of a wrong width."""
    terms = np.zeros((sums.ROWS, 5))
    terms[sums.AXES_A : sums.AXES_A + 3, :3] = np.diag([0.3, 0.4, 0.5])
    terms[sums.AXES_A : sums.AXES_A + 3, sums.LENGTH] = 0.3, 0.4, 0.5
    difference, n = (terms, sums.SEGMENT, sums.SEGMENT, 0.0, 0.0), tuple(X)
    search = getattr(normals.nearby_minimum, 'py_func', normals.nearby_minimum)
    for off, kind in ((0.0, normals.SMOOTH), (1e-15, normals.SMOOTH), (1e-13, normals.NOTHING)):
        told = normals.SMOOTH, n, 0.3 + off, 0.0
        monkeypatch.setattr(normals, 'descend', lambda *_, told=told: told)
        assert search(difference, n, 1e-14)[0] == kind
