"""A path of joint values: straight from row to row, or along a polynomial for each value."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.motion.arrays import CURVE_WIDTH

Floats = NDArray[np.float64]


class JointPath(NamedTuple):
    """Rows (k, c) of joint values, and the curves (k - 1, CURVE_WIDTH, c) between them.

    With ``curves`` of no edges, (0, CURVE_WIDTH, c), all edges are straight. On a curved edge a
    value is ``row + s a[0] + s^2 a[1] + ... + s^5 a[4]`` at s from 0 to 1. After these five
    coefficients come bounds over the edge: of the first derivative and of the second one in s, of
    the size of the value, and of the rounding of the sum. The value at s = 1 is the next row.

    ``times`` (k,) [s], never descending, are when each row is reached. They matter to pairs that
    may approach each other by themselves meanwhile; within an edge time is linear in s.
    """

    rows: Floats
    curves: Floats
    times: Floats

    @classmethod
    def straight(cls, rows: Floats) -> JointPath:
        """Return the path that is straight from row to row."""
        return cls(rows, np.zeros((0, CURVE_WIDTH, rows.shape[1])), np.zeros(len(rows)))

    def is_still(self, first: int, last: int) -> bool:
        """Return whether no value changes from row ``first`` to row ``last``."""
        moves = (self.rows[first : last + 1] != self.rows[first]).any()
        return not (moves or self.curves[first:last, :5].any())


NO_VALUES = JointPath.straight(np.zeros((2, 0)))  # of a motion of frames
