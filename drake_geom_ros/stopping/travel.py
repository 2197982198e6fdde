"""How far bodies go, and how fast, while the columns of a stop do."""

from __future__ import annotations

import numpy as np

from drake_geom_ros.geometry.queries.joint_trees import JointChain, JointKind
from drake_geom_ros.geometry.queries.motion_queries import MotionQueries
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.stopping.robots import Columns
from drake_geom_ros.stopping.stop_paths import StopProfile, unit_path


class BodyTravel:
    """Certified bounds of the way and the speed of all points of geometries, in the world."""

    def __init__(self, queries: MotionQueries, columns: Columns) -> None:
        self._queries, self._has_base = queries, max(columns.bases, default=-1) >= 0
        # (n, c) [m] how far points of each geometry go for a unit of each column, and the values
        # for which that holds.
        self._levers: tuple[Floats, Floats] | None = None

    def of(self, chain: JointChain, values: Floats, profile: StopProfile, share: float) -> Floats:
        """Return the way (n,) [m] of geometries in the stop from a share of the present speed."""
        levers = self._levers_at(chain, values, profile)
        return _moved(levers, np.abs(profile.travel(share)))

    def speeds(
        self, chain: JointChain, values: Floats, profile: StopProfile, share: float
    ) -> Floats:
        """Return the speeds (n,) [m/s] of geometries at a share of the present speed."""
        levers = self._levers_at(chain, values, profile)
        return _moved(levers, share * np.abs(profile.velocities))

    def _levers_at(self, chain: JointChain, values: Floats, profile: StopProfile) -> Floats:
        """Return levers (n, c); those of joints that only turn do not depend on values."""
        known = self._levers
        depends = self._has_base or bool((chain.kinds == JointKind.PRISMATIC).any())
        if known is None or (depends and known[1] is not values):
            self._queries.drive_by(chain)
            sizes = np.abs(np.nan_to_num(values)) + np.abs(profile.travel(profile.fastest))
            known = self._levers = self._queries.speeds(unit_path(sizes)).T, values
        return known[0]


def _moved(levers: Floats, ways: Floats) -> Floats:
    """Return how far (n,) [m] points go; a column that stands moves none, of any lever."""
    moves = ways > 0.0
    return np.asarray(levers[:, moves] @ ways[moves])
