"""Messages to values of the core and back: here messages stop.

No ROS import: a function reads or fills any object with the fields of the message, so that plain
objects test it. What a message holds is checked here, once; errors name the field.
"""

from __future__ import annotations

import array
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import (
    ArgumentError,
    CollisionFilterDeclaration,
    FramePoseVector,
    GeometrySet,
    PenetrationResults,
    PointDistanceResults,
    SignedDistanceResults,
)
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.ros.names import NameTable

_POSE_WIDTH = 7


def _array(code: str, values: NDArray[Any]) -> array.array[Any]:
    """Return an array field: rclpy takes an array.array as it is, other types item by item."""
    filled = array.array(code)
    filled.frombytes(np.ascontiguousarray(values).data.cast('B') if values.size else b'')
    return filled


def floats(values: NDArray[np.float64]) -> array.array[float]:
    """Return a float64[] field."""
    return _array('d', np.asarray(values, dtype=np.float64))


def unsigned(values: NDArray[Any]) -> array.array[int]:
    """Return a uint64[] field."""
    return _array('Q', np.asarray(values).astype(np.uint64))


def uint32s(values: NDArray[Any]) -> array.array[int]:
    """Return a uint32[] field."""
    return _array('I', np.asarray(values).astype(np.uint32))


def seconds_of(stamp: Any) -> float:
    """Return a builtin_interfaces/Time as a number [s]."""
    return float(stamp.sec + 1e-9 * stamp.nanosec)


def pose_from_message(message: Any) -> RigidTransform:
    """Return the pose of a geometry_msgs/Pose; raises RuntimeError for what is no pose."""
    p, q = message.position, message.orientation
    return RigidTransform.FromArray([p.x, p.y, p.z, q.x, q.y, q.z, q.w])


def fill_pose(message: Any, X: RigidTransform) -> None:
    """Fill a geometry_msgs/Pose."""
    p, q = message.position, message.orientation
    p.x, p.y, p.z, q.x, q.y, q.z, q.w = X.ToArray().tolist()


class FramePosesReader:
    """Reads FramePoses messages of one version of a scene.

    A stream names the same frames again and again, so the look-up of a list of names is kept.
    """

    def __init__(self, names: NameTable) -> None:
        self._names = names
        self._known: dict[tuple[str, ...], NDArray[np.int64]] = {}

    def read(self, message: Any) -> FramePoseVector:
        """Return the poses of a message; raises RuntimeError, and nothing is half read."""
        frames = self._frames(message)
        poses = np.asarray(message.poses, dtype=np.float64)
        if poses.size != _POSE_WIDTH * len(frames):
            raise ArgumentError(
                f'poses holds {poses.size} numbers for {len(frames)} frames; it must hold '
                f'{_POSE_WIDTH} a frame: x y z qx qy qz qw'
            )
        return FramePoseVector.FromArrays(frames, poses.reshape(-1, _POSE_WIDTH))

    def _frames(self, message: Any) -> NDArray[np.int64]:
        """Return the ids (n,) of the frames that a message names, in its order."""
        if len(message.frame_names) and len(message.frame_ids):
            raise ArgumentError('frame_names and frame_ids are both given; exactly one must be')
        key = (message.source, *message.frame_names, *map(str, message.frame_ids))
        frames = self._known.get(key)
        if frames is None:
            ids = [frame.get_value() for frame in self._look_up(message)]
            frames = np.array(ids, dtype=np.int64)
            # One list for each sender; a sender whose lists never repeat must not fill the memory.
            if len(self._known) >= 64:
                self._known.clear()
            self._known[key] = frames
        return frames

    def _look_up(self, message: Any) -> list[Any]:
        names, source = self._names, message.source
        if source:
            names.source(source)
        if message.frame_names:
            frames = [names.frame(name, source) for name in message.frame_names]
        else:
            frames = [names.frame_of_value(value) for value in message.frame_ids]
        prefix = f'{source}::'
        for frame in frames:
            full = names.frame_names[frame]
            if source and not full.startswith(prefix):
                raise ArgumentError(f"frame '{full}' does not belong to source '{source}'")
            if frame == names.world:
                raise ArgumentError('the world frame cannot be posed')
        if len(set(frames)) != len(frames):
            twice = next(f for k, f in enumerate(frames) if f in frames[:k])
            raise ArgumentError(f"frame '{names.frame_names[twice]}' is named twice")
        return frames


def geometry_set_from_message(message: Any, names: NameTable) -> GeometrySet:
    """Return a GeometrySet; raises UnknownNameError for what the scene does not hold."""
    frames = [names.frame(name) for name in message.frames]
    frames += [names.frame_of_value(value) for value in message.frame_ids]
    geometries = [names.geometry(name) for name in message.geometries]
    geometries += [names.geometry_of_value(value) for value in message.geometry_ids]
    return GeometrySet(geometry_ids=geometries, frame_ids=frames)


def declaration_from_message(message: Any, names: NameTable) -> CollisionFilterDeclaration:
    """Return a CollisionFilterDeclaration; raises RuntimeError, naming the statement."""
    declaration = CollisionFilterDeclaration()
    for number, statement in enumerate(message.statements):
        try:
            set_a = geometry_set_from_message(statement.set_a, names)
            set_b = geometry_set_from_message(statement.set_b, names)
        except RuntimeError as error:
            raise ArgumentError(f'statements[{number}]: {error}') from None
        if statement.operation == 1:
            declaration.ExcludeWithin(set_a)
        elif statement.operation == 2:
            declaration.ExcludeBetween(set_a, set_b)
        elif statement.operation == 3:
            declaration.AllowWithin(set_a)
        elif statement.operation == 4:
            declaration.AllowBetween(set_a, set_b)
        else:
            raise ArgumentError(
                f'statements[{number}].operation is {statement.operation}; it must be 1 '
                '(EXCLUDE_WITHIN), 2 (EXCLUDE_BETWEEN), 3 (ALLOW_WITHIN) or 4 (ALLOW_BETWEEN)'
            )
    return declaration


def fill_penetrations(message: Any, results: PenetrationResults) -> None:
    """Fill the arrays of a PenetrationPairs message."""
    message.id_a = unsigned(results.id_A)
    message.id_b = unsigned(results.id_B)
    message.p_wca = floats(results.p_WCa)
    message.p_wcb = floats(results.p_WCb)
    message.nhat_ba_w = floats(results.nhat_BA_W)
    message.depth = floats(results.depth)
    message.error_bound = floats(results.error_bound)
    message.method = _array('B', results.method)


def fill_signed_distances(
    message: Any, results: SignedDistanceResults, max_distance: float
) -> None:
    """Fill the arrays of a SignedDistancePairs message."""
    message.max_distance = max_distance
    message.id_a = unsigned(results.id_A)
    message.id_b = unsigned(results.id_B)
    message.p_aca = floats(results.p_ACa)
    message.p_bcb = floats(results.p_BCb)
    message.nhat_ba_w = floats(results.nhat_BA_W)
    message.distance = floats(results.distance)
    message.is_nhat_ba_w_unique = results.is_nhat_BA_W_unique.tolist()
    message.error_bound = floats(results.error_bound)
    message.method = _array('B', results.method)


def fill_point_distances(
    message: Any,
    parts: Sequence[PointDistanceResults],
    threshold: float,
    indices: Sequence[NDArray[np.int64]],
) -> None:
    """Fill the arrays of a PointDistances message with the results of blocks of points.

    ``indices[k]`` (m,) are the numbers of block k's points among all points.
    """
    numbers = [index[part.point_index] for part, index in zip(parts, indices, strict=True)]

    def joined(name: str) -> NDArray[Any]:
        return np.concatenate([getattr(part, name) for part in parts])

    message.threshold = threshold
    message.point_index = uint32s(np.concatenate(numbers))
    message.id_g = unsigned(joined('id_G'))
    message.p_gn = floats(joined('p_GN'))
    message.distance = floats(joined('distance'))
    message.grad_w = floats(joined('grad_W'))
    message.is_grad_w_unique = joined('is_grad_W_unique').tolist()
    message.error_bound = floats(joined('error_bound'))
    message.method = _array('B', joined('method'))
