"""Derivatives of whole results by the motions of frames, as arrays."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.geometry._proximity.derivatives.gradients import (
    gradients_of_pairs,
    gradients_of_rows,
    places_of,
)
from drake_geom_ros.geometry._proximity.kernels.calling.points import POINT_GRADIENT
from drake_geom_ros.geometry._proximity.pairs.answer_rows import PointBatch
from drake_geom_ros.geometry._proximity.world.kept_poses import KeptPoses, PosedWorld
from drake_geom_ros.geometry.errors import ArgumentError, GeometryError
from drake_geom_ros.geometry.ids import FrameId
from drake_geom_ros.math.array_types import Floats, Indices

Booleans = NDArray[np.bool_]


class Derivatives(NamedTuple):
    """Gradients (k, 12) of the distances in some rows, and whether each is unique (k,)."""

    rows: Floats
    gradients: Floats
    unique: Booleans


class PairGradients:
    """Derivatives of a sequence of pairs, computed on first use."""

    _ids: Indices
    _rows: Floats
    _kept_poses: KeptPoses | None
    _derived: Derivatives | None = None

    @property
    def _surface_rows(self) -> Floats:
        """The rows about the bodies themselves."""
        raise NotImplementedError

    @property
    def gradients(self) -> Floats:
        """Derivatives (k, 12) of the reported depths or distances."""
        raise NotImplementedError

    @property
    def is_gradient_unique(self) -> Booleans:
        """True (k,) where the gradient is unique: the distance has a derivative there.

        False where several normals are equally good, where faces or edges are parallel, where
        corners touch, for answers from bounds alone, for solids that touch, and for sensed maps.
        For solids that are apart all parts are compared that may be as near. For solids that
        overlap it is False unless no other separating translation is proved to be as short. Within
        about 1e-6 rad of such a case rounding decides.
        """
        return self._derivatives().unique

    @property
    def frame_id_A(self) -> Indices:
        """Id values (k,) of the frames that carry A."""
        return self._frames()[:, 0]

    @property
    def frame_id_B(self) -> Indices:
        """Id values (k,) of the frames that carry B."""
        return self._frames()[:, 1]

    def jacobian_by_frames(self, J_WFs: Mapping[FrameId, ArrayLike]) -> Floats:
        """Return the derivatives (k, n) of depths or distances by n coordinates, such as joints.

        ``J_WFs`` maps frames to their Jacobians d(V_WF)/d(qdot) (6, n), in the layout of
        ``gradients``; other frames do not move. Raises ArgumentError for other shapes and for an
        empty mapping.
        """
        if not J_WFs:
            raise ArgumentError('jacobian_by_frames: J_WFs is empty; give at least one frame.')
        Js = {frame.get_value(): np.asarray(J, dtype=float) for frame, J in J_WFs.items()}
        shapes = {J.shape for J in Js.values()}
        width = next(iter(shapes))
        if len(shapes) > 1 or len(width) != 2 or width[0] != 6:
            raise ArgumentError(
                f'jacobian_by_frames: Jacobians have the shapes {shapes}, not (6, n)'
            )
        ids = np.array(sorted(Js), dtype=np.int64)
        stacked = np.stack([*(Js[int(frame)] for frame in ids), np.zeros(width)])
        frames = self._frames()
        at = np.searchsorted(ids, frames).clip(max=len(ids) - 1)
        at[ids[at] != frames] = len(ids)
        return self._jacobian(stacked[at[:, 0]], stacked[at[:, 1]])

    def _derivatives(self) -> Derivatives:
        """Return the derivatives of the distances; one compiled call."""
        if self._derived is None or self._derived.rows is not self._rows:
            # Paddings are constants and move points along the normal: they change no gradient.
            derivatives = gradients_of_pairs(self._scene, self._ids, self._surface_rows)
            self._derived = Derivatives(self._rows, *derivatives)
        return self._derived

    @property
    def _scene(self) -> PosedWorld:
        return _posed(self._kept_poses)

    def _frames(self) -> Indices:
        scene = self._scene
        frames: Indices = scene.frame_ids[scene.frames[places_of(scene, self._ids)]]
        return frames

    def _jacobian(self, J_As: ArrayLike, J_Bs: ArrayLike) -> Floats:
        gradients = self.gradients
        Js = [_checked(J, len(gradients)) for J in (J_As, J_Bs)]
        if Js[0].shape[-1] != Js[1].shape[-1]:
            raise ArgumentError(
                f'Jacobians of {Js[0].shape[-1]} and of {Js[1].shape[-1]} coordinates were given; '
                'both must be of the same ones.'
            )
        by_A, by_B = gradients[:, None, :6] @ Js[0], gradients[:, None, 6:] @ Js[1]
        total: Floats = (by_A + by_B)[:, 0]
        return total


class PointGradients:
    """Derivatives of distances to points."""

    _arrays: PointBatch
    _kept_poses: KeptPoses | None
    _p_WQs: Floats  # (m, 3) [m]

    @property
    def _scene(self) -> PosedWorld:
        return _posed(self._kept_poses)

    @property
    def gradients(self) -> Floats:
        """Derivatives (k, 6) of the distances by the motion of the frame F that carries G.

        By its spatial velocity V_WF = [w_WF, v_WFo], angular before linear, in World axes
        [m/rad, -]; moving G is equivalent to moving the point the other way. ``grad_W`` is the
        derivative by the point's position. Where ``is_grad_W_unique`` is False, this one belongs
        to the reported ``grad_W``.
        """
        grads = self._arrays.rows[:, POINT_GRADIENT : POINT_GRADIENT + 3]
        scene = self._scene
        frames = scene.frames[places_of(scene, self._arrays.ids)]
        p_FQs = self._p_WQs[self._arrays.points] - scene.p_WFs[frames]
        return -np.hstack((np.cross(p_FQs, grads), grads))

    def distance_jacobian(self, J_Gs: ArrayLike, J_Qs: ArrayLike | None = None) -> Floats:
        """Return the derivatives (k, n) of the distances by n coordinates.

        ``J_Gs`` (k, 6, n), or (6, n) for all, are d(V_WF)/d(qdot) of the frames that carry G, in
        the layout of ``gradients``; ``J_Qs`` (k, 3, n) or (3, n) are those of the points, which
        do not move without it. Raises ArgumentError for other shapes.
        """
        count = len(self._arrays.rows)
        total: Floats = (self.gradients[:, None] @ _checked(J_Gs, count))[:, 0]
        if J_Qs is None:
            return total
        grads = self._arrays.rows[:, None, POINT_GRADIENT : POINT_GRADIENT + 3]
        of_points: Floats = total + (grads @ _checked(J_Qs, count, 3))[:, 0]
        return of_points


class PairEvidence(NamedTuple):
    """Data that the derivatives of k pairs are computed from."""

    ids: Indices  # (k, 2)
    rows: Floats  # the reported answers
    surface_rows: Floats  # the same about the bodies themselves, without their paddings
    scene: PosedWorld


class PointEvidence(NamedTuple):
    """Data that the derivatives of distances to points are computed from."""

    p_WQs: Floats  # (m, 3) [m]
    scene: PosedWorld


def pair_evidence(pairs: PairGradients) -> PairEvidence:
    """Return the data behind results of one state; raises GeometryError for many states."""
    return PairEvidence(pairs._ids, pairs._rows, pairs._surface_rows, pairs._scene)


def point_evidence(points: PointGradients) -> PointEvidence:
    """Return the data behind results of one state; raises GeometryError for many states."""
    return PointEvidence(points._p_WQs, points._scene)


def distance_gradients(pairs: PairGradients) -> Floats:
    """Return the gradients (k, 12) of distances, also for results of many states."""
    return gradients_of_rows(pairs._rows)


def _posed(kept_poses: KeptPoses | None) -> PosedWorld:
    """Return the shapes at the poses of the query."""
    if kept_poses is None:
        raise GeometryError(
            'Derivatives of results of many states were asked for, which keep no orientations: '
            'ask a QueryObject of the state in question.'
        )
    return kept_poses.keep()


def _checked(J: ArrayLike, count: int, height: int = 6) -> Floats:
    """Return a Jacobian (k, height, n) or (height, n); raises ArgumentError for other shapes."""
    matrix = np.asarray(J, dtype=float)
    fits = matrix.ndim in (2, 3) and matrix.shape[-2] == height
    if not fits or (matrix.ndim == 3 and len(matrix) != count):
        raise ArgumentError(
            f'A Jacobian of shape {matrix.shape} was given for {count} results; it must be '
            f'({count}, {height}, n) or ({height}, n).'
        )
    return matrix
