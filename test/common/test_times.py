"""Moments between two others are rounded to the side that is asked for."""

import math
from fractions import Fraction

from hypothesis import given
from hypothesis import strategies as st

from drake_geom_ros.common.times import time_between

MOMENTS = st.floats(-1e6, 1e6)


@given(MOMENTS, st.floats(0.0, 1e6), st.floats(0.0, 1.0))
def test_what_is_true_lies_between_what_is_rounded_down_and_up(begin, longer, part):
    end = begin + longer
    exact = Fraction(begin) + Fraction(part) * (Fraction(end) - Fraction(begin))
    low, high = (time_between(begin, end, part, side) for side in (-math.inf, math.inf))
    assert begin <= low <= exact <= high <= end
    assert low <= time_between(begin, end, part) <= high or begin == end
