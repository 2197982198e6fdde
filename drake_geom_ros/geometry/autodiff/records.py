"""Records of a pair, or of a geometry and a point, in numbers with derivatives."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np

from drake_geom_ros.autodiffutils import AutoDiffXd
from drake_geom_ros.geometry.ids import GeometryId
from drake_geom_ros.geometry.queries.query_records import (
    PenetrationAsPointPair,
    SignedDistancePair,
    SignedDistanceToPoint,
)


class _AutoDiffRecord:
    """Named values; points and normals are computed on first access.

    Access raises GeometryError if they have no derivatives, even where the distance has.
    """

    _NAMES: ClassVar[tuple[str, ...]] = ()
    _PLAIN: ClassVar[Callable[[], Any]]  # makes the record of floats
    _witnesses: Callable[[], dict[str, Any]] | None = None

    def __init__(self, **values: Any) -> None:
        """Take values by name; without any, those of a new record of floats."""
        for name, value in (values or self._defaults()).items():
            self._set(name, value)

    def _defaults(self) -> dict[str, Any]:
        plain = type(self)._PLAIN()
        values = {name: getattr(plain, name, False) for name in self._NAMES}
        for name, value in values.items():
            if isinstance(value, np.ndarray):
                values[name] = np.array([AutoDiffXd(x, []) for x in value.tolist()], dtype=object)
            elif name in ('distance', 'depth'):
                values[name] = AutoDiffXd(value, [])
        return values

    def _set(self, name: str, value: Any) -> None:
        if name not in self._NAMES:
            raise TypeError(f'{type(self).__name__} has {", ".join(self._NAMES)}; not {name}')
        setattr(self, name, value)

    def __getattr__(self, name: str) -> Any:
        if name in self._NAMES and self._witnesses is not None:
            vars(self).update(self._witnesses())
            return vars(self)[name]
        raise AttributeError(f'{type(self).__name__} has no {name}')

    def completed_by(self, witnesses: Callable[[], dict[str, Any]]) -> Any:
        """Set the function that computes the missing values, and return this record."""
        self._witnesses = witnesses
        return self


class SignedDistancePairAutoDiffXd(_AutoDiffRecord):
    """A ``SignedDistancePair`` of AutoDiffXd: distance, p_ACa, p_BCb and nhat_BA_W are such.

    ``is_gradient_unique`` is True if the distance has a derivative; otherwise it has a member of
    the generalised gradient. Access to points and the normal raises GeometryError, with the
    reason, if they have no derivatives. The error bound is that of the distance's value.
    """

    _PLAIN = SignedDistancePair
    _NAMES = (
        *('id_A', 'id_B', 'distance', 'p_ACa', 'p_BCb', 'nhat_BA_W', 'is_nhat_BA_W_unique'),
        *('is_gradient_unique', 'error_bound', 'method'),
    )
    id_A: GeometryId
    id_B: GeometryId


class PenetrationAsPointPairAutoDiffXd(_AutoDiffRecord):
    """A ``PenetrationAsPointPair`` of AutoDiffXd: depth, p_WCa, p_WCb and nhat_BA_W are such.

    As for ``SignedDistancePair_[AutoDiffXd]`` the depth always has derivatives, and access to the
    others may raise GeometryError.
    """

    _PLAIN = PenetrationAsPointPair
    _NAMES = (
        *('id_A', 'id_B', 'depth', 'p_WCa', 'p_WCb', 'nhat_BA_W'),
        *('is_gradient_unique', 'error_bound', 'method'),
    )
    id_A: GeometryId
    id_B: GeometryId


class SignedDistanceToPointAutoDiffXd(_AutoDiffRecord):
    """A ``SignedDistanceToPoint`` of AutoDiffXd: distance, p_GN and grad_W are such.

    The distance always has derivatives, and access to the others may raise GeometryError.
    """

    _PLAIN = SignedDistanceToPoint
    _NAMES = (
        *('id_G', 'distance', 'p_GN', 'grad_W', 'is_grad_W_unique'),
        *('error_bound', 'method', 'point_index'),
    )
    id_G: GeometryId
