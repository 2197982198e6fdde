"""Almost rings of equal minima: bounds as narrow as promised, and no plane proves them false."""

import math

import numpy as np
import pytest
from numba import config
from oracles.core_pairs import (
    almost_coaxial,
    answer_of,
    circle,
    core_pair,
    core_widths,
    directions,
    ring,
    turned,
    widths,
)
from oracles.forms import hull_of
from oracles.kernel_calls import call_for_pair

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    NORMAL,
    PAIR_WIDTH,
    UNIQUE,
)
from drake_geom_ros.geometry._proximity.kernels.convex import depths
from drake_geom_ros.geometry._proximity.kernels.convex import pairs as convex
from drake_geom_ros.geometry._proximity.kernels.cores import sums
from drake_geom_ros.geometry._proximity.kernels.cores.records import CorePair
from drake_geom_ros.geometry._proximity.kernels.revolution import barrels, rings, slices
from drake_geom_ros.geometry._proximity.kinds import BOX, CAPSULE, CONVEX, CYLINDER, ELLIPSOID
from drake_geom_ros.geometry._proximity.tolerances import SAME_DIRECTION

COUNT = 3 if config.DISABLE_JIT else 60
KINDS = [
    (CAPSULE, CYLINDER),
    (CAPSULE, ELLIPSOID),
    (CYLINDER, CYLINDER),
    (CYLINDER, ELLIPSOID),
    (ELLIPSOID, ELLIPSOID),
]


@pytest.mark.parametrize('kinds', KINDS)
def test_bounds_hold_and_are_as_narrow_as_promised(kinds):
    rng = np.random.default_rng(12)
    for _ in range(COUNT):
        pair = almost_coaxial(rng, kinds)
        out, promised = answer_of(pair)
        depth, bound = -out[DISTANCE], out[ERROR_BOUND]
        assert bound <= promised
        n = -out[NORMAL : NORMAL + 3]
        ns = directions(rng, pair, n)
        there = widths(pair, ns)
        assert there.min() >= depth - bound - 1e-18
        if out[UNIQUE]:
            assert (there[ns @ n < SAME_DIRECTION - 0.005] > depth + bound).all()


@pytest.mark.parametrize('size', [1e-8, 1e-4, 1e-2])
def test_a_tiny_body_in_the_middle_of_a_cylinder(size):
    # Out sideways: the barrel's radius, and how deep the plane of the body's projection is.
    small, p = size * np.array([1.0, 2.0, 3.0]), (1e-3 * size, 0.0, 0.0)
    pair = core_pair(CYLINDER, [0.2, 0.3], np.eye(3), ELLIPSOID, small, np.eye(3), p)
    out, promised = answer_of(pair)
    assert out[ERROR_BOUND] <= promised
    assert out[DISTANCE] == pytest.approx(-(0.2 + size - 1e-3 * size), abs=promised)


def test_a_tiny_ellipsoid_at_the_axis_of_a_capsule():
    """As narrow as promised, and as deep as it is out across the axis, seen from all around."""
    rng, angles = np.random.default_rng(5), np.linspace(0, 2 * np.pi, 20_001)
    for _ in range(COUNT):
        size = 10 ** rng.uniform(-7, -2) * rng.uniform(0.5, 2.0, 3)
        R_WA, R_WB = (turned(rng.normal(size=3), rng.uniform(0, 3)) for _ in range(2))
        p = rng.uniform(-0.2, 0.2) * size[0] * R_WA[:, 0] + rng.uniform(-0.4, 0.4) * R_WA[:, 2]
        pair = core_pair(CAPSULE, [0.2, 0.9], R_WA, ELLIPSOID, size, R_WB, p)
        out, promised = answer_of(pair)
        assert out[ERROR_BOUND] <= promised
        truth = widths(pair, circle(R_WA[:, 0], R_WA[:, 1], angles)).min()
        assert truth - 1e-6 * size.max() <= -out[DISTANCE] <= truth + promised


def _in_short_barrel(radii):
    pair = core_pair(CYLINDER, [0.3, 0.2], np.eye(3), ELLIPSOID, radii, np.eye(3), np.zeros(3))
    return barrels.least_in_long_barrel(
        sums.difference_of(pair), sums.SEGMENT, sums.AXES_A, (1.0, 0.0, 0.0), 0.301, 1e-10, 1e-15
    )


def test_out_of_a_short_barrel_along_the_axis():
    complete, h, floor, n, unique = _in_short_barrel([1e-3, 1e-3, 2e-3])
    core = 1e-3 * 1e-3 / 2e-3  # the ball that the ellipsoid's core is less
    assert complete
    assert h == pytest.approx(0.202 - core, abs=1e-15)
    assert floor == h
    assert n in [(0.0, 0.0, 1.0), (0.0, 0.0, -1.0)]
    assert not unique


def test_a_barrel_that_is_short_beside_what_is_in_it_is_left():
    assert not _in_short_barrel([0.1, 0.1, 0.19])[0]


@pytest.mark.parametrize('half', [0.1, 0.2, 0.6])
def test_a_small_body_in_a_barrel_against_all_directions(half):
    rng = np.random.default_rng(4)
    for _ in range(COUNT):
        small, R = 0.01 * rng.uniform(0.2, 1.0, 3), turned(rng.normal(size=3), 1.0)
        p = 0.01 * rng.normal(size=3)
        pair = core_pair(CYLINDER, [0.2, half], np.eye(3), ELLIPSOID, small, R, p)
        difference = sums.difference_of(pair)
        complete, h, floor, n, _ = barrels.least_in_long_barrel(
            difference, sums.SEGMENT, sums.AXES_A, (1.0, 0.0, 0.0), 1.0, 1e-12, 1e-15
        )
        if complete:
            ns = np.vstack([directions(rng, pair, np.array(n)), np.eye(3), -np.eye(3)])
            assert core_widths(pair, ns).min() >= floor - 1e-15
            assert core_widths(pair, n) == pytest.approx(h, abs=1e-14)


def test_the_normal_of_segments_that_touch_along_a_body_is_not_0():
    """The capsule's axis ends on the cylinder's side; its own axis is no direction across it."""
    pair = CorePair(
        CAPSULE, np.array([1.0, 0.5]), turned([1, 0, 0], math.pi / 2),
        CYLINDER, np.array([1.0, 0.5]), turned([0, 1, 0], math.pi / 2),
        np.array([0.4999999999999992, 0.9999999999999983, 0.5000000000000003]),
    )  # fmt: skip
    out, _ = answer_of(pair)
    assert np.linalg.norm(out[NORMAL : NORMAL + 3]) == pytest.approx(1.0, abs=1e-14)


@pytest.mark.parametrize('tilt', [1e-12, 1e-8, 1e-4, 0.05])
def test_cylinders_in_each_other_almost_parallel(tilt):
    R = turned([1, 2, 0], tilt)
    pair = core_pair(CYLINDER, [0.3, 0.9], np.eye(3), CYLINDER, [0.2, 0.8], R, (0.0, 0.0, 0.1))
    difference = sums.difference_of(pair)
    start = (1.0, 0.0, 0.0)
    complete, h, floor, n, _ = barrels.least_of_barrels(difference, start, 0.4, 1e-10, 1e-15)
    assert complete
    assert h - 1e-10 <= floor <= h
    rng = np.random.default_rng(1)
    assert widths(pair, directions(rng, pair, np.array(n))).min() >= floor


def test_cylinders_too_far_from_parallel_are_left_to_others():
    R = turned([1, 2, 0], 0.9)
    pair = core_pair(CYLINDER, [0.3, 0.9], np.eye(3), CYLINDER, [0.2, 0.8], R, (0.0, 0.0, 0.1))
    start = (1.0, 0.0, 0.0)
    found = barrels.least_of_barrels(sums.difference_of(pair), start, 0.4, 1e-10, 1e-15)
    assert not found.complete


def test_bends_between_half_planes_hold():
    # The second derivative about the axis, by differences, is never above M_0 + |c| M_1.
    rng = np.random.default_rng(2)
    for _ in range(COUNT):
        pair = almost_coaxial(rng, (CYLINDER, ELLIPSOID))
        u, flat, steep = slices.roundest_axis(sums.difference_of(pair))
        angles, step = np.linspace(0, 2 * np.pi, 400, retstep=True)
        e = ring(u, angles)
        for c in rng.uniform(-1, 1, 8):
            h = widths(pair, math.sqrt(1 - c * c) * e + c * np.array(u))
            bend = (h[2:] - 2 * h[1:-1] + h[:-2]) / step**2
            assert bend.max() <= flat + abs(c) * steep + 1e-9


def test_a_plane_that_no_search_chose_guards_what_it_found():
    pair = CYLINDER, [0.3, 0.9], np.eye(3), CYLINDER, [0.2, 0.1], np.eye(3)
    difference = sums.difference_of(core_pair(*pair, (0.0, 0.0, 0.9)))
    # Out along the axis: 0.9 + 0.1 - 0.9. A floor above that was proven by nothing.
    assert depths.guarded(difference, 0.4, 1e-15) == pytest.approx(0.1, abs=1e-15)
    assert depths.guarded(difference, 0.1 - 1e-12, 1e-15) == 0.1 - 1e-12


def test_a_small_box_in_an_ellipsoid_from_any_hint():
    # Half planes through the axis tell nothing of a box: its edges are not along it.
    R = turned([1, 0, 0], math.atan2(4, 3))
    pair = core_pair(BOX, [2e-5, 1.5e-5, 1e-5], R, ELLIPSOID, [1.0, 0.1, 0.1], R, np.zeros(3))
    rng = np.random.default_rng(3)
    for _ in range(COUNT):
        out = np.zeros(PAIR_WIDTH)
        out[NORMAL : NORMAL + 3] = rng.normal(size=3)
        call_for_pair(convex.signed_distance_of_cores, *pair, 1e-9 * 2.7e-5, math.inf, out)
        assert abs(out[DISTANCE] + 0.10001) <= out[ERROR_BOUND]


def test_the_least_of_two_vertices_on_an_arc_against_all_of_it():
    rng, seen = np.random.default_rng(8), 0
    while seen < 50:
        R, (x, y) = turned(rng.normal(size=3), 2.0), rng.normal(size=(2, 3))
        angles = rng.uniform(0, 6) + np.linspace(0, rng.uniform(0.1, 1.57), 2001)
        ns = circle(R[:, 0], R[:, 1], angles)
        along = -ns @ np.array([x, y]).T
        if along[0, 0] < along[0, 1] or along[-1, 1] < along[-1, 0]:
            continue  # each is extreme at its end
        seen += 1
        known = np.array([[*ns[0], *x, along[0, 0]], [*ns[-1], *y, along[-1, 1]]])
        n, least = rings.least_of_two(known, 0, 1, tuple(R[:, 2]))
        assert least == pytest.approx(max(-np.dot(x, n), -np.dot(y, n)), abs=1e-14)
        assert -1e-14 <= along.max(axis=1).min() - least <= 1e-3
        assert np.max(ns @ n) >= 1.0 - 1e-6


def test_the_least_of_two_ends_of_a_needle_is_across_the_axis():
    """Hunted: seen along the axis they are 1e-11 m apart, and both far to one side."""
    rng, cuts = np.random.default_rng(8), 0
    for _ in range(4000):
        R, (x, y) = turned(rng.normal(size=3), 2.0), 1e-11 * rng.normal(size=(2, 3))
        x, y = (R @ [*a[:2], along] for a, along in ((x, -1.5), (y, -2.3)))
        ns = [R[:, 0], R @ [math.cos(1.5), math.sin(1.5), 0.0]]
        (from_x, from_y), (to_x, to_y) = ([-x @ n, -y @ n] for n in ns)
        if from_x > from_y and to_y > to_x:
            known = np.array([[*ns[0], *x, from_x], [*ns[1], *y, to_y]])
            n, _ = rings.least_of_two(known, 0, 1, tuple(R[:, 2]))
            cuts += all(np.dot(n, end) < 1.0 - 1e-9 for end in ns)
            assert abs(np.dot(n, R[:, 2])) <= 1e-15
    assert cuts > 100


def test_a_search_about_a_barrel_that_comes_to_no_end_says_so():
    """No cut is ever as low as this noise asks for."""
    hull = hull_of(0.01 * np.eye(3))
    pair = core_pair(CYLINDER, [0.3, 0.3], np.eye(3), CONVEX, hull, np.eye(3), (0.0,) * 3)
    found = rings.least_of_hull_in_barrel(pair, 1e-15, -1.0)
    assert not found.complete
    assert found.floor == -math.inf
    assert found.h <= 0.31
