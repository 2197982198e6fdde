"""Contact surfaces with names, and the pairs that overlap without a surface."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any, TypeVar

import numpy as np

from drake_geom_ros.client.left_out import IncompleteError
from drake_geom_ros.client.results import Pair, PairResults
from drake_geom_ros.common.counting import counted
from drake_geom_ros.math.array_types import Floats

OUT_OF_TIME = 7  # NoSurface.OUT_OF_TIME
_SHOWN = 3  # pairs in a sentence
_REASONS = {
    1: 'one has no hydroelastic properties',
    2: 'both are rigid',
    3: 'both are half spaces',
    4: 'one is too deep within the other',
    5: 'all faces are left out: one pressure does not grow along their normals',
    6: 'the meshes that stand for them are too coarse to meet',
    OUT_OF_TIME: 'there was no time to compute their surface',
}
_Surfaces = TypeVar('_Surfaces', bound='ContactSurfaces')


@dataclass(frozen=True)
class ContactSurface(Pair):
    """Contact surface of two geometries: ``area`` [m^2], ``max_pressure`` [Pa].

    ``centroid`` and ``centre_of_pressure`` (3,) [m], ``force_on_A_W`` (3,) [N] and
    ``torque_on_A_Wo_W`` (3,) [N m] about the world's origin are in the world.
    """

    area: float
    max_pressure: float
    centroid: Floats
    centre_of_pressure: Floats
    force_on_A_W: Floats
    torque_on_A_Wo_W: Floats


@dataclass(frozen=True)
class PairWithoutSurface(Pair):
    """A pair that overlaps without a contact surface, with the reason and the depth [m].

    Two half spaces have infinite depth, and NaN for witness points and normal.
    """

    reason: str
    depth: float
    error_bound: float
    p_WCa: Floats
    p_WCb: Floats
    nhat_BA_W: Floats


class PairsWithoutSurface(PairResults[PairWithoutSurface]):
    """The pairs of a ContactSurfaces message that overlap and have no surface.

    Arrays: ``depth``, ``error_bound`` (n,) [m], ``p_WCa``, ``p_WCb``, ``nhat_BA_W`` (n, 3),
    ``reason`` (n,) REASON_* constants, ``id_a``, ``id_b`` (n,).
    """

    _PREFIX = 'point_pair_'

    def _read(self, message: Any) -> None:
        super()._read(message)
        self.reason = self._column('reason', kind=np.int64)  # (n,)
        self.depth = self._column('depth')  # (n,) [m]
        self.error_bound = self._column('error_bound')  # (n,) [m]
        self.p_WCa = self._column('p_wca', 3)  # (n, 3) [m]
        self.p_WCb = self._column('p_wcb', 3)  # (n, 3) [m]
        self.nhat_BA_W = self._column('nhat_ba_w', 3)  # (n, 3)

    def _record(self, k: int) -> PairWithoutSurface:
        columns = self._row(k, 'depth', 'error_bound', 'p_WCa', 'p_WCb', 'nhat_BA_W')
        number = int(self.reason[k])
        reason = _REASONS.get(number, f'reason {number}')
        return PairWithoutSurface(**self._pair(k), reason=reason, **columns)


class ContactSurfaces(PairResults[ContactSurface]):
    """Surfaces of a ContactSurfaces message, with names.

    Arrays: ``area`` (n,) [m^2], ``max_pressure`` (n,) [Pa], ``centroid``, ``centre_of_pressure``
    (n, 3) [m], ``force_on_A_W`` (n, 3) [N], ``torque_on_A_Wo_W`` (n, 3) [N m], ``faces`` (n,),
    ``id_a``, ``id_b`` (n,). ``without_surface`` holds the pairs that overlap without a surface,
    ``participants`` the number of geometries with hydroelastic properties.

    An empty result does not prove that nothing touches: its ``bool()`` raises IncompleteError if
    pairs overlap without a surface, or if no geometry has hydroelastic properties.
    """

    def _read(self, message: Any) -> None:
        super()._read(message)
        self.participants = int(message.participants)
        self.area = self._column('area')
        self.max_pressure = self._column('max_pressure')
        self.centroid = self._column('p_wc', 3)
        self.centre_of_pressure = self._column('centre_of_pressure', 3)
        self.force_on_A_W = self._column('force_on_a_w', 3)
        self.torque_on_A_Wo_W = self._column('torque_on_a_wo_w', 3)
        self.faces = self._column('faces', kind=np.int64)
        self.without_surface = PairsWithoutSurface(message, self.table)

    def whole(self: _Surfaces, what: str) -> _Surfaces:
        """Return the results if they are complete; raise IncompleteError about ``what`` if not."""
        if not self.participants:
            raise IncompleteError(
                f'{what}: no geometry of the scene has hydroelastic properties, so nothing was '
                'computed; see docs/contact_surfaces.md'
            )
        if late := int((self.without_surface.reason == OUT_OF_TIME).sum()):
            raise IncompleteError(
                f'{what}: there was no time to compute the surfaces of {counted(late, "pair")}; '
                'see without_surface, and docs/contact_surfaces.md'
            )
        return super().whole(what)

    def between(self: _Surfaces, a: str, b: str = '*') -> _Surfaces:
        """Return the surfaces between geometries that match ``a`` and ``b``, in any order.

        ``without_surface`` is restricted to these pairs too. Patterns and errors are those of
        ``PairResults.between``.
        """
        surfaces = super().between(a, b)
        surfaces.without_surface = self.without_surface.between(a, b)
        return surfaces

    def polygons(self, k: int) -> list[tuple[Floats, Floats]]:
        """Return corners (m, 3) [m] in the world and pressures (m,) [Pa] of surface k's polygons.

        Raises RuntimeError if the message was requested without polygons.
        """
        message, row = self._message, int(self._rows[k])
        if not message.has_polygons:
            raise RuntimeError(
                'these results have no polygons: ask with polygons=True, or set the parameter '
                'contact_polygons of the node'
            )
        first = int(np.sum(np.asarray(message.faces[:row], dtype=np.int64)))
        ends = np.concatenate(([0], np.asarray(message.polygon_ends))).astype(np.int64)
        p_WVs = np.reshape(np.asarray(message.p_wv, dtype=np.float64), (-1, 3))
        pressures = np.asarray(message.pressure, dtype=np.float64)
        bounds = ends[first : first + int(message.faces[row]) + 1].tolist()
        return [(p_WVs[begin:end], pressures[begin:end]) for begin, end in pairwise(bounds)]

    def __bool__(self) -> bool:
        """Return whether there is a surface; raise IncompleteError if pairs overlap without."""
        if not len(self) and len(self.without_surface):
            pairs = self.without_surface[:_SHOWN]
            pair_reasons = ', '.join(f'{p.name_a} and {p.name_b} ({p.reason})' for p in pairs)
            raise IncompleteError(
                f'no surface, and yet pairs overlap: {pair_reasons}; see without_surface'
            )
        return super().__bool__()

    def _record(self, k: int) -> ContactSurface:
        columns = self._row(
            *(k, 'area', 'max_pressure', 'centroid', 'centre_of_pressure'),
            *('force_on_A_W', 'torque_on_A_Wo_W'),
        )
        return ContactSurface(**self._pair(k), **columns)
