"""The larger number, in compiled code too."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_geom_ros.geometry._proximity.runtime.compiled import compiled
from drake_geom_ros.geometry._proximity.runtime.larger import larger

NUMBERS = st.floats(allow_nan=False)


@compiled
def largest(numbers):
    most = -np.inf
    for k in range(np.uint64(numbers.size)):
        most = larger(numbers[k], most)
    return most


@given(st.lists(NUMBERS, min_size=1, max_size=40))
def test_of_many_it_is_the_largest(numbers):
    assert largest(np.array(numbers)) == max(numbers)


@pytest.mark.parametrize('count', [1, 3, 4, 7, 8, 9, 31, 32, 33, 100])
def test_wherever_it_stands(count):
    for k in range(count):
        numbers = np.full(count, -1.0)
        numbers[k] = 2.0
        assert largest(numbers) == 2.0
