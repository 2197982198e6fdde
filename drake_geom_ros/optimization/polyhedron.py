"""``HPolyhedron``: a convex set of linear inequalities, with pydrake's names."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.math.array_types import Floats

_MIXING = 10  # steps of hit and run between two samples, by dimension


class HPolyhedron:
    """The set of all x (n,) with A x <= b, for A (m, n) and b (m,); it never changes.

    Names are those of ``pydrake.geometry.optimization.HPolyhedron``. Raises ArgumentError for
    arrays of other shapes, or with values that are not finite.

        >>> HPolyhedron.MakeBox([0, 0], [1, 2]).PointInSet([0.5, 1.5])
        True
    """

    def __init__(self, A: ArrayLike, b: ArrayLike) -> None:
        """Take the inequalities."""
        self._A, self._b = np.array(A, dtype=np.float64), np.array(b, dtype=np.float64)
        if self._A.ndim != 2 or self._b.shape != self._A.shape[:1]:
            raise ArgumentError(
                f'A has the shape {self._A.shape} and b {self._b.shape}; they must be (m, n), (m,)'
            )
        if not np.isfinite(self._A).all() or not np.isfinite(self._b).all():
            raise ArgumentError('A and b must be finite; leave out inequalities without a limit')

    @classmethod
    def MakeBox(cls, lb: ArrayLike, ub: ArrayLike) -> HPolyhedron:
        """Return the box between two corners (n,); raises ArgumentError for crossed ones."""
        lower, upper = np.array(lb, dtype=np.float64), np.array(ub, dtype=np.float64)
        if lower.shape != upper.shape or lower.ndim != 1 or not (lower <= upper).all():
            raise ArgumentError(f'lb={lower.tolist()} must be at most ub={upper.tolist()}')
        eye = np.eye(len(lower))
        return cls(np.vstack((eye, -eye)), np.concatenate((upper, -lower)))

    def A(self) -> Floats:
        """Return the normals (m, n)."""
        return self._A.copy()

    def b(self) -> Floats:
        """Return the offsets (m,)."""
        return self._b.copy()

    def ambient_dimension(self) -> int:
        """Return n."""
        return int(self._A.shape[1])

    def PointInSet(self, x: ArrayLike, tol: float = 0.0) -> bool:
        """Return whether a point (n,) is in the set, up to ``tol`` in each inequality."""
        return bool((self._A @ np.asarray(x, dtype=np.float64) <= self._b + tol).all())

    def Intersection(self, other: HPolyhedron) -> HPolyhedron:
        """Return the points of both sets."""
        return HPolyhedron(np.vstack((self._A, other._A)), np.concatenate((self._b, other._b)))

    def UniformSamples(
        self, generator: np.random.Generator, previous_sample: ArrayLike, count: int
    ) -> Floats:
        """Return nearly uniform samples (count, n) of a bounded set, by hit and run.

        ``previous_sample`` (n,) is a point of the set, where the walk starts. Raises ArgumentError
        for a point that is not in the set, and for a set without a limit along a line.
        """
        point, n = np.array(previous_sample, dtype=np.float64), self.ambient_dimension()
        if not self.PointInSet(point):
            raise ArgumentError(f'previous_sample={point.tolist()} is not in the set')
        samples, values = np.empty((count, n)), self._A @ point
        for k in range(count):
            directions = generator.normal(size=(_MIXING * n, n))
            slopes, places = directions @ self._A.T, generator.uniform(size=_MIXING * n)
            for direction, slope, place in zip(directions, slopes, places, strict=True):
                with np.errstate(divide='ignore', invalid='ignore'):
                    steps = (self._b - values) / slope
                ahead = float(steps[slope > 0.0].min(initial=math.inf))
                behind = float(steps[slope < 0.0].max(initial=-math.inf))
                if not (math.isfinite(ahead) and math.isfinite(behind)):
                    raise ArgumentError('the set has no limit along a line: it has no samples')
                step = behind + place * (ahead - behind)
                point, values = point + step * direction, values + step * slope
            values = self._A @ point  # without the rounding of the sum of steps
            samples[k] = point
        return samples
