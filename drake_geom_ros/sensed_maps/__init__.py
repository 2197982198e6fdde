"""What sensors saw, as points or as cells of a grid: files, octrees, thinning, ages.

=================  ===========================================================================
``cells``          a grid's occupied cells by their keys: made of points, thinned, joined
``octree``         OctoMap's trees as bytes, binary and full, to cells and back
``octree_file``    the files of these, ``.bt`` and ``.ot``
``pcd_file``       point clouds of PCL, ``.pcd``
``map_files``      all formats by their suffix: what a command or a scene file reads and writes
``keeping``        which cells are held from one cloud to the next, and until when
=================  ===========================================================================

In: bytes, points (n, 3) [m], times [s].
Out: cells and points, checked before memory is taken for them.
May import: ``math``, ``common``, ``geometry``; numpy.
"""

from drake_geom_ros.sensed_maps.cells import Cells, MapError
from drake_geom_ros.sensed_maps.map_files import (
    CELL_SUFFIXES,
    MAP_SUFFIXES,
    POINT_SUFFIXES,
    MapFile,
    map_bytes,
    read_map,
)

__all__ = [
    'CELL_SUFFIXES',
    'MAP_SUFFIXES',
    'POINT_SUFFIXES',
    'Cells',
    'MapError',
    'MapFile',
    'map_bytes',
    'read_map',
]
