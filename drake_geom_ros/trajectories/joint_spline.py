"""The curve on which a controller takes joints through the points of a trajectory."""

from __future__ import annotations

from copy import copy
from itertools import pairwise
from math import comb
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.geometry.queries.motion_queries import JointPath
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.tolerances import SPLINE_ROUNDING

_DEGREE = 5
# Bounds of a motion hold for a whole edge of a path. With two edges a segment a proof about two
# arms takes half the time of one, and with four more than with two (bench.motion trajectories).
EDGES = 2
_PIECES = 2  # of an edge, for the bounds of its values: closer than of the whole


class JointTrajectory(NamedTuple):
    """Points (k,) of n joints: times [s], positions [rad] or [m], and derivatives by seconds.

    ``velocities`` and ``accelerations`` (k, n) are None, or have rows of NaN for points without.
    """

    times: ArrayLike
    positions: ArrayLike
    velocities: ArrayLike | None = None
    accelerations: ArrayLike | None = None


class Extreme(NamedTuple):
    """The value of a joint, by its column, that is farthest beyond its limits."""

    joint: int
    time: float  # [s]
    value: float  # [rad] or [m]


class JointSpline:
    """Polynomials from point to point, as ros2_controllers' joint_trajectory_controller has them.

    A segment is straight, cubic where both of its points have velocities, and quintic where both
    have velocities and accelerations (Biagiotti and Melchiorri, Trajectory Planning for Automatic
    Machines and Robots, section 2.1).

    >>> spline = JointSpline(JointTrajectory([0, 2], [[0.0], [1.0]], [[0.0], [0.0]]))
    >>> spline.value(0.5).tolist()
    [0.15625]
    """

    def __init__(self, trajectory: JointTrajectory) -> None:
        """Raise ArgumentError for times that do not grow, and for arrays of other shapes."""
        self.positions = _rows(trajectory.positions, 'positions', None)
        shape = self.positions.shape
        self.times = _times(trajectory.times, len(self.positions))
        velocities = _rows(trajectory.velocities, 'velocities', shape)
        accelerations = _rows(trajectory.accelerations, 'accelerations', shape)
        bad = np.argwhere(~np.isfinite(self.positions))
        if bad.size:
            row, column = bad[0].tolist()
            raise ArgumentError(
                f'positions[{row}, {column}] is {self.positions[row, column]}; it must be finite'
            )
        _refuse_partial(velocities, 'velocities')
        _refuse_partial(accelerations, 'accelerations')
        spans = np.diff(self.times)[:, None]
        begin, end = self.positions[:-1], self.positions[1:]
        m0, m1 = velocities[:-1] * spans, velocities[1:] * spans
        n0, n1 = accelerations[:-1] * spans**2, accelerations[1:] * spans**2
        is_cubic = np.isfinite(m0).all(1) & np.isfinite(m1).all(1)
        is_quintic = is_cubic & np.isfinite(n0).all(1) & np.isfinite(n1).all(1)
        # (k - 1, 5, n) of s to s^5, where s goes from 0 to 1 on each segment
        self._powers = _straight(end - begin)
        self._powers[is_cubic] = _cubic(end - begin, m0, m1)[is_cubic]
        self._powers[is_quintic] = _quintic(end - begin, m0, m1, n0, n1)[is_quintic]
        sizes = [np.abs(terms) for terms in (begin, end, m0, m1, n0, n1)]
        self._sizes = np.nansum(sizes, axis=0)

    def value(self, time: float) -> Floats:
        """Return the values (n,) at a time [s]; before and after the trajectory, its ends."""
        edge = int(np.clip(np.searchsorted(self.times, time, 'right') - 1, 0, self._last))
        if len(self.times) == 1 or time >= self.times[-1]:
            return np.array(self.positions[-1])
        s = max(0.0, (time - self.times[edge]) / (self.times[edge + 1] - self.times[edge]))
        change = np.zeros(self.positions.shape[1])
        for power in self._powers[edge][::-1]:
            change = s * (power + change)
        return np.asarray(self.positions[edge] + change)

    @property
    def _last(self) -> int:
        return max(0, len(self.times) - 2)

    def part(self, begin: float, end: float) -> JointSpline:
        """Return the spline from a time [s] to a later one, both within one segment."""
        edge = int(np.clip(np.searchsorted(self.times, begin, 'right') - 1, 0, self._last))
        span = self.times[edge + 1] - self.times[edge]
        a, b = (begin - self.times[edge]) / span, (end - self.times[edge]) / span
        powers = _shift(a, b - a) @ self._values()[edge]
        cut = copy(self)
        cut.times = np.array([begin, end])
        cut.positions = np.stack((powers[0], powers.sum(axis=0)))
        cut._powers, cut._sizes = powers[np.newaxis, 1:], self._sizes[edge : edge + 1]
        return cut

    def rest(self, begin: float) -> JointSpline:
        """Return the spline from a time [s] on; all of it where that is before its first point.

        Raises ArgumentError where the last point is not later.
        """
        if begin <= self.times[0]:
            return self
        if not begin < self.times[-1]:
            raise ArgumentError(
                f'nothing is left at {begin:g} s of a trajectory that ends at {self.times[-1]:g} s'
            )
        edge = int(np.searchsorted(self.times, begin, 'right')) - 1
        first = self.part(begin, float(self.times[edge + 1]))
        cut = copy(self)
        cut.times = np.concatenate((first.times[:1], self.times[edge + 1 :]))
        cut.positions = np.concatenate((first.positions[:1], self.positions[edge + 1 :]))
        cut._powers = np.concatenate((first._powers, self._powers[edge + 1 :]))
        cut._sizes = np.concatenate((first._sizes, self._sizes[edge + 1 :]))
        return cut

    def begun_at(self, values: Floats, time: float) -> JointSpline:
        """Return the spline with the straight way from values (n,) in front, from a time [s] on.

        The time must be before the first point, else this raises ArgumentError.
        """
        if not time < self.times[0]:
            raise ArgumentError(f'{time:g} s is not before the first point at {self.times[0]:g} s')
        way = JointSpline(
            JointTrajectory([time, self.times[0]], np.stack((values, self.positions[0])))
        )
        cut = copy(self)
        cut.times = np.concatenate(([time], self.times))
        cut.positions = np.concatenate((way.positions[:1], self.positions))
        cut._powers = np.concatenate((way._powers, self._powers))
        cut._sizes = np.concatenate((way._sizes, self._sizes))
        return cut

    def beside(self, other: JointSpline) -> JointSpline:
        """Return the spline of the joints of both; raises ArgumentError for other times."""
        if not np.array_equal(self.times, other.times):
            raise ArgumentError('two splines side by side must have points at the same times')
        cut = copy(self)
        cut.positions = np.hstack((self.positions, other.positions))
        cut._powers = np.concatenate((self._powers, other._powers), axis=2)
        cut._sizes = np.hstack((self._sizes, other._sizes))
        return cut

    def split(self, times: Floats) -> JointSpline:
        """Return the same spline with points at more times [s] between its own."""
        wanted = np.union1d(self.times, times[(times > self.times[0]) & (times < self.times[-1])])
        parts = [self.part(begin, end) for begin, end in pairwise(wanted.tolist())]
        if not parts:
            return self
        cut = copy(self)
        cut.times = wanted
        cut.positions = np.concatenate(
            [part.positions[:1] for part in parts] + [self.positions[-1:]]
        )
        cut._powers = np.concatenate([part._powers for part in parts])
        cut._sizes = np.concatenate([part._sizes for part in parts])
        return cut

    def path(self) -> JointPath:
        """Return the path, with ``EDGES`` of equal length a segment, for a ``PathChecker``."""
        values = np.einsum('hmd,edn->ehmn', _SHIFTS, self._values())
        values = values.reshape(-1, _DEGREE + 1, values.shape[-1])
        powers = values[:, 1:]
        derivative = powers * np.arange(1, _DEGREE + 1)[:, None]
        second = derivative[:, 1:] * np.arange(1, _DEGREE)[:, None]
        bounds = [_largest(polynomials) for polynomials in (derivative, second, values)]
        rounding = SPLINE_ROUNDING * np.repeat(self._sizes, EDGES, axis=0)
        curves = np.concatenate((powers, np.stack((*bounds, rounding), axis=1)), axis=1)
        rows = np.concatenate((values[:, 0], self.positions[-1:]))
        rows, curves = np.ascontiguousarray(rows), np.ascontiguousarray(curves)
        return JointPath(rows, curves, np.zeros(len(rows)))

    def _values(self) -> NDArray[np.float64]:
        """Return the coefficients (k - 1, 6, n) of the values on each segment."""
        return np.concatenate((self.positions[:-1, None], self._powers), axis=1)

    def speeds(self) -> Floats:
        """Return an upper bound (n,) of the speed of each joint [rad/s] or [m/s]."""
        derivative = self._powers * np.arange(1, _DEGREE + 1)[:, None]
        by_segment = _largest(derivative) / np.diff(self.times)[:, None]
        return np.asarray(by_segment.max(axis=0, initial=0.0))

    def beyond(self, lower: Floats, upper: Floats) -> Extreme | None:
        """Return where a joint is farthest beyond its limits (n,), None if all stay within.

        A spline may overshoot between two points that are within. Its extremes are the roots of
        its derivative.
        """
        worst, most = None, 0.0
        for edge, joint in self._suspects(lower, upper):
            powers = np.concatenate(([self.positions[edge, joint]], self._powers[edge, :, joint]))
            derivative = np.polynomial.Polynomial(powers).deriv()
            roots = derivative.roots() if derivative.coef.any() else np.zeros(0)
            # The real part of a pair of complex roots is one more place to look at.
            for s in (0.0, *roots.real[(roots.real > 0.0) & (roots.real < 1.0)].tolist()):
                value = float(np.polynomial.polynomial.polyval(s, powers))
                excess = max(lower[joint] - value, value - upper[joint])
                if excess > most:
                    begin, end = self.times[edge : edge + 2].tolist()
                    worst, most = Extreme(joint, begin + s * (end - begin), value), excess
        return worst

    def _suspects(self, lower: Floats, upper: Floats) -> list[tuple[int, int]]:
        """Return the segments and joints that may be beyond limits, by bounds of their values."""
        controls = _controls(self._values())
        beyond = (controls.min(axis=1) < lower) | (controls.max(axis=1) > upper)
        return [(int(edge), int(joint)) for edge, joint in np.argwhere(beyond)]


def _times(times: ArrayLike, count: int) -> Floats:
    rows = np.asarray(times, dtype=np.float64)
    if rows.shape != (count,):
        raise ArgumentError(f'times {rows.shape} must be ({count},), one for each point')
    if not np.isfinite(rows).all() or (np.diff(rows) <= 0.0).any():
        raise ArgumentError('times must be finite and grow from point to point [s]')
    return rows


def _rows(values: ArrayLike | None, name: str, shape: tuple[int, ...] | None) -> Floats:
    """Return an array (k, n); NaN for None."""
    if values is None:
        assert shape is not None
        return np.full(shape, np.nan)
    try:
        rows = np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ArgumentError(f'{name} must be numbers (k, n): {error}') from None
    if rows.ndim != 2 or not len(rows) or (shape is not None and rows.shape != shape):
        wanted = '(k, n) of at least one point' if shape is None else f'{shape}'
        raise ArgumentError(f'{name} {rows.shape} must be {wanted}')
    return rows


def _refuse_partial(rows: Floats, name: str) -> None:
    """Raise ArgumentError for a point with some of its derivatives, or infinite ones."""
    missing = np.isnan(rows)
    partial = (missing.any(1) & ~missing.all(1)) | np.isinf(rows).any(1)
    if partial.any():
        row = int(np.argmax(partial))
        raise ArgumentError(
            f'{name}[{row}] is {rows[row].tolist()}; a point has finite numbers for all joints, '
            'or NaN for all'
        )


def _straight(change: Floats) -> NDArray[np.float64]:
    powers = np.zeros((len(change), _DEGREE, change.shape[1]))
    powers[:, 0] = change
    return powers


def _cubic(change: Floats, m0: Floats, m1: Floats) -> NDArray[np.float64]:
    """Return the coefficients for slopes m [1/segment]."""
    none = np.zeros_like(change)
    powers = (m0, 3.0 * change - 2.0 * m0 - m1, m0 + m1 - 2.0 * change, none, none)
    return np.stack(powers, axis=1)


def _quintic(
    change: Floats, m0: Floats, m1: Floats, n0: Floats, n1: Floats
) -> NDArray[np.float64]:
    """Return the coefficients for slopes m and second derivatives n, by segments."""
    powers = (
        m0,
        0.5 * n0,
        10.0 * change - 6.0 * m0 - 4.0 * m1 - 1.5 * n0 + 0.5 * n1,
        -15.0 * change + 8.0 * m0 + 7.0 * m1 + 1.5 * n0 - n1,
        6.0 * change - 3.0 * (m0 + m1) - 0.5 * (n0 - n1),
    )
    return np.stack(powers, axis=1)


def _shift(a: float, h: float) -> Floats:
    """Return the matrix from coefficients of p(s) to those of ``p(a + h u)`` in u."""
    every = range(_DEGREE + 1)
    rows = [[comb(i, j) * a ** (i - j) * h**j if i >= j else 0.0 for i in every] for j in every]
    return np.array(rows)


def _to_controls(degree: int) -> Floats:
    """Return the matrix from coefficients to the Bernstein coefficients of all pieces.

    A polynomial is within the range of its Bernstein coefficients (Farin, Curves and Surfaces for
    CAGD, section 4.3).
    """
    every = range(degree + 1)
    bernstein = np.array(
        [[comb(j, i) / comb(degree, i) if j >= i else 0.0 for i in every] for j in every]
    )
    pieces = [_shift(piece / _PIECES, 1.0 / _PIECES) for piece in range(_PIECES)]
    shifts = [shift[: degree + 1, : degree + 1] for shift in pieces]
    return np.concatenate([bernstein @ shift for shift in shifts])


_SHIFTS = np.stack([_shift(edge / EDGES, 1.0 / EDGES) for edge in range(EDGES)])
_TO_CONTROLS = {degree: _to_controls(degree) for degree in (3, 4, 5)}


def _controls(powers: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return numbers (e, m, n) whose range has all values of polynomials (e, d + 1, n) in it."""
    matrix = _TO_CONTROLS[powers.shape[1] - 1]
    controls = np.einsum('md,edn->emn', matrix, powers)
    slack = SPLINE_ROUNDING * np.einsum('md,edn->emn', matrix, np.abs(powers))
    return np.concatenate((controls - slack, controls + slack), axis=1)


def _largest(powers: NDArray[np.float64]) -> Floats:
    """Return an upper bound (e, n) of the size of polynomials (e, d + 1, n) for s in [0, 1]."""
    return np.asarray(np.abs(_controls(powers)).max(axis=1))
