"""What ``evaluate`` returns: arrays by name."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Flags = NDArray[np.bool_]


class LeastDistances(NamedTuple):
    """The pair of the least signed distance in each of N states, as QueryObject tells of it.

    Where a state has no pair within reach ``distance`` is infinity, ids and all else are 0.
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

    Of ``within`` by (id_A, id_B), of ``nearest`` the nearest first.
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


Results = Flags | LeastDistances | PairsOfStates | PointsOfStates


def with_ids(columns: dict[str, NDArray[Any]], ids: Indices) -> dict[str, NDArray[Any]]:
    """Return columns in which geometries go by their ids (n,), no longer by their place.

    Place -1, where there is none, becomes 0.
    """
    known = np.append(ids, 0)
    named: dict[str, NDArray[Any]] = {
        name: known[columns[name]] for name in ('id_A', 'id_B', 'id_G') if name in columns
    }
    return {**columns, **named}


def gathered(want: str, blocks: list[dict[str, NDArray[Any]]]) -> Results:
    """Return the results of blocks of states in their order; at least one block."""
    columns = {
        name: np.concatenate([block.pop(name) for block in blocks]) for name in list(blocks[0])
    }
    if want == 'collision':
        return columns['collision']
    if want == 'least':
        return LeastDistances(**columns)
    columns['offsets'] = np.concatenate(([0], np.cumsum(columns.pop('counts'))))
    return PointsOfStates(**columns) if want == 'points' else PairsOfStates(**columns)
