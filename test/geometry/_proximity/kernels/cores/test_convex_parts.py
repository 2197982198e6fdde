"""Steps of the iterative kernel whose outcome is known."""

import numpy as np
import pytest
from oracles.pairs import random_rotation

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import NORMAL, PAIR_WIDTH
from drake_geom_ros.geometry._proximity.kernels.cores import convex
from drake_geom_ros.geometry._proximity.kernels.cores.records import Pair
from drake_geom_ros.geometry._proximity.kinds import BOX, CAPSULE, CONVEX, CYLINDER

CUBE = np.array([1.0, 1.0, 1.0])


@pytest.mark.parametrize(
    ('hint', 'p', 'n', 'hinted'),
    [
        ((0.0, -0.6, -0.8), (5.0, 0.0, 0.0), (0.0, 0.6, 0.8), True),
        ((0.0, 0.0, -1e-300), (5.0, 0.0, 0.0), (0.0, 0.0, 1.0), True),
        ((0.0, 0.0, 0.0), (0.0, -5.0, 0.0), (0.0, -1.0, 0.0), False),
        ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), False),
        ((np.nan, 0.0, 0.0), (0.0, 2.0, 0.0), (0.0, 1.0, 0.0), False),
    ],
)
def test_a_hint_of_any_length_is_taken_else_the_way_to_the_other(hint, p, n, hinted):
    out = np.zeros(PAIR_WIDTH)
    out[NORMAL : NORMAL + 3] = hint
    found, is_hinted = convex.hint_of(out, p)
    assert tuple(found) == pytest.approx(n, abs=1e-15)
    assert is_hinted == hinted


def test_points_are_drawn_to_their_distance_by_as_little_as_can_be():
    n, a, b = (0.0, 0.0, 1.0), (0.0, 0.0, 0.0), (0.5, 0.0, 2.0)
    a, b, miss = convex.drawn_to(1.5, n, a, b)
    assert (tuple(a), tuple(b)) == ((0.25, 0.0, 0.25), (0.25, 0.0, 1.75))
    assert miss == pytest.approx(np.hypot(0.25, 0.25))


@pytest.mark.parametrize('in_A', [0.0, 0.125, -0.25])
@pytest.mark.parametrize('in_B', [0.0, 0.125, -0.25])
@pytest.mark.parametrize('miss', [0.0625, 1.0])
@pytest.mark.parametrize(('kind', 'radius'), [(CYLINDER, 0.0), (CAPSULE, 0.5)])
def test_points_are_off_their_surfaces_by_the_worse_but_no_more_than_they_were_moved(
    in_A, in_B, miss, kind, radius
):
    """Seen from a face of a cube, and from the side of a turned rod; a core's point is given."""
    R, p, n = random_rotation(np.random.default_rng(1)), np.array([1.0, 2.0, 3.0]), np.eye(3)[0]
    pair = Pair(BOX, CUBE, np.eye(3), kind, np.array([0.5, 2.0]), R, tuple(p))
    on_B = p + R @ [0.3 / 0.5 * (0.5 - in_B), 0.4 / 0.5 * (0.5 - in_B), 0.25]
    a, b = (1.0 - in_A, 0.25, 0.25), on_B + radius * n
    found = convex.off_surfaces(pair, tuple(n), a, tuple(b), miss)
    assert found == pytest.approx(max(min(abs(in_A), miss), min(abs(in_B), miss)), abs=1e-14)


def test_polytopes_have_vertices():
    kinds = [BOX, CAPSULE, CYLINDER, CONVEX]
    assert [convex.is_polytope(kind) for kind in kinds] == [True, True, False, True]


def test_the_gap_along_a_direction_is_that_of_the_planes():
    pair = Pair(BOX, CUBE, np.eye(3), BOX, CUBE, np.eye(3), (3.0, 4.0, 0.0))
    assert convex.gap_along(pair, (1.0, 0.0, 0.0)) == 1.0
    assert convex.gap_along(pair, (0.6, 0.8, 0.0)) == pytest.approx(5.0 - 2.0 * 1.4)
