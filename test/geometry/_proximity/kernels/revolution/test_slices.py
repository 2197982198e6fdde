"""Half planes through the axis of two bodies that are almost round about it, and their cells."""

import math

import numpy as np
import pytest
from oracles.core_pairs import core_pair, core_widths, turned

from drake_geom_ros.geometry._proximity.kernels.cores import sums
from drake_geom_ros.geometry._proximity.kernels.revolution import circles, slices
from drake_geom_ros.geometry._proximity.kinds import CYLINDER, ELLIPSOID

ENOUGH, NOISE = 1e-9, 1e-15
X, Z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
# Almost round about z, with two minima of h that differ by twice what p is along y.
SIZES = np.array([0.31, 0.3, 0.6]), np.array([0.2, 0.2, 0.5])


def _pair(angle, aside, along=0.0):
    """Return a pair turned about z, B being ``aside`` on the shortest axis of A."""
    R = turned(Z, angle)
    return core_pair(ELLIPSOID, SIZES[0], R, ELLIPSOID, SIZES[1], R, R @ [0.0, aside, along])


@pytest.mark.parametrize('long', range(3))
@pytest.mark.parametrize('which', range(2))
def test_the_roundest_axis_is_that_of_the_least_bends(long, which):
    """Of one that is round about its longest axis, beside one that is almost a ball."""
    rng = np.random.default_rng(1)
    R = [turned(rng.normal(size=3), 1.0) for _ in range(2)]
    sizes = [np.array([0.4, 0.41, 0.42]), np.roll([0.5, 0.1, 0.1], long)]
    if which == 0:
        R, sizes = R[::-1], sizes[::-1]
    pair = core_pair(ELLIPSOID, sizes[0], R[0], ELLIPSOID, sizes[1], R[1], np.zeros(3))
    difference = sums.difference_of(pair)
    u, flat, steep = slices.roundest_axis(difference)
    assert abs(np.dot(u, R[which][:, long])) == pytest.approx(1.0, abs=1e-14)
    assert (flat, steep) == tuple(slices.largest_curvatures(difference[0], u))


def test_the_axis_of_a_segment_is_the_roundest():
    R = turned((1, 2, 3), 1.0)
    pair = core_pair(CYLINDER, [0.3, 0.5], R, ELLIPSOID, SIZES[0], np.eye(3), np.zeros(3))
    u, *_ = slices.roundest_axis(sums.difference_of(pair))
    assert u == pytest.approx(R[:, 2], abs=1e-15)


@pytest.mark.parametrize('along', [0.0, 0.05, -0.2])
@pytest.mark.parametrize('unique', [False, True])
@pytest.mark.parametrize(('span', 'steep'), [(1e-3, 0.0), (0.3, 0.0), (0.3, 0.5)])
def test_a_half_plane_holds_if_its_least_less_the_bend_is_not_below(along, unique, span, steep):
    """Against dense directions of the half circle; best is elsewhere."""
    pair = _pair(0.0, 0.1, along)
    difference = sums.difference_of(pair)
    e = np.array([math.cos(2.0), math.sin(2.0), 0.0])
    flat, least_steep = slices.largest_curvatures(difference[0], Z)
    bends = flat, max(steep, least_steep)
    t = np.linspace(-math.pi / 2, math.pi / 2, 40001)
    ns = np.outer(np.cos(t), e) + np.outer(np.sin(t), Z)
    less = (bends[0] + abs(np.sin(t)) * bends[1]) * span**2 / 8
    least = float((core_widths(pair, ns) - less).min())
    for above, holds in ((-1e-6, True), (1e-6, False)):
        arcs = np.full((circles.MOST_ARCS, circles.ARC_WIDTH), np.nan)
        h = least + above
        held, floor, m = slices.slice_holds(
            difference, Z, tuple(e), span, bends, (X, h, unique), ENOUGH, arcs
        )
        assert held == holds
        if holds:
            assert h - ENOUGH <= floor <= least + 1e-12
        else:
            there = core_widths(pair, m) - (bends[0] + abs(m[2]) * bends[1]) * span**2 / 8
            assert there < h + 2.0 * ENOUGH * unique
            assert abs(np.dot(np.cross(e, Z), m)) < 1e-15
        assert np.isnan(arcs[24:]).all()  # a polygon that grows where it is lowest needs few


@pytest.mark.parametrize('unique', [False, True])
@pytest.mark.parametrize('width', [0.5, 2.0])
def test_the_best_is_not_compared_with_itself_in_a_cell_within_the_border(width, unique):
    """In a wider one there may be other directions: it fails at once, as long as best is alone."""
    pair, n = _pair(0.0, 0.1), (0.0, 1.0, 0.0)
    difference, span = sums.difference_of(pair), width * circles.BORDER
    best, bends = (n, core_widths(pair, n), unique), slices.largest_curvatures(difference[0], Z)
    arcs = np.full((circles.MOST_ARCS, circles.ARC_WIDTH), np.nan)
    held, _, m = slices.slice_holds(difference, Z, n, span, bends, best, 1e-5, arcs)
    assert held == (width < 1.0 or not unique)
    assert held or m == pytest.approx(n, abs=0.01)
    assert np.isnan(arcs[24 if held else 3 :]).all()


@pytest.mark.parametrize('side', [1.0, -1.0])
def test_where_a_half_plane_is_least_on_the_axis_the_bend_counts_in_full(side):
    disks = [(ELLIPSOID, [r + 0.01, r, 0.1], np.eye(3)) for r in (0.3, 0.2)]
    difference = sums.difference_of(core_pair(*disks[0], *disks[1], (0.0, 0.0, 0.05 * side)))
    span, bends = 0.3, (0.1, 0.5)
    least = 0.15 - (0.1 + 0.5) * span**2 / 8 - difference.r_A - difference.r_B
    for above, holds in ((-1e-6, True), (1e-6, False)):
        arcs = np.full((circles.MOST_ARCS, circles.ARC_WIDTH), np.nan)
        held, _, m = slices.slice_holds(
            difference, Z, X, span, bends, (X, least + above, False), ENOUGH, arcs
        )
        assert held == holds
        assert held or m == pytest.approx((0.0, 0.0, side), abs=0.01)


@pytest.mark.parametrize('side', [1.0, -1.0])
def test_the_low_end_of_a_half_plane_is_looked_at_at_once(side):
    """The segment of a cylinder makes a kink across the axis: h rises from there on both sides."""
    pair = CYLINDER, [0.3, 0.5], np.eye(3), ELLIPSOID, SIZES[1], np.eye(3)
    difference = sums.difference_of(core_pair(*pair, (0.0, 0.1, 0.0)))
    e = (0.0, side, 0.0)
    h = 0.3 + 0.2 - 0.1 * side - 0.2 * 0.2 / 0.5 + 1e-6
    arcs = np.full((circles.MOST_ARCS, circles.ARC_WIDTH), np.nan)
    bends = slices.largest_curvatures(difference[0], Z)
    held, _, m = slices.slice_holds(difference, Z, e, 1e-6, bends, (X, h, True), ENOUGH, arcs)
    assert not held
    assert m == e
    assert np.isnan(arcs[2:]).all()


@pytest.mark.parametrize(
    ('above', 'far', 'unique'),
    [
        (1e-3, True, True),
        (1.9e-9, True, False),
        (2.1e-9, True, True),
        (-1.9e-9, True, False),
        (-2.1e-9, True, True),
        (1e-3, False, True),
        (-1.9e-9, False, True),
    ],
)
def test_a_better_direction_is_taken_and_one_as_good_elsewhere_is_told(above, far, unique):
    pair = _pair(0.0, 0.1)
    m = (0.0, 1.0, 0.0)
    h = core_widths(pair, m)
    n = X if far else (1e-3, math.sqrt(1.0 - 1e-6), 0.0)
    found = slices.bettered(sums.difference_of(pair), (n, h + above, True), m, ENOUGH, NOISE)
    assert found[2] == unique
    assert found[:2] == ((m, pytest.approx(h, abs=1e-15)) if above > 0.0 else (n, h + above))


def test_the_least_is_found_from_another_minimum():
    pair = _pair(3.4, 1e-3)
    start = tuple(-pair.R_WA[:, 1])
    found = slices.least_over_slices(
        sums.difference_of(pair), start, core_widths(pair, start), 1e-5, NOISE
    )
    best = pair.R_WA[:, 1]
    assert found.complete
    assert found.h == pytest.approx(core_widths(pair, best), abs=1e-14)
    assert found.h - 1e-5 <= found.floor <= found.h
    assert found.n == pytest.approx(best, abs=1e-6)
    assert found.unique


def test_cells_go_all_around_the_axis_and_one_that_fails_is_halved(monkeypatch):
    """A minimum may be as narrow as a cell, and only a look into its own cell tells of it."""
    seen, narrow = [], 2.0 * math.pi / slices.FIRST_CELLS / 4.0

    def holds(difference, u, e, span, *_):
        seen.append((math.atan2(e[1], e[0]), span))
        return span <= 1.001 * narrow, 0.25, e

    monkeypatch.setattr(slices, 'slice_holds', holds)
    search = getattr(slices.least_over_slices, 'py_func', slices.least_over_slices)
    pair = _pair(0.0, 0.1)
    assert search(sums.difference_of(pair), X, 0.5, ENOUGH, NOISE).complete
    done = [angle for angle, span in seen if span <= 1.001 * narrow]
    starts, ends = np.array(done[::2]), np.array(done[1::2])
    assert len(starts) == 4 * slices.FIRST_CELLS
    np.testing.assert_allclose((ends - starts) % (2.0 * math.pi), narrow, rtol=1e-12)
    np.testing.assert_allclose(np.diff(np.sort(starts)), narrow, rtol=1e-12)
