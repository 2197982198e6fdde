"""The least h on a great circle: against dense directions, where rounding once decided too."""

import numpy as np
import pytest
from numba import config
from oracles.core_pairs import core_pair, core_widths, ring, turned
from oracles.pairs import random_pairs

from drake_geom_ros.geometry._proximity.kernels.cores import sums
from drake_geom_ros.geometry._proximity.kernels.revolution import circles
from drake_geom_ros.geometry._proximity.kernels.revolution.circles import BORDER
from drake_geom_ros.geometry._proximity.kinds import BOX, CAPSULE, CYLINDER, ELLIPSOID
from drake_geom_ros.geometry._proximity.tolerances import SAME_DIRECTION

COUNT = 4 if config.DISABLE_JIT else 30
ENOUGH, NOISE = 1e-10, 1e-15


ALL_AROUND = np.linspace(0, 2 * np.pi, 20001)


def _search(pair, e, n):
    h = core_widths(pair, n)
    arcs = np.empty((circles.MOST_ARCS, circles.ARC_WIDTH))
    kinks = np.empty((circles.MOST_KINKS, circles.KINK_WIDTH))
    best = tuple(n), h, circles.NO_CAP, True, h
    return circles.least_on_circle(
        sums.difference_of(pair), tuple(e), best, 0.0, ENOUGH, NOISE, arcs, kinks
    )  # fmt: skip


@pytest.mark.parametrize('kind', [BOX, CAPSULE, CYLINDER])
def test_no_direction_of_the_circle_is_better(kind):
    for pair in random_pairs(np.random.default_rng(7), (kind, CYLINDER), COUNT):
        e = pair.b.R[:, 2]
        pair = core_pair(*pair.a.form, pair.a.R, *pair.b.form, pair.b.R, 0.3 * pair.b.p)
        ns = ring(e, ALL_AROUND)
        complete, (n, h, _, _, floor) = _search(pair, e, ns[0])
        assert complete
        assert h == pytest.approx(core_widths(pair, n), abs=1e-14)
        if h > 0:
            assert core_widths(pair, ns).min() >= min(floor, h) - 1e-14


@pytest.mark.parametrize('tilt', [0.0, 1e-14, 1e-11, 1e-9, 1e-6, 1e-3])
@pytest.mark.parametrize('aside', [0.0, 1e-12, 1e-6])
def test_an_almost_ring_takes_few_arcs(tilt, aside):
    # The first kink, a product of almost parallel vectors, once was 1e-6 off the circle.
    R = turned((1, 0, 0), tilt)
    pair = core_pair(
        CAPSULE, [0.25, 0.7], np.eye(3), CYLINDER, [0.3, 0.45], R, (aside, 0, 0.1)
    )  # fmt: skip
    ns = ring(R[:, 2], ALL_AROUND)
    complete, (_, h, _, _, floor) = _search(pair, R[:, 2], ns[17])
    assert complete
    assert h - floor <= ENOUGH
    assert abs(core_widths(pair, ns).min() - h) <= ENOUGH + 1e-14


def test_all_of_a_circle_across_the_line_of_centres_is_looked_at():
    # On it p . n is rounding, and the whole circle was once left out for its sign.
    R = np.array([[-1, 0, 0], [0, -0.6, 0.8], [0, 0.8, 0.6]])
    p = 0.01 * R[:, 2]
    pair = core_pair(CAPSULE, [0.25, 0.5], R, CYLINDER, [0.25, 0.02], np.eye(3), p)
    complete, (n, h, _, _, floor) = _search(pair, R[:, 2], (1.0, 0.0, 0.0))
    assert complete
    assert h == pytest.approx(0.25 * 0.6 + 0.02 * 0.8 - abs(np.dot(n, p)), abs=1e-15)
    assert floor == pytest.approx(h, abs=1e-10)


def test_kinks_come_in_turn():
    R = np.eye(3)[[1, 2, 0]]
    pair = core_pair(BOX, np.ones(3), np.eye(3), CYLINDER, np.ones(2), R, np.ones(3))
    terms, _, last, _, _ = sums.difference_of(pair)
    kinks = np.empty((circles.MOST_KINKS, circles.KINK_WIDTH))
    count = circles.kinks_on_circle(terms, last, (0.0, 0.0, 1.0), kinks)
    turns = np.arctan2(kinks[:count, 1], kinks[:count, 0])
    steps = np.diff(np.append(turns, turns[0])) % (2 * np.pi)
    assert steps.sum() == pytest.approx(2 * np.pi)
    assert np.abs(kinks[:count, 2]).max() == 0.0


@pytest.mark.parametrize('tilt', [0.0, 1e-15, 1e-10, 0.3])
def test_no_arc_is_wider_than_a_right_angle(tilt):
    R = turned((1, 0, 0), tilt)
    for kind, size in ((CAPSULE, [0.1, 1.0]), (CYLINDER, [0.1, 1.0]), (BOX, [1.0, 2.0, 3.0])):
        pair = core_pair(kind, size, np.eye(3), CYLINDER, [0.2, 1.0], R, (0, 0, 0))
        terms, _, last, _, _ = sums.difference_of(pair)
        kinks = np.empty((circles.MOST_KINKS, circles.KINK_WIDTH))
        count = circles.kinks_on_circle(terms, last, tuple(R[:, 2]), kinks)
        ns = kinks[:count, :3]
        assert (abs(np.linalg.norm(ns, axis=1) - 1) < 1e-15).all()
        assert abs(ns @ R[:, 2]).max() < 1e-15
        assert (np.einsum('ij,ij->i', ns, np.roll(ns, -1, axis=0)) >= -1e-15).all()


def test_an_arc_without_curvature_has_its_chord_and_a_round_one_its_ends():
    arc = np.empty(circles.ARC_WIDTH)
    x, y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
    circles.put_arc(arc, x, y, x, y)  # two points of the unit circle
    m = circles.chord_normal(arc, (0.0, 0.0, 1.0))
    assert m == pytest.approx((np.sqrt(0.5), np.sqrt(0.5), 0))
    assert circles.least_on_arc(arc, m, 0.0, np.inf) == pytest.approx(np.sqrt(0.5), abs=1e-15)
    assert circles.least_on_arc(arc, m, 0.0, 1.0) == 1.0
    assert circles.least_on_arc(arc, m, 0.25, 1.0) == 0.75
    # Between the two: y = rho - (rho - 1) / cos(45 degrees), in the middle.
    bent = 1.1 - 0.1 * np.sqrt(2)
    assert circles.least_on_arc(arc, m, 0.0, 1.1) == pytest.approx(bent, abs=1e-15)


def test_the_largest_radius_is_that_of_the_ellipse_seen_along_the_circles_axis():
    sphere = sums.difference_of(core_pair(
        5, [3.0, 2.0, 1.0], np.eye(3), CYLINDER, [0.5, 1.0], np.eye(3), (0, 0, 0)
    ))  # fmt: skip
    seen = circles.largest_radius(sphere[0], (0.0, 0.0, 1.0))
    assert seen == pytest.approx(9 / 2 + 0.5, rel=1e-13)
    assert circles.largest_radius(sphere[0], (1.0, 0.0, 0.0)) == np.inf


@pytest.mark.parametrize('seed', range(20))
def test_an_arc_that_reaches_is_kept_and_no_other(seed):
    """Against the largest q . n of many directions on the arc."""
    rng = np.random.default_rng(seed)
    start, width = rng.uniform(0, 7), rng.uniform(0.1, np.pi / 2)
    angles = start + np.linspace(0.0, width, 2001)
    ns = np.column_stack([np.cos(angles), np.sin(angles), 0.0 * angles])
    q = np.append(rng.normal(size=2), 0.0)
    largest = float((ns @ q).max())
    for away, kept in ((1e-5, True), (0.0, True), (-1e-5, False)):
        found = circles.may_reach(
            tuple(ns[0]), tuple(ns[-1]), (0.0, 0.0, 1.0), tuple(q), largest - away, NOISE
        )
        assert found == kept


@pytest.mark.parametrize('flip', [1.0, -1.0])
def test_an_arc_that_reaches_at_its_end_or_within_but_for_rounding_is_kept(flip):
    """Equal to the last digit, and within the rounding that q is allowed."""
    e, near, far = (0.0, 0.0, flip), (0.6, -0.8 * flip, 0.0), (1.0, 0.0, 0.0)
    q = (1.0, flip, 0.0)  # beyond the end of an arc from near to far; q . far is 1
    assert circles.may_reach(near, far, e, q, 1.0, NOISE)
    assert circles.may_reach(near, far, e, q, 1.0 + 0.5 * NOISE, NOISE)
    assert not circles.may_reach(near, far, e, q, 1.0 + 1e-12, NOISE)
    q = (1.0, -flip, 0.0)  # beyond the start of the same arc, mirrored
    mirrored = (0.6, 0.8 * flip, 0.0)
    assert circles.may_reach(far, mirrored, e, q, 1.0, NOISE)
    assert circles.may_reach(far, mirrored, e, q, 1.0 + 0.5 * NOISE, NOISE)
    assert not circles.may_reach(far, mirrored, e, q, 1.0 + 1e-12, NOISE)
    along = (0.8, -0.6 * flip, 0.0)  # within; longest there
    assert circles.may_reach(near, far, e, along, 1.0, NOISE)
    assert not circles.may_reach(near, far, e, along, 1.0 + 1e-12, NOISE)


@pytest.mark.parametrize('height', [0.0, 5.0, -5.0])
def test_only_arcs_on_the_side_of_p_are_taken_and_none_where_p_is_short(height):
    """Of p only the part across e counts, 0.25 m along x here; arcs end at x and y."""
    difference = sums.difference_of(core_pair(
        BOX, [1.0, 1.0, 1.0], np.eye(3), CYLINDER, [0.5, 1.0], np.eye(3), (0.25, 0.0, height)
    ))  # fmt: skip
    arcs = np.full((circles.MOST_ARCS, circles.ARC_WIDTH), np.nan)
    kinks = np.empty((circles.MOST_KINKS, circles.KINK_WIDTH))
    for reach, taken in ((-1.0, 4), (0.1, 2), (0.2, 2), (0.3, 0)):
        count = circles.first_arcs(
            difference[0], difference[2], (0.0, 0.0, 1.0), reach, NOISE, arcs, kinks
        )
        assert count == taken
        for arc in arcs[:count]:
            start, end = arc[:3], arc[3:6]
            assert np.cross(start, end)[2] == pytest.approx(1.0, abs=1e-15)
            assert reach < 0.0 or start[0] + end[0] == pytest.approx(1.0, abs=1e-15)
            # The corner of the box less the rim, and the difference of the axes' ends aside.
            for n, point in ((start, arc[6:9]), (end, arc[9:12])):
                middle = start + end
                corner = np.sign(np.round(middle[:2], 9)) + 0.5 * n[:2] - [0.25, 0.0]
                np.testing.assert_allclose(point[:2], corner, rtol=0, atol=1e-15)


def test_a_better_direction_elsewhere_is_alone_if_that_before_is_clearly_worse():
    """An ellipse that is thin at 35 degrees, from x on, where an arc ends."""
    c, s = np.cos(np.radians(35.0)), np.sin(np.radians(35.0))
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    pair = core_pair(
        ELLIPSOID, [0.2, 0.3, 0.4], R, CYLINDER, [0.2, 1.0], np.eye(3), R @ [0.05, 0.0, 0.0]
    )
    complete, (n, h, _, unique, floor) = _search(pair, np.eye(3)[2], np.eye(3)[0])
    assert complete
    assert floor >= h - ENOUGH
    assert n == pytest.approx(R[:, 0], abs=1e-6)
    assert unique


def test_an_arc_is_away_if_any_of_it_is_clearly_elsewhere_and_it_does_not_end_at_the_border():
    near, far = SAME_DIRECTION, np.nextafter(SAME_DIRECTION, 0.0)
    for ends in ((near, near), (1.0, near), (far, far), (far, -1.0)):
        for span in (0.5 * BORDER, 2.0 * BORDER):
            assert circles.is_away(*ends, span) == (ends[0] == far)
    for ends in ((near, far), (far, near), (1.0, 0.0)):
        assert not circles.is_away(*ends, BORDER)
        assert circles.is_away(*ends, 1.001 * BORDER)
