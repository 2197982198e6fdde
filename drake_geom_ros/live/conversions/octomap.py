"""octomap_msgs/Octomap to cells."""

from __future__ import annotations

from drake_geom_ros.live.conversions.message_types import OctomapMessage
from drake_geom_ros.sensed_maps.cells import Cells, MapError, check_resolution
from drake_geom_ros.sensed_maps.octree import (
    bytes_a_node,
    cells_of_binary,
    cells_of_full,
    check_kind,
)

MOST_NODES = 3_000_000  # of a tree in a message: reading it costs a microsecond a node


def refuse_too_many_nodes(message: OctomapMessage, most: int = MOST_NODES) -> None:
    """Raise MapError for a tree of more nodes than are taken, before any is read."""
    each = bytes_a_node(message.id, binary=message.binary)
    if len(message.data) > most * each:
        raise MapError(
            f'data holds {len(message.data)} bytes; at most {most * each} are taken, {most} nodes '
            f'of {each} bytes'
        )


def cells_from_octomap(message: OctomapMessage) -> Cells:
    """Return the occupied cells of an Octomap, binary or full, in its frame.

    They may be none: a tree has no leaves but where a sensor looked. Raises MapError for bytes
    that are no tree, for a tree without leaves, for a kind of tree that is not read and for a
    resolution that is none.
    """
    check_kind(message.id)
    check_resolution(message.resolution)
    data = memoryview(message.data).cast('B')
    if not len(data):
        raise MapError('the tree has no leaves: it shows nothing')
    if message.binary:
        return cells_of_binary(data, message.resolution)
    return cells_of_full(data, message.resolution, message.id)
