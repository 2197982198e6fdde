"""Maps of what sensors saw, in scene files: of a file beside it, or written out."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Callable, Mapping
from typing import Any

from drake_geom_ros.geometry import OccupiedCells, PointCloud, Shape
from drake_geom_ros.scene_files.packed_rows import numbers_of
from drake_geom_ros.sensed_maps import read_map

CELLS, POINTS = 'occupied_cells', 'point_cloud'
KINDS = (CELLS, POINTS)
_MOST_ROWS = 2000  # that are written as lists; of more a reader of YAML would take seconds


def map_of(plain: Mapping[str, Any], find_file: Callable[[str], str]) -> Shape:
    """Return the map that keys of a shape describe; ``find_file`` gives the path of a URI.

    Raises MapError or ValueError for a file that holds none, and for numbers that are none.
    """
    resolution = plain.get('resolution')
    if plain['type'] == CELLS:
        if 'centres' in plain:
            return OccupiedCells(plain['resolution'], numbers_of(plain['centres'], '<f8'))
        cells = read_map(find_file(plain['uri'])).as_cells(resolution)
        return OccupiedCells(cells.resolution, cells.centres())
    if 'positions' in plain:
        return PointCloud(plain['radius'], numbers_of(plain['positions'], '<f8'))
    read = read_map(find_file(plain['uri']))
    points = read.points if resolution is None else read.as_cells(resolution).centres()
    return PointCloud(plain['radius'], points)


def plain_map(shape: OccupiedCells | PointCloud) -> dict[str, Any]:
    """Return the keys of a map, with all of its numbers."""
    if isinstance(shape, OccupiedCells):
        size, rows, key = {'resolution': shape.resolution()}, shape.centres(), 'centres'
        kind = CELLS
    else:
        size, rows, key = {'radius': shape.radius()}, shape.positions(), 'positions'
        kind = POINTS
    if len(rows) <= _MOST_ROWS:
        return {'type': kind, **size, key: rows.tolist()}
    return {'type': kind, **size, key: b64encode(rows.astype('<f8').tobytes()).decode()}
