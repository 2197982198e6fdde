"""What nothing near the axes of two cylinders is below, against dense directions."""

import numpy as np
import pytest
from oracles.core_pairs import core_pair, turned

from drake_geom_ros.geometry._proximity.kernels.cores import sums
from drake_geom_ros.geometry._proximity.kernels.revolution import barrels
from drake_geom_ros.geometry._proximity.kinds import CYLINDER, ELLIPSOID


def two_cylinders(sizes, tilt, p):
    R = turned((1, 0, 0), tilt)
    return sums.difference_of(core_pair(CYLINDER, sizes[0], np.eye(3), CYLINDER, sizes[1], R, p))


@pytest.mark.parametrize('p', [(0, 0, 0), (0.3, 0.1, -0.2), (0.9, 0.5, 0.4), (0, 1.5, 0.1)])
@pytest.mark.parametrize('sine', [0.1, 0.5, 0.8])
def test_the_least_in_caps_about_the_axis_is_that_of_a_cone_over_the_ends(p, sine):
    """Both segments end at the top, or both at the bottom, and disks of both radii lie level."""
    difference = two_cylinders(([0.3, 0.9], [0.2, 0.8]), 0.0, p)
    angles, turns = np.meshgrid(np.linspace(0, np.arcsin(sine), 60), np.linspace(0, 7, 400))
    n = np.stack([np.sin(angles) * np.cos(turns), np.sin(angles) * np.sin(turns), np.cos(angles)])
    widths = [
        side * 1.7 * side * n[2] - side * np.tensordot(p, n, 1) + 0.5 * np.sin(angles)
        for side in (1.0, -1.0)
    ]
    axis = (0.0, 0.0, 1.0)
    found = barrels.least_in_caps(difference[0], axis, axis, sine, 0.5)
    assert found == pytest.approx(np.min(widths), abs=1e-3)
    assert found <= np.min(widths) + 1e-12


@pytest.mark.parametrize(('floor', 'tried'), [(0.02, False), (0.05, True), (-0.1, False)])
def test_cylinders_that_are_not_parallel_enough_are_left(floor, tried):
    """The cap has the sine 0.2 + cbrt(0.2 sin(0.2)^2 / floor): 0.93 and 0.74 for the first two."""
    difference = two_cylinders(([0.3, 0.9], [0.2, 0.8]), np.arcsin(0.2), (0.0, 0.0, 0.1))
    found = barrels.least_of_barrels(difference, (1.0, 0.0, 0.0), floor, 1e-10, 1e-15)
    assert (found[1] > 0.0) == tried


def test_a_body_that_reaches_far_across_a_long_barrel_leaves_it_across():
    """The barrel is longer than the way across: 5 - 0.3 > 0.1 + 0.35."""
    pair = CYLINDER, [0.1, 5.0], np.eye(3), ELLIPSOID, [0.4, 0.35, 0.3], np.eye(3)
    difference = sums.difference_of(core_pair(*pair, (0.0, 0.1, 0.0)))
    depth = 0.1 + 0.35 - 0.1 - 0.3 * 0.3 / 0.4  # the ball that the core of the ellipsoid is less
    start = (0.0, 1.0, 0.0)
    found = barrels.least_in_long_barrel(
        difference, sums.SEGMENT, sums.AXES_A, start, depth, 1e-10, 1e-15
    )
    assert found.complete
    assert found.h == pytest.approx(depth, abs=1e-15)
    assert depth - 1e-10 <= found.floor <= found.h
    assert found.n == pytest.approx((0.0, 1.0, 0.0), abs=1e-7)
    assert found.unique


def test_a_search_of_the_ring_that_came_to_no_end_is_not_complete(monkeypatch):
    monkeypatch.setattr(barrels, 'least_on_circle', lambda difference, e, best, *_: (False, best))
    difference = two_cylinders(([0.1, 5.0], [0.1, 0.5]), 0.0, (0, 0, 0))
    search = getattr(barrels.least_in_long_barrel, 'py_func', barrels.least_in_long_barrel)
    start = (1.0, 0.0, 0.0)
    assert not search(difference, sums.SEGMENT, sums.AXES_A, start, 0.2, 1e-10, 1e-15).complete
