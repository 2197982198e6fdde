"""Ways out of a solid, of which the shortest comes first."""

import numpy as np
import pytest
from oracles.solids import solid

from drake_geom_ros.geometry._proximity.kernels.solids import overlap as solid_overlap
from drake_geom_ros.geometry._proximity.kernels.solids.distance import nearest
from drake_geom_ros.geometry._proximity.kernels.solids.tree import body_of, solid_of
from drake_geom_ros.geometry._proximity.kinds import SPHERE

TOLERANCE, SIZE = 1e-9, 8.0


def ways_out(radius, p):
    """Return the pushes (k, 4), direction and length [m], of a ball at p out of the L."""
    body, ball = solid('L', np.eye(3), np.zeros(3)), np.array([radius])
    A, B = body_of(SPHERE, ball, np.eye(3)), solid_of(body.parameters)
    found = nearest(A, B, p, (1.0, 0.0, 0.0), SIZE, TOLERANCE, np.inf)
    pushes = np.full((solid_overlap.MOST_PUSHES, 4), np.nan)
    count = solid_overlap.push_of(A, B, p, found, SIZE, TOLERANCE, radius, pushes)
    return pushes[:count]


@pytest.mark.parametrize('gaps', [(0.1, 0.2), (0.2, 0.1), (0.15, 0.05), (0.05, 0.15)])
def test_a_ball_in_the_inner_corner_has_ways_out_by_both_walls_the_shorter_first(gaps):
    """The walls x = 1 and y = 1 of the notch, from x, y > 1: so far from them is the middle."""
    pushes = ways_out(0.3, (1.0 + gaps[0], 1.0 + gaps[1], 0.5))
    assert (np.diff(pushes[:, 3]) > 0.0).all()
    for wall in ([1.0, 0.0, 0.0, 0.3 - gaps[0]], [0.0, 1.0, 0.0, 0.3 - gaps[1]]):
        assert np.abs(pushes - wall).max(axis=1).min() <= 1e-12


@pytest.mark.parametrize(
    ('p', 'm', 'length'),
    [
        ((0.5, 0.25, 0.5), (0.0, -1.0, 0.0), 0.25),
        ((0.125, 0.5, 0.5), (-1.0, 0.0, 0.0), 0.125),
        ((1.5, 0.9375, 0.5), (0.0, 1.0, 0.0), 0.0625),
        ((0.5, 1.5, 0.875), (0.0, 0.0, 1.0), 0.125),
    ],
)
def test_a_ball_within_leaves_through_the_nearest_wall(p, m, length):
    (push,) = ways_out(0.03125, p)
    np.testing.assert_allclose(push, [*m, length + 0.03125], atol=1e-12)
