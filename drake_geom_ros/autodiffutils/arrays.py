"""Conversions between arrays of AutoDiffXd and arrays of values and derivatives."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.autodiffutils.autodiff import AutoDiffXd, is_autodiff
from drake_geom_ros.math.array_types import Floats

Objects = NDArray[np.object_]


def InitializeAutoDiff(
    value: ArrayLike, num_derivatives: int | None = None, deriv_num_start: int | None = None
) -> Objects:
    """Return a matrix (m, n) of AutoDiffXd of these values, each an independent variable.

    Variables are numbered down the columns, from ``deriv_num_start`` (0) on. There are
    ``num_derivatives`` of them, by default one for each value. Values (m,) are a column. Raises
    RuntimeError if the numbers exceed this.

        >>> InitializeAutoDiff([5.0, 7.0])[1, 0]
        AutoDiffXd(7.0, [0.0, 1.0])
    """
    values, start = _matrix(np.asarray(value, dtype=np.float64)), deriv_num_start or 0
    total = start + values.size if num_derivatives is None else num_derivatives
    if start < 0 or start + values.size > total:
        raise RuntimeError(
            f'InitializeAutoDiff: {values.size} variables from number {start} on do not fit into '
            f'num_derivatives = {total}'
        )
    numbers = np.empty(values.size, dtype=object)
    for k, number in enumerate(values.ravel(order='F')):
        numbers[k] = AutoDiffXd(number, total, start + k)
    return numbers.reshape(values.shape, order='F')


def InitializeAutoDiffTuple(*args: ArrayLike) -> tuple[Objects, ...]:
    """Return each argument as a matrix of AutoDiffXd, with variables numbered consecutively."""
    values = [_matrix(np.asarray(value, dtype=np.float64)) for value in args]
    total, start, matrices = sum(v.size for v in values), 0, []
    for value in values:
        matrices.append(InitializeAutoDiff(value, total, start))
        start += value.size
    return tuple(matrices)


def ExtractValue(auto_diff_matrix: Any) -> Floats:
    """Return the values (m, n) of a matrix of AutoDiffXd and floats; (m,) is a column."""
    return values_of(_matrix(np.asarray(auto_diff_matrix)))


def ExtractGradient(auto_diff_matrix: Any, num_derivatives: int | None = None) -> Floats:
    """Return the derivatives (m n, number of variables) of a matrix, down its columns.

    Raises RuntimeError if numbers have different numbers of variables, or not
    ``num_derivatives``; constants fit any number.
    """
    numbers = _matrix(np.asarray(auto_diff_matrix)).ravel(order='F')
    return derivatives_of(numbers, num_derivatives)


def autodiff_equal_to(a: Any, b: Any, semantic: bool = False) -> Any:
    """Return, element by element, whether two arrays have the same values and derivatives.

    With ``semantic`` a constant equals a number whose derivatives are all 0.
    """

    def equal(x: Any, y: Any) -> bool:
        of_x, of_y = (n.derivatives() if is_autodiff(n) else np.zeros(0) for n in (x, y))
        if semantic and not (of_x.size and of_y.size):
            same = not (of_x.any() or of_y.any())
        else:
            same = np.array_equal(of_x, of_y)
        return bool(same and x == y)

    return np.vectorize(equal, otypes=[bool])(a, b)


def values_of(numbers: Any) -> Floats:
    """Return the values of an array of AutoDiffXd and floats, in its shape."""
    array = np.asarray(numbers)
    if array.dtype != object:
        return array.astype(np.float64)
    values = [n.value() if is_autodiff(n) else float(n) for n in array.ravel()]
    return np.array(values, dtype=np.float64).reshape(array.shape)


def derivatives_of(numbers: Any, num_derivatives: int | None = None) -> Floats:
    """Return the derivatives (..., n) of an array (...) of AutoDiffXd and floats."""
    array = np.asarray(numbers, dtype=object)
    of_each = [n.derivatives() if is_autodiff(n) else np.zeros(0) for n in array.ravel()]
    sizes = {len(each) for each in of_each} - {0}
    if num_derivatives is not None:
        sizes.add(num_derivatives)
    if len(sizes) > 1:
        raise RuntimeError(f'AutoDiffXd: numbers of {sorted(sizes)} independent variables met')
    count = sizes.pop() if sizes else 0
    rows = [each if len(each) else np.zeros(count) for each in of_each]
    return np.array(rows, dtype=np.float64).reshape(*array.shape, count)


def autodiff_array(values: Floats, derivatives: Floats, scalar: Any = AutoDiffXd) -> Objects:
    """Return an array of numbers of a scalar type, of values (...) and derivatives (..., n)."""
    numbers = np.empty(values.shape, dtype=object)
    for index in np.ndindex(values.shape):
        numbers[index] = scalar(float(values[index]), derivatives[index])
    return numbers


def scalar_type(*arrays: Any) -> Any:
    """Return the type of the first number with derivatives in some arrays, or AutoDiffXd."""
    for array in arrays:
        for number in np.asarray(array, dtype=object).ravel():
            if is_autodiff(number):
                return type(number)
    return AutoDiffXd


def _matrix(array: Any) -> Any:
    """Return an array of one or two dimensions as a matrix; (m,) is a column."""
    if array.ndim > 2:
        raise RuntimeError(f'AutoDiffXd: shape {array.shape} is no matrix')
    return array.reshape(-1, 1) if array.ndim < 2 else array
