"""Smooth curves through timed waypoints that never leave the range of their neighbours."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.math.array_types import Floats


class MonotoneCubic:
    """A C1 curve through waypoints, monotone between neighbours, with zero slope at both ends.

    Piecewise cubic Hermite with the slopes of Fritsch and Butland (SIAM J. Sci. Stat. Comput. 5,
    1984): the weighted harmonic mean of the neighbouring secants, zero where they differ in sign.
    Such a curve never overshoots: waypoints within the joint limits keep the whole curve within
    them, and equal neighbours keep the joint exactly still between them.

    >>> curve = MonotoneCubic([0.0, 1.0, 2.0], [[0.0], [1.0], [1.0]])
    >>> curve.value([0.0, 0.5, 1.5]).ravel().tolist()
    [0.0, 0.5, 1.0]
    """

    def __init__(self, times: ArrayLike, values: ArrayLike):
        """Make a curve through values (k, m) at strictly increasing times (k,) [s]."""
        self.times = np.array(times, dtype=float)
        self.values = np.array(values, dtype=float)
        if self.times.ndim != 1 or self.times.size < 2:
            raise ValueError(f'a curve needs two or more waypoint times, got {times!r}')
        if self.values.ndim != 2 or len(self.values) != len(self.times):
            raise ValueError(
                f'values must have shape ({len(self.times)}, m), got {self.values.shape}'
            )
        if not (np.isfinite(self.times).all() and np.isfinite(self.values).all()):
            raise ValueError('waypoint times and values must be finite')
        if not (np.diff(self.times) > 0).all():
            raise ValueError(f'waypoint times must increase strictly, got {self.times.tolist()}')
        self._slopes = _fritsch_butland_slopes(self.times, self.values)

    def value(self, t: ArrayLike) -> Floats:
        """Return the curve (..., m) at times t (...) [s]; before and after it, its ends."""
        segment, s = self.locate(t)
        h = np.diff(self.times)[segment][..., None]
        y0, y1 = self.values[segment], self.values[segment + 1]
        m0, m1 = h * self._slopes[segment], h * self._slopes[segment + 1]
        shape = s * s * (3.0 - 2.0 * s)
        bend = s * (1.0 - s) * ((1.0 - s) * m0 - s * m1)
        # The clip removes rounding only, so that constant values stay exactly constant.
        y = (1.0 - shape) * y0 + shape * y1 + bend
        return np.asarray(np.clip(y, np.minimum(y0, y1), np.maximum(y0, y1)))

    def max_speed(self) -> Floats:
        """Return the largest absolute rate of change of each of the m values (m,) [1/s].

        The rate of a segment is a parabola in s: its extremes are at the ends and the vertex.
        """
        h = np.diff(self.times)[:, None]
        secant = np.diff(self.values, axis=0) / h
        m0, m1 = self._slopes[:-1], self._slopes[1:]
        square = 3.0 * (m0 + m1) - 6.0 * secant  # rate(s) = square s^2 + linear s + m0
        linear = 6.0 * secant - 4.0 * m0 - 2.0 * m1
        straight = square == 0.0
        vertex = np.clip(
            np.where(straight, 0.0, -linear / np.where(straight, 1.0, 2 * square)), 0, 1
        )
        rates = [np.abs(m0), np.abs(m1), np.abs((square * vertex + linear) * vertex + m0)]
        return np.asarray(np.max(rates, axis=(0, 1)))

    def locate(self, t: ArrayLike) -> tuple[NDArray[np.intp], Floats]:
        """Return the segments (...) of times t (...), and positions in them (..., 1) in [0, 1]."""
        t = np.clip(np.asarray(t, dtype=float), self.times[0], self.times[-1])
        segment = np.searchsorted(self.times, t, side='right') - 1
        segment = np.minimum(segment, len(self.times) - 2)
        h = self.times[segment + 1] - self.times[segment]
        return segment, np.asarray((t - self.times[segment]) / h)[..., None]


def _fritsch_butland_slopes(times: Floats, values: Floats) -> Floats:
    """Return the slope at every waypoint (k, m), zero at the ends."""
    h = np.diff(times)[:, None]
    secants = np.diff(values, axis=0) / h
    before, after = secants[:-1], secants[1:]
    w_before, w_after = h[:-1] + 2.0 * h[1:], 2.0 * h[:-1] + h[1:]
    slopes = np.zeros_like(values)
    # The slope is also zero where the product of small secants underflows.
    same = before * after > 0.0
    mean = w_before * after + w_after * before
    slopes[1:-1][same] = ((w_before + w_after) * before * after)[same] / mean[same]
    return slopes
