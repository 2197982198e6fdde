"""nav_msgs/OccupancyGrid messages to cells."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.conversions.fields import pose_from_message
from drake_geom_ros.live.conversions.message_types import GridMessage
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.tolerances import OUT_OF_PLANE
from drake_geom_ros.sensed_maps.cells import MOST_CELLS, Cells, check_resolution

MOST_IN_GRID = 50_000_000  # cells of a message, occupied or not


class GridCells(NamedTuple):
    """The occupied cells of a grid: cubes that its plane cuts in the middle."""

    cells: Cells  # in a frame M, whose x and y axes are the grid's
    X_FM: RigidTransform  # in the frame of the message
    corners: tuple[tuple[float, float], ...]  # (4, 2) [m] of the grid, in M


def cells_from_grid(grid: GridMessage, threshold: int, *, unknown_is_free: bool) -> GridCells:
    """Return the cells of an OccupancyGrid with at least the value ``threshold``.

    Unknown cells (negative) are occupied, too, unless ``unknown_is_free``. Raises ArgumentError
    for sizes and values that are none, for too many cells, and for a grid that shows nothing: one
    without cells, or one with unknown cells alone where these are free.
    """
    info, count = grid.info, len(grid.data)
    width, height, resolution = int(info.width), int(info.height), float(info.resolution)
    check_resolution(resolution)
    if count != width * height or not 0 < count <= MOST_IN_GRID:
        raise ArgumentError(
            f'data has {count} cells, and the grid is {width} by {height}; both must be the same '
            f'number, from 1 to {MOST_IN_GRID}'
        )
    values = np.asarray(grid.data, dtype=np.int8)
    if values.max() > 100:
        raise ArgumentError(f'a cell has the value {values.max()}; it must be at most 100')
    unknown = values < 0
    if unknown_is_free and unknown.all():
        raise ArgumentError('all cells of the grid are unknown: it shows nothing')
    occupied = values >= threshold
    if not unknown_is_free:
        occupied |= unknown
    places = np.flatnonzero(occupied)
    if len(places) > MOST_CELLS:
        raise ArgumentError(
            f'the grid has {len(places)} occupied cells, {np.count_nonzero(unknown)} of them '
            f'unknown; at most {MOST_CELLS} are taken'
        )
    keys = np.stack([places % width, places // width, np.zeros_like(places)], axis=1)
    X_FM = pose_from_message(info.origin) @ RigidTransform([0.0, 0.0, -0.5 * resolution])
    ends = width * resolution, height * resolution
    corners = tuple((x, y) for x in (0.0, ends[0]) for y in (0.0, ends[1]))
    return GridCells(Cells.of_keys(keys, resolution), X_FM, corners)


def extruded(cells: Cells, X_WM: RigidTransform, low: float, high: float) -> Cells:
    """Return cells and those above and below them at heights from low to high [m] in the world.

    Raises ArgumentError where the z axis of their frame M does not point up.
    """
    tilt = math.acos(min(1.0, float(X_WM.rotation().matrix()[2, 2])))
    if tilt > OUT_OF_PLANE:
        raise ArgumentError(
            f'the grid is tilted by {math.degrees(tilt):.3g} degrees, and columns stand upright; '
            'leave extrude out, or send it in a frame that is level'
        )
    height = float(X_WM.translation()[2])
    return cells.extruded(low - height, high - height)
