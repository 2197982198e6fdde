"""Bounds of the way and the speed of bodies while the columns of a stop move."""

from __future__ import annotations

import numpy as np

from drake_geom_ros.math.array_types import Flags, Floats
from drake_geom_ros.stopping.moving_pairs import Moment, PosedPairs
from drake_geom_ros.stopping.stop_profile import StopProfile


class BodyTravel:
    """Certified bounds of the way and the speed of all points of geometries, in the world."""

    def __init__(self, posed: PosedPairs) -> None:
        self._posed = posed

    def of(self, moment: Moment, profile: StopProfile, share: float) -> Floats:
        """Return the way (n,) [m] of geometries in the stop from a share of the present speed."""
        self._posed.be_at(moment)
        longest = np.abs(profile.travel(profile.fastest))
        # Values of columns that matter are known: those that are not, count as 0.
        sizes = np.fmax(np.abs(moment.values), 0.0) + longest
        return self._posed.queries.ways(sizes, np.abs(profile.travel(share)))

    def measures(
        self, moment: Moment, profile: StopProfile, share: float, moving: Flags
    ) -> list[float]:
        """Return the time [s] and the way [m] of the longest stop that is known.

        Return the speeds of the fastest point [m/s] and turn [rad/s] at a share of the present
        speed, too. Ways and points are those of geometries (n,) that are ``moving``.
        """
        self._posed.be_at(moment)
        arrays = profile.columns, profile.shares, profile.times
        return self._posed.queries.measures(
            moment.values, arrays, share, moving, self._posed.turns
        )
