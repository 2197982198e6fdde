"""What ``evaluate`` returns: arrays by name."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Flags = NDArray[np.bool_]


class LeastDistances(NamedTuple):
    """The pair of the least lower bound in each of N states, as QueryObject tells of it.

    ``distance`` is within ``error_bound`` of the least distance of all pairs. Where every pair of
    a state is certified to be out of reach it is infinity, ids and all else are 0.
    """

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


class PairsOfStates(NamedTuple):
    """Pairs of N states: those of state s are rows ``offsets[s]`` to ``offsets[s + 1]``.

    Of ``within`` by (id_A, id_B), of ``nearest`` by their lower bounds, the least first.
    """

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


class PointsOfStates(NamedTuple):
    """Distances of geometries to points: of state s rows ``offsets[s]`` to ``offsets[s + 1]``.

    Sorted by (point_index, id_G).
    """

    offsets: Indices  # (N + 1,)
    point_index: NDArray[np.uint32]  # (k,)
    id_G: Indices  # (k,) values of GeometryId
    distance: Floats  # (k,) [m]
    error_bound: Floats  # (k,) [m]
    grad_W: Floats  # (k, 3)
    is_grad_W_unique: Flags  # (k,)
    p_GN: Floats  # (k, 3) [m] in the geometry's frame


_IDS = ('id_A', 'id_B', 'id_G')

Results = Flags | LeastDistances | PairsOfStates | PointsOfStates


class Gathered:
    """The results of ``count`` states, of blocks that come in any order; at least of one.

    Where each state has one row, a block is put where it belongs at once: it is held once.
    """

    def __init__(self, want: str, count: int, ids: Indices) -> None:
        self._want, self._count = want, count
        self._ids = np.append(ids, 0)  # of geometries by their place; 0 for place -1, none
        self._rows: dict[str, NDArray[Any]] = {}
        self._ragged: dict[tuple[int, int], dict[str, NDArray[Any]]] = {}

    def put(self, block: tuple[int, int], columns: dict[str, NDArray[Any]]) -> None:
        """Take the answers of a block, in which geometries go by their place in the scene."""
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
        """Return all of it, in the order of the states."""
        if self._want == 'collision':
            return self._rows['collision']
        if self._want == 'least':
            return LeastDistances(**self._rows)
        blocks = [self._ragged[block] for block in sorted(self._ragged)]
        columns = {
            name: np.concatenate([block.pop(name) for block in blocks]) for name in list(blocks[0])
        }
        columns['offsets'] = np.concatenate(([0], np.cumsum(columns.pop('counts'))))
        return (PointsOfStates if self._want == 'points' else PairsOfStates)(**columns)
