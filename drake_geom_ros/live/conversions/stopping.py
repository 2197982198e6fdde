"""Answers about stops to messages."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from drake_geom_ros.live.conversions.fields import floats, uint32s, unsigned
from drake_geom_ros.stopping import Stop

_NUMBERS = (
    *('scale', 'stopping_time', 'stopping_distance', 'least_clearance', 'contact_time'),
    *('reaction_time', 'oldest_pose_age'),
)


def fill_speed_limits(message: Any, stops: Mapping[str, Stop]) -> None:
    """Fill a SpeedLimits message, but for its header, with answers by rule."""
    message.rules = list(stops)
    for field in ('linear', 'angular'):
        setattr(message, field, _column(stops, field))


def fill_stopping(message: Any, stops: Mapping[str, Stop], names: Callable[[int], str]) -> None:
    """Fill a Stopping message, but for its header, with answers by rule.

    ``names`` maps ids of geometries to names.
    """
    message.rules = list(stops)
    message.clear = [stop.clear for stop in stops.values()]
    message.trouble = [stop.trouble for stop in stops.values()]
    for field in _NUMBERS:
        setattr(message, field, _column(stops, field))
    for end, field in (('a', 'id_A'), ('b', 'id_B')):
        ids = [getattr(stop, field) for stop in stops.values()]
        setattr(message, f'id_{end}', unsigned(np.array(ids, dtype=np.int64)))
        setattr(message, f'geometry_{end}', [names(id) if id else '' for id in ids])
    for field in ('pairs', 'far_pairs'):
        counts = [getattr(stop, field) for stop in stops.values()]
        setattr(message, field, uint32s(np.array(counts, dtype=np.int64)))


def _column(stops: Mapping[str, Stop], field: str) -> Any:
    return floats(np.array([getattr(stop, field) for stop in stops.values()], dtype=np.float64))
