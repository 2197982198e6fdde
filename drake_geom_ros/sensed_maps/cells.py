"""Occupied cells of a grid by integer keys, exact and in a canonical order."""

from __future__ import annotations

import math
from dataclasses import dataclass
from numbers import Real

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_geom_ros.geometry import ArgumentError
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.sensed_maps.passes import (
    BITS,
    MOST_STEPS,
    NO_KEY,
    count_in_cells,
    empty_table,
)

MOST_CELLS = 5_000_000  # of a map: 120 MB as centres
_FIRST_TABLE = 1 << 17  # rows of the hash table for counting, filled at most by half
LEAST_RESOLUTION, LARGEST_RESOLUTION = 1.0 / 8192.0, 1024.0  # [m]

Keys = NDArray[np.int64]


class MapError(ArgumentError):
    """A map, or the file of one, is invalid."""


@dataclass(frozen=True)
class Cells:
    """Cubes of a grid; the one of key (i, j, k) has its centre at ((i, j, k) + 0.5) * resolution.

    ``resolution`` is the edge length [m]; ``packed`` (n,) are the keys packed into integers,
    unique and ascending (see ``of_keys``). The grid is OctoMap's.

    >>> Cells.of_points([[0.01, 0.02, -0.01], [0.04, 0.0, -0.04]], 0.05).centres().tolist()
    [[0.025, 0.025, -0.025]]
    """

    resolution: float
    packed: Keys

    @classmethod
    def of_points(cls, points: ArrayLike, resolution: float) -> Cells:
        """Return the cells that contain points (n, 3) [m], in any order.

        Raises MapError for an invalid array, a point that is not finite or too far away, and an
        invalid resolution.
        """
        return cls.counted(points, resolution)[0]

    @classmethod
    def counted(cls, points: ArrayLike, resolution: float) -> tuple[Cells, Keys]:
        """Return the cells that contain points (n, 3) [m], and their numbers of points (c,).

        Raises MapError like ``of_points``.
        """
        check_resolution(resolution)
        rows = _rows(points)
        size, counted = _FIRST_TABLE, -1
        while counted < len(rows):
            table = empty_table(size)
            counted = count_in_cells(rows, float(resolution), table)
            if counted < len(rows):
                _refuse_point_outside(rows[counted], counted, resolution)
                size <<= math.ceil(math.log2(len(rows) / counted))
        filled = table[table[:, 0] != NO_KEY]
        keys, counts = filled[np.argsort(filled[:, 0])].T.copy()
        return cls(float(resolution), keys), counts

    @classmethod
    def of_keys(cls, keys: Keys, resolution: float) -> Cells:
        """Return the unique cells of keys (n, 3); raises MapError like ``of_points``."""
        check_resolution(resolution)
        if keys.ndim != 2 or keys.shape[1] != 3:
            raise MapError(f'keys {keys.shape} must be (n, 3)')
        if keys.size and not -MOST_STEPS < keys.min() <= keys.max() < MOST_STEPS:
            raise MapError(f'a key must lie within {MOST_STEPS} cells of the origin')
        return cls(float(resolution), unique_numbers(_packed(keys)))

    @classmethod
    def touching(cls, low: Floats, high: Floats, resolution: float) -> Cells:
        """Return the cells that boxes with corners ``low``, ``high`` (n, 3) [m] overlap.

        Raises MapError if one would be too far away.
        """
        first, last = np.floor(low / resolution), np.ceil(high / resolution) - 1.0
        if not ((first > -MOST_STEPS) & (last < MOST_STEPS)).all():
            raise MapError(
                f'cells of {resolution:g} m must lie within {MOST_STEPS} of them from the origin'
            )
        count, packed = int((last - first).max(initial=-1.0)) + 1, np.zeros(0, dtype=np.int64)
        for step in np.ndindex(count, count, count):
            keys = np.minimum(first + step, last).astype(np.int64)
            packed = unique_numbers(np.concatenate((packed, _packed(keys))))
        return cls(float(resolution), packed)

    def changed(self, added: Cells | None = None, removed: Cells | None = None) -> Cells:
        """Return the cells after removing some and adding others.

        A cell that is both removed and added is present. Raises MapError for cells of another
        resolution, and if a removed cell is absent.

        >>> before = Cells.of_points([[0.01, 0.02, 0.0], [0.07, 0.0, 0.0]], 0.05)
        >>> seen, gone = (Cells.of_points([[x, 0.0, 0.0]], 0.05) for x in (0.11, 0.06))
        >>> before.changed(added=seen, removed=gone).keys().tolist()
        [[0, 0, 0], [2, 0, 0]]
        """
        packed = self.packed
        for what, some in (('added', added), ('removed', removed)):
            if some is not None and some.resolution != self.resolution:
                raise MapError(
                    f'{what} cells have a resolution of {some.resolution:g} m; it must be that of '
                    f'the map, {self.resolution:g} m'
                )
        if removed is not None and len(removed):
            places, is_there = _places_in(packed, removed.packed)
            if not is_there.all():
                unknown = Cells(self.resolution, removed.packed[~is_there])
                raise MapError(
                    f'{len(unknown)} of {len(removed)} cells to remove are not in the map, the '
                    f'first is that at {unknown.centres()[0].tolist()} m'
                )
            packed = np.delete(packed, places)
        if added is not None and len(added):
            places, is_there = _places_in(packed, added.packed)
            packed = np.insert(packed, places[~is_there], added.packed[~is_there])
        return Cells(self.resolution, packed)

    def extruded(self, low: float, high: float) -> Cells:
        """Return these cells, and all above and below them at heights from low to high [m].

        Raises MapError for heights beyond the grid, and for more cells than a map may have.
        """
        bottom, top = math.floor(low / self.resolution), math.ceil(high / self.resolution)
        keys = self.keys()
        feet = np.unique(keys[:, :2], axis=0)
        if len(feet) * (top - bottom) > MOST_CELLS:
            raise MapError(
                f'{len(feet)} columns of {top - bottom} cells are more than {MOST_CELLS}; make '
                'the cells larger, or the columns lower'
            )
        heights = np.arange(bottom, top)
        columns = np.column_stack(
            (np.repeat(feet, len(heights), axis=0), np.tile(heights, len(feet)))
        )
        return Cells.of_keys(np.concatenate((keys, columns)), self.resolution)

    def moved(self, R: Floats, p: Floats) -> Cells:
        """Return the cells of the same grid that cover these after a rotation R and a shift p."""
        centres = self.centres() @ R.T + p
        reach = 0.5 * self.resolution * np.abs(R).sum(axis=1)
        return Cells.touching(centres - reach, centres + reach, self.resolution)

    def __len__(self) -> int:
        return len(self.packed)

    def keys(self) -> Keys:
        """Return the keys (n, 3)."""
        mask = (1 << BITS) - 1
        columns = [(self.packed >> shift) & mask for shift in (2 * BITS, BITS, 0)]
        return np.stack(columns, axis=1) - MOST_STEPS

    def centres(self) -> Floats:
        """Return the centres (n, 3) [m]."""
        return np.asarray((self.keys() + 0.5) * self.resolution, dtype=np.float64)

    def coarser(self, resolution: float) -> Cells:
        """Return the cells of a coarser grid that cover these.

        Raises MapError for a finer grid, since the contents are known only to these cells.
        """
        check_resolution(resolution)
        if resolution < self.resolution:
            raise MapError(
                f'resolution {resolution:g} m is finer than the map, whose cells are '
                f'{self.resolution:g} m; it must be at least that'
            )
        keys, times = self.keys(), resolution / self.resolution
        whole = round(times)
        if abs(whole * self.resolution - resolution) <= math.ulp(resolution):  # 0.3 and 0.1
            return Cells.of_keys(keys // whole, resolution)
        low = np.asarray(keys * self.resolution, dtype=np.float64)
        high = np.asarray((keys + 1) * self.resolution, dtype=np.float64)
        return Cells.touching(low, high, resolution)


def keys_of(points: Floats, resolution: float) -> Keys:
    """Return the packed key (n,) of the cell of each point (n, 3) [m], all within the grid."""
    return _packed(np.floor(points / resolution).astype(np.int64))


def check_resolution(resolution: float) -> None:
    """Raise MapError for an invalid edge length [m]."""
    is_number = isinstance(resolution, Real)
    if not is_number or not LEAST_RESOLUTION <= resolution <= LARGEST_RESOLUTION:
        raise MapError(
            f'resolution is {resolution!r} m; it must lie in '
            f'[{LEAST_RESOLUTION:g}, {LARGEST_RESOLUTION:g}]'
        )


def _rows(points: ArrayLike) -> Floats:
    """Return points (n, 3) writable and contiguous; others would compile another version."""
    try:
        rows = np.require(points, np.float64, ['C', 'W'])
    except (TypeError, ValueError) as problem:
        raise MapError(f'points are no numbers (n, 3): {problem}') from None
    if rows.ndim != 2 or rows.shape[1] != 3:
        raise MapError(f'points {rows.shape} must be (n, 3)')
    return rows


def _refuse_point_outside(point: Floats, number: int, resolution: float) -> None:
    """Raise MapError for a point (3,) [m] that is not finite, or beyond the grid's keys."""
    with np.errstate(over='ignore'):
        steps = np.floor(point / resolution)
    if not (np.abs(steps) < MOST_STEPS).all():
        raise MapError(
            f'point {number} is {point.tolist()} m; with cells of {resolution:g} m it must be '
            f'finite and within {MOST_STEPS * resolution:g} m of the origin'
        )


def _places_in(packed: Keys, some: Keys) -> tuple[Keys, NDArray[np.bool_]]:
    """Return insertion places of ascending keys in others, and a mask of those present."""
    places = np.searchsorted(packed, some)
    is_there = np.zeros(len(some), dtype=np.bool_)
    within = places < len(packed)
    is_there[within] = packed[places[within]] == some[within]
    return places, is_there


def unique_numbers(values: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the different values, ascending, as ``np.unique`` does.

    Other threads go on meanwhile: np.unique hashes, by which two million values took 0.9 s of
    Python's lock and 3.7 s in all, and a sort 0.1 s.

    >>> unique_numbers(np.array([3, 1, 3]))
    array([1, 3])
    """
    ordered = np.sort(values)
    is_first = np.ones(len(ordered), dtype=np.bool_)
    np.not_equal(ordered[1:], ordered[:-1], out=is_first[1:])
    return ordered[is_first]


def _packed(keys: Keys) -> Keys:
    i, j, k = (keys[:, axis] + MOST_STEPS for axis in range(3))
    packed: Keys = (i << 2 * BITS) | (j << BITS) | k
    return packed
