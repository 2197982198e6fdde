"""octomap_msgs/Octomap to cells, no ROS import."""

from __future__ import annotations

from typing import Any

from drake_geom_ros.sensed_maps.cells import Cells, check_resolution
from drake_geom_ros.sensed_maps.octree import cells_of_binary, cells_of_full, check_kind


def cells_from_octomap(message: Any) -> Cells:
    """Return the occupied cells of an Octomap, binary or full, in its frame.

    Raises MapError for bytes that are no tree, for a kind of tree that is not read and for a
    resolution that is none.
    """
    check_kind(message.id)
    check_resolution(message.resolution)
    data = memoryview(message.data).cast('B')
    if message.binary:
        return cells_of_binary(data, message.resolution)
    return cells_of_full(data, message.resolution, message.id)
