"""Lower bounds of the loop over near pairs: below the truth, and no more than rounding below."""

import math
from fractions import Fraction

import numpy as np
import pytest
from oracles.worlds import random_world

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    METHOD,
    PAIR_WIDTH,
)
from drake_geom_ros.geometry._proximity.kinds import BOUND_ONLY, ITERATIVE
from drake_geom_ros.geometry._proximity.pairs import distance_bounds as pair_gaps
from drake_geom_ros.geometry._proximity.pairs import narrow_phase
from drake_geom_ros.geometry._proximity.tolerances import EPS, ROUNDING
from drake_geom_ros.geometry._proximity.world.pose_rounding import RADIUS


@pytest.mark.parametrize('least', [0.1, -0.1, 1e-9, 1e9])
@pytest.mark.parametrize('travelled', [0.0, 0.3, 1e-9, 1e9])
def test_a_slack_is_rounded_down(least, travelled):
    for _ in range(20):
        least, travelled = math.nextafter(least, math.inf), math.nextafter(travelled, math.inf)
        exact = Fraction(least) + Fraction(travelled)
        off = exact - Fraction(float(narrow_phase._slack(least, travelled, 1, 1)))
        assert 0 <= off <= Fraction(8 * EPS * (abs(least) + travelled))


def test_what_an_answer_says_at_least():
    row = np.zeros(PAIR_WIDTH)
    row[[DISTANCE, ERROR_BOUND, METHOD]] = 10.0, 0.5, BOUND_ONLY
    for size in (0.1, 100.0):
        rounding = 10.0 - narrow_phase._least(row, 1e-9, size, 0.0)  # of a kernel's lower bound
        assert 1.0 <= rounding / (ROUNDING * EPS * (size + 10.0)) <= 3.0
        assert narrow_phase._least(row, 1e-9, size, 0.25) == pytest.approx(9.75, abs=1e-12)
        assert narrow_phase._least(row, math.inf, size, 0.25) == 9.5  # of an interval from bounds
    row[METHOD] = ITERATIVE
    assert narrow_phase._least(row, 1e-9, 0.1, 0.25) == 9.5


def test_gaps_of_balls_are_lower_bounds_and_tight():
    world = random_world(np.random.default_rng(1), 30)
    for i in range(29):
        apart = np.linalg.norm(world.p_WGs[i] - world.p_WGs[i + 1])
        expected = apart - world.outer_radii[i] - world.outer_radii[i + 1]
        arguments = world.p_WGs, world.roundings, world.outer_radii
        found = pair_gaps.separation_of_balls(i, i + 1, *arguments)
        assert expected - 1e-13 <= found <= expected


@pytest.mark.parametrize('offset', [1.0, 1e3, 1e6])
def test_gaps_of_balls_count_the_rounding_of_where_they_are(offset):
    p_WGs, outer = np.array([[offset, 0, 0], [0, offset, 0]]), np.array([0.1, 0.2])
    roundings = np.zeros((2, 2))
    expected = math.sqrt(2.0) * offset - 0.3
    found = pair_gaps.separation_of_balls(0, 1, p_WGs, roundings, outer)
    assert 8 * EPS * offset <= expected - found <= 40 * EPS * (offset + 1.0)
    roundings[:, RADIUS] = 0.02, 0.03
    found = pair_gaps.separation_of_balls(0, 1, p_WGs, roundings, outer)
    assert expected - found == pytest.approx(0.05, abs=40 * EPS * (offset + 1.0))


def test_balls_too_far_apart_for_squares_are_left_to_boxes():
    p_WGs, outer = np.array([[1e200, 0, 0], [-1e200, 0, 0]]), np.ones(2)
    with np.errstate(over='ignore'):
        assert pair_gaps.separation_of_balls(0, 1, p_WGs, np.zeros((2, 2)), outer) == -math.inf
