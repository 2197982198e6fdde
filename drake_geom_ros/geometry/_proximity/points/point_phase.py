"""Compiled loop of point queries: blocks of points, each against every geometry."""

from __future__ import annotations

from collections.abc import Set
from typing import NamedTuple, TypeAlias

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.addresses import (
    ADDRESSES,
    compile_rows,
    table_rows,
)
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import compiled_address
from drake_geom_ros.geometry._proximity.kernels.calling.points import (
    POINT_WIDTH,
    POINTS_SIGNATURE,
    PointAnswers,
    PointedBody,
    Span,
    call_points_kernel,
)
from drake_geom_ros.geometry._proximity.kernels.pair_table import (
    BY_ADDRESS,
    POINT_KERNELS,
    TYPE_COUNT,
    load_kernel,
)
from drake_geom_ros.geometry._proximity.kinds import SPHERE
from drake_geom_ros.geometry._proximity.runtime.addresses import Addresses, address_table
from drake_geom_ros.geometry._proximity.runtime.arrays import Booleans, Floats, Indices, Unsigned32
from drake_geom_ros.geometry._proximity.runtime.compiled import Tell, compilation, compiled
from drake_geom_ros.geometry._proximity.runtime.handles import Handle
from drake_geom_ros.geometry._proximity.runtime.views import part, row
from drake_geom_ros.geometry._proximity.world.arrays import world_of
from drake_geom_ros.geometry._proximity.world.pose_rounding import RADIUS, TILT
from drake_geom_ros.geometry._proximity.world.world import PointShapes

BLOCK = 64  # points whose rows, strided by the geometries, stay in the nearest caches
# By shape type: point kernels, compiled once per process, and the pair table's row of a point.
POINT_ADDRESSES = address_table(TYPE_COUNT)
POINT_ROWS = table_rows(np.full(TYPE_COUNT, SPHERE), np.arange(TYPE_COUNT))
POINTS_COMPILED: set[int] = set()  # shape types


def compile_point_kernels(types: Set[int], tell: Tell | None = None) -> list[str]:
    """Compile the point kernels of shapes of these types; return the names of new kernels."""
    names: dict[str, None] = {}
    missing = sorted(types - POINTS_COMPILED)
    for number, kind in enumerate(missing, 1):
        name = POINT_KERNELS[kind]
        with compilation(tell, name, number, len(missing)):
            if name in BY_ADDRESS:
                names.update(dict.fromkeys(compile_rows(POINT_ROWS[[kind]])))
            POINT_ADDRESSES[kind] = compiled_address(load_kernel(name), POINTS_SIGNATURE)
        POINTS_COMPILED.add(kind)
        names[name] = None
    return list(names)


class PointTables(NamedTuple):
    """The shapes of n geometries for point queries, and the addresses of their kernels."""

    addresses: Addresses  # by shape type
    pair_addresses: Addresses  # those of the pair table
    pair_rows: Indices  # (n,) of points to each geometry in that table
    types: Indices  # (n,)
    starts: Indices  # (n + 1,)
    pool: Floats


# The tables as passed to compiled code, and the arrays that it fills: see ``pairs.slots``.
TableArrays: TypeAlias = tuple[Addresses, Addresses, Indices, Indices, Indices, Floats]
AnswerArrays: TypeAlias = tuple[Floats, Booleans, Unsigned32, Indices, Indices]


def point_tables(shapes: PointShapes) -> TableArrays:
    """Return the ``PointTables`` of geometries as a plain tuple."""
    types, starts, pool, _ = shapes
    return PointTables(POINT_ADDRESSES, ADDRESSES, POINT_ROWS[types], types, starts, pool)[:]


@compiled
def point_phase(
    tables: TableArrays, world: Handle, p_WQs: Floats, threshold: float, answers: AnswerArrays
) -> int:
    """Answer for points (m, 3) and n geometries; return the number of answers.

    ``tables`` is a plain tuple of ``PointTables``, ``world`` is a handle. The ``answers`` are rows
    (m n, POINT_WIDTH), flags (m n,), points and ids (m n,), and counts by method. Rows, points and
    ids are filled from the front, ordered by point and then id. The flags have to be False.
    """
    addresses, pair_addresses, pair_rows, types, starts, pool = tables
    rows, is_within, points, ids, counts = answers
    world = world_of(world)
    R_WGs, p_WGs, roundings, outer = world.R_WGs, world.p_WGs, world.roundings, world.outer
    m, n, filled = p_WQs.shape[0], types.size, PointAnswers(rows, is_within, counts)
    for first in range(0, m, BLOCK):
        last = min(first + BLOCK, m)
        for g in range(n):
            rounding, tilt = roundings[g, RADIUS], roundings[g, TILT]
            shape = part(pool, starts[g], starts[g + 1])
            body = PointedBody(shape, row(R_WGs, g), row(p_WGs, g), outer[g], rounding, tilt)
            call_points_kernel(
                addresses[types[g]],
                pair_addresses[pair_rows[g]],
                types[g],
                body,
                p_WQs,
                threshold,
                Span(first, last, g, n),
                filled,
            )
    count = 0
    for k in range(m * n):
        count += is_within[k]
    if count == m * n:  # usual without a threshold: all rows are in place already
        for q in range(m):
            for g in range(n):
                points[q * n + g], ids[q * n + g] = q, world.ids[g]
        return count
    count = 0
    for q in range(m):
        for g in range(n):
            if is_within[q * n + g]:
                points[count], ids[count] = q, world.ids[g]
                if count < q * n + g:
                    for c in range(POINT_WIDTH):
                        rows[count, c] = rows[q * n + g, c]
                count += 1
    return count
