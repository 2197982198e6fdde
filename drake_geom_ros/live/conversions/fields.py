"""Fields that many messages have: arrays, times, poses."""

from __future__ import annotations

import array
from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.live.conversions.message_types import (
    PoseMessage,
    TimeMessage,
)
from drake_geom_ros.live.conversions.serialized_results import ResultRecord
from drake_geom_ros.math import RigidTransform

# Bytes that are copied at once: other threads get the interpreter in between. 48 MB, the cells of
# a large map, take 20 to 40 ms.
_AT_ONCE = 1 << 20


def _array(code: str, values: NDArray[Any]) -> array.array[Any]:
    """Return an array field: rclpy takes an array.array as it is, other types item by item."""
    filled = array.array(code)
    filled.frombytes(np.ascontiguousarray(values).data.cast('B') if values.size else b'')
    return filled


def floats(values: NDArray[np.float64]) -> array.array[float]:
    """Return a float64[] field."""
    return _array('d', np.asarray(values, dtype=np.float64))


def fill_floats(field: array.array[float], values: NDArray[np.float64]) -> None:
    """Fill a float64[] field of a message where it is.

    To set such a field copies it once more, and holds up all threads for as long.
    """
    del field[:]
    packed = np.ascontiguousarray(values, dtype=np.float64).ravel().view(np.uint8)
    for start in range(0, len(packed), _AT_ONCE):
        field.frombytes(packed[start : start + _AT_ONCE].data)


def unsigned(values: NDArray[Any]) -> array.array[int]:
    """Return a uint64[] field."""
    return _array('Q', np.asarray(values).astype(np.uint64))


def uint32s(values: NDArray[Any]) -> array.array[int]:
    """Return a uint32[] field."""
    return _array('I', np.asarray(values).astype(np.uint32))


def int32s(values: NDArray[Any]) -> array.array[int]:
    """Return an int32[] field."""
    return _array('i', np.asarray(values).astype(np.int32))


def uint8s(values: NDArray[Any]) -> array.array[int]:
    """Return a uint8[] field."""
    return _array('B', np.asarray(values).astype(np.uint8, copy=False))


def fill_arrays(message: Any, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Fill fields by name: bool[], uint8[] from bytes, uint64[] from integers, else float64[].

    A ``ResultRecord`` takes the arrays as they are.
    """
    if isinstance(message, ResultRecord):
        message.fill(arrays)
        return
    for name, values in arrays.items():
        if values.dtype == np.bool_:
            setattr(message, name, values.tolist())
        elif values.dtype.kind == 'f':
            setattr(message, name, floats(values))
        else:
            setattr(message, name, (uint8s if values.itemsize == 1 else unsigned)(values))


def seconds_of(stamp: TimeMessage) -> float:
    """Return a builtin_interfaces/Time as a number [s]."""
    return float(stamp.sec + 1e-9 * stamp.nanosec)


def nanoseconds_of(stamp: TimeMessage) -> int:
    """Return a builtin_interfaces/Time as a whole number [ns]."""
    return int(stamp.sec) * 10**9 + int(stamp.nanosec)


def stamp_after(stamp: TimeMessage, seconds: float) -> TimeMessage:
    """Return a time with the fields of a builtin_interfaces/Time, so many seconds after it."""
    whole, part = divmod(nanoseconds_of(stamp) + round(seconds * 1e9), 10**9)
    return SimpleNamespace(sec=whole, nanosec=part)


def stamp_seconds(stamp: Any, seconds: float) -> None:
    """Fill a builtin_interfaces/Time; seconds before 0, which it has none for, are 0."""
    whole, part = divmod(round(max(0.0, seconds) * 1e9), 10**9)
    stamp.sec, stamp.nanosec = whole, part


def pose_from_message(message: PoseMessage) -> RigidTransform:
    """Return the pose of a geometry_msgs/Pose; raises RuntimeError for what is no pose."""
    p, q = message.position, message.orientation
    return RigidTransform.FromArray([p.x, p.y, p.z, q.x, q.y, q.z, q.w])


def fill_pose(message: PoseMessage, X: RigidTransform) -> None:
    """Fill a geometry_msgs/Pose."""
    fill_pose_row(message, X.ToArray())


def fill_pose_row(message: PoseMessage, row: NDArray[np.float64]) -> None:
    """Fill a geometry_msgs/Pose with x y z [m] qx qy qz qw (7,)."""
    p, q = message.position, message.orientation
    p.x, p.y, p.z, q.x, q.y, q.z, q.w = row.tolist()
