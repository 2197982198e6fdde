"""Caps about minima of bodies whose curvature is known."""

import numpy as np
import pytest

from drake_geom_ros.geometry._proximity.kernels.cores import caps, normals, sums
from drake_geom_ros.geometry._proximity.kernels.cores.records import Difference, Minimum

X, Z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


def _terms(*segments):
    """Return the terms of segments of half a unit vector, all of them held."""
    terms = np.zeros((sums.ROWS, 5))
    for k, segment in enumerate(segments, start=sums.SEGMENT):
        terms[k, :3], terms[k, sums.LENGTH] = np.multiply(0.5, segment), 0.5
    return terms


def _with_ellipsoid(terms, axes, sizes):
    """Add an ellipsoid along World's axes."""
    terms[axes : axes + 3, :3] = np.diag(sizes)
    terms[axes : axes + 3, sums.LENGTH] = sizes
    return terms


@pytest.mark.parametrize('axes', [sums.AXES_A, sums.AXES_B])
@pytest.mark.parametrize('sizes', [(0.5, 0.7, 0.4), (0.7, 0.5, 0.4), (0.5, 0.6, 0.7)])
@pytest.mark.parametrize('radius', [0.0, 0.03])
def test_a_smooth_cap_is_as_wide_as_the_least_radius_of_curvature_allows(axes, sizes, radius):
    """It is a^2 / c at the end c of an ellipsoid, and less as |E n| grows to the longest."""
    terms = _with_ellipsoid(_terms(), axes, sizes)
    h, longest = 0.3, max(sizes)
    least = min(sizes[0], sizes[1]) ** 2 / sizes[2]
    found = Minimum(normals.SMOOTH, (0.0, 0.0, 1.0), h, 0.0)
    arguments = terms, sums.SEGMENT, radius, found
    reach = sizes[2] * (least / (h + radius)) ** (1.0 / 3.0)
    if reach >= longest:
        assert caps.is_cap(*arguments, 1.5, 1e-9)
        return
    # reach = c cos(cap) + longest sin(cap)
    cap = np.arcsin(reach / np.hypot(sizes[2], longest)) - np.arctan2(sizes[2], longest)
    assert caps.is_cap(*arguments, 0.999 * cap, 1e-9)
    assert not caps.is_cap(*arguments, 1.001 * cap, 1e-9)
    assert not caps.is_cap(*arguments, 0.999 * cap, 1e-3)


@pytest.mark.parametrize(('across', 'proven'), [(1.0, True), (0.2, False)])
@pytest.mark.parametrize('margin', [0.3, 1e-8])
def test_the_cap_of_a_crease_is_that_across_its_line(across, proven, margin):
    """A rod along x, held, and another along z, not held, about an ellipsoid thin along x."""
    terms, last = _with_ellipsoid(_terms(X, Z), sums.AXES_A, (0.01, across, 0.5)), 3
    terms[2, sums.SHARE] = 1.0
    found = Minimum(normals.CREASE, (0.0, 0.0, 1.0), 0.1, margin)
    assert caps.is_cap(terms, last, 0.0, found, 0.05, 1e-9) == (proven and margin > 1e-6)


@pytest.mark.parametrize(('margin', 'narrow'), [(0.009, True), (0.011, False)])
def test_a_crease_needs_a_margin_for_what_turns_along_it(margin, narrow):
    """2 tan(cap / 2) h: here the core has no curvature along its line at all."""
    terms, last = _with_ellipsoid(_terms(X), sums.AXES_A, (1e-9, 1.0, 0.5)), 2
    found = Minimum(normals.CREASE, (0.0, 0.0, 1.0), 0.1, margin)
    cap = 2.0 * np.arctan(0.05)
    assert caps.is_cap(terms, last, 0.0, found, cap, 1e-9) != narrow


@pytest.mark.parametrize(
    ('h', 'margin', 'cap'),
    [
        (0.5, 0.2, 2.0 * np.arctan(0.36)),
        (0.5, 0.3, 2.0 * np.arctan(0.54)),
        (0.1, 0.2, 1.2),
        (0.0, 0.2, 1.2),
        (0.5, 1e-6, 0.0),
        (0.5, 1e-4, 2.0 * np.arctan(1.8e-4)),
    ],
)
def test_the_cap_of_a_face_is_seen_from_the_origin(h, margin, cap):
    found = Minimum(normals.FLAT, (0.0, 0.0, 1.0), h, margin)
    difference = Difference(np.zeros((sums.ROWS, 5)), sums.SEGMENT, sums.SEGMENT, 0.0, 0.0)
    assert caps.widest_cap(difference, found, 1e-8) == pytest.approx(cap, rel=1e-14)
