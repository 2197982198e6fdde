"""Records of one pair, or of one geometry and a point, with the fields of pydrake's records."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from drake_geom_ros.geometry.ids import GeometryId
from drake_geom_ros.math.array_types import Floats


def _zeros() -> Floats:
    return np.zeros(3)


def _no_id() -> GeometryId:
    return GeometryId(0)


class _Record:
    """Base of records: they are equal if all their fields are."""

    __slots__ = ()

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        pairs = zip(vars(self).values(), vars(other).values(), strict=True)
        return all(np.array_equal(value, other_value) for value, other_value in pairs)

    __hash__ = None  # type: ignore[assignment]


@dataclass(kw_only=True, eq=False)
class PenetrationAsPointPair(_Record):
    """Two overlapping geometries, with the pair of points of deepest penetration.

    ``depth = (p_WCb - p_WCa) . nhat_BA_W`` [m], positive; -1 in a default record.
    ``nhat_BA_W`` is unit and points out of B into A. ``|depth - true depth| <= error_bound``. An
    answer from bounds alone may report bodies that are apart; their true depth is minus their
    distance.
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
class SignedDistancePair(_Record):
    """The signed distance of two geometries, with its witness points.

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
        surface points move with v + w x p, and only their separation along the normal counts
        (envelope theorem). Valid where the normal is unique.
        """
        n = self.nhat_BA_W
        return (
            np.concatenate((np.cross(self._p_FaCa_W, n), n)),
            -np.concatenate((np.cross(self._p_FbCb_W, n), n)),
        )


@dataclass(kw_only=True, eq=False)
class SignedDistanceToPoint(_Record):
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
