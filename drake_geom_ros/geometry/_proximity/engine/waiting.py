"""Count of the pairs that queries omit because geometries lack a pose."""

from __future__ import annotations

import numpy as np

from drake_geom_ros.geometry._proximity.filters.state import FilterState
from drake_geom_ros.geometry._proximity.world.world import World


def count_waiting_pairs(world: World, filters: FilterState) -> int:
    """Return the number of unfiltered pairs with a geometry that waits for a first pose.

    Their distances are unknown, so no cutoff applies.
    """
    if not world.waiting.any():
        return 0
    slots = filters.slots(world.geometries.ids)
    count = 0
    # One geometry at a time: a scene that waits as a whole may have millions of pairs.
    partners = np.ones(world.geometry_count, dtype=np.bool_)
    for waiting in np.flatnonzero(world.waiting).tolist():
        partners[waiting] = False
        rows = np.flatnonzero(partners)
        slot = np.full(len(rows), slots[waiting])
        count += int(np.count_nonzero(filters.mask(slot, slots[rows])))
    return count
