"""Narrow phase: one compiled loop a query, which calls the kernel of each pair by its address."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.compiled import compiled
from drake_geom_ros.geometry._proximity.kernels.bounds import bounding_interval
from drake_geom_ros.geometry._proximity.kernels.calling import (
    DISTANCE,
    ERROR_BOUND,
    NORMAL,
    WITNESS_A,
    WITNESS_B,
    address_table,
    call_kernel,
    compiled_address,
)
from drake_geom_ros.geometry._proximity.pair_table import (
    PAIR_TABLE,
    ROW_OF_TYPES,
    SPHERE,
    TYPE_COUNT,
)
from drake_geom_ros.geometry._proximity.tolerances import EPS

_ROWS = np.array(ROW_OF_TYPES, dtype=np.int64)
# Kernels are compiled once a process, whatever scene asked for them.
ADDRESSES = address_table(len(PAIR_TABLE))
_COMPILED = np.zeros(len(PAIR_TABLE), dtype=np.bool_)


def table_rows(types_a: NDArray[np.int64], types_b: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the pair table's row of each pair of shape types, in either order; -1: none."""
    low, high = np.minimum(types_a, types_b), np.maximum(types_a, types_b)
    rows: NDArray[np.int64] = _ROWS[low * TYPE_COUNT + high]
    return rows


def compile_rows(rows: NDArray[np.int64]) -> list[str]:
    """Compile the kernels of table rows that are not compiled yet; return their names."""
    missing = rows[(rows >= 0) & ~_COMPILED[rows]]
    names: dict[str, None] = {}
    for row in np.unique(missing).tolist():
        ADDRESSES[row] = compiled_address(PAIR_TABLE[row].load_kernel())
        _COMPILED[row] = True
        names[PAIR_TABLE[row].kernel] = None
    return list(names)


@compiled
def _pose_rounding(p_WGs, i, j):  # type: ignore[no-untyped-def]
    """Return what composing world poses may have cost the pair [m]: far away, digits."""
    reach = 0.0
    for k in range(3):
        reach = max(reach, abs(p_WGs[i, k]), abs(p_WGs[j, k]))
    return 8.0 * EPS * reach


@compiled
def narrow_phase(  # type: ignore[no-untyped-def]
    addresses, rows, pairs, swapped, types, scene, sizes, gap, cutoff, results
):
    """Call the kernel of each pair; the only place where the order of A and B is exchanged."""
    starts, pool, R_WGs, p_WGs = scene
    p_AB_W = np.empty(3)
    for k in range(pairs.shape[0]):
        if swapped[k]:
            a, b = pairs[k, 1], pairs[k, 0]
        else:
            a, b = pairs[k, 0], pairs[k, 1]
        for c in range(3):
            p_AB_W[c] = p_WGs[b, c] - p_WGs[a, c]
        # The gap is absolute for bodies of a metre and more, relative below.
        tolerance = gap * min(1.0, sizes[0][a], sizes[0][b])
        out = results[k]
        call_kernel(  # type: ignore[no-untyped-call]
            addresses[rows[k]],
            types[a],
            pool[starts[a] : starts[a + 1]],
            R_WGs[a],
            types[b],
            pool[starts[b] : starts[b + 1]],
            R_WGs[b],
            p_AB_W,
            tolerance,
            cutoff,
            out,
        )
        out[ERROR_BOUND] += _pose_rounding(p_WGs, a, b)
        if swapped[k]:
            for c in range(3):
                # Measured from the other body's origin from now on.
                p_a = out[WITNESS_A + c] - p_AB_W[c]
                p_b = out[WITNESS_B + c] - p_AB_W[c]
                out[WITNESS_A + c], out[WITNESS_B + c] = p_b, p_a
                out[NORMAL + c] = -out[NORMAL + c]


@compiled
def bound_phase(pairs, types, scene, sizes, results):  # type: ignore[no-untyped-def]
    """Answer each pair by the certified interval of its bounds alone."""
    starts, pool, R_WGs, p_WGs = scene
    inner = sizes[1]
    p_AB_W = np.empty(3)
    for k in range(pairs.shape[0]):
        a, b = pairs[k, 0], pairs[k, 1]
        for c in range(3):
            p_AB_W[c] = p_WGs[b, c] - p_WGs[a, c]
        bounding_interval(
            (types[a], pool[starts[a] : starts[a + 1]], R_WGs[a], inner[a]),
            (types[b], pool[starts[b] : starts[b + 1]], R_WGs[b], inner[b]),
            p_AB_W,
            results[k],
        )
        results[k, ERROR_BOUND] += _pose_rounding(p_WGs, a, b)


@compiled
def point_phase(  # type: ignore[no-untyped-def]
    addresses, rows, types, p_WQs, scene, sizes, threshold, results, points, geometries
):
    """Call the kernel of a sphere without radius for each point and geometry within reach.

    ``rows`` (n,) holds the table row of SPHERE against each geometry. Returns how many of
    ``results``, ``points`` and ``geometries`` were filled, in the order of points, then ids.
    """
    starts, pool, R_WGs, p_WGs = scene
    outer = sizes[0]
    nothing, identity = np.zeros(1), np.eye(3)
    p_QG_W = np.empty(3)
    count = 0
    for q in range(p_WQs.shape[0]):
        for g in range(rows.size):
            squared, reach = 0.0, 0.0
            for c in range(3):
                p_QG_W[c] = p_WGs[g, c] - p_WQs[q, c]
                squared += p_QG_W[c] * p_QG_W[c]
                reach = max(reach, abs(p_WQs[q, c]), abs(p_WGs[g, c]))
            rounding = 8.0 * EPS * reach
            if math.sqrt(squared) - outer[g] > threshold + rounding:
                continue
            out = results[count]
            call_kernel(  # type: ignore[no-untyped-call]
                addresses[rows[g]],
                SPHERE,
                nothing,
                identity,
                types[g],
                pool[starts[g] : starts[g + 1]],
                R_WGs[g],
                p_QG_W,
                0.0,
                math.inf,
                out,
            )
            if out[DISTANCE] <= threshold:
                out[ERROR_BOUND] += rounding
                points[count], geometries[count] = q, g
                count += 1
    return count
