"""What queries return: records as pydrake has them, made when indexed, over arrays.

A record costs about a microsecond of Python, which for all pairs of a large scene is more than
the whole query (measured: 0.7 us to 1 us each). So a query returns a read-only sequence that
keeps NumPy arrays and makes the record of an index when somebody asks for it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Generic, TypeVar, overload

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.batches import (
    P_ACA,
    P_BCB,
    P_FACA,
    P_FBCB,
    PROMISED,
    PairBatch,
    PointBatch,
)
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
from drake_geom_ros.geometry.ids import GeometryId

Floats = NDArray[np.float64]
Record = TypeVar('Record')


def _zeros() -> Floats:
    return np.zeros(3)


def _no_id() -> GeometryId:
    return GeometryId(0)


@dataclass(kw_only=True, eq=False)
class PenetrationAsPointPair:
    """Two overlapping geometries, by the pair of points that most deeply penetrate each other.

    ``depth = (p_WCb - p_WCa) . nhat_BA_W`` [m], positive; -1 in a record nobody filled.
    ``nhat_BA_W`` is unit and points out of B into A. ``|depth - true depth| <= error_bound``; the
    true depth of bodies that are apart, which bounds alone may report, is minus their distance.
    """

    id_A: GeometryId = field(default_factory=_no_id)
    id_B: GeometryId = field(default_factory=_no_id)
    p_WCa: Floats = field(default_factory=_zeros)
    p_WCb: Floats = field(default_factory=_zeros)
    nhat_BA_W: Floats = field(default_factory=_zeros)
    depth: float = -1.0
    error_bound: float = 0.0
    method: int = 0


@dataclass(kw_only=True, eq=False)
class SignedDistancePair:
    """The signed distance of two geometries and the points that witness it.

    ``p_ACa`` and ``p_BCb`` are measured and expressed in the geometries' own frames [m],
    ``nhat_BA_W`` is the gradient of the distance with respect to a translation of A, out of B
    into A. ``|distance - true distance| <= error_bound``.
    """

    id_A: GeometryId = field(default_factory=_no_id)
    id_B: GeometryId = field(default_factory=_no_id)
    p_ACa: Floats = field(default_factory=_zeros)
    p_BCb: Floats = field(default_factory=_zeros)
    distance: float = 0.0
    nhat_BA_W: Floats = field(default_factory=_zeros)
    is_nhat_BA_W_unique: bool = True
    error_bound: float = 0.0
    method: int = 0
    _p_FaCa_W: Floats = field(default_factory=_zeros, repr=False)
    _p_FbCb_W: Floats = field(default_factory=_zeros, repr=False)

    def gradient(self) -> tuple[Floats, Floats]:
        """Return d(distance)/d(pose) for the frames Fa and Fb that carry A and B, (6,) each.

        With the spatial velocities V_WF = [w_WF, v_WFo] (rotational first, as in Drake, in World)
        the distance changes at the rate ``gradient[0] . V_WFa + gradient[1] . V_WFb``: the
        surface points move with v + w x p, and only their parting along the normal counts
        (envelope theorem). Valid where the normal is unique.
        """
        n = self.nhat_BA_W
        return (
            np.concatenate((np.cross(self._p_FaCa_W, n), n)),
            -np.concatenate((np.cross(self._p_FbCb_W, n), n)),
        )


@dataclass(kw_only=True, eq=False)
class SignedDistanceToPoint:
    """The signed distance from a geometry G to a query point Q.

    ``p_GN`` is the point of G's surface nearest to Q, in G [m]; ``grad_W`` the gradient of the
    distance with respect to the position of Q: unit, and finite even where it is not unique.
    """

    id_G: GeometryId = field(default_factory=_no_id)
    p_GN: Floats = field(default_factory=_zeros)
    distance: float = 0.0
    grad_W: Floats = field(default_factory=_zeros)
    is_grad_W_unique: bool = True
    error_bound: float = 0.0
    method: int = 0
    point_index: int = 0


class ResultSequence(Sequence[Record], Generic[Record]):
    """A read-only sequence of records over arrays; subclasses name the arrays."""

    def __init__(self, count: int) -> None:
        self._count = count

    def __len__(self) -> int:
        return self._count

    @overload
    def __getitem__(self, index: int) -> Record: ...
    @overload
    def __getitem__(self, index: slice) -> list[Record]: ...
    def __getitem__(self, index: int | slice) -> Record | list[Record]:
        if isinstance(index, slice):
            return [self._record(k) for k in range(*index.indices(self._count))]
        if not -self._count <= index < self._count:
            raise IndexError(f'result {index} of {self._count} results was asked for')
        return self._record(index % self._count)

    def __repr__(self) -> str:
        return f'<{type(self).__name__} of {self._count} results>'

    def _record(self, k: int) -> Record:
        raise NotImplementedError


def _vector(row: Floats, column: int) -> Floats:
    """Return three numbers of a row as an array of its own."""
    return row[column : column + 3].copy()


class _PairSequence(ResultSequence[Record]):
    """What both pair results share: ids, normals, bounds and methods."""

    def __init__(self, batch: PairBatch) -> None:
        super().__init__(len(batch.ids))
        self._batch = batch
        self._rows = batch.rows

    @property
    def id_A(self) -> NDArray[np.int64]:
        """Id values (k,) of the first geometries."""
        return self._batch.ids[:, 0]

    @property
    def id_B(self) -> NDArray[np.int64]:
        """Id values (k,) of the second geometries."""
        return self._batch.ids[:, 1]

    @property
    def nhat_BA_W(self) -> Floats:
        """Unit normals (k, 3), out of B into A."""
        return self._rows[:, NORMAL : NORMAL + 3]

    @property
    def p_WCa(self) -> Floats:
        """Witness points on A (k, 3) [m], in World."""
        return self._rows[:, WITNESS_A : WITNESS_A + 3]

    @property
    def p_WCb(self) -> Floats:
        """Witness points on B (k, 3) [m], in World."""
        return self._rows[:, WITNESS_B : WITNESS_B + 3]

    @property
    def error_bound(self) -> Floats:
        """Certified bounds (k,) [m] on the error of the distance."""
        return self._rows[:, ERROR_BOUND]

    @property
    def promised_error_bound(self) -> Floats:
        """What the accuracy level promises of each error bound (k,) [m]; see ``breaks_promise``.

        Infinite where bounds alone answered (METHOD_BOUND_ONLY) and for overlapping solids.
        """
        return self._rows[:, PROMISED]

    def breaks_promise(self) -> NDArray[np.bool_]:
        """Return which answers (k,) are not finite or less sharp than their level promises."""
        return self._batch.broken()

    @property
    def method(self) -> NDArray[np.uint8]:
        """The METHOD_* constant (k,) of each answer."""
        return self._rows[:, METHOD].astype(np.uint8)


class PenetrationResults(_PairSequence[PenetrationAsPointPair]):
    """The penetrating pairs, sorted by (id_A, id_B)."""

    @property
    def depth(self) -> Floats:
        """Penetration depths (k,) [m], positive."""
        return -self._rows[:, DISTANCE]

    def _record(self, k: int) -> PenetrationAsPointPair:
        row = self._rows[k]
        id_A, id_B = self._batch.ids[k].tolist()
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

    def penetrations(self) -> PenetrationResults:
        """Return those of these pairs that ComputePointPairPenetration would report.

        One narrow phase serves both answers of a cycle.
        """
        return PenetrationResults(self._batch.penetrating())

    @property
    def distance(self) -> Floats:
        """Signed distances (k,) [m]."""
        return self._rows[:, DISTANCE]

    @property
    def is_nhat_BA_W_unique(self) -> NDArray[np.bool_]:
        """Whether each normal is the only one (k,)."""
        return self._rows[:, UNIQUE].astype(np.bool_)

    @property
    def p_ACa(self) -> Floats:
        """Witness points on A (k, 3) [m], each in its A's frame."""
        return self._rows[:, P_ACA : P_ACA + 3]

    @property
    def p_BCb(self) -> Floats:
        """Witness points on B (k, 3) [m], each in its B's frame."""
        return self._rows[:, P_BCB : P_BCB + 3]

    def _record(self, k: int) -> SignedDistancePair:
        row = self._rows[k]
        id_A, id_B = self._batch.ids[k].tolist()
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


class PointDistanceResults(ResultSequence[SignedDistanceToPoint]):
    """The signed distances from geometries to points, sorted by (point_index, id_G)."""

    def __init__(self, batch: PointBatch) -> None:
        super().__init__(len(batch.ids))
        self._rows = batch.rows
        self.id_G: NDArray[np.int64] = batch.ids
        self.point_index: NDArray[np.uint32] = batch.points

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
        """Whether each gradient is the only one (k,)."""
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
