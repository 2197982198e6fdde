"""Objects as they are given: arrays come out as they went in, and what is none is told."""

import sys

import numpy as np
import pytest

from drake_geom_ros.geometry._proximity.compiled import Entry, compiled
from drake_geom_ros.geometry._proximity.given import GIVEN, array_in, is_alike

matrix_in, numbers_in = array_in(np.float64, 2), array_in(np.int64, 1)


@compiled
def _alike(given, ours):
    return is_alike(given, ours)


@compiled
def _weighed(matrix, weights, sums):
    matrix, weights, sums = matrix_in(matrix), numbers_in(weights), matrix_in(sums)
    for k in range(matrix.shape[0]):
        for c in range(matrix.shape[1]):
            sums[0, c] += weights[k] * matrix[k, c]
    return matrix.size


alike = Entry(_alike, GIVEN, GIVEN)
weighed = Entry(_weighed, GIVEN, GIVEN, GIVEN)
OURS = np.zeros((3, 7))


@pytest.mark.parametrize('shape', [(0, 3), (1, 1), (5, 4)])
def test_compiled_code_reads_and_writes_what_is_given(shape):
    rng = np.random.default_rng(0)
    matrix, weights = rng.random(shape), rng.integers(0, 9, shape[0])
    sums = np.zeros((1, shape[1]))
    assert weighed.call(matrix, weights, sums) == matrix.size
    np.testing.assert_allclose(sums[0], weights @ matrix)


def test_a_view_in_one_piece_is_read_where_it_is():
    matrix = np.arange(12.0).reshape(4, 3)
    sums = np.zeros((1, 3))
    weighed.call(matrix[1:3], np.array([1, 10]), sums)
    np.testing.assert_array_equal(sums[0], matrix[1] + 10 * matrix[2])


@pytest.mark.parametrize(
    ('given', 'told'),
    [
        (np.ones((5, 7)), True),
        (np.ones((9, 7))[2:4], True),
        (np.frombuffer(bytes(8 * 14)).reshape(2, 7), True),  # which nobody may write to
        (np.ones((0, 7)), True),
        (np.ones((5, 7), order='F'), False),
        (np.ones((5, 14))[:, ::2], False),
        (np.ones((5, 7))[::-1], False),
        (np.ones((5, 7), dtype=np.float32), False),
        (np.ones((5, 7), dtype=np.int64), False),
        (np.ones((5, 7), dtype='>f8'), False),
        (np.frombuffer(bytes(8 * 14 + 1), offset=1).reshape(2, 7), False),  # not aligned
        (np.ones(7), False),
        (np.ones((1, 5, 7)), False),
        (np.float64(3.0), False),
        (np.ma.ones((5, 7)), False),
        (np.asmatrix(np.ones((5, 7))), False),
        (None, False),
        (3, False),
        ([[0.0] * 7], False),
        ('poses', False),
        (np.ndarray, False),
        (object(), False),
    ],
)
def test_it_is_told_what_is_an_array_like_ours(given, told):
    assert bool(alike.call(given, OURS)) is told


def test_no_reference_is_lost_or_kept():
    matrix, sums, others = np.ones((2, 2)), np.zeros((1, 2)), ([3], object(), np.ones(2))
    weights = np.array([1, 2])
    counted = [matrix, sums, weights, *others]
    before = [sys.getrefcount(each) for each in counted]
    for _ in range(1000):
        weighed.call(matrix, weights, sums)
        assert [bool(alike.call(other, OURS)) for other in others] == [False] * 3
    assert [sys.getrefcount(each) for each in counted] == before
