"""MarkerArray and Detection3DArray messages to the bodies of trackers."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.geometry import ArgumentError, Box, Capsule, Cylinder, Ellipsoid, Shape, Sphere
from drake_geom_ros.live.conversions.fields import nanoseconds_of
from drake_geom_ros.live.conversions.tracked_objects import (
    Bodies,
    refuse_lifetimes,
    refuse_names,
    refuse_poses,
)
from drake_geom_ros.math import RigidTransform, RotationMatrix
from drake_geom_ros.math.array_types import Floats

# Constants of visualization_msgs/Marker.
_ARROW, _CUBE, _SPHERE, _CYLINDER, _LINE_STRIP, _TEXT = 0, 1, 2, 3, 4, 9
_ADD, _DELETE, _DELETEALL = 0, 2, 3
_NO_BODIES = _ARROW, _TEXT  # velocities and labels
_NO_TURN = [0.0, 0.0, 0.0, 0.0]  # which RViz takes for the identity


class _Part(NamedTuple):
    """A body of a marker: its shape, and its pose X_MB."""

    shape: Shape
    X_MB: RigidTransform


class MarkerReader:
    """Reads MarkerArray messages: which bodies come, and which leave."""

    def __init__(self) -> None:
        self._names: dict[str, tuple[str, ...]] = {}  # of the bodies of each marker

    def read(self, message: Any) -> Bodies:
        """Return the bodies of a message; raises RuntimeError for one that is to be refused.

        A body is called ``ns/id``, and the segments of a line strip ``ns/id/0`` and on. Arrows and
        texts are no bodies. All markers of a message have one frame, and the oldest stamp counts.
        """
        named, gone = dict(self._names), set[str]()
        bodies: dict[str, tuple[_Part, Any]] = {}
        for marker in message.markers:
            key = f'{marker.ns}/{marker.id}'
            if marker.action == _DELETEALL:
                gone |= {name for names in named.values() for name in names}
                named, bodies = {}, {}
            elif marker.action == _DELETE:
                gone |= set(named.pop(key, ()))
                bodies = {name: each for name, each in bodies.items() if name not in gone}
            elif marker.action != _ADD:
                raise ArgumentError(
                    f'the marker {key!r} has the action {marker.action}; it must be ADD (0), '
                    'DELETE (2) or DELETEALL (3)'
                )
            elif marker.type not in _NO_BODIES:
                parts = dict(_parts(marker, key))
                gone |= set(named.get(key, ()))
                named[key] = tuple(parts)
                gone -= parts.keys()
                bodies |= {name: (part, marker) for name, part in parts.items()}
        read = self._bodies(message, bodies, frozenset(gone))
        self._names = named
        return read

    def _bodies(
        self, message: Any, bodies: dict[str, tuple[_Part, Any]], gone: frozenset[str]
    ) -> Bodies:
        names = tuple(bodies)
        refuse_names(names)
        markers = [marker for _, marker in bodies.values()]
        header = _common_header(markers or list(message.markers))
        rows = [_pose_of(marker.pose) @ part.X_MB for part, marker in bodies.values()]
        poses = np.array([X.ToArray() for X in rows]).reshape(-1, 7)
        lifetimes = tuple(_lifetime(marker) for marker in markers)
        refuse_lifetimes(lifetimes, names)
        shapes = tuple(part.shape for part, _ in bodies.values())
        return Bodies(header, names, shapes, poses, None, lifetimes, gone)


def bodies_of_detections(message: Any, lifetime: float) -> Bodies:
    """Return the boxes of a Detection3DArray, which live for ``lifetime`` [s].

    A body is called as the ``id`` of its detection; without one nobody knows whether it is
    the one of before. Raises RuntimeError for a message that is to be refused.
    """
    names = tuple(detection.id for detection in message.detections)
    if '' in names:
        raise ArgumentError(
            f'detections[{names.index("")}].id is empty: a detection needs the id of its track'
        )
    refuse_names(names)
    boxes = [detection.bbox for detection in message.detections]
    shapes = tuple(
        _sized(name, Box, box.size.x, box.size.y, box.size.z)
        for name, box in zip(names, boxes, strict=True)
    )
    poses = np.array([_row(box.center) for box in boxes]).reshape(-1, 7)
    refuse_poses(poses)
    return Bodies(message.header, names, shapes, poses, None, (lifetime,) * len(names))


def _parts(marker: Any, key: str) -> Iterator[tuple[str, _Part]]:
    """Yield the bodies of a marker by name."""
    scale = [marker.scale.x, marker.scale.y, marker.scale.z]
    at_it = RigidTransform()
    if marker.type == _CUBE:
        yield key, _Part(_sized(key, Box, *scale), at_it)
    elif marker.type == _SPHERE:
        radii = [0.5 * each for each in scale]
        is_ball = len(set(radii)) == 1
        shape = _sized(key, Sphere, radii[0]) if is_ball else _sized(key, Ellipsoid, *radii)
        yield key, _Part(shape, at_it)
    elif marker.type == _CYLINDER:
        if scale[0] != scale[1]:
            raise ArgumentError(
                f'the marker {key!r} is a cylinder of the diameters {scale[0]} and {scale[1]}; '
                'they must be the same'
            )
        yield key, _Part(_sized(key, Cylinder, 0.5 * scale[0], scale[2]), at_it)
    elif marker.type == _LINE_STRIP:
        yield from _segments(marker, key)
    else:
        raise ArgumentError(
            f'the marker {key!r} has the type {marker.type}; a body is a CUBE (1), SPHERE (2), '
            'CYLINDER (3) or LINE_STRIP (4)'
        )


def _segments(marker: Any, key: str) -> Iterator[tuple[str, _Part]]:
    """Yield the capsules around the segments of a line strip, as wide as the line."""
    points = np.array([[p.x, p.y, p.z] for p in marker.points]).reshape(-1, 3)
    if len(points) < 2 or not np.isfinite(points).all():
        raise ArgumentError(
            f'the marker {key!r} is a LINE_STRIP of {len(points)} points; it must have 2 or more, '
            'all finite'
        )
    for k, (start, end) in enumerate(pairwise(points)):
        name = key if len(points) == 2 else f'{key}/{k}'
        radius, length = 0.5 * marker.scale.x, float(np.linalg.norm(end - start))
        if not length:
            yield name, _Part(_sized(key, Sphere, radius), RigidTransform(start))
            continue
        shape = _sized(key, Capsule, radius, length)
        yield name, _Part(shape, RigidTransform(_along(end - start), 0.5 * (start + end)))


def _along(direction: Floats) -> RotationMatrix:
    """Return a rotation whose z axis has a direction."""
    z = direction / np.linalg.norm(direction)
    x = np.cross(np.eye(3)[np.argmin(np.abs(z))], z)
    x /= np.linalg.norm(x)
    return RotationMatrix(np.column_stack((x, np.cross(z, x), z)))


def _sized(name: str, kind: Any, *sizes: float) -> Shape:
    """Return a shape; the error of one that cannot be names the body."""
    if not min(sizes) > 0.0:
        raise ArgumentError(f'the body {name[:80]!r} has the sizes {sizes}; all must be > 0 [m]')
    try:
        shape: Shape = kind(*map(float, sizes))
    except RuntimeError as error:
        raise ArgumentError(f'the body {name[:80]!r}: {error}') from None
    return shape


def _common_header(markers: Sequence[Any]) -> Any:
    """Return the header of the oldest marker; raises ArgumentError for several frames."""
    frames = list(dict.fromkeys(marker.header.frame_id for marker in markers))
    if len(frames) > 1:
        raise ArgumentError(
            f'the markers are in the frames {frames[0][:80]!r} and {frames[1][:80]!r}; those of a '
            'message must be in one'
        )
    if not markers:  # nobody is there, now
        return SimpleNamespace(stamp=SimpleNamespace(sec=0, nanosec=0), frame_id='')
    return min((marker.header for marker in markers), key=lambda h: nanoseconds_of(h.stamp))


def _row(pose: Any) -> list[float]:
    p, q = pose.position, pose.orientation
    turn = [q.x, q.y, q.z, q.w]
    return [p.x, p.y, p.z, *([0.0, 0.0, 0.0, 1.0] if turn == _NO_TURN else turn)]


def _pose_of(pose: Any) -> RigidTransform:
    return RigidTransform.FromArray(_row(pose))


def _lifetime(marker: Any) -> float:
    """Return the lifetime [s] of a marker; 0 in the message is for good."""
    return 1e-9 * (marker.lifetime.sec * 10**9 + marker.lifetime.nanosec) or math.inf
