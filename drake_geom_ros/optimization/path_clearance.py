"""Clearance of whole paths, certified between way points, with derivatives.

The smallest distance c of all pairs changes by at most M = max over pairs of (rates @ |q - p|)
between the states q and p. On the straight way between them it is therefore at least
(c(q) + c(p) - M) / 2: at a part t of the way it is at least c(q) - t M and c(p) - (1 - t) M.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.batch import Checker
from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.geometry.checks import as_number
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.optimization.constraint import Constraint
from drake_geom_ros.optimization.spline_clearance import ClampedCubicSpline, Travel


class PathClearance(NamedTuple):
    """Certified bounds of e edges of a path, each in s pieces, with their derivatives.

    Along piece j of edge i no pair is nearer than ``lower_bound[i, j]``. The gradient of a
    straight path is by the way points at both ends of the edge, that of a spline by all.
    """

    lower_bound: Floats  # (e, s) [m]
    gradient: Floats  # (e, s, 2, c), or (e, s, k, c) of a spline
    clearance: Floats  # (e s + 1,) [m] of the states between pieces, in their order

    @property
    def least(self) -> float:
        """The smallest lower bound [m]: no pair comes nearer on the whole path."""
        return float(self.lower_bound.min())


def path_clearance(
    checker: Checker,
    path: ArrayLike,
    pieces: int = 8,
    *,
    spline: ClampedCubicSpline | None = None,
) -> PathClearance:
    """Return certified bounds of the clearance of a path, and derivatives by its way points.

    Args:
        checker: a ``batch.Checker``.
        path: way points (k, c), at least two, within the limits of the joints. The path is
            straight in joint space from one to the next, as in ``batch.check_path``.
        spline: the curve through the way points in place of straight lines; its ``trajectory`` is
            for ``batch.check_trajectory`` and for controllers.
        pieces: states per edge. More of them make bounds closer: these are below the clearance by
            half of the motion of one piece at most.

    Returns:
        ``PathClearance``; bounds are minus infinity where a distance changes at an unlimited rate.

    Raises:
        ArgumentError: another shape, values that are not finite or beyond their limits, between
            way points of a spline, too.
        GeometryError: the scene has changed.

        >>> scene_graph = SceneGraph()
        >>> joints = Joints.of(load_scene('scenes/two_pandas.yaml', scene_graph))
        >>> start = [0, -0.7854, 0, -2.3562, 0, 1.5707, 0.7854, 0.04] * 2
        >>> end = [0.1, -0.7, 0, -2.3, 0, 1.5, 0.7, 0.04] * 2
        >>> path_clearance(Checker(scene_graph, joints), [start, end]).gradient.shape
        (1, 8, 2, 16)
    """
    if not isinstance(pieces, int) or pieces < 1:
        raise ArgumentError(f'pieces={pieces!r} must be an integer >= 1')
    points = _way_points(checker, path)
    if spline is not None:
        return _of_spline(checker, points, pieces, spline)
    steps = np.diff(points, axis=0)
    times = np.arange(pieces) / pieces
    inner = points[:-1, None] + times[:, None] * steps[:, None]
    states = np.vstack((inner.reshape(-1, points.shape[1]), points[-1:]))
    clearance, gradients = checker.clearance_and_gradient(states)
    motions, slopes = _motions(checker, steps / pieces)
    first = np.arange(len(states) - 1).reshape(len(steps), pieces)
    bounds = 0.5 * (clearance[first] + clearance[first + 1] - motions[:, None])
    g, h, t = gradients[first], gradients[first + 1], times[:, None]
    later = t + 1.0 / pieces
    slopes = slopes[:, None] / pieces
    by_start = 0.5 * ((1.0 - t) * g + (1.0 - later) * h + slopes)
    by_end = 0.5 * (t * g + later * h - slopes)
    return PathClearance(bounds, np.stack((by_start, by_end), axis=2), clearance)


def _of_spline(
    checker: Checker, points: Floats, pieces: int, spline: ClampedCubicSpline
) -> PathClearance:
    """Return the bounds of a path (k, c) along a spline, with derivatives by all way points."""
    if len(spline.times) != len(points):
        raise ArgumentError(
            f'the spline has {len(spline.times)} times and path {len(points)} way points; give '
            'each a time'
        )
    travel = spline.travel(points, pieces)
    _refuse_overshoot(checker, travel)
    weights = spline.weights(pieces)  # (m + 1, k)
    clearance, gradients = checker.clearance_and_gradient(weights @ points)
    motions, slopes = _motions(checker, travel.length.reshape(-1, points.shape[1]))
    bounds = 0.5 * (clearance[:-1] + clearance[1:] - motions)
    by_states = weights[:, :, None] * gradients[:, None]  # (m + 1, k, c)
    by_travel = travel.slopes.reshape(-1, *points.shape) * slopes[:, None]
    gradient = 0.5 * (by_states[:-1] + by_states[1:] - by_travel)
    shape = len(points) - 1, pieces
    return PathClearance(bounds.reshape(shape), gradient.reshape(*shape, *points.shape), clearance)


def _refuse_overshoot(checker: Checker, travel: Travel) -> None:
    """Raise ArgumentError where a spline leaves the limits of a joint between way points."""
    joints = checker.joints
    beyond = np.flatnonzero((travel.lowest < joints.lower) | (travel.highest > joints.upper))
    if beyond.size:
        k = int(beyond[0])
        raise ArgumentError(
            f'between way points {joints.names[k]} goes from {travel.lowest[k]:.6g} to '
            f'{travel.highest[k]:.6g}, outside its limits [{joints.lower[k]:.6g}, '
            f'{joints.upper[k]:.6g}], within which bounds hold; keep way points away from limits'
        )


class PathClearanceConstraint(Constraint):
    """Keeps a path certified to be clear, between its way points, too.

    Values are all way points in a row, ``path.ravel()``; outputs are the lower bounds [m] of
    ``path_clearance``, which have to be at least ``bound``. A path that satisfies it is proved.

    Args:
        checker: a ``batch.Checker``.
        way_points: their number, at least 2.
        bound: [m] smallest allowed distance.
        pieces: states per edge.
        spline: as in ``path_clearance``.

    Raises:
        ArgumentError: values out of range.
    """

    def __init__(
        self,
        checker: Checker,
        way_points: int,
        bound: float,
        pieces: int = 8,
        *,
        spline: ClampedCubicSpline | None = None,
    ) -> None:
        """Prepare the constraint; see the class."""
        number = as_number(bound)
        if way_points < 2 or pieces < 1 or number is None or not np.isfinite(number):
            raise ArgumentError(
                f'way_points={way_points!r} must be >= 2, pieces={pieces!r} >= 1, and '
                f'bound={bound!r} a finite number, in metres'
            )
        self.checker, self._shape, self._pieces = checker, (way_points, -1), pieces
        self._spline = spline
        limits = np.full((way_points - 1) * pieces, number)
        super().__init__(way_points * checker.joints.count, limits, np.full_like(limits, np.inf))

    def value_and_jacobian(self, q: ArrayLike) -> tuple[Floats, Floats]:
        """Return the outputs (e s,) and their derivatives (e s, n); see ``Constraint``."""
        values = np.asarray(q, dtype=np.float64)
        if values.shape != (self._columns,):
            raise ArgumentError(f'q has the shape {values.shape}; it must be ({self._columns},)')
        points = values.reshape(self._shape)
        bounds = path_clearance(self.checker, points, self._pieces, spline=self._spline)
        if self._spline is not None:
            return bounds.lower_bound.ravel(), bounds.gradient.reshape(-1, values.size)
        edges, pieces, _, columns = bounds.gradient.shape
        jacobian = np.zeros((edges, pieces, edges + 1, columns))
        every = np.arange(edges)
        jacobian[every, :, every] = bounds.gradient[:, :, 0]
        jacobian[every, :, every + 1] = bounds.gradient[:, :, 1]
        return bounds.lower_bound.ravel(), jacobian.reshape(edges * pieces, -1)


def _way_points(checker: Checker, path: ArrayLike) -> Floats:
    """Return way points (k, c); raises ArgumentError for others."""
    points, joints = np.array(path, dtype=np.float64), checker.joints
    if points.ndim != 2 or points.shape[1] != joints.count or len(points) < 2:
        raise ArgumentError(
            f'path has the shape {points.shape}; it must be (k, {joints.count}) with k >= 2, one '
            f'value each for {", ".join(joints.names)}'
        )
    beyond = np.argwhere((points < joints.lower) | (points > joints.upper)).tolist()
    if beyond:
        row, k = beyond[0]
        raise ArgumentError(
            f'way point {row}: {joints.names[k]} = {points[row, k]:.6g} is outside its limits '
            f'[{joints.lower[k]:.6g}, {joints.upper[k]:.6g}], within which bounds hold'
        )
    return points


def _motions(checker: Checker, steps: Floats) -> tuple[Floats, Floats]:
    """Return bounds (e,) [m] of the change of the clearance over steps (e, c), and derivatives."""
    rates = np.unique(checker.distance_rates, axis=0)
    sizes = np.abs(steps)
    with np.errstate(invalid='ignore'):
        products = np.where(sizes[:, None] > 0.0, sizes[:, None] * rates, 0.0).sum(axis=2)
    fastest = np.argmax(products, axis=1)
    motions = products[np.arange(len(steps)), fastest]
    slopes = np.where(np.isfinite(motions)[:, None], rates[fastest] * np.sign(steps), 0.0)
    return motions, slopes
