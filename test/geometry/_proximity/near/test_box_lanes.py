"""Boxes compared side by side: against a comparison of each, and rounding that is outwards."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from drake_geom_ros.geometry._proximity.near.box_lanes import (
    LANES,
    above,
    below,
    box_at,
    empty_sides,
    first_lanes,
    lowest,
    overlapping,
)
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled


@compiled
def bits_of(sides, first, k, count):
    """Return which of so many boxes from the first on overlap box k."""
    return overlapping(sides, first, box_at(sides, k)) & first_lanes(count)


@compiled
def lowest_of(bits):
    return lowest(bits)


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(1, 3 * LANES))
def test_each_box_is_compared_as_it_would_be_alone(seed, count):
    """Sides are small whole numbers, so that many of them are equal."""
    rng = np.random.default_rng(seed)
    lowers = rng.integers(-4, 4, (3, count))
    sides = empty_sides(count)
    sides[:3, :count], sides[3:, :count] = lowers, lowers + rng.integers(0, 4, (3, count))
    sides[:, count:] = np.nan  # whatever stands behind the last one
    boxes = sides[:, :count].T
    for k in range(count):
        meet = (boxes[:, :3] <= boxes[k, 3:]) & (boxes[k, :3] <= boxes[:, 3:])
        wanted = np.flatnonzero(meet.all(axis=1)).tolist()
        found = []
        for first in range(0, count, LANES):
            bits = int(bits_of(sides, first, k, count - first))
            found += [first + j for j in range(LANES) if bits >> j & 1]
        assert found == wanted


def test_boxes_without_end_overlap_all():
    sides = empty_sides(LANES)
    sides[:3, 0], sides[3:, 0] = -np.inf, np.inf
    assert bits_of(sides, 0, 0, LANES) == 2**LANES - 1


@pytest.mark.parametrize('bits', [1, 2, 3, 0b10100, 1 << LANES - 1])
def test_the_lowest_bit_is_found(bits):
    assert lowest_of(bits) == (bits & -bits).bit_length() - 1


@given(st.floats(allow_nan=False, allow_infinity=False))
@example(1.0)
@example(1.0 + 2.0**-24)
@example(3.4028235677973366e38)  # rounds to infinity
@example(-1e300)
@example(5e-324)
@example(-1e-46)
@example(0.0)
def test_rounding_is_outwards_and_no_more_than_it_must_be(value):
    lower, upper = float(below(value)), float(above(value))
    assert not math.isnan(lower)
    assert not math.isnan(upper)
    assert lower <= value <= upper
    assert upper == -float(below(-value))
    if abs(value) < 1e38:
        width = Fraction(upper) - Fraction(lower)
        assert width <= Fraction(abs(value)) / 2**21 + Fraction(2) ** -123


@pytest.mark.parametrize('value', [math.inf, -math.inf])
def test_what_has_no_end_is_rounded_outwards(value):
    assert float(below(value)) <= value <= float(above(value))
