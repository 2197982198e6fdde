"""Sensed maps in scene files, read from a file of their own or written out."""

from __future__ import annotations

import math
from base64 import b64decode, b64encode
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from drake_geom_ros.common.counting import are, counted
from drake_geom_ros.geometry import OccupiedCells, PointCloud, Shape
from drake_geom_ros.sensed_maps import MapError, MapFile, read_map

CELLS, POINTS = 'occupied_cells', 'point_cloud'
KINDS = (CELLS, POINTS)
_MOST_ROWS = 2000  # written as lists; a YAML reader would take seconds for more


def map_of(
    plain: Mapping[str, Any], find_file: Callable[[str], str], warn: Callable[[str], None]
) -> Shape:
    """Return the map that the keys of a shape describe.

    ``find_file`` returns the path of a URI, and ``warn`` is called with a text about skipped
    points. Raises MapError or ValueError for a file without a map, for invalid numbers, and for
    balls that are too small for the cells that their points were moved to.
    """
    resolution = plain.get('resolution')
    if plain['type'] == CELLS:
        if 'centres' in plain:
            return OccupiedCells(plain['resolution'], numbers_of(plain['centres'], '<f8'))
        cells = _read(find_file(plain['uri']), warn).as_cells(resolution)
        return OccupiedCells(cells.resolution, cells.centres())
    radius = plain['radius']
    if 'positions' in plain:
        return PointCloud(radius, numbers_of(plain['positions'], '<f8'))
    read = _read(find_file(plain['uri']), warn)
    if read.cells is None and resolution is None:
        return PointCloud(radius, read.points)
    cells = read.as_cells(resolution)
    _refuse_balls_within_cells(radius, cells.resolution)
    return PointCloud(radius, cells.centres())


def _read(path: str, warn: Callable[[str], None]) -> MapFile:
    read = read_map(path)
    if n := read.left_out:
        warn(f'{counted(n, "point")} of {path!r} {are(n)} not finite and left out')
    return read


def _refuse_balls_within_cells(radius: float, resolution: float) -> None:
    """Raise MapError for balls that do not reach the corners of their cells.

    Otherwise points measured in the corners would count as free.
    """
    reach = 0.5 * math.sqrt(3.0) * resolution
    if radius < reach:
        raise MapError(
            f'radius is {radius!r} m, and the balls are at the centres of cells of '
            f'{resolution:g} m, in whose corners something may have been measured: it must be at '
            f'least {1.001 * reach:.4g} m'
        )


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


def numbers_of(plain: Any, kind: str) -> Any:
    """Return rows (n, 3) that are listed, or packed as base64; ValueError for invalid text."""
    if not isinstance(plain, str):
        return plain
    try:
        return np.frombuffer(b64decode(plain, validate=True), kind).reshape(-1, 3)
    except ValueError as error:
        raise ValueError(f'rows of three {kind} are packed as base64: {error}') from None
