"""Ways out of a solid: what is tried first."""

import numpy as np
import pytest
from oracles.forms import kernel_form
from oracles.solids import solid

from drake_geom_ros.geometry._proximity.kernels.cores.gjk import OVERLAP
from drake_geom_ros.geometry._proximity.kernels.solids.clearing import MOST_CONTACTS
from drake_geom_ros.geometry._proximity.kernels.solids.contacts import contacts
from drake_geom_ros.geometry._proximity.kernels.solids.distance import NEVER, nearest
from drake_geom_ros.geometry._proximity.kernels.solids.overlap import (
    MOST_PUSHES,
    push_of,
)
from drake_geom_ros.geometry._proximity.kernels.solids.solid import SolidPair, body_of, solid_of
from drake_geom_ros.geometry._proximity.kinds import BOX, SPHERE

L = kernel_form(solid('L'))[1]


@pytest.mark.parametrize(('x', 'y'), [(0.02, 0.05), (0.05, 0.02), (0.03, 0.03)])
def test_the_shortest_push_comes_first(x, y):
    """A ball in the inner corner of the L is in both walls."""
    ball = np.array([0.1])
    A, B = body_of(SPHERE, ball, np.eye(3)), solid_of(L)
    p, n = (1.1 - x, 1.1 - y, 0.5), (1.0, 0.0, 0.0)
    pair = SolidPair(A, B, p, 4.0, 1e-9, 0.1)
    found = nearest(pair, n, np.inf, NEVER)
    pushes = np.full((MOST_PUSHES, 4), np.nan)
    count = push_of(pair, found, pushes)
    lengths = pushes[:count, 3]
    assert (np.diff(lengths) >= 0.0).all()
    assert lengths[0] == pytest.approx(min(x, y), abs=1e-14)
    assert {round(float(s), 9) for s in lengths} >= {x, y}
    for *m, s in pushes[:count]:
        assert np.linalg.norm(m) == pytest.approx(1.0, abs=1e-14)
        assert s > 0.0


@pytest.mark.parametrize('inside', [(0.5, 0.5, 0.5), (1.5, 0.2, 0.9)])
def test_what_crosses_is_pushed_by_its_contacts_alone(inside):
    """Then the nearest point that was found tells nothing, even where it is inside."""
    box, n, p = np.array([0.1, 0.2, 0.3]), (1.0, 0.0, 0.0), (1.05, 1.5, 0.5)
    A, B = body_of(BOX, box, np.eye(3)), solid_of(L)
    pair = SolidPair(A, B, p, 4.0, 1e-9, 0.0)
    found = nearest(pair, n, np.inf, NEVER)
    assert found.end == OVERLAP
    pushes, expected = np.zeros((2, MOST_PUSHES, 4))
    count = push_of(pair, found._replace(a=inside), pushes)
    assert count == contacts(pair, found.n, 0.0, expected, MOST_CONTACTS) > 0
    np.testing.assert_array_equal(pushes[:count], expected[np.argsort(expected[:count, 3])])
