"""Result sequences of pairs and points, see ``result_sequence``."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    METHOD,
    NORMAL,
    UNIQUE,
    WITNESS_A,
    WITNESS_B,
)
from drake_geom_ros.geometry._proximity.kernels.calling.points import (
    POINT_DISTANCE,
    POINT_ERROR_BOUND,
    POINT_GRADIENT,
    POINT_METHOD,
    POINT_NEAREST,
    POINT_UNIQUE,
)
from drake_geom_ros.geometry._proximity.pairs.answer_rows import (
    BATCH_WIDTH,
    DEPTH,
    IDS,
    P_ACA,
    P_BCB,
    P_FACA,
    P_FBCB,
    PROMISED,
    PairBatch,
    PointBatch,
)
from drake_geom_ros.geometry._proximity.world.kept_poses import KeptPoses
from drake_geom_ros.geometry.ids import GeometryId
from drake_geom_ros.geometry.queries.query_gradients import PairGradients, PointGradients
from drake_geom_ros.geometry.queries.query_records import (
    PenetrationAsPointPair,
    SignedDistancePair,
    SignedDistanceToPoint,
)
from drake_geom_ros.geometry.queries.result_sequence import Record, ResultSequence
from drake_geom_ros.math.array_types import Floats

# Slices of columns, made once, since making them takes a third of the time of a view.
_FIRST, _SECOND, _IDS = np.s_[:, 0], np.s_[:, 1], np.s_[:, IDS:]
_INT64, _Array = np.dtype(np.int64), np.ndarray
_NORMALS = np.s_[:, NORMAL : NORMAL + 3]
_POINTS_A, _POINTS_B = np.s_[:, WITNESS_A : WITNESS_A + 3], np.s_[:, WITNESS_B : WITNESS_B + 3]
_IN_A, _IN_B = np.s_[:, P_ACA : P_ACA + 3], np.s_[:, P_BCB : P_BCB + 3]
_DEPTHS, _DISTANCES = np.s_[:, DEPTH], np.s_[:, DISTANCE]

# Columns of a table that all pairs have.
_OF_PAIRS = ('error_bound', 'nhat_BA_W', 'p_WCa', 'p_WCb', 'method')

_Pairs = TypeVar('_Pairs', bound='_PairSequence[Any]')

Ids = NDArray[np.int64]


def _vector(row: Floats, column: int) -> Floats:
    """Return a copy of three numbers of a row."""
    return row[column : column + 3].copy()


class _PairSequence(PairGradients, ResultSequence[Record, PairBatch]):
    """Base of results of pairs: ids, normals, bounds, methods and derivatives."""

    def __init__(self, answers: Floats | PairBatch, kept_poses: KeptPoses | None = None) -> None:
        """Refer to answers (k, ANSWER_WIDTH), which must not change, or to a batch.

        Without ``kept_poses``, as for pairs of many states, there are no derivatives.
        """
        if type(answers) is _Array:
            self._ids, self._rows = answers.view(_INT64)[_IDS], answers
        else:
            self._ids, self._rows = answers
        self._kept_poses = kept_poses

    @property
    def _batch(self) -> PairBatch:
        return PairBatch(self._ids, self._rows)

    def _take(self, batch: PairBatch) -> None:
        self._ids, self._rows = batch

    @property
    def is_padded(self) -> bool:
        """True if the answers include paddings, see ``queries.padding``."""
        return bool(self._rows.shape[1] == 2 * BATCH_WIDTH)

    @property
    def _surface_rows(self) -> Floats:
        """The rows about the bodies themselves, without their paddings."""
        return np.ascontiguousarray(self._rows[:, BATCH_WIDTH:]) if self.is_padded else self._rows

    def without_padding(self) -> SignedDistanceResults:
        """Return the same pairs with the distances and witness points of the bodies themselves."""
        bare = SignedDistanceResults(PairBatch(self._ids, self._surface_rows), self._kept_poses)
        return self._with_names(bare)

    def _with_names(self, results: _Pairs) -> _Pairs:
        """Return results that look up names where these do."""
        if self._names_of_ids is not None:
            results.know_names(self._names_of_ids)
        return results

    @property
    def id_A(self) -> NDArray[np.int64]:
        """Id values (k,) of the first geometries."""
        return self._ids[_FIRST]

    @property
    def id_B(self) -> NDArray[np.int64]:
        """Id values (k,) of the second geometries."""
        return self._ids[_SECOND]

    @property
    def name_A(self) -> NDArray[np.str_]:
        """Names (k,) of the first geometries, ``source::frame/geometry``; see ``names_of``."""
        return self.names_of(self.id_A)

    @property
    def name_B(self) -> NDArray[np.str_]:
        """Names (k,) of the second geometries; see ``names_of``."""
        return self.names_of(self.id_B)

    @property
    def nhat_BA_W(self) -> Floats:
        """Unit normals (k, 3), out of B into A."""
        return self._rows[_NORMALS]

    @property
    def p_WCa(self) -> Floats:
        """Witness points on A (k, 3) [m], in World."""
        return self._rows[_POINTS_A]

    @property
    def p_WCb(self) -> Floats:
        """Witness points on B (k, 3) [m], in World."""
        return self._rows[_POINTS_B]

    @property
    def error_bound(self) -> Floats:
        """Certified bounds (k,) [m] on the error of the distance."""
        return self._rows[:, ERROR_BOUND]

    @property
    def promised_error_bound(self) -> Floats:
        """Largest error bounds (k,) [m] that the accuracy level allows; see ``breaks_promise``.

        Infinite where bounds alone answered (METHOD_BOUND_ONLY) and for overlapping solids.
        """
        return self._rows[:, PROMISED]

    def breaks_promise(self) -> NDArray[np.bool_]:
        """Return the mask (k,) of answers that are not finite or exceed the promised bound."""
        return self._batch.broken()

    @property
    def method(self) -> NDArray[np.uint8]:
        """The METHOD_* constant (k,) of each answer."""
        return self._rows[:, METHOD].astype(np.uint8)


class PenetrationResults(_PairSequence[PenetrationAsPointPair]):
    """The penetrating pairs, sorted by (id_A, id_B)."""

    _listed = ('id_A', 'id_B', 'depth', *_OF_PAIRS)

    @property
    def depth(self) -> Floats:
        """Penetration depths (k,) [m], positive."""
        return self._rows[_DEPTHS]

    @property
    def gradients(self) -> Floats:
        """Derivatives (k, 12) of the depths: minus those of the signed distances."""
        return -self._derivatives().gradients

    def depth_jacobian(self, J_As: ArrayLike, J_Bs: ArrayLike) -> Floats:
        """Return the derivatives (k, n) of the depths, as ``distance_jacobian`` of distances."""
        return self._jacobian(J_As, J_Bs)

    def of(self, which: NDArray[np.bool_] | Ids) -> PenetrationResults:
        """Return the pairs of a mask (k,), or of places in their order."""
        batch = PairBatch(self._ids[which], self._rows[which])
        return self._with_names(type(self)(batch, self._kept_poses))

    def and_others(self, batch: PairBatch) -> PenetrationResults:
        """Return these pairs followed by those of a batch, with the batch's columns."""
        ids = np.vstack((self._ids, batch.ids))
        rows = np.vstack((self._rows[:, : batch.rows.shape[1]], batch.rows))
        return self._with_names(type(self)(PairBatch(ids, rows), self._kept_poses))

    def _record(self, k: int) -> PenetrationAsPointPair:
        row = self._rows[k]
        id_A, id_B = self._ids[k].tolist()
        return PenetrationAsPointPair(
            id_A=GeometryId(id_A),
            id_B=GeometryId(id_B),
            p_WCa=_vector(row, WITNESS_A),
            p_WCb=_vector(row, WITNESS_B),
            nhat_BA_W=_vector(row, NORMAL),
            depth=-float(row[DISTANCE]),
            error_bound=float(row[ERROR_BOUND]),
            method=int(row[METHOD]),
        )


class SignedDistanceResults(_PairSequence[SignedDistancePair]):
    """The signed distances of pairs, sorted by (id_A, id_B)."""

    _listed = ('id_A', 'id_B', 'distance', 'is_nhat_BA_W_unique', *_OF_PAIRS)

    def penetrations(self) -> PenetrationResults:
        """Return the pairs among these that ComputePointPairPenetration would report.

        One narrow phase serves both answers of a cycle.
        """
        return self._with_names(PenetrationResults(self._batch.penetrating(), self._kept_poses))

    @property
    def distance(self) -> Floats:
        """Signed distances (k,) [m]."""
        return self._rows[_DISTANCES]

    @property
    def gradients(self) -> Floats:
        """Derivatives (k, 12) of the distances by the motions of A's frame and of B's.

        The first six numbers are by the spatial velocity V_WFa = [w_WFa, v_WFao] of the frame Fa
        that carries A, angular before linear, in World axes, the linear part that of the frame's
        origin [m/rad, -]; the other six by V_WFb likewise: ``gradients[k] @ [V_WFa, V_WFb]`` is
        the rate of distance k [m/s]. For geometry on the world frame it is that frame's motion.
        Where ``is_gradient_unique`` is False it is the member of Clarke's generalised gradient
        that belongs to the row's witness points and normal. It is as exact as the normal, which
        depends on the accuracy level.
        """
        return self._derivatives().gradients

    def distance_jacobian(self, J_As: ArrayLike, J_Bs: ArrayLike) -> Floats:
        """Return the derivatives (k, n) of the distances by n coordinates, from frame Jacobians.

        ``J_As`` and ``J_Bs`` (k, 6, n), or (6, n) for all pairs, are d(V_WF)/d(qdot) of the frames
        that carry A and B, in the layout of ``gradients``. Raises ArgumentError for other shapes.
        """
        return self._jacobian(J_As, J_Bs)

    @property
    def is_nhat_BA_W_unique(self) -> NDArray[np.bool_]:
        """True (k,) where the normal is unique."""
        return self._rows[:, UNIQUE].astype(np.bool_)

    @property
    def p_ACa(self) -> Floats:
        """Witness points on A (k, 3) [m], each in its A's frame."""
        return self._rows[_IN_A]

    @property
    def p_BCb(self) -> Floats:
        """Witness points on B (k, 3) [m], each in its B's frame."""
        return self._rows[_IN_B]

    def _record(self, k: int) -> SignedDistancePair:
        row = self._rows[k]
        id_A, id_B = self._ids[k].tolist()
        return SignedDistancePair(
            id_A=GeometryId(id_A),
            id_B=GeometryId(id_B),
            p_ACa=_vector(row, P_ACA),
            p_BCb=_vector(row, P_BCB),
            distance=float(row[DISTANCE]),
            nhat_BA_W=_vector(row, NORMAL),
            is_nhat_BA_W_unique=bool(row[UNIQUE]),
            error_bound=float(row[ERROR_BOUND]),
            method=int(row[METHOD]),
            _p_FaCa_W=_vector(row, P_FACA),
            _p_FbCb_W=_vector(row, P_FBCB),
        )


class PointDistanceResults(PointGradients, ResultSequence[SignedDistanceToPoint, PointBatch]):
    """The signed distances from geometries to points, sorted by (point_index, id_G)."""

    _listed = (
        *('point_index', 'id_G', 'distance', 'error_bound', 'grad_W', 'is_grad_W_unique'),
        *('p_GN', 'method'),
    )

    def __init__(
        self,
        batch: PointBatch,
        kept_poses: KeptPoses | None = None,
        p_WQs: Floats | None = None,
        is_padded: bool = False,
    ) -> None:
        """Without ``kept_poses``, as for points in many states, there are no derivatives."""
        self.is_padded = is_padded
        self._take(batch)
        self._kept_poses = kept_poses
        if p_WQs is not None:
            self._p_WQs = p_WQs

    @property
    def _batch(self) -> PointBatch:
        return self._arrays

    def _take(self, batch: PointBatch) -> None:
        self._arrays, self._rows = batch, batch.rows

    @property
    def id_G(self) -> NDArray[np.int64]:
        """Id values (k,) of the geometries."""
        return self._batch.ids

    @property
    def name_G(self) -> NDArray[np.str_]:
        """Names (k,) of the geometries, ``source::frame/geometry``; see ``names_of``."""
        return self.names_of(self.id_G)

    @property
    def point_index(self) -> NDArray[np.uint32]:
        """Index (k,) of each answer's point."""
        return self._batch.points

    @property
    def distance(self) -> Floats:
        """Signed distances (k,) [m]."""
        return self._rows[:, POINT_DISTANCE]

    @property
    def grad_W(self) -> Floats:
        """Unit gradients (k, 3) of the distances with respect to the point."""
        return self._rows[:, POINT_GRADIENT : POINT_GRADIENT + 3]

    @property
    def is_grad_W_unique(self) -> NDArray[np.bool_]:
        """True (k,) where the gradient is unique."""
        return self._rows[:, POINT_UNIQUE].astype(np.bool_)

    @property
    def p_GN(self) -> Floats:
        """Nearest surface points (k, 3) [m], each in its geometry's frame."""
        return self._rows[:, POINT_NEAREST : POINT_NEAREST + 3]

    @property
    def error_bound(self) -> Floats:
        """Certified bounds (k,) [m] on the error of the distance."""
        return self._rows[:, POINT_ERROR_BOUND]

    @property
    def method(self) -> NDArray[np.uint8]:
        """The METHOD_* constant (k,) of each answer."""
        return self._rows[:, POINT_METHOD].astype(np.uint8)

    def _record(self, k: int) -> SignedDistanceToPoint:
        row = self._rows[k]
        return SignedDistanceToPoint(
            id_G=GeometryId(int(self.id_G[k])),
            p_GN=_vector(row, POINT_NEAREST),
            grad_W=_vector(row, POINT_GRADIENT),
            distance=float(row[POINT_DISTANCE]),
            is_grad_W_unique=bool(row[POINT_UNIQUE]),
            error_bound=float(row[POINT_ERROR_BOUND]),
            method=int(row[POINT_METHOD]),
            point_index=int(self.point_index[k]),
        )
