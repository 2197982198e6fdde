"""How far bodies go, and how fast, while the columns of a stop do."""

from __future__ import annotations

import numpy as np

from drake_geom_ros.geometry.queries.joint_trees import JointChain, JointKind
from drake_geom_ros.geometry.queries.motion_queries import MotionQueries
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.stopping.robots import Columns
from drake_geom_ros.stopping.stop_paths import StopProfile, unit_path

_GRID = 0.05  # [m] of values of joints that slide


class BodyTravel:
    """Certified bounds of the way and the speed of all points of geometries, in the world."""

    def __init__(self, queries: MotionQueries, columns: Columns) -> None:
        self._queries, self._has_base = queries, max(columns.bases, default=-1) >= 0
        # (n, c) [m] how far points of each geometry go for a unit of each column, and the chain
        # and the sizes of values for which that holds.
        self._levers: tuple[Floats, JointChain, Floats] | None = None

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
        """Return levers (n, c). Those of a robot without a base hold for all values of a grid."""
        sizes = np.abs(np.nan_to_num(values)) + np.abs(profile.travel(profile.fastest))
        slides = chain.leaders[(chain.kinds == JointKind.PRISMATIC) & (chain.leaders >= 0)]
        rounded = np.zeros_like(sizes)  # of values of joints that turn levers do not depend
        rounded[slides] = _GRID * np.ceil(sizes[slides] / _GRID)
        if not self._is_known(chain, rounded):
            self._queries.drive_by(chain)
            self._levers = self._queries.speeds(unit_path(rounded)).T, chain, rounded
        assert self._levers is not None
        return self._levers[0]

    def _is_known(self, chain: JointChain, sizes: Floats) -> bool:
        if self._levers is None or (self._has_base and self._levers[1] is not chain):
            return False  # a base that moves turns about another centre each time
        return bool((self._levers[2] == sizes).all())


def _moved(levers: Floats, ways: Floats) -> Floats:
    """Return how far (n,) [m] points go; a column that stands moves none, of any lever."""
    moves = ways > 0.0
    return np.asarray(levers[:, moves] @ ways[moves])
