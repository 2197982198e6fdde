"""LaserScan messages to points, each where its ray ended when it was measured."""

from __future__ import annotations

import math

import numpy as np

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.conversions.message_types import ScanMessage
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.batched import (
    quaternions_from_rotations,
    rotations_from_quaternions,
    slerp,
)

_LONGEST = 10.0  # [s] that a scan may take: no lidar turns as slowly


def points_of_scan(scan: ScanMessage, no_echo: float = math.nan) -> Floats:
    """Return the points (n, 3) [m] of a LaserScan in its frame, as if it had stood still.

    A range of -inf is something nearer than ``range_min``, which counts as its distance (REP 117).
    A ray without an echo (inf) ends at the distance ``no_echo`` [m]; of a range that is not one
    (NaN, below ``range_min``, above ``range_max``) the point is not finite. Raises ArgumentError
    for angles or limits that are no numbers.
    """
    limits = scan.range_min, scan.range_max
    if not (0.0 <= limits[0] <= limits[1] < math.inf):
        raise ArgumentError(
            f'range_min is {limits[0]:g} and range_max is {limits[1]:g}; they must be finite '
            'lengths [m], the first one no larger'
        )
    angles = scan.angle_min, scan.angle_increment
    if not all(map(math.isfinite, angles)):
        raise ArgumentError(
            f'angle_min is {angles[0]} and angle_increment is {angles[1]}; both must be finite'
        )
    ranges = np.asarray(scan.ranges, dtype=np.float64)
    ranges = np.where(np.isneginf(ranges), limits[0], ranges)
    # Limits and ranges are float32 in a message, so both are rounded alike.
    with np.errstate(invalid='ignore'):
        is_one = (ranges >= limits[0]) & (ranges <= limits[1])
    ranges = np.where(is_one, ranges, np.where(np.isposinf(ranges), no_echo, np.nan))
    headings = scan.angle_min + scan.angle_increment * np.arange(len(ranges))
    return np.stack([ranges * np.cos(headings), ranges * np.sin(headings), 0.0 * ranges], axis=1)


def duration_of_scan(scan: ScanMessage) -> float:
    """Return the time [s] from the first ray, which has the stamp, to the last one.

    Raises ArgumentError for a ``time_increment`` that is none.
    """
    duration = float(scan.time_increment) * max(0, len(scan.ranges) - 1)
    if not 0.0 <= duration <= _LONGEST:
        raise ArgumentError(
            f'time_increment is {scan.time_increment:g} s for {len(scan.ranges)} rays; together '
            f'they may take from 0 to {_LONGEST:g} s'
        )
    return duration


def unturned(points: Floats, R_FE: Floats, p_FE: Floats) -> Floats:
    """Return points (n, 3) in the frame F of a sensor when the first of them was measured.

    Each is given in the sensor's frame at its own time, at equal steps until the frame is E. Its
    pose between is that of even turning about one axis, and of even motion of the origin.

    >>> quarter = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    >>> unturned(np.array([[1.0, 0, 0]] * 3), quarter, np.zeros(3)).round(3).tolist()
    [[1.0, 0.0, 0.0], [0.707, 0.707, 0.0], [0.0, 1.0, 0.0]]
    """
    done = np.linspace(0.0, 1.0, len(points))[:, np.newaxis]
    first, last = quaternions_from_rotations(np.stack([np.eye(3), R_FE]))
    R_FSs = rotations_from_quaternions(slerp(first, last, done))
    return np.asarray((R_FSs @ points[:, :, np.newaxis])[:, :, 0] + p_FE * done)
