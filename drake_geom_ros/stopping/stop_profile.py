"""Times to brake by the share of the present speed, as a question or several ones together say."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from drake_geom_ros.math.array_types import Floats


class StopProfile(NamedTuple):
    """Times [s] that columns (c,) take to brake, by the share of their present speed.

    They are linear between ``shares`` (k,), which ascend from 0; above the last one nothing is
    known. Columns that do not brake have the time 0. ``columns`` (4, c) are the fields below.
    """

    columns: Floats
    shares: Floats
    times: Floats  # (k, c) [s]

    @property
    def velocities(self) -> Floats:
        """Velocities (c,); 0: the column stands."""
        return np.asarray(self.columns[0])

    @property
    def ages(self) -> Floats:
        """Times (c,) [s] for which a column already went on at its velocity."""
        return np.asarray(self.columns[1])

    @property
    def reactions(self) -> Floats:
        """Times (c,) [s] for which a column will go on at its velocity."""
        return np.asarray(self.columns[2])

    @property
    def radii(self) -> Floats:
        """Distances (c,) by which values may deviate from their path."""
        return np.asarray(self.columns[3])

    @property
    def fastest(self) -> float:
        """The largest share that is known."""
        return float(self.shares[-1])

    def times_at(self, share: float) -> Floats:
        """Return the times (c,) to brake from a share."""
        shares, times = self.shares, self.times
        k = min(int(shares.searchsorted(share, 'right')), len(shares) - 1) - 1
        begin, end = shares[k : k + 2].tolist()
        return np.asarray(times[k] + (share - begin) / (end - begin) * (times[k + 1] - times[k]))

    def duration_at(self, share: float) -> float:
        """Return the time [s] from now until all columns stand."""
        moves = self.velocities != 0.0
        return float(np.where(moves, self.reactions + self.times_at(share), 0.0).max(initial=0.0))

    def travel(self, share: float = 1.0) -> Floats:
        """Return how far (c,) [rad] or [m] columns go from their values, with their sign."""
        on = self.reactions + 0.5 * self.times_at(share)
        return np.asarray(self.velocities * (self.ages + share * on))


def joined(profile: StopProfile, other: StopProfile) -> StopProfile:
    """Return the profile of the columns that move in one of two profiles, each by its own."""
    is_other = other.velocities != 0.0
    shares, (own, others) = profile.shares, (profile.times, other.times)
    if not np.array_equal(shares, other.shares):
        shares = np.unique(np.concatenate((shares, other.shares)))
        shares = shares[shares <= min(profile.fastest, other.fastest)]
        own, others = (
            np.array([each.times_at(share) for share in shares.tolist()])
            for each in (profile, other)
        )
    columns = np.where(is_other, other.columns, profile.columns)
    return StopProfile(columns, shares, np.where(is_other, others, own))
