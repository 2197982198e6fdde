"""Views without references show what slices show, and write through."""

import numpy as np
import pytest

from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled
from drake_geom_ros.geometry._proximity.runtime.views import part, row


@allocating
def row_of(array, k):
    return row(array, k).copy()


@allocating
def part_of(array, start, stop):
    return part(array, start, stop).copy()


@compiled
def add_to_row(array, k, x):
    view = row(array, k)
    for i in range(view.size):
        view[i] += x


@pytest.mark.parametrize('shape', [(4, 3), (4, 3, 3), (1, 13), (5, 0)])
def test_a_row_is_the_slice(shape):
    array = np.random.default_rng(0).normal(size=shape)
    for k in range(shape[0]):
        np.testing.assert_array_equal(row_of(array, k), array[k])


@pytest.mark.parametrize(('start', 'stop'), [(0, 0), (0, 7), (2, 5), (6, 7), (7, 7)])
def test_a_part_is_the_slice(start, stop):
    array = np.random.default_rng(1).normal(size=7)
    np.testing.assert_array_equal(part_of(array, start, stop), array[start:stop])


def test_what_is_written_to_a_view_is_in_the_array():
    array = np.zeros((3, 2))
    add_to_row(array, 1, 2.5)
    np.testing.assert_array_equal(array, [[0, 0], [2.5, 2.5], [0, 0]])
