"""Measured pairs of a cycle, the input of rule decisions."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.math.array_types import Flags, Floats

Ids = NDArray[np.int64]


class UnseenBodies(NamedTuple):
    """Geometries (n,), by the order of ``WatchedPairs.ids``, that sensors of maps (m,) can see."""

    maps: Ids  # (m,) rows of the maps among the geometries
    is_unseen: Flags  # (m, n) no sensor of the map sees the geometry
    is_reported: Flags  # (m, n) pairs that may be reported


class Measured(NamedTuple):
    """Unfiltered pairs (k,) of a cycle: all within its maximum distance."""

    id_A: Ids
    id_B: Ids
    distance: Floats  # [m]
    error_bound: Floats  # [m]
    p_WCa: Floats  # (k, 3) [m]
    p_WCb: Floats
    closing_speed: Floats | None = None  # [m/s], NaN where unknown; None: not computed
    # (n,) geometries of unknown motion, in the order of ``WatchedPairs.ids``; None: none.
    unpredicted: Flags | None = None
    unseen: UnseenBodies | None = None  # None: nothing is out of the sight of sensors
    # By ``min_points`` of rules: the distances (k,) [m] that count for them, with the same bounds.
    counted: Mapping[int, Floats] = MappingProxyType({})


_NO_IDS, _NO_NUMBERS, _NO_POINTS = np.empty(0, dtype=np.int64), np.empty(0), np.empty((0, 3))
NOTHING = Measured(_NO_IDS, _NO_IDS, _NO_NUMBERS, _NO_NUMBERS, _NO_POINTS, _NO_POINTS)
