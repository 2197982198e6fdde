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

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Booleans = NDArray[np.bool_]


class Derivatives(NamedTuple):
    """Gradients (k, 12) of the distances in some rows, and which of them are unique (k,)."""

    rows: Floats
    gradients: Floats
    unique: Booleans


class PairGradients:
    """The part of a sequence of pairs that is about derivatives, computed when first asked for."""

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
        """Derivatives (k, 12) of what the results report."""
        raise NotImplementedError

    @property
    def is_gradient_unique(self) -> Booleans:
        """Whether each gradient (k,) is the only one: the distance has a derivative there.

        False where normals are equally good, where faces or edges lie parallel, where corners
        touch, for answers from bounds alone, and for solids that touch. Of solids that are apart
        all parts are looked at that may be as near; of those that overlap it is False, too, where
        nothing proves that no other way out is as short, and of sensed maps everywhere. Rounding
        decides for what is so by less than about 1e-6 rad.
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
        """Return the derivatives (k, n) of what is reported by n coordinates, such as joints.

        ``J_WFs`` maps frames to their Jacobians d(V_WF)/d(qdot) (6, n), in the layout of
        ``gradients``; frames that are not in it stay where they are. Raises ArgumentError for
        other shapes and for an empty mapping.
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
        known = np.array(sorted(Js), dtype=np.int64)
        stacked = np.stack([*(Js[int(frame)] for frame in known), np.zeros(width)])
        frames = self._frames()
        at = np.searchsorted(known, frames).clip(max=len(known) - 1)
        at[known[at] != frames] = len(known)
        return self._jacobian(stacked[at[:, 0]], stacked[at[:, 1]])

    def _derivatives(self) -> Derivatives:
        """Return the derivatives of the distances; one compiled call."""
        if self._derived is None or self._derived.rows is not self._rows:
            # Paddings change none: they are constants, and points move along the normal only.
            found = gradients_of_pairs(self._scene, self._ids, self._surface_rows)
            self._derived = Derivatives(self._rows, *found)
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
    """The part of distances to points that is about derivatives."""

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
        [m/rad, -]: to move G one way is to move the point the other way. That by the point's own
        position is ``grad_W``. Where ``is_grad_W_unique`` is False it belongs to that member.
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
        stay where they are without. Raises ArgumentError for other shapes.
        """
        count = len(self._arrays.rows)
        total: Floats = (self.gradients[:, None] @ _checked(J_Gs, count))[:, 0]
        if J_Qs is None:
            return total
        grads = self._arrays.rows[:, None, POINT_GRADIENT : POINT_GRADIENT + 3]
        of_points: Floats = total + (grads @ _checked(J_Qs, count, 3))[:, 0]
        return of_points


class PairEvidence(NamedTuple):
    """What the derivatives of k pairs are made of."""

    ids: Indices  # (k, 2)
    rows: Floats  # what is reported
    surface_rows: Floats  # the same about the bodies themselves, without their paddings
    scene: PosedWorld


class PointEvidence(NamedTuple):
    """What the derivatives of distances to points are made of."""

    p_WQs: Floats  # (m, 3) [m]
    scene: PosedWorld


def pair_evidence(found: PairGradients) -> PairEvidence:
    """Return what results of one state rest on; raises GeometryError for those of many."""
    return PairEvidence(found._ids, found._rows, found._surface_rows, found._scene)


def point_evidence(found: PointGradients) -> PointEvidence:
    """Return what results of one state rest on; raises GeometryError for those of many."""
    return PointEvidence(found._p_WQs, found._scene)


def distance_gradients(found: PairGradients) -> Floats:
    """Return the gradients (k, 12) of the distances, of results of many states as well."""
    return gradients_of_rows(found._rows)


def _posed(kept_poses: KeptPoses | None) -> PosedWorld:
    """Return the shapes as they were when the query was answered."""
    if kept_poses is None:
        raise GeometryError(
            'Derivatives of results of many states were asked for, which keep no orientations: '
            'ask a QueryObject of the state in question.'
        )
    return kept_poses.keep()


def _checked(J: ArrayLike, count: int, height: int = 6) -> Floats:
    """Return a Jacobian as (k, height, n), or (height, n); raises ArgumentError for others."""
    matrix = np.asarray(J, dtype=float)
    fits = matrix.ndim in (2, 3) and matrix.shape[-2] == height
    if not fits or (matrix.ndim == 3 and len(matrix) != count):
        raise ArgumentError(
            f'A Jacobian of shape {matrix.shape} was given for {count} results; it must be '
            f'({count}, {height}, n) or ({height}, n).'
        )
    return matrix
