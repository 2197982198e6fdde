"""How far bodies go, and how fast, while the columns of a stop do."""

from __future__ import annotations

import numpy as np

from drake_geom_ros.geometry.queries.joint_trees import JointChain, JointKind
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.stopping.moving_pairs import PosedPairs
from drake_geom_ros.stopping.stop_paths import StopProfile, unit_path

_GRID = 0.05  # [m] of values of joints that slide
_MOST_LEVERS = 64  # sets of levers that are kept


class BodyTravel:
    """Certified bounds of the way and the speed of all points of geometries, in the world."""

    def __init__(self, posed: PosedPairs) -> None:
        self._posed = posed
        self._chain: JointChain | None = None
        # By the sizes of values for which they hold: see ``_levers_at``.
        self._levers: dict[bytes, Floats] = {}

    def forget(self) -> None:
        """Compute levers anew: shapes changed."""
        self._levers.clear()

    def of(self, chain: JointChain, values: Floats, profile: StopProfile, share: float) -> Floats:
        """Return the way (n,) [m] of geometries in the stop from a share of the present speed."""
        levers = self._levers_at(chain, values, profile)
        return _moved(levers, np.abs(profile.travel(share)))

    def and_speeds(
        self, chain: JointChain, values: Floats, profile: StopProfile, share: float
    ) -> tuple[Floats, Floats]:
        """Return the way (n,) [m] of geometries in the longest stop that is known.

        Return their speeds (n,) [m/s] at a share of the present speed, too.
        """
        levers = self._levers_at(chain, values, profile)
        ways = _moved(levers, np.abs(profile.travel(profile.fastest)))
        return ways, _moved(levers, share * np.abs(profile.velocities))

    def _levers_at(self, chain: JointChain, values: Floats, profile: StopProfile) -> Floats:
        """Return how far (n, c) [m] points of geometries go for a unit of each column.

        Levers of a robot without a base hold for all values of a grid.
        """
        # A base that moves turns about another centre each time.
        if self._chain is not chain or len(self._levers) >= _MOST_LEVERS:
            self._chain = chain
            self._levers.clear()
        sizes = np.abs(np.nan_to_num(values)) + np.abs(profile.travel(profile.fastest))
        slides = chain.leaders[(chain.kinds == JointKind.PRISMATIC) & (chain.leaders >= 0)]
        rounded = np.zeros_like(sizes)  # of values of joints that turn levers do not depend
        rounded[slides] = _GRID * np.ceil(sizes[slides] / _GRID)
        key = rounded.tobytes()
        levers = self._levers.get(key)
        if levers is None:
            self._posed.drive_by(chain)
            levers = self._levers[key] = self._posed.queries.speeds(unit_path(rounded)).T
        return levers


def _moved(levers: Floats, ways: Floats) -> Floats:
    """Return how far (n,) [m] points go; a column that stands moves none, of any lever."""
    moves = ways > 0.0
    return np.asarray(levers[:, moves] @ ways[moves])
