"""Results of ``evaluate``: arrays by name."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.batch.contacts import ContactsOfStates
from drake_geom_ros.batch.names import Names, PairNames
from drake_geom_ros.common.tables import Columns, Tabular
from drake_geom_ros.math.array_types import Flags, Floats, Indices


class _LeastDistances(NamedTuple):
    distance: Floats  # (N,) [m]
    error_bound: Floats  # (N,) [m]
    id_A: Indices  # (N,) values of GeometryId
    id_B: Indices  # (N,)
    gradient: Floats  # (N, 12) with respect to the poses of both frames, see SignedDistancePair
    nhat_BA_W: Floats  # (N, 3)
    is_nhat_BA_W_unique: Flags  # (N,)
    p_WCa: Floats  # (N, 3) [m]
    p_WCb: Floats  # (N, 3) [m]
    method: NDArray[np.uint8]  # (N,) the METHOD_* constants
    joint_gradient: Floats  # (N, q) by joint values [m/rad] or [-]; (N, 0) without by_joints


class _OfStates(Tabular, Names):
    """Base of results with columns of rows, each of a state."""

    def columns(self) -> Columns:
        """Return the arrays (k, ...) by name, after the ``state`` (k,) of each row."""
        fields: Columns = self._asdict()  # type: ignore[attr-defined]
        offsets = fields.pop('offsets', None)
        rows = np.arange(len(fields['distance']))
        if offsets is not None:
            rows = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
        columns: Columns = {'state': rows}
        for name, values in fields.items():
            columns[name] = values
            if name.startswith('id_') and self._name_of:
                columns[name.replace('id_', 'name_')] = self.names_of(values)
        return columns

    def __repr__(self) -> str:
        columns = self._asdict()  # type: ignore[attr-defined]
        distance, offsets = columns['distance'], columns.get('offsets')
        states = len(distance) if offsets is None else len(offsets) - 1
        nearest = f', the nearest {distance.min():.6g} m' if len(distance) else ''
        return f'<{type(self).__name__}: {len(distance)} rows of {states} states{nearest}>'


class LeastDistances(_OfStates, PairNames, _LeastDistances):
    """The pair with the smallest lower bound in each of N states, with QueryObject's quantities.

    ``distance`` is within ``error_bound`` of the smallest distance of all pairs. If every pair of
    a state is certified to be beyond ``max_distance``, it is infinity, and ids and all else are 0.
    For two half spaces that cross it is minus infinity, with their ids, and all else is 0.
    """


class _PairsOfStates(NamedTuple):
    offsets: Indices  # (N + 1,)
    distance: Floats  # (k,) [m]
    error_bound: Floats  # (k,) [m]
    id_A: Indices  # (k,) values of GeometryId
    id_B: Indices  # (k,)
    gradient: Floats  # (k, 12)
    nhat_BA_W: Floats  # (k, 3)
    is_nhat_BA_W_unique: Flags  # (k,)
    p_WCa: Floats  # (k, 3) [m]
    p_WCb: Floats  # (k, 3) [m]
    method: NDArray[np.uint8]  # (k,)
    joint_gradient: Floats  # (k, q) by joint values [m/rad] or [-]; (k, 0) without by_joints


class PairsOfStates(_OfStates, PairNames, _PairsOfStates):
    """Pairs of N states: those of state s are rows ``offsets[s]`` to ``offsets[s + 1]``.

    Those of ``within`` are sorted by (id_A, id_B), those of ``nearest`` by ascending lower bounds.
    The distance is minus infinity for two half spaces that cross, without a normal, witness points
    or gradient.
    """


class _PointsOfStates(NamedTuple):
    offsets: Indices  # (N + 1,)
    point_index: NDArray[np.uint32]  # (k,)
    id_G: Indices  # (k,) values of GeometryId
    distance: Floats  # (k,) [m]
    error_bound: Floats  # (k,) [m]
    grad_W: Floats  # (k, 3)
    is_grad_W_unique: Flags  # (k,)
    p_GN: Floats  # (k, 3) [m] in the geometry's frame


class PointsOfStates(_OfStates, _PointsOfStates):
    """Distances of geometries to points; those of state s are rows ``offsets[s:s + 2]``.

    They are sorted by (point_index, id_G).
    """

    @property
    def name_G(self) -> NDArray[np.str_]:
        """The names (k,) of the geometries."""
        return self.names_of(self.id_G)


_Named = TypeVar('_Named', LeastDistances, PairsOfStates, PointsOfStates, ContactsOfStates)
_IDS = ('id_A', 'id_B', 'id_G', 'id_M', 'id_N')

Results = Flags | LeastDistances | PairsOfStates | PointsOfStates | ContactsOfStates


class Gathered:
    """Collects the results of ``count`` states, from at least one block, in any order.

    If each state has one row, blocks are copied directly to their place, without a second copy.
    """

    def __init__(self, want: str, count: int, ids: Indices, names: Sequence[str]) -> None:
        self._name_of = dict(zip(ids.tolist(), names, strict=True))
        self._want, self._count = want, count
        self._ids = np.append(ids, 0)  # ids of geometries by place; place -1, for none, has id 0
        self._rows: dict[str, NDArray[Any]] = {}
        self._ragged: dict[tuple[int, int], dict[str, NDArray[Any]]] = {}

    def put(self, block: tuple[int, int], columns: dict[str, NDArray[Any]]) -> None:
        """Add the answers of a block, in which geometries are places in the scene."""
        ids = {name: self._ids[columns[name]] for name in _IDS if name in columns}
        columns = {**columns, **ids}
        if 'counts' in columns:
            self._ragged[block] = columns
            return
        for name, values in columns.items():
            if name not in self._rows:
                self._rows[name] = np.empty((self._count, *values.shape[1:]), values.dtype)
            self._rows[name][slice(*block)] = values

    def results(self) -> Results:
        """Return all results, in the order of the states."""
        if self._want == 'collision':
            return self._rows['collision']
        if self._want == 'least':
            return self._named(LeastDistances(**_with_joints(self._rows)))
        blocks = [self._ragged[block] for block in sorted(self._ragged)]
        columns = {
            name: np.concatenate([block.pop(name) for block in blocks]) for name in list(blocks[0])
        }
        columns['offsets'] = _offsets(columns.pop('counts'))
        if self._want == 'contacts':
            columns['point_offsets'] = _offsets(columns.pop('point_counts'))
            return self._named(ContactsOfStates(**columns))
        if self._want == 'points':
            return self._named(PointsOfStates(**columns))
        return self._named(PairsOfStates(**_with_joints(columns)))

    def _named(self, results: _Named) -> _Named:
        results._name_of = self._name_of
        return results


def _offsets(counts: Indices) -> Indices:
    """Return the first row of each state, and the end of the last one's (N + 1,)."""
    return np.concatenate(([0], np.cumsum(counts)))


def _with_joints(columns: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """Return columns of pairs with gradients by joints, of width 0 if they were not requested."""
    return {'joint_gradient': np.zeros((len(columns['distance']), 0)), **columns}
