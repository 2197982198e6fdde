"""sensor_msgs/Range messages to points on the cap of the cone in which the echo arose."""

from __future__ import annotations

import math

import numpy as np

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.conversions.message_types import RangeMessage
from drake_geom_ros.math.array_types import Floats

_MOST_POINTS = 1_000_000


def points_of_range(message: RangeMessage, spacing: float, no_echo: float = math.nan) -> Floats:
    """Return points (n, 3) [m] of a Range in its frame, no more than ``spacing`` [m] apart.

    The sensor looks along x, and the echo may come from anywhere on the cap of the cone of its
    ``field_of_view`` at the measured distance: the points cover that cap. A range of -inf is
    something nearer than ``min_range``, which counts as its distance. A range of inf is no echo
    (REP 117): the cap is at the distance ``no_echo`` [m], and NaN has no points. Raises
    ArgumentError for limits that are none, and for a range that is none: NaN, or not between the
    limits.
    """
    least, most, fov = message.min_range, message.max_range, message.field_of_view
    if not 0.0 <= least <= most < math.inf:
        raise ArgumentError(
            f'min_range is {least:g} and max_range is {most:g}; they must be finite lengths [m], '
            'the first one no larger'
        )
    if not 0.0 <= fov <= 2.0 * math.pi:
        raise ArgumentError(f'field_of_view is {fov}; it must be from 0 to 2 pi [rad]')
    if message.range == math.inf:
        return np.zeros((0, 3)) if math.isnan(no_echo) else _cap(no_echo, 0.5 * fov, spacing)
    distance = least if message.range == -math.inf else message.range
    if not least <= distance <= most:
        raise ArgumentError(
            f'range is {message.range}; it must be inf, -inf, or from min_range {least:g} to '
            f'max_range {most:g} [m]'
        )
    return _cap(float(distance), 0.5 * float(fov), spacing)


def _cap(radius: float, angle: float, spacing: float) -> Floats:
    """Return points (n, 3) [m] of the cap of a sphere up to an angle [rad] from the x axis."""
    rings = math.ceil(angle * radius / spacing) + 1
    angles = np.linspace(0.0, angle, rings)
    around = np.ceil(2.0 * math.pi * radius * np.sin(angles) / spacing).astype(np.int64)
    around = np.maximum(around, 1)
    if around.sum() > _MOST_POINTS:
        raise ArgumentError(
            f'an echo at {radius:g} m in a field_of_view of {2.0 * angle:g} rad has '
            f'{around.sum()} points {spacing:g} m apart; at most {_MOST_POINTS} are made: choose '
            'a larger resolution'
        )
    ring = np.repeat(np.arange(rings), around)
    number = np.arange(len(ring)) - np.repeat(np.cumsum(around) - around, around)
    turns = 2.0 * math.pi * number / around[ring]
    across = np.sin(angles[ring])
    unit = np.stack([np.cos(angles[ring]), across * np.cos(turns), across * np.sin(turns)], axis=1)
    return np.asarray(radius * unit)
