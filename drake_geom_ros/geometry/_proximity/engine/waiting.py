"""Count of the pairs that queries omit because geometries lack a pose."""

from __future__ import annotations

from drake_geom_ros.geometry._proximity.filters.matrix import count_lacking
from drake_geom_ros.geometry._proximity.filters.state import FilterState
from drake_geom_ros.geometry._proximity.world.world import World


def count_waiting_pairs(world: World, filters: FilterState) -> int:
    """Return the number of unfiltered pairs with a geometry that waits for a first pose.

    Their distances are unknown, so no cutoff applies.
    """
    if world.is_whole:
        return 0
    slots = filters.slots(world.geometries.ids)
    return int(count_lacking(*filters.matrix, slots, world.unplaced()))
