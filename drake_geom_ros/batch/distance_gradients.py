"""Distances with their derivatives by joint values, as ``Checker`` returns them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from drake_geom_ros.batch.running import blocks_of, cores, size_for_all
from drake_geom_ros.geometry import ArgumentError, GeometryId
from drake_geom_ros.geometry.queries.joint_gradients import NearDistances
from drake_geom_ros.math.array_types import Flags, Floats, Indices

# Pairs (k, 2) of geometries, by GeometryId or their values.
Pairs: TypeAlias = Sequence[Sequence[Any]] | ArrayLike

_LARGEST_BLOCK = 256  # states of one task


class _ClearanceAndGradient(NamedTuple):
    clearance: Any  # [m] float, or (N,) for N states
    gradient: Floats  # (c,) or (N, c) [m/rad] or [-]


class ClearanceAndGradient(_ClearanceAndGradient):
    """Clearance of a state, or of N states, with its derivatives: ``clearance, gradient``.

    ``is_gradient_unique``, a bool or (N,), is False where the distance of the nearest pair has no
    derivative; the gradient is then a member of Clarke's generalised gradient. Of several pairs
    that are equally near, the first one counts.
    """

    is_gradient_unique: Any


class DistancesAndGradients(NamedTuple):
    """Distances of k pairs in a fixed order, with their derivatives by c joint values.

    For N states each array has N rows of these. A pair that is certified to be farther apart than
    ``within`` has an infinite distance, and all else is 0.
    """

    distance: Floats  # (k,) [m]
    error_bound: Floats  # (k,) [m]
    gradient: Floats  # (k, c) [m/rad] or [-]
    is_gradient_unique: Flags  # (k,)

    @property
    def lower_bound(self) -> Floats:
        """Certified lower bounds [m] of the distances: distance minus error bound."""
        lower: Floats = self.distance - self.error_bound
        return lower

    @classmethod
    def empty(cls, shape: tuple[int, ...], columns: int) -> DistancesAndGradients:
        """Return arrays for distances of a shape, to be filled; their content is arbitrary."""
        arrays = np.empty(shape), np.empty(shape), np.empty((*shape, columns))
        return cls(*arrays, np.empty(shape, dtype=np.bool_))

    def check(self, shape: tuple[int, ...], columns: int) -> None:
        """Raise ArgumentError unless these arrays can hold such distances."""
        wanted = self.empty((0,) * len(shape), columns)
        for name, array, like in zip(self._fields, self, wanted, strict=True):
            whole = (*shape, columns) if name == 'gradient' else shape
            fits = isinstance(array, np.ndarray) and array.shape == whole
            if not fits or array.dtype != like.dtype or not array.flags.writeable:
                kind = getattr(array, 'dtype', type(array).__name__)
                raise ArgumentError(
                    f'out.{name} is {kind} {np.shape(array)}; it must be a writeable array '
                    f'{like.dtype} {whole}'
                )


class NearPairs(NamedTuple):
    """The h pairs of a state that may be within a distance, with derivatives by c joint values.

    Pairs that are left out are certified to be farther apart.
    """

    numbers: Indices  # (h,) rows of ``Checker.pairs``, ascending
    distance: Floats  # (h,) [m]
    error_bound: Floats  # (h,) [m]
    gradient: Floats  # (h, c) [m/rad] or [-]
    is_gradient_unique: Flags  # (h,)


def numbers_of_pairs(pairs: Pairs, number_of: Mapping[tuple[int, int], int]) -> Indices:
    """Return the numbers (k,) of pairs of geometries, by ``number_of`` their ascending id values.

    ``pairs`` are k pairs of GeometryId or their values. Raises ArgumentError for a pair that is
    unknown or filtered out, and for one that is named twice.
    """
    rows = np.array(pairs, dtype=object)
    if rows.ndim != 2 or rows.shape[1] != 2 or not len(rows):
        raise ArgumentError(
            f'pairs has the shape {rows.shape}; it must be (k, 2), two geometry ids for each of '
            'at least one pair'
        )
    numbers = np.empty(len(rows), dtype=np.int64)
    for k, pair in enumerate(rows.tolist()):
        a, b = (x.get_value() if isinstance(x, GeometryId) else x for x in pair)
        number = number_of.get((a, b), number_of.get((b, a)))
        if number is None:
            raise ArgumentError(
                f'pairs has ({a}, {b}), which is no pair of this checker: filters leave it out, '
                'or the scene has no such geometry with the proximity role; Checker.pairs lists '
                'all'
            )
        numbers[k] = number
    if len(np.unique(numbers)) < len(numbers):
        raise ArgumentError(f'pairs names a pair twice: {rows.tolist()}')
    return numbers


def fill_distances(near: NearDistances, order: Indices | None, out: DistancesAndGradients) -> None:
    """Fill ``out`` with the distances of a state, infinite for pairs that are not near.

    ``order`` has the row of each pair in ``out``; None: the order of the queries.
    """
    rows = near.numbers if order is None else order[near.numbers]
    out.distance.fill(np.inf)
    out.error_bound.fill(0.0)
    out.gradient.fill(0.0)
    out.is_gradient_unique.fill(False)
    out.distance[rows], out.error_bound[rows] = near.distance, near.error_bound
    out.gradient[rows], out.is_gradient_unique[rows] = near.gradient, near.is_unique


def on_all_cores(count: int, answer: Callable[[int], None]) -> None:
    """Call ``answer`` for each of ``count`` states, by a thread for each core."""
    size = size_for_all(count, 0, _LARGEST_BLOCK)
    stopped = False

    def each(block: tuple[int, int]) -> None:
        for number in range(*block):
            if stopped:
                return
            answer(number)

    pool = ThreadPoolExecutor(cores())
    try:
        for _ in pool.map(each, blocks_of(count, size)):
            pass
    finally:
        stopped = True
        pool.shutdown(wait=True, cancel_futures=True)
