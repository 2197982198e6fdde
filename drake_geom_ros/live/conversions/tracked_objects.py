"""TrackedObjects messages to bodies."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from drake_geom_ros.common.counting import counted
from drake_geom_ros.geometry import (
    ArgumentError,
    FramePoseVector,
    HalfSpace,
    OccupiedCells,
    PointCloud,
    Shape,
)
from drake_geom_ros.live.conversions.fields import nanoseconds_of
from drake_geom_ros.live.conversions.file_access import FileAccess
from drake_geom_ros.live.conversions.names import HEARTBEAT
from drake_geom_ros.live.conversions.shapes import shape_from_message
from drake_geom_ros.math.array_types import Floats

MOST_BODIES = 1000  # of a message, and of all trackers together
_POSE_WIDTH, _TWIST_WIDTH = 7, 6
_LONGEST_NAME = 200  # letters
_MOST_SHAPES = 4096  # that are cached
_UNBOUNDED = HalfSpace, OccupiedCells, PointCloud


class Bodies(NamedTuple):
    """The bodies (n,) of a message, in the frame H of its header; ``gone`` are those that leave.

    Of one reader the same shape is the same object, which is soon compared.
    """

    header: Any
    names: tuple[str, ...]
    shapes: tuple[Shape, ...]
    poses: Floats  # (n, 7) X_HB
    velocities: Floats | None  # (n, 6) V_WB in the axes of H
    lifetimes: tuple[float, ...]  # [s]
    gone: frozenset[str] = frozenset()


class TrackedObjectsReader:
    """Reads TrackedObjects messages; a tracker repeats shapes, so these are cached."""

    def __init__(self) -> None:
        self._shapes: dict[tuple[Any, ...], Shape] = {}
        # The source of the message and its shapes: see ``serialized_tracked``.
        self._last: tuple[Any, tuple[Shape, ...]] = ((), ())
        self._last_names: tuple[str, ...] = ()

    def read(self, message: Any, files: FileAccess) -> Bodies:
        """Return the bodies of a message; raises RuntimeError for one that is to be refused."""
        names = tuple(message.names)  # the same one of a sender that repeats them
        if names is not self._last_names:
            refuse_names(names)
            self._last_names = names
        count = len(names)
        _as_many(message.shapes, names, 'shapes')
        source, shapes = self._last
        if source is not message.shapes:
            pairs = zip(message.shapes, names, strict=True)
            shapes = tuple([self._shape(shape, files, name) for shape, name in pairs])
        poses = _rows(message.poses, _POSE_WIDTH, count, 'poses', 'x y z qx qy qz qw')
        refuse_poses(poses)
        velocities = None
        if len(message.velocities):
            velocities = _rows(
                message.velocities, _TWIST_WIDTH, count, 'velocities', 'wx wy wz vx vy vz'
            )
            if not np.isfinite(velocities).all():
                raise ArgumentError('velocities must be finite')
            if not nanoseconds_of(message.header.stamp):
                raise ArgumentError(
                    'header.stamp is 0; velocities belong to the poses of their time'
                )
        values = np.asarray(_as_many(message.lifetimes, names, 'lifetimes'), dtype=np.float64)
        refuse_lifetimes(values, names)
        if isinstance(message.shapes, tuple):  # nobody changes it
            self._last = message.shapes, shapes
        return Bodies(message.header, names, shapes, poses, velocities, tuple(values.tolist()))

    def _shape(self, message: Any, files: FileAccess, name: str) -> Shape:
        key = (
            message.type,
            tuple(message.dimensions),
            message.mesh_uri,
            bytes(memoryview(message.vertices)) if len(message.vertices) else b'',
            bytes(memoryview(message.triangles)) if len(message.triangles) else b'',
        )
        shape = self._shapes.get(key)
        if shape is not None:
            return shape
        try:
            shape = shape_from_message(message, files)
        except RuntimeError as error:
            raise ArgumentError(f'the body {name[:80]!r}: {error}') from None
        if isinstance(shape, _UNBOUNDED):
            raise ArgumentError(
                f'the body {name[:80]!r} is a {type(shape).__name__}; it must be a sphere, box, '
                'capsule, cylinder, ellipsoid, or a mesh'
            )
        if len(self._shapes) >= _MOST_SHAPES:
            self._shapes.clear()
        self._shapes[key] = shape
        return shape


def refuse_names(names: Sequence[str]) -> None:
    """Raise ArgumentError for names that bodies cannot bear."""
    if len(names) > MOST_BODIES:
        raise ArgumentError(f'{len(names)} bodies are named; at most {MOST_BODIES} are taken')
    for name in names:
        if not name.strip(' \t') or name != name.strip(' \t') or '\0' in name:
            raise ArgumentError(f'a name is {name[:80]!r}; it must not be empty, or end in spaces')
        if len(name) > _LONGEST_NAME:
            raise ArgumentError(
                f'a name has {len(name)} letters ({name[:20]!r}...); at most {_LONGEST_NAME} are '
                'taken'
            )
        if name == HEARTBEAT:
            raise ArgumentError(f'the name {HEARTBEAT!r} is that of no body; choose another')
    if len(set(names)) < len(names):
        twice = next(name for k, name in enumerate(names) if name in names[:k])
        raise ArgumentError(f'the body {twice[:80]!r} is named twice')


def refuse_poses(poses: Floats) -> None:
    """Raise RuntimeError for rows (n, 7) that are no poses."""
    if len(poses):
        FramePoseVector.FromArrays(np.arange(1, len(poses) + 1), poses)


def refuse_lifetimes(lifetimes: Sequence[float] | Floats, names: Sequence[str]) -> None:
    """Raise ArgumentError for a lifetime that is none."""
    if (np.asarray(lifetimes) > 0.0).all():
        return
    for name, lifetime in zip(names, lifetimes, strict=True):
        if not lifetime > 0.0:
            raise ArgumentError(
                f'the lifetime of {name[:80]!r} is {lifetime} [s]; it must be > 0, or inf for a '
                'body that stays'
            )


def _as_many(values: Any, names: Sequence[str], what: str) -> Any:
    if len(values) != len(names):
        raise ArgumentError(
            f'{what} holds {len(values)} for {counted(len(names), "body")}; it must '
            'hold one for each'
        )
    return values


def _rows(flat: Any, width: int, count: int, what: str, layout: str) -> Floats:
    values = np.asarray(flat, dtype=np.float64)
    if values.size != width * count:
        raise ArgumentError(
            f'{what} holds {values.size} numbers for {counted(count, "body")}; it must '
            f'hold {width} for each: {layout}'
        )
    return values.reshape(-1, width)
