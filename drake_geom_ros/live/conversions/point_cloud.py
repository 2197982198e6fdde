"""PointCloud2 messages to arrays."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.live.conversions.message_types import (
    CloudMessage,
    PointFieldMessage,
)
from drake_geom_ros.math.array_types import Floats

Columns = tuple[NDArray[Any], NDArray[Any], NDArray[Any]]

_MOST_FIELDS = 1000
_FORMATS = {7: 'f4', 8: 'f8'}  # sensor_msgs/PointField: FLOAT32, FLOAT64


def points_from_cloud(message: CloudMessage) -> Floats:
    """Return the points (n, 3) of a PointCloud2, in its order; some may not be finite.

    Raises ArgumentError as ``columns_of_cloud`` does.
    """
    columns = columns_of_cloud(message)
    points = np.empty((*columns[0].shape, 3))
    with np.errstate(invalid='ignore'):  # there are NaNs that warn when they are widened
        for k, column in enumerate(columns):
            points[..., k] = column
    return points.reshape(-1, 3)


def columns_of_cloud(message: CloudMessage) -> Columns:
    """Return x, y and z (height, width) of a PointCloud2, float32 or float64, as they lie there.

    Takes any point_step, row_step, byte order and offsets; x, y and z are FLOAT32 or FLOAT64.
    Raises ArgumentError for a cloud without them, or with less or more data than it says.
    """
    fields = _coordinates(message)
    order = '>' if message.is_bigendian else '<'
    formats = []
    for axis in 'xyz':
        field = fields[axis]
        if field.datatype not in _FORMATS or field.count > 1:
            raise ArgumentError(
                f'field {axis} has datatype {field.datatype} and count {field.count}; it must be '
                'one FLOAT32 (7) or FLOAT64 (8)'
            )
        formats.append(order + _FORMATS[field.datatype])
    width, height = message.width, message.height
    try:
        point = np.dtype(
            {
                'names': ['x', 'y', 'z'],
                'formats': formats,
                'offsets': [fields[axis].offset for axis in 'xyz'],
                'itemsize': message.point_step,
            }
        )
    except (ValueError, OverflowError) as error:
        raise ArgumentError(f'point_step {message.point_step}: {error}') from None
    # Of a single row some senders tell no row_step.
    length = width * message.point_step
    row_step = message.row_step if height > 1 else max(message.row_step, length)
    needed = row_step * (height - 1) + length if height and width else 0
    if row_step < length or len(message.data) < needed:
        raise ArgumentError(
            f'data holds {len(message.data)} bytes; {height} rows of {width} points with '
            f'point_step {message.point_step} and row_step {message.row_step} do not fit in it'
        )
    if len(message.data) > height * row_step:
        raise ArgumentError(
            f'data holds {len(message.data)} bytes; {height} rows with row_step {row_step} have '
            f'{height * row_step}; it may hold no more'
        )
    strides = (row_step, message.point_step)
    if not needed:
        none = np.zeros((0, 0))
        return none, none, none
    cloud = np.ndarray((height, width), point, memoryview(message.data), strides=strides)
    return cloud['x'], cloud['y'], cloud['z']


def _coordinates(message: CloudMessage) -> dict[str, PointFieldMessage]:
    """Return the fields x, y and z; raises ArgumentError where one is missing or not alone."""
    refuse_too_many_fields(len(message.fields))
    names = [field.name for field in message.fields]
    if missing := [axis for axis in 'xyz' if axis not in names]:
        raise ArgumentError(
            f'fields lacks {", ".join(missing)}; it has {", ".join(names)[:200] or "none"}'
        )
    # Others may be padding, which is called alike.
    if twice := [axis for axis in 'xyz' if names.count(axis) > 1]:
        raise ArgumentError(
            f'fields has {", ".join(twice)} more than once: {", ".join(names)[:200]}; x, y and z '
            'must be there once each'
        )
    return {field.name: field for field in message.fields if field.name in ('x', 'y', 'z')}


def refuse_too_many_fields(count: int) -> None:
    """Raise ArgumentError for a cloud with more fields than are read."""
    if count > _MOST_FIELDS:
        raise ArgumentError(f'it has {count} fields; at most {_MOST_FIELDS} are read')
