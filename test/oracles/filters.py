"""Filters for the small worlds of the tests."""

from drake_geom_ros.geometry._proximity.filter_state import FilterState


def filters_of(world):
    """Return filters that know the world's geometries, each on a frame of its own."""
    filters = FilterState()
    table = world.geometries
    for key, frame, anchored in zip(table.ids, table.frames, world.anchored, strict=True):
        filters.add(int(key), int(frame) + 100, bool(anchored))
    return filters
