"""Contact surfaces by state: the columns of a block, and the result of ``evaluate``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.batch.names import PairNames
from drake_geom_ros.common.tables import Columns, Tabular
from drake_geom_ros.geometry import GeometryError
from drake_geom_ros.geometry.queries.contact_bodies import NoSurface
from drake_geom_ros.geometry.queries.contact_queries import Contacts
from drake_geom_ros.geometry.queries.contact_surfaces import SURFACE_COLUMNS
from drake_geom_ros.math.array_types import Floats, Indices

_OF_OTHERS = ('id_A', 'id_B', 'depth', 'error_bound')


class _ContactsOfStates(NamedTuple):
    offsets: Indices  # (N + 1,) of the surfaces
    id_M: Indices  # (k,) values of GeometryId, the lower ones
    id_N: Indices  # (k,)
    area: Floats  # (k,) [m^2]
    centroid: Floats  # (k, 3) [m]
    centre_of_pressure: Floats  # (k, 3) [m]
    force_on_M_W: Floats  # (k, 3) [N]
    torque_on_M_Wo_W: Floats  # (k, 3) [N m], about World's origin
    max_pressure: Floats  # (k,) [Pa]
    point_offsets: Indices  # (N + 1,) of the pairs that overlap and have no surface
    id_A: Indices  # (p,) values of GeometryId
    id_B: Indices  # (p,)
    depth: Floats  # (p,) [m]
    error_bound: Floats  # (p,) [m]
    reason: Indices  # (p,) values of NoSurface


class ContactsOfStates(Tabular, PairNames, _ContactsOfStates):
    """The contact surfaces of N states, and the overlapping pairs without one.

    Surfaces of state s are rows ``offsets[s]`` to ``offsets[s + 1]``, sorted by (id_M, id_N), with
    ``ContactSurface``'s quantities in World. Pairs without a surface are rows ``point_offsets[s]``
    to ``point_offsets[s + 1]``, with depth and reason, and the names ``name_A`` and ``name_B``.
    Half spaces that overlap are infinitely deep.
    """

    @property
    def name_M(self) -> NDArray[np.str_]:
        """The names (k,) of the geometries of lower id."""
        return self.names_of(self.id_M)

    @property
    def name_N(self) -> NDArray[np.str_]:
        """The names (k,) of the geometries of higher id."""
        return self.names_of(self.id_N)

    def columns(self) -> Columns:
        """Return a row for each overlapping pair, after its ``state``, as columns by name.

        In each state those with a surface come first. Missing values are NaN; ``reason`` is 0 for
        a surface, and of the others a value of NoSurface.
        """
        counts = np.diff(self.offsets)
        fields = {**self._asdict(), 'counts': counts, 'point_counts': np.diff(self.point_offsets)}
        rows = rows_of_pairs(fields)
        columns: Columns = {'state': np.repeat(np.arange(len(counts)), rows.pop('counts'))}
        for name, values in rows.items():
            columns[name] = values
            if name.startswith('id_') and self._name_of:
                columns[name.replace('id_', 'name_')] = self.names_of(values)
        return columns

    def __repr__(self) -> str:
        return (
            f'<ContactsOfStates: {len(self.area)} surfaces and {len(self.depth)} pairs without '
            f'one of {len(self.offsets) - 1} states>'
        )

    def total_areas(self, *, with_fallback: bool = False) -> Floats:
        """Return the total area (N,) [m^2] of the surfaces of each state, 0 without contact.

        Raises GeometryError for the first pair that overlaps without a surface, since its area is
        unknown. ``with_fallback`` ignores such pairs: the caller should consider
        ``point_offsets``. Pairs whose meshes are too coarse to meet are always ignored.
        """
        unknown = np.flatnonzero(self.reason != NoSurface.TOO_COARSE)
        if len(unknown) and not with_fallback:
            k = int(unknown[0])
            state = int(np.searchsorted(self.point_offsets, k, 'right')) - 1
            raise GeometryError(
                f'total_areas: in state {state} {self.name_A[k]} and {self.name_B[k]} overlap and '
                f'have no surface: {NoSurface(int(self.reason[k])).in_words()}; in all states '
                f'{len(unknown)} pairs do. Filter such pairs, or say with_fallback=True.'
            )
        of = np.repeat(np.arange(len(self.offsets) - 1), np.diff(self.offsets))
        totals = np.zeros(len(self.offsets) - 1)
        np.add.at(totals, of, self.area)
        return totals


def rows_of_pairs(columns: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """Return contacts by column with one row for each overlapping pair, as in files.

    In each state those with a surface come first. Missing values are NaN, so that no sum hides
    them; ``reason`` is 0 for a surface. ``counts`` (N,) are the numbers of pairs of each state.
    """
    counts, others = columns['counts'], columns['point_counts']
    states = np.arange(len(counts))
    of = np.concatenate((np.repeat(states, counts), np.repeat(states, others)))
    order = np.argsort(of, kind='stable')
    k, p = len(columns['area']), len(columns['depth'])
    joined = {
        'id_A': np.concatenate((columns['id_M'], columns['id_A'])),
        'id_B': np.concatenate((columns['id_N'], columns['id_B'])),
        'reason': np.concatenate((np.zeros(k, dtype=np.int64), columns['reason'])),
    }
    for name in SURFACE_COLUMNS:
        if name not in ('id_M', 'id_N'):
            nothing = np.full((p, *columns[name].shape[1:]), np.nan)
            joined[name.replace('_M_', '_A_')] = np.concatenate((columns[name], nothing))
    for name in ('depth', 'error_bound'):
        joined[name] = np.concatenate((np.full(k, np.nan), columns[name]))
    return {'counts': counts + others, **{name: rows[order] for name, rows in joined.items()}}


def contact_columns(each: Iterable[Contacts]) -> dict[str, NDArray[Any]]:
    """Return the contacts of states, one after another, by column."""
    rows: dict[str, list[Any]] = {name: [] for name in (*SURFACE_COLUMNS, *_OF_OTHERS, 'reason')}
    counts, point_counts = [], []
    for surfaces, others, reasons in each:
        counts.append(len(surfaces))
        point_counts.append(len(others))
        # Copies, so that the polygons behind them can be freed.
        for name, array in SURFACE_COLUMNS.items():
            rows[name].append(getattr(surfaces, array).copy())
        for name in _OF_OTHERS:
            rows[name].append(getattr(others, name).copy())
        rows['reason'].append(reasons)
    columns = {name: _joined(name, arrays) for name, arrays in rows.items()}
    columns['counts'] = np.array(counts, dtype=np.int64)
    columns['point_counts'] = np.array(point_counts, dtype=np.int64)
    return columns


def _joined(name: str, arrays: list[NDArray[Any]]) -> NDArray[Any]:
    """Return the rows of all states, or an empty array of the right type without states."""
    if arrays:
        return np.concatenate(arrays)
    wide = name.endswith('_W') or name in ('centroid', 'centre_of_pressure')
    whole = name.startswith('id_') or name == 'reason'
    return np.zeros((0, 3) if wide else 0, dtype=np.int64 if whole else np.float64)
