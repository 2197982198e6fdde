"""``FramePoseVector``: poses of frames by id."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.common.counting import counted
from drake_geom_ros.geometry._proximity.world.pose_rows import (
    FRAME_POSES,
    KNOWN,
    POSE_WIDTH,
    REFUSED,
    RISING,
    packed_poses,
    positions_of,
    rotations_of,
)
from drake_geom_ros.geometry.checks import checked_pose, checked_type
from drake_geom_ros.geometry.errors import PoseError, UnknownIdError
from drake_geom_ros.geometry.ids import FrameId
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.math.array_types import Floats, Indices
from drake_geom_ros.math.batched import matrices_from_poses
from drake_geom_ros.math.tolerances import FARTHEST

_INT64, _FLOAT64 = np.dtype(np.int64), np.dtype(np.float64)
# Local names for a hot path, see ``FromArrays``.
_new, _empty, _Array = object.__new__, np.empty, np.ndarray
# The last strictly ascending ids, read-only: a call with equal ids shares them without a copy.
_rising = [np.zeros(0, dtype=np.int64)]

# Id values (n,) of frames, and their poses (n, POSE_WIDTH): see ``_proximity.poses``.
_Arrays: TypeAlias = tuple[Indices, Floats]


class FramePoseVector:
    """Poses X_PF of frames in their parents.

    It is filled one by one, as in pydrake, or made from arrays by ``FromArrays``, without work per
    frame. One form is converted to the other only when needed.

        >>> poses = FramePoseVector({FrameId(2): RigidTransform([0, 0, 1])})
        >>> poses.set_value(FrameId(3), RigidTransform())
        >>> poses.size()
        2
    """

    __slots__ = ('_arrays', '_values')

    def __init__(self, poses: Mapping[FrameId, RigidTransform] | None = None) -> None:
        self._values: dict[FrameId, RigidTransform] | None = {}
        self._arrays: _Arrays | None = None
        for frame_id, X_PF in (poses or {}).items():
            self.set_value(frame_id, X_PF)

    @classmethod
    def FromArrays(
        cls, frame_ids: Sequence[FrameId] | NDArray[np.integer], poses: ArrayLike
    ) -> FramePoseVector:
        """Return the poses (n, 7), x y z [m] qx qy qz qw, of n frames.

        ``frame_ids`` are ids or, quicker, an array of their values. Quaternions are normalised.
        Raises RuntimeError for another shape, a number that is not finite, a quaternion whose
        length differs from 1 by more than 1e-3, a coordinate beyond 1e302 m, or a duplicate frame.
        """
        # After 10 ms of other work each step here is a cache miss, so compiled code checks all
        # else about these arrays.
        vector: FramePoseVector = _new(cls)
        vector._values = None
        if (
            type(frame_ids) is _Array
            and type(poses) is _Array
            and frame_ids.dtype is _INT64
            and poses.dtype is _FLOAT64
        ):
            ids = _rising[0]
            try:
                X_PFs = _empty((len(frame_ids), POSE_WIDTH))
                status = FRAME_POSES.call(frame_ids, ids, poses, X_PFs)
            except TypeError:  # of another number of dimensions
                status = REFUSED
            if status == KNOWN:
                vector._arrays = ids, X_PFs
                return vector
            if status == RISING:
                _rising[0] = ids = frame_ids.astype(_INT64)  # a copy
                vector._arrays = ids, X_PFs
                return vector
        ids = _id_values(frame_ids)
        vector._arrays = ids, _poses_of(ids, poses)
        return vector

    def set_value(self, id: FrameId, value: RigidTransform) -> None:
        """Set X_PF of a frame."""
        checked_type(id, FrameId, 'FramePoseVector.set_value: id')
        X_PF = checked_pose(value, 'FramePoseVector.set_value: value')
        self._by_id()[id] = X_PF
        self._arrays = None

    def value(self, id: FrameId) -> RigidTransform:
        """Return X_PF of a frame; raises RuntimeError without a pose of it."""
        if id not in self._by_id():
            raise UnknownIdError(f'FramePoseVector: no pose of {id!r} among {self.size()} frames')
        return RigidTransform(self._by_id()[id])

    def has_id(self, id: FrameId) -> bool:
        """Return whether the vector has a pose of the frame."""
        return id in self._by_id()

    def ids(self) -> list[FrameId]:
        """Return the ids of the frames, in the order of the poses."""
        if self._values is None:
            return [FrameId(value) for value in self._ids.tolist()]
        return list(self._values)

    def frame_ids(self) -> list[FrameId]:
        """Return ``ids()``, by the older name."""
        return self.ids()

    def id_values(self) -> Indices:
        """Return the id values (n,) of the frames, in the order of the poses; read-only."""
        values = self._ids.view()
        values.flags.writeable = False  # other vectors may share them
        return values

    def size(self) -> int:
        """Return the number of poses."""
        return len(self)

    def clear(self) -> None:
        """Remove all poses."""
        self._values, self._arrays = {}, None

    def __len__(self) -> int:
        return len(self._ids if self._values is None else self._values)

    def __repr__(self) -> str:
        return f'<FramePoseVector of {counted(len(self), "frame")}>'

    @property
    def _ids(self) -> Indices:
        """Values of the frames' ids (n,)."""
        return self._as_arrays()[0]

    @property
    def _R_PFs(self) -> Floats:
        """Orientations (n, 3, 3)."""
        return rotations_of(self._as_arrays()[1])

    @property
    def _p_PFs(self) -> Floats:
        """Positions (n, 3) [m]."""
        return positions_of(self._as_arrays()[1])

    def _by_id(self) -> dict[FrameId, RigidTransform]:
        """Return the poses as a dictionary, converted from the arrays if necessary."""
        if self._values is None:
            poses = zip(self._R_PFs, self._p_PFs, strict=True)
            self._values = {
                id: RigidTransform._make(R.copy(), p.copy())
                for id, (R, p) in zip(self.ids(), poses, strict=True)
            }
        return self._values

    def _as_arrays(self) -> _Arrays:
        """Return the poses as arrays, converted from the dictionary if necessary."""
        if self._arrays is None:
            X_PFs = list(self._by_id().values())
            Rs = np.array([X.rotation().matrix() for X in X_PFs]).reshape(-1, 3, 3)
            ps = np.array([X.translation() for X in X_PFs]).reshape(-1, 3)
            self._arrays = _id_values(list(self._by_id())), packed_poses(Rs, ps)
        return self._arrays


def arrays_of(poses: FramePoseVector) -> _Arrays:
    """Return id values (n,) and poses (n, POSE_WIDTH), read-only by convention."""
    return poses._arrays or poses._as_arrays()


def _poses_of(ids: Indices, poses: ArrayLike) -> Floats:
    """Return the rows (n, POSE_WIDTH) of the poses (n, 7) of n different frames.

    Raises PoseError for an invalid pose, another number of poses, and a duplicate frame.
    """
    status, X_PFs = REFUSED, np.empty((len(ids), POSE_WIDTH))
    if isinstance(poses, np.ndarray) and poses.shape == (len(ids), 7) and poses.dtype.kind == 'f':
        status = FRAME_POSES.call(ids, ids[:0], poses.astype(np.float64), X_PFs)
    if status == REFUSED:  # read again in Python, for an error that names the fault
        X_PFs = packed_poses(*_read_slowly(poses))
    if len(ids) != len(X_PFs):
        raise PoseError(f'FramePoseVector.FromArrays: {len(ids)} frame_ids for {len(X_PFs)} poses')
    values, counts = np.unique(ids, return_counts=True)
    if len(values) != len(ids):
        twice = values[counts > 1][0]
        raise PoseError(f'FramePoseVector.FromArrays: frame {twice} is named more than once')
    return X_PFs


def _read_slowly(poses: ArrayLike) -> tuple[Floats, Floats]:
    """Return R (n, 3, 3) and p (n, 3) of poses (n, 7); raises PoseError for an invalid pose."""
    try:
        Rs, ps = matrices_from_poses(poses)
    except RuntimeError as error:
        raise PoseError(f'FramePoseVector.FromArrays: {error}') from None
    too_far = np.flatnonzero((np.abs(ps) > FARTHEST).any(axis=1))
    if len(too_far):
        row = int(too_far[0])
        raise PoseError(
            f'FramePoseVector.FromArrays: poses[{row}] lies at {ps[row].tolist()} m; no '
            f'coordinate may be beyond {FARTHEST:.3g} m'
        )
    return Rs, ps


def _id_values(frame_ids: Sequence[FrameId] | NDArray[np.integer]) -> Indices:
    """Return the values (n,) of frame ids, which may be values already."""
    if isinstance(frame_ids, np.ndarray) and frame_ids.dtype.kind in 'iu':
        values = frame_ids.astype(np.int64)
        if values.ndim != 1:
            raise PoseError(f'FramePoseVector.FromArrays: frame_ids has shape {values.shape}')
        return values
    try:
        ids = [checked_type(id, FrameId, 'FramePoseVector: frame id') for id in frame_ids]
    except TypeError as error:
        raise PoseError(str(error)) from None
    return np.array([id.get_value() for id in ids], dtype=np.int64)
