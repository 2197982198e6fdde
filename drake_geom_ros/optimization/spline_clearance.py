"""The cubic spline through way points, and how far it goes between its states.

A spline that interpolates is linear in its way points, q(t) = sum over k of B_k(t) P_k, so states
have constant derivatives by these. Between two states a joint goes as far as the sum of its
monotone pieces, whose ends are the roots of a quadratic.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.trajectories.joint_spline import JointTrajectory


class Travel(NamedTuple):
    """The way that joints go in each piece of a spline, and what they pass."""

    length: Floats  # (e, s, c) [rad] or [m], of each joint there and back
    slopes: Floats  # (e, s, k, c) of these, by the way points
    lowest: Floats  # (c,) values of the joints anywhere on the spline
    highest: Floats  # (c,)


class ClampedCubicSpline:
    """The cubic spline through way points at given times that is at rest at both ends.

    Its second derivative is continuous (C. de Boor, A Practical Guide to Splines, chapter IV), so
    a controller follows it without jumps of acceleration.

    Args:
        times: (k,) [s] of the way points, growing.

    Raises:
        ArgumentError: fewer than two times, or times that do not grow.

        >>> spline = ClampedCubicSpline([0.0, 1.0, 2.0])
        >>> spline.states([[0.0], [1.0], [0.0]], pieces=2).ravel().tolist()
        [0.0, 0.5, 1.0, 0.5, 0.0]
    """

    def __init__(self, times: ArrayLike) -> None:
        """Prepare the spline; see the class."""
        knots = np.array(times, dtype=np.float64)
        if knots.ndim != 1 or len(knots) < 2 or not (np.diff(knots) > 0.0).all():
            raise ArgumentError(f'times={times!r} must be at least two that grow [s]')
        self.times = knots
        from scipy.interpolate import CubicSpline  # 0.2 s, which only splines need

        basis = CubicSpline(knots, np.eye(len(knots)), bc_type='clamped')
        self._powers = basis.c[::-1]  # (4, e, k) by the time since the beginning of an edge

    def trajectory(self, path: ArrayLike) -> JointTrajectory:
        """Return the trajectory that controllers execute, and ``batch.check_trajectory`` proves.

        ``path`` (k, c): way points. Velocities at these make each segment the same cubic.
        """
        points = np.asarray(path, dtype=np.float64)
        velocities = np.vstack((self._powers[1] @ points, np.zeros((1, points.shape[1]))))
        return JointTrajectory(self.times, points, velocities)

    def weights(self, pieces: int) -> Floats:
        """Return the weights (e s + 1, k) of way points in the states between pieces."""
        spans = np.diff(self.times)
        steps = spans[:, None] * (np.arange(pieces) / pieces)
        inner = _cubics(self._powers[:, :, None], steps[..., None])
        return np.vstack((inner.reshape(-1, len(self.times)), np.eye(len(self.times))[-1:]))

    def states(self, path: ArrayLike, pieces: int) -> Floats:
        """Return the states (e s + 1, c) between ``pieces`` of each edge of a path (k, c)."""
        return np.asarray(self.weights(pieces) @ np.asarray(path, dtype=np.float64))

    def travel(self, path: Floats, pieces: int) -> Travel:
        """Return how far joints go in each piece of a path (k, c)."""
        powers = self._powers @ path  # (4, e, c)
        spans = np.diff(self.times)[:, None, None, None]
        part = np.arange(pieces)[:, None, None]
        begin, end = spans * (part / pieces), spans * ((part + 1) / pieces)  # (e, s, 1, 1)
        turns = np.clip(_turns(powers)[:, None], begin, end)  # (e, s, c, 2)
        first, last = (np.broadcast_to(each, (*turns.shape[:3], 1)) for each in (begin, end))
        times = np.concatenate((first, turns, last), axis=3)
        values = _cubics(powers[:, :, None, :, None], times)
        weights = _cubics(self._powers[:, :, None, None, None], times[..., None])
        steps = np.diff(values, axis=3)
        slopes = np.einsum('escm,escmk->eskc', np.sign(steps), np.diff(weights, axis=3))
        lowest, highest = values.min(axis=(0, 1, 3)), values.max(axis=(0, 1, 3))
        return Travel(np.abs(steps).sum(axis=3), slopes, lowest, highest)


def _cubics(powers: NDArray[np.float64], times: NDArray[np.float64]) -> Floats:
    """Return the values of cubics, by coefficients (4, ...) of a power each, at times."""
    a, b, c, d = powers
    return np.asarray(a + times * (b + times * (c + times * d)))


def _turns(powers: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the times (e, c, 2), ascending, at which cubics (4, e, c) turn; 0: they do not."""
    _, b, c, d = powers
    square = c * c - 3.0 * b * d
    root = np.sqrt(np.maximum(square, 0.0))
    # The form without cancellation: of the two roots one is from the sum, one from the product.
    half = -(c + np.where(c < 0.0, -root, root))
    with np.errstate(divide='ignore', invalid='ignore'):
        both = np.stack((half / (3.0 * d), b / half), axis=-1)
    both[~np.isfinite(both) | (square < 0.0)[..., None]] = 0.0
    return np.sort(both, axis=-1)
