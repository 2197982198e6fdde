"""Answers of ``query`` as tables, and tables as CSV, as JSON or for people.

A table maps column names to arrays (k,) or, for points and directions, (k, 3). In CSV the latter
become three columns, ``p_wca_x`` and so on; in JSON a row is an object with lists. Numbers are
written with all digits, and for people with six.
"""

import csv
import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TextIO

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.command_line.opened_scene import OpenedScene
from drake_geom_ros.geometry import METHODS, GeometryId

Table = Mapping[str, Any]
_METHOD_NAMES = {number: name for name, number in METHODS.items()}


@dataclass(frozen=True)
class QueryOptions:
    """The points, limits and accuracy of a query, beside the scene."""

    max_distance: float = math.inf  # [m]
    accuracy: str = 'exact'
    points: Any = None  # (m, 3) [m] in the world
    count: int = 1  # pairs of ``nearest``


def distances(scene: OpenedScene, options: QueryOptions) -> Table:
    """Return the signed distances up to the maximum distance; witness points in the world."""
    pairs = scene.query.ComputeSignedDistancePairwiseClosestPoints(
        options.max_distance, accuracy=options.accuracy
    )
    return _distances_of(scene, pairs)


def nearest(scene: OpenedScene, options: QueryOptions) -> Table:
    """Return the ``count`` pairs with the smallest lower bounds, half spaces included.

    These are those of a batch of one state: two half spaces that cross are minus infinity apart.
    """
    from drake_geom_ros.batch import evaluate  # takes time that other questions need not wait

    no_frames, as_it_is = np.zeros(0, dtype=np.int64), np.zeros((1, 0, 7))
    pairs = evaluate(
        *(scene.context, no_frames, as_it_is, 'nearest', options.max_distance, options.accuracy),
        count=options.count,
    )
    return _distances_of(scene, pairs)


def _distances_of(scene: OpenedScene, pairs: Any) -> Table:
    """Return the columns of signed distances, of a query or of a batch."""
    return _pairs(scene, pairs.id_A, pairs.id_B) | {
        'distance': pairs.distance,
        'p_wca': pairs.p_WCa,
        'p_wcb': pairs.p_WCb,
        'nhat_ba_w': pairs.nhat_BA_W,
        'is_nhat_ba_w_unique': pairs.is_nhat_BA_W_unique,
        'error_bound': pairs.error_bound,
        'method': _methods(pairs.method),
    }


def penetrations(scene: OpenedScene, options: QueryOptions) -> Table:
    """Return the overlapping pairs."""
    overlaps = scene.query.ComputePointPairPenetration(accuracy=options.accuracy)
    return _pairs(scene, overlaps.id_A, overlaps.id_B) | {
        'depth': overlaps.depth,
        'p_wca': overlaps.p_WCa,
        'p_wcb': overlaps.p_WCb,
        'nhat_ba_w': overlaps.nhat_BA_W,
        'error_bound': overlaps.error_bound,
        'method': _methods(overlaps.method),
    }


def point_distances(scene: OpenedScene, options: QueryOptions) -> Table:
    """Return the signed distances of the points up to the maximum distance."""
    points = scene.query.ComputeSignedDistanceToPoint(
        options.points, options.max_distance, accuracy=options.accuracy
    )
    return {
        'point_index': points.point_index,
        'geometry': _names(scene, points.id_G),
        'distance': points.distance,
        'p_gn': points.p_GN,
        'grad_w': points.grad_W,
        'is_grad_w_unique': points.is_grad_W_unique,
        'error_bound': points.error_bound,
        'method': _methods(points.method),
    }


def candidates(scene: OpenedScene, options: QueryOptions) -> Table:
    """Return the candidate pairs, which bounding volumes do not separate."""
    ids = scene.query.collision_candidates()
    return _pairs(scene, ids[:, 0], ids[:, 1])


def collisions(scene: OpenedScene, options: QueryOptions) -> Table:
    """Return one row with the flag whether any pair overlaps."""
    return {'has_collisions': np.array([scene.query.HasCollisions(accuracy=options.accuracy)])}


KINDS: dict[str, Callable[[OpenedScene, QueryOptions], Table]] = {
    'distance': distances,
    'least': nearest,
    'nearest': nearest,
    'penetration': penetrations,
    'points': point_distances,
    'candidates': candidates,
    'collisions': collisions,
}
# The same questions by the words of ``batch``.
AS_IN_BATCHES = {'within': 'distance', 'collision': 'collisions'}


def half_spaces_beside(scene: OpenedScene) -> list[str]:
    """Return remarks about overlapping half spaces, which no list of pairs includes."""
    return [
        f'{" and ".join(_names(scene, ids))} are half spaces that overlap, and in no list of '
        'distances or penetrations: ask for collisions, or filter the pair'
        for ids in scene.query.half_space_gaps().overlapping
    ]


OF_PAIRS = ('distance', 'penetration')  # lists of pairs, in which half spaces are not
LIMITED = ('distance', 'least', 'nearest', 'points')  # kinds with a maximum distance


def _names(scene: OpenedScene, ids: NDArray[Any]) -> list[str]:
    return [scene.names[GeometryId(value)] for value in ids.tolist()]


def _pairs(scene: OpenedScene, ids_A: NDArray[Any], ids_B: NDArray[Any]) -> dict[str, Any]:
    return {'geometry_a': _names(scene, ids_A), 'geometry_b': _names(scene, ids_B)}


def _methods(numbers: NDArray[Any]) -> list[str]:
    return [_METHOD_NAMES[number] for number in numbers.tolist()]


def write_csv(answers: Iterable[tuple[float | None, Table]], timed: bool, file: TextIO) -> None:
    """Write the tables of moments below one header, with a column ``time`` if ``timed``."""
    csv.writer(file, lineterminator='\n').writerows(_lines(answers, timed))


def write_table(answers: Iterable[tuple[float | None, Table]], timed: bool, file: TextIO) -> None:
    """Write what ``write_csv`` writes for people: in columns, numbers with six digits."""
    lines = [[_short(value) for value in line] for line in _lines(answers, timed)]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    for line in lines:
        cells = (cell.ljust(width) for cell, width in zip(line, widths, strict=True))
        file.write('  '.join(cells).rstrip() + '\n')


def _short(value: object) -> str:
    return f'{value:.6g}' if isinstance(value, float) else str(value)


def _lines(
    answers: Iterable[tuple[float | None, Table]], timed: bool
) -> Iterator[Sequence[object]]:
    """Yield a header and the rows of tables; a point is three columns."""
    header: list[str] = []
    for time, table in answers:
        columns = [('time', [time] * len(_first(table)))] if timed else []
        for name, values in table.items():
            array = np.asarray(values)
            if array.ndim == 2:
                columns += [(f'{name}_{axis}', array[:, k].tolist()) for k, axis in _AXES]
            else:
                columns.append((name, array.tolist()))
        if not header:
            header = [name for name, _ in columns]
            yield header
        yield from zip(*(values for _, values in columns), strict=True)


def write_json(answers: Iterable[tuple[float | None, Table]], timed: bool, file: TextIO) -> None:
    """Write a list of one object a moment, with its ``time`` (or null) and its ``rows``.

    Minus infinity, for which JSON has no number, is the text ``-inf``, as in CSV.
    """
    file.write('[')
    for number, (time, table) in enumerate(answers):
        columns = [_for_json(np.asarray(values)) for values in table.values()]
        rows = [dict(zip(table, row, strict=True)) for row in zip(*columns, strict=True)]
        file.write(',\n' if number else '\n')
        json.dump({'time': time, 'rows': rows}, file)
    file.write('\n]\n')


def _for_json(values: NDArray[Any]) -> list[Any]:
    if values.dtype.kind != 'f' or values.ndim > 1:  # points are finite
        return list(values.tolist())
    return [each if math.isfinite(each) else str(each) for each in values.tolist()]


FORMATS = {'csv': write_csv, 'json': write_json, 'table': write_table}
_AXES = tuple(enumerate('xyz'))


def _first(table: Table) -> Any:
    return next(iter(table.values()))
