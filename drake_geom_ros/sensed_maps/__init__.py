"""Maps from sensors, as points or cells of a grid: files, octrees, downsampling, ages.

=================  ===========================================================================
``cells``          occupied cells of a grid by their keys: from points, downsampled, joined
``octree``         OctoMap's trees as bytes, binary and full, from and to cells
``octree_file``    files of such trees, ``.bt`` and ``.ot``
``pcd_file``       point clouds of PCL, ``.pcd``
``map_files``      all formats by suffix, as commands and scene files read and write them
``keeping``        the cells that stay from one cloud to the next, and until when
=================  ===========================================================================

Points are (n, 3) [m], times [s]. Files are checked before memory is allocated for them.
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
