"""Results of a scene_graph node with names: arrays that return records when indexed.

::

    for pair in distances.between('left', 'room'):
        print(pair.name_a, pair.name_b, pair.lower_bound)
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.client.left_out import LeftOut
from drake_geom_ros.client.scene_table import SceneTable
from drake_geom_ros.math.array_types import Floats

Ids = NDArray[np.int64]
Record = TypeVar('Record')
Rows = TypeVar('Rows', bound='Results[Any]')
Pairs = TypeVar('Pairs', bound='PairResults[Any]')


@dataclass(frozen=True)
class Pair:
    """Two geometries; names are ``frame/geometry``."""

    id_a: int
    source_a: str
    name_a: str
    id_b: int
    source_b: str
    name_b: str


@dataclass(frozen=True)
class SignedDistance(Pair):
    """The signed distance [m] of two geometries; ``|distance - truth| <= error_bound``.

    ``p_ACa`` and ``p_BCb`` (3,) [m] are the nearest points, each in its geometry's frame;
    ``nhat_BA_W`` (3,) is the unit normal out of B into A, in the world.
    """

    distance: float
    error_bound: float
    p_ACa: Floats
    p_BCb: Floats
    nhat_BA_W: Floats

    @property
    def lower_bound(self) -> float:
        """The certified lower bound of the true distance [m]."""
        return self.distance - self.error_bound


@dataclass(frozen=True)
class Penetration(Pair):
    """The depth [m] by which two geometries overlap; ``|depth - truth| <= error_bound``.

    ``p_WCa`` and ``p_WCb`` (3,) [m] are the deepest points, in the world.
    """

    depth: float
    error_bound: float
    p_WCa: Floats
    p_WCb: Floats
    nhat_BA_W: Floats


@dataclass(frozen=True)
class PointDistance:
    """The signed distance [m] of a point to a geometry; ``|distance - truth| <= error_bound``.

    ``p_GN`` (3,) [m] is the nearest point of the surface, in the geometry's frame; ``grad_W`` (3,)
    is the gradient of the distance with respect to the point, in the world.
    """

    point_index: int
    id: int
    source: str
    name: str
    distance: float
    error_bound: float
    p_GN: Floats
    grad_W: Floats

    @property
    def lower_bound(self) -> float:
        """The certified lower bound of the true distance [m]."""
        return self.distance - self.error_bound


class Results(Sequence[Record], Generic[Record]):
    """Rows of a message, with the scene table that it refers to.

    Rows omit geometries on frames that have never received a pose; ``waiting_frames`` names
    these frames. They also omit the ``shell_points``, which sensors saw beside bodies, the nearest
    ``least_shell_distance`` [m] from one. ``is_complete`` is true if nothing is omitted.
    An empty incomplete result must not look like free space: its ``bool()`` raises
    IncompleteError.
    """

    _PREFIX = ''  # of the message's columns
    _KEY: str  # a column with one entry per row

    def __init__(
        self,
        message: Any,
        table: SceneTable,
        rows: Ids | None = None,
        is_complete: bool | None = None,
    ) -> None:
        """Select ``rows`` of the message, or all; ``is_complete`` None: as the message says."""
        self._message = message
        self._left_out = self._missing_from(message)
        self.waiting_frames = self._left_out.frames
        self.shell_points = self._left_out.shell_points
        self.least_shell_distance = self._left_out.least_shell_distance  # inf: there is no point
        self.is_complete = self._left_out.is_nothing if is_complete is None else is_complete
        count = len(getattr(message, self._PREFIX + self._KEY))
        self._rows = np.arange(count) if rows is None else rows
        self.table = table
        self.scene_version = int(message.scene_version)
        # [s] of the newest pose used
        self.stamp = message.header.stamp.sec + message.header.stamp.nanosec / 1_000_000_000
        self.oldest_pose_age = float(message.oldest_pose_age)  # [s]; inf: unknown
        self.oldest_frame = table.frame_name(message.oldest_frame)  # empty: no pose gets stale
        self._read(message)

    @abstractmethod
    def _read(self, message: Any) -> None:
        """Read the columns of this kind of results."""

    def _column(self, name: str, width: int = 1, kind: type = np.float64) -> NDArray[Any]:
        column = getattr(self._message, self._PREFIX + name)
        values: NDArray[Any] = np.asarray(column).astype(kind)
        return (values if width == 1 else values.reshape(-1, width))[self._rows]

    def _row(self, k: int, *names: str) -> dict[str, Any]:
        """Return row ``k`` of the named columns, with scalars as Python numbers."""
        columns = {name: getattr(self, name) for name in names}
        return {name: x[k] if x.ndim > 1 else x[k].item() for name, x in columns.items()}

    @staticmethod
    @abstractmethod
    def _missing_from(message: Any) -> LeftOut:
        """Return what a message of this kind omits."""

    def whole(self: Rows, what: str) -> Rows:
        """Return the results if they are complete; raise IncompleteError about ``what`` if not."""
        if not self.is_complete:
            self._left_out.refuse(what)
        return self

    def _subset(self: Rows, mask: NDArray[np.bool_], *names: Ids) -> Rows:
        """Return the masked rows, which are all rows of the geometries with these ids."""
        is_complete = self.is_complete or not (
            self.table.waits(names, self.waiting_frames)
            or (self.shell_points and self.table.have_maps(names))
        )
        return type(self)(self._message, self.table, self._rows[mask], is_complete)

    def __len__(self) -> int:
        return len(self._rows)

    def __bool__(self) -> bool:
        """Return whether there is a row; raise IncompleteError if rows may be omitted."""
        if not len(self):
            self.whole('no row')
        return len(self) > 0

    def __getitem__(self, k: Any) -> Any:
        """Return the record of row ``k``, or the rows of a slice."""
        if isinstance(k, slice):
            return type(self)(self._message, self.table, self._rows[k], self.is_complete)
        return self._record(range(len(self))[k])

    def __iter__(self) -> Iterator[Record]:
        return map(self._record, range(len(self)))

    @abstractmethod
    def _record(self, k: int) -> Record:
        """Return the record of row ``k``."""


class PairResults(Results[Record]):
    """Rows about pairs of geometries."""

    _KEY = 'id_a'

    def _read(self, message: Any) -> None:
        self.id_a = self._column('id_a', kind=np.int64)  # (n,)
        self.id_b = self._column('id_b', kind=np.int64)  # (n,)

    @staticmethod
    def _missing_from(message: Any) -> LeftOut:
        return LeftOut.of_pairs(message)

    @property
    def waiting_pairs(self) -> int:
        """Number of unfiltered pairs that the message omits."""
        return self._left_out.number

    def between(self: Pairs, a: str, b: str = '*') -> Pairs:
        """Return the pairs of a geometry that matches ``a`` and one that matches ``b``.

        The order does not matter. Each is a source, a frame, a geometry or a pattern: see
        ``Geometry.matches``. Raises UnknownNameError, with the nearest names, if no geometry
        that queries report matches.
        """
        ids_a, ids_b = self.table.ids(a), self.table.ids(b)
        one_way = np.isin(self.id_a, ids_a) & np.isin(self.id_b, ids_b)
        other_way = np.isin(self.id_a, ids_b) & np.isin(self.id_b, ids_a)
        return self._subset(one_way | other_way, ids_a, ids_b)

    def _pair(self, k: int) -> dict[str, Any]:
        a, b = self.table[self.id_a[k]], self.table[self.id_b[k]]
        of_a = {'id_a': a.id, 'source_a': a.source, 'name_a': a.short_name}
        return {**of_a, 'id_b': b.id, 'source_b': b.source, 'name_b': b.short_name}


class _CertifiedPairs(PairResults[Record]):
    """Rows about pairs with normals, error bounds and methods."""

    def _read(self, message: Any) -> None:
        super()._read(message)
        self.nhat_BA_W = self._column('nhat_ba_w', 3)  # (n, 3)
        self.error_bound = self._column('error_bound')  # (n,) [m]
        self.method = self._column('method', kind=np.int64)  # (n,) METHOD_* constants


class SignedDistances(_CertifiedPairs[SignedDistance]):
    """Signed distances of a SignedDistancePairs message, with names.

    Arrays: ``distance``, ``error_bound``, ``lower_bound`` (n,) [m], ``p_ACa``, ``p_BCb``,
    ``nhat_BA_W`` (n, 3), ``id_a``, ``id_b``, ``method`` (n,).
    """

    def _read(self, message: Any) -> None:
        super()._read(message)
        self.max_distance = float(message.max_distance)  # [m]
        self.distance = self._column('distance')  # (n,) [m]
        self.p_ACa = self._column('p_aca', 3)  # (n, 3) [m]
        self.p_BCb = self._column('p_bcb', 3)  # (n, 3) [m]

    @property
    def lower_bound(self) -> Floats:
        """The certified lower bounds of the true distances (n,) [m]."""
        return np.asarray(self.distance - self.error_bound)

    def closest(self, allow_incomplete: bool = False) -> SignedDistance | None:
        """Return the pair with the smallest lower bound; None if there is no pair.

        Raises IncompleteError if a closer pair may be omitted, unless ``allow_incomplete``.
        """
        if not allow_incomplete:
            self.whole('the closest pair')
        return self[int(np.argmin(self.lower_bound))] if len(self) else None

    def _record(self, k: int) -> SignedDistance:
        columns = self._row(k, 'distance', 'error_bound', 'p_ACa', 'p_BCb', 'nhat_BA_W')
        return SignedDistance(**self._pair(k), **columns)


class Penetrations(_CertifiedPairs[Penetration]):
    """Overlaps of a PenetrationPairs message, with names.

    Arrays: ``depth``, ``error_bound`` (n,) [m], ``p_WCa``, ``p_WCb``, ``nhat_BA_W`` (n, 3),
    ``id_a``, ``id_b``, ``method`` (n,).
    """

    def _read(self, message: Any) -> None:
        super()._read(message)
        self.depth = self._column('depth')  # (n,) [m]
        self.p_WCa = self._column('p_wca', 3)  # (n, 3) [m]
        self.p_WCb = self._column('p_wcb', 3)  # (n, 3) [m]

    def _record(self, k: int) -> Penetration:
        columns = self._row(k, 'depth', 'error_bound', 'p_WCa', 'p_WCb', 'nhat_BA_W')
        return Penetration(**self._pair(k), **columns)


class PointDistances(Results[PointDistance]):
    """Distances of a PointDistances message, with names.

    Arrays: ``point_index``, ``id``, ``method`` (n,), ``distance``, ``error_bound`` (n,) [m],
    ``p_GN``, ``grad_W`` (n, 3).
    """

    _KEY = 'id_g'

    def _read(self, message: Any) -> None:
        self.error_bound = self._column('error_bound')  # (n,) [m]
        self.method = self._column('method', kind=np.int64)  # (n,) METHOD_* constants
        self.point_index = self._column('point_index', kind=np.int64)  # (n,)
        self.id = self._column('id_g', kind=np.int64)  # (n,)
        self.distance = self._column('distance')  # (n,) [m]
        self.p_GN = self._column('p_gn', 3)  # (n, 3) [m]
        self.grad_W = self._column('grad_w', 3)  # (n, 3)
        # [s] stamp of the query points
        self.query_stamp = message.query_stamp.sec + message.query_stamp.nanosec / 1_000_000_000

    @staticmethod
    def _missing_from(message: Any) -> LeftOut:
        return LeftOut.of_geometries(message)

    @property
    def waiting_geometries(self) -> int:
        """Number of geometries that the message omits."""
        return self._left_out.number

    def to(self, name: str) -> PointDistances:
        """Return the distances to the geometries that a name or a pattern matches.

        Raises UnknownNameError, with the nearest names, if no geometry that queries report does.
        """
        ids = self.table.ids(name)
        return self._subset(np.isin(self.id, ids), ids)

    def _record(self, k: int) -> PointDistance:
        g = self.table[self.id[k]]
        columns = self._row(k, 'point_index', 'distance', 'error_bound', 'p_GN', 'grad_W')
        return PointDistance(id=g.id, source=g.source, name=g.short_name, **columns)
