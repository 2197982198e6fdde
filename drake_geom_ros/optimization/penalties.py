"""Penalty functions and smooth maxima of constraints on minimum distances.

The formulas are those of Drake's ``solvers::MinimumValueLowerBoundConstraint`` and
``solvers::MinimumValueUpperBoundConstraint`` (release 1.51).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from drake_geom_ros.math.array_types import Floats

# Takes x and whether a derivative is wanted; returns the penalty, and its derivative or None.
PenaltyFunction = Callable[[float, bool], tuple[float, float | None]]

SHARPNESS = 100.0  # [-] of smooth maxima: Drake's value


def QuadraticallySmoothedHingeLoss(x: float, compute_grad: bool) -> tuple[float, float | None]:
    """Return a hinge with a quadratic corner, and its derivative or None.

    It is 0 for x >= 0, x^2 / 2 down to -1, and -1/2 - x below.

        >>> QuadraticallySmoothedHingeLoss(-1.0, True)
        (0.5, -1.0)
    """
    if x >= 0.0:
        value, slope = 0.0, 0.0
    elif x > -1.0:
        value, slope = 0.5 * x * x, x
    else:
        value, slope = -0.5 - x, -1.0
    return value, slope if compute_grad else None


def ExponentiallySmoothedHingeLoss(x: float, compute_grad: bool) -> tuple[float, float | None]:
    """Return a hinge with derivatives of all orders, and its first derivative or None.

    It is 0 for x >= 0, and -x exp(1 / x) below.

        >>> ExponentiallySmoothedHingeLoss(-1.0, False) == (math.exp(-1.0), None)
        True
    """
    factor = math.exp(1.0 / x) if x < 0.0 else 0.0
    if factor == 0.0:  # also just below 0
        return 0.0, 0.0 if compute_grad else None
    return -x * factor, (1.0 / x - 1.0) * factor if compute_grad else None


def smooth_over_maximum(values: Floats, zeros: int) -> tuple[float, Floats]:
    """Return log(sum exp(100 v)) / 100 of values (k,) and so many zeros, and its gradient (k,).

    It is at least the largest of all. There must be a value or a zero.
    """
    largest = max(float(values.max(initial=-math.inf)), 0.0 if zeros else -math.inf)
    weights = np.exp(SHARPNESS * (values - largest))
    total = float(weights.sum()) + zeros * math.exp(-SHARPNESS * largest)
    return largest + math.log(total) / SHARPNESS, weights / total


def smooth_under_maximum(values: Floats, zeros: int) -> tuple[float, Floats]:
    """Return the mean of values (k,) and so many zeros with the weights exp(100 v).

    With its gradient (k,). It is at most the largest of all. There must be a value or a zero.
    """
    largest = max(float(values.max(initial=-math.inf)), 0.0 if zeros else -math.inf)
    weights = np.exp(SHARPNESS * (values - largest))
    total = float(weights.sum()) + zeros * math.exp(-SHARPNESS * largest)
    mean = float(weights @ values) / total
    return mean, weights / total * (1.0 + SHARPNESS * (values - mean))
