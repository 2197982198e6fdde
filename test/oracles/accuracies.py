"""Rows of a core or a solid and a solid at many accuracies, and the laws that hold among them."""

import math

import numpy as np
import pytest
from oracles.forms import kernel_form
from oracles.kernel_calls import call_for_pair
from oracles.solids import parts_gap

from drake_geom_ros.cross_check.surfaces import height, nearest_points
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    METHOD,
    NORMAL,
    PAIR_WIDTH,
    WITNESS_A,
    WITNESS_B,
)
from drake_geom_ros.geometry._proximity.kernels.solids.pairs import signed_distance_to_solid
from drake_geom_ros.geometry._proximity.kinds import MESH, SOLID

# Over the size of the bodies, which have few triangles; the smallest ones leave all to ``exact``.
ACCURACIES = (1.0, 0.3, 0.08, 0.02, 5e-3, 1e-3, 1e-5)


def row_to(a, b, accuracy):
    """Return the row of a core or solid and a solid to an accuracy [m], 0 for ``exact``."""
    (kind_A, shape_A), (kind_B, shape_B) = kernel_form(a), kernel_form(b)
    assert kind_A <= kind_B == SOLID
    out = np.zeros(PAIR_WIDTH)
    gap = 1e-9 * min(1.0, a.radius, b.radius)
    bodies = kind_A, shape_A, a.R, kind_B, shape_B, b.R
    kernel = signed_distance_to_solid
    call_for_pair(kernel, *bodies, b.p - a.p, gap, math.inf, out, accuracy)
    assert np.isfinite(out).all()
    return out


def check_rows(a, b, scale):
    """Check the laws of all accuracies against the row of ``exact``, and return that."""
    exact = row_to(a, b, 0.0)
    size = a.radius + b.radius + np.linalg.norm(b.p - a.p)
    rounding = 1e-13 * size
    # [m] A direction is as good as the distance along it, and so are the points across it.
    across = math.sqrt(2.0 * max(exact[DISTANCE], 0.0) * exact[ERROR_BOUND])
    widest = math.inf
    for accuracy in scale * np.array(ACCURACIES):
        out = row_to(a, b, accuracy)
        if exact[DISTANCE] < 0.0:
            assert out[DISTANCE] < 0.0
        elif exact[DISTANCE] < exact[ERROR_BOUND]:
            assert (out == exact).all() or out[DISTANCE] > 0.0
        off = abs(out[DISTANCE] - exact[DISTANCE])
        assert off <= out[ERROR_BOUND] + exact[ERROR_BOUND], (accuracy, out, exact)
        if exact[DISTANCE] > exact[ERROR_BOUND] and exact[METHOD] == MESH:
            assert out[METHOD] == MESH
            assert out[ERROR_BOUND] <= max(accuracy, exact[ERROR_BOUND]) + rounding
            # A smaller length never has a wider bound.
            assert out[ERROR_BOUND] <= widest + rounding
            widest = out[ERROR_BOUND]
            n, apart = out[NORMAL : NORMAL + 3], out[WITNESS_A : WITNESS_A + 3]
            apart = apart - out[WITNESS_B : WITNESS_B + 3]
            assert np.linalg.norm(n) == pytest.approx(1.0, abs=1e-12)
            assert apart == pytest.approx(out[DISTANCE] * n, abs=rounding)
            for each, witness in ((a, WITNESS_A), (b, WITNESS_B)):
                away = away_from(each, a.p + out[witness : witness + 3])
                assert away <= across + 16.0 * rounding  # the points are on the surfaces
            if kernel_form(a)[0] == SOLID:
                swapped = row_to(b, a, accuracy)
                between = abs(swapped[DISTANCE] - out[DISTANCE])
                assert between <= swapped[ERROR_BOUND] + out[ERROR_BOUND]
    # Other accuracies, asked before, change nothing.
    assert (row_to(a, b, 0.0) == exact).all()
    widest = row_to(a, b, scale)
    assert (row_to(a, b, 0.0) == exact).all()
    assert (row_to(a, b, scale) == widest).all()
    return exact


def check_parts(a, b, scale):
    """Check the laws of all accuracies, and each row against the convex parts of both bodies."""
    exact = check_rows(a, b, scale)
    truth, error = parts_gap(a, b)
    if truth > error and not (exact[DISTANCE] < 0.0):
        for accuracy in scale * np.array(ACCURACIES):
            out = row_to(a, b, accuracy)
            assert abs(out[DISTANCE] - truth) <= out[ERROR_BOUND] + error


def at_gap(a, b, gap):
    """Return b moved along the normal of ``exact`` until it is at a gap [m] from a."""
    out = row_to(a, b, 0.0)
    return b.at(b.p + (out[DISTANCE] - gap) * out[NORMAL : NORMAL + 3])


def away_from(each, p_W):
    """Return the distance [m] of a point from a body's surface; of a solid by all triangles."""
    if each.kind != 'Solid':
        return abs(height(each, p_W))
    q = each.R.T @ (p_W - each.p)
    return np.linalg.norm(nearest_points(each.corners, q) - q, axis=1).min()
