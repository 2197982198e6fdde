"""Point queries: block after block of points, each geometry in turn."""

from __future__ import annotations

from collections.abc import Set

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.addresses import compile_rows, table_rows
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
    BY_PAIR_KERNEL,
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

BLOCK = 64  # points: their rows of one geometry, far from each other, stay in the nearest caches
# By shape type: the point kernels, compiled once a process, and the pair table's row of a point.
POINT_ADDRESSES = address_table(TYPE_COUNT)
POINT_ROWS = table_rows(np.full(TYPE_COUNT, SPHERE), np.arange(TYPE_COUNT))
POINTS_COMPILED: set[int] = set()  # shape types


def compile_point_kernels(types: Set[int], tell: Tell | None = None) -> list[str]:
    """Compile what points to shapes of these types need; return the names of new kernels."""
    names: dict[str, None] = {}
    missing = sorted(types - POINTS_COMPILED)
    for number, kind in enumerate(missing, 1):
        name = POINT_KERNELS[kind]
        with compilation(tell, name, number, len(missing)):
            if name == BY_PAIR_KERNEL:
                names.update(dict.fromkeys(compile_rows(POINT_ROWS[[kind]])))
            POINT_ADDRESSES[kind] = compiled_address(load_kernel(name), POINTS_SIGNATURE)
        POINTS_COMPILED.add(kind)
        names[name] = None
    return list(names)


@compiled
def point_phase(
    addresses: Addresses,
    pair_addresses: Addresses,
    pair_rows: Indices,
    types: Indices,
    starts: Indices,
    pool: Floats,
    world: Handle,
    p_WQs: Floats,
    threshold: float,
    rows: Floats,
    found: Booleans,
    points: Unsigned32,
    ids: Indices,
    counts: Indices,
) -> int:
    """Answer for points (m, 3) and n geometries; return how many answers there are.

    ``pair_rows`` (n,) are those of points to each geometry in the pair table, ``types`` (n,),
    ``starts`` (n + 1,) and ``pool`` what it is to them; ``world`` is a handle. The first of
    ``rows`` (m n, POINT_WIDTH), ``points`` and ``ids`` (m n,) are filled, in the order of points,
    then ids. ``found`` (m n,) comes in as False, ``counts`` get how many answers there are by
    each method.
    """
    world = world_of(world)
    R_WGs, p_WGs, roundings, outer = world.R_WGs, world.p_WGs, world.roundings, world.outer
    m, n, answers = p_WQs.shape[0], types.size, PointAnswers(rows, found, counts)
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
                answers,
            )
    count = 0
    for k in range(m * n):
        count += found[k]
    if count == m * n:  # as without a threshold: all are where they belong
        for q in range(m):
            for g in range(n):
                points[q * n + g], ids[q * n + g] = q, world.ids[g]
        return count
    count = 0
    for q in range(m):
        for g in range(n):
            if found[q * n + g]:
                points[count], ids[count] = q, world.ids[g]
                if count < q * n + g:
                    for c in range(POINT_WIDTH):
                        rows[count, c] = rows[q * n + g, c]
                count += 1
    return count
