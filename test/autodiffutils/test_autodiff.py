"""AutoDiffXd: arithmetic by the rules of differentiation, arrays, and pydrake's behaviour."""

import importlib.util
import operator

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_geom_ros.autodiffutils import (
    AutoDiffXd,
    ExtractGradient,
    ExtractValue,
    InitializeAutoDiff,
    InitializeAutoDiffTuple,
)

numbers = st.floats(0.3, 3.0)
slopes = st.lists(st.floats(-3.0, 3.0), min_size=2, max_size=2).map(np.array)
BINARY = [operator.add, operator.sub, operator.mul, operator.truediv, operator.pow, np.arctan2]
UNARY = [
    *(np.sqrt, np.exp, np.log, np.sin, np.cos, np.sinh, np.cosh, np.tanh, np.arctan),
    *(operator.neg, operator.pos, abs, lambda x: np.arcsin(x / 4), lambda x: np.arccos(x / 4)),
    *(lambda x: 2.0 - x, lambda x: 2 / x, lambda x: np.float64(3.0) * x, lambda x: 2.0**x),
    *(lambda x: np.tan(x / 3), lambda x: (-x) ** 3, lambda x: x**0, lambda x: np.arctan2(x, -2.0)),
]


def slope_of(function, x):
    """Return the derivative by differences of fourth order."""
    h = 1e-3
    steps = {-2: 1 / 12, -1: -2 / 3, 1: 2 / 3, 2: -1 / 12}
    return sum(w * function(x + s * h) for s, w in steps.items()) / h


@pytest.mark.parametrize('function', UNARY)
@given(x=numbers, rates=slopes)
def test_functions_of_one_number(function, x, rates):
    found = function(AutoDiffXd(x, rates))
    assert found.value() == pytest.approx(function(x), rel=1e-15)
    expected = slope_of(function, x) * rates
    np.testing.assert_allclose(found.derivatives(), expected, rtol=1e-7, atol=1e-7)


@pytest.mark.parametrize('function', BINARY)
@given(x=numbers, y=numbers, of_x=slopes, of_y=slopes)
def test_functions_of_two_numbers(function, x, y, of_x, of_y):
    found = function(AutoDiffXd(x, of_x), AutoDiffXd(y, of_y))
    assert found.value() == pytest.approx(function(x, y), rel=1e-15)
    by_x, by_y = slope_of(lambda t: function(t, y), x), slope_of(lambda t: function(x, t), y)
    np.testing.assert_allclose(
        found.derivatives(), by_x * of_x + by_y * of_y, rtol=1e-6, atol=1e-6
    )
    constant = function(AutoDiffXd(x, of_x), AutoDiffXd(y))
    np.testing.assert_allclose(constant.derivatives(), by_x * of_x, rtol=1e-6, atol=1e-6)


def test_values_decide_comparisons():
    x, y = AutoDiffXd(1.0, [5.0]), AutoDiffXd(2.0, [3.0])
    assert x < y
    assert x <= 1
    assert y > x
    assert y >= 2.0
    assert x == AutoDiffXd(1.0)
    assert x != y
    assert np.maximum(x, y) is y
    assert repr(x) == 'AutoDiffXd(1.0, [5.0])'
    with pytest.raises(TypeError):
        float(x)


def test_different_variables_do_not_meet():
    with pytest.raises(RuntimeError, match='2 and of 3'):
        AutoDiffXd(1.0, [1, 2]) + AutoDiffXd(1.0, [1, 2, 3])
    with pytest.raises(RuntimeError, match=r'\[2, 3\]'):
        ExtractGradient([AutoDiffXd(1.0, [1, 2]), AutoDiffXd(1.0, [1, 2, 3])])
    with pytest.raises(TypeError):
        AutoDiffXd(1.0) + 'a'


def test_matrices_are_counted_down_their_columns():
    values = np.arange(6.0).reshape(2, 3)
    numbers = InitializeAutoDiff(value=values)
    np.testing.assert_array_equal(ExtractValue(numbers), values)
    np.testing.assert_array_equal(ExtractGradient(numbers), np.eye(6))
    assert numbers[0, 1].derivatives().tolist() == [0, 0, 1, 0, 0, 0]
    some = InitializeAutoDiff([1.0, 2.0], num_derivatives=5, deriv_num_start=3)
    np.testing.assert_array_equal(ExtractGradient(some), np.eye(5)[3:])
    assert some.shape == (2, 1)
    with pytest.raises(RuntimeError, match='do not fit'):
        InitializeAutoDiff([1.0, 2.0], num_derivatives=3, deriv_num_start=2)


def test_a_tuple_is_counted_through():
    a, b = InitializeAutoDiffTuple([1.0, 2.0], [[3.0]])
    np.testing.assert_array_equal(ExtractGradient(a), np.eye(3)[:2])
    np.testing.assert_array_equal(ExtractGradient(b), np.eye(3)[2:])
    mixed = np.array([a[0, 0], AutoDiffXd(4.0), 5.0], dtype=object)
    np.testing.assert_array_equal(ExtractGradient(mixed), [[1, 0, 0], [0, 0, 0], [0, 0, 0]])
    np.testing.assert_array_equal(ExtractGradient(mixed[1:], 2), np.zeros((2, 2)))


def test_numpy_works_on_arrays_of_them():
    x = InitializeAutoDiff([0.3, 0.4])[:, 0]
    length = np.sqrt(x @ x)
    np.testing.assert_allclose(length.derivatives(), [0.6, 0.8], rtol=0, atol=1e-15)
    A = np.array([[1.0, 2.0], [3.0, 4.0]])
    np.testing.assert_array_equal(ExtractGradient(A @ x), A)


@pytest.mark.skipif(importlib.util.find_spec('pydrake') is None, reason='no pydrake')
def test_it_computes_as_pydrake_does():
    from pydrake import autodiffutils as pydrake

    def script(module):
        x, y = module.InitializeAutoDiffTuple([0.4, 0.7], [1.2])
        z = np.sin(x[0, 0]) * y[0, 0] ** 2 / np.sqrt(x[1, 0]) - np.arctan2(y[0, 0], x[0, 0])
        row = np.array([z, abs(-z), 2.0 - z, z / 3.0, np.exp(z), np.tanh(z)])
        return module.ExtractValue(row), module.ExtractGradient(row)

    import drake_geom_ros.autodiffutils as ours

    for mine, its in zip(script(ours), script(pydrake), strict=True):
        np.testing.assert_allclose(mine, its, rtol=1e-14)
