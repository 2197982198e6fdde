"""Addresses of the kernels of the pair table, compiled once per process when first needed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.kernels.calling.extremes import (
    SIGNATURE_BY_ADDRESS,
    address_at_one_metre,
)
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import compiled_address
from drake_geom_ros.geometry._proximity.kernels.pair_table import (
    ALL_ROWS,
    HULLS_KERNEL,
    OVER_MAP_KERNEL,
    PLAIN_OVERLAP_KERNEL,
    ROW_OF_TYPES,
    TYPE_COUNT,
    load_kernel,
)
from drake_geom_ros.geometry._proximity.runtime.addresses import address_table
from drake_geom_ros.geometry._proximity.runtime.arrays import Booleans, Indices
from drake_geom_ros.geometry._proximity.runtime.compiled import Tell, compilation, compiled

ROWS = np.array(ROW_OF_TYPES, dtype=np.int64)
# Kernels are compiled once per process, for all scenes.
ADDRESSES = address_table(len(ALL_ROWS) + 4)
AT_ONE_METRE = len(ALL_ROWS)  # after the rows: the wrapper of kernels for extreme pairs
OVER_MAP = AT_ONE_METRE + 1  # the loop of a kernel over the cells of a map
PLAIN_OVERLAP = OVER_MAP + 1  # the test whether a solid plainly overlaps, without a depth
HULLS = PLAIN_OVERLAP + 1  # the kernel of a body and the hull of a solid
COMPILED_ROWS = np.zeros(len(ALL_ROWS), dtype=np.bool_)


def table_rows(types_a: NDArray[np.int64], types_b: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the pair table's row of each pair of shape types, in either order; -1 for none."""
    low, high = np.minimum(types_a, types_b), np.maximum(types_a, types_b)
    rows: NDArray[np.int64] = ROWS[low * TYPE_COUNT + high]
    return rows


def compile_rows(rows: NDArray[np.int64], tell: Tell | None = None) -> list[str]:
    """Compile the kernels of table rows that are not compiled yet; return their names."""
    missing = np.unique(rows[(rows >= 0) & ~COMPILED_ROWS[rows]]).tolist()
    if missing and not ADDRESSES[AT_ONE_METRE]:
        ADDRESSES[AT_ONE_METRE] = address_at_one_metre()
    if any(ALL_ROWS[number].is_of_map for number in missing) and not ADDRESSES[OVER_MAP]:
        with compilation(tell, OVER_MAP_KERNEL, 1, 1):
            ADDRESSES[OVER_MAP] = compiled_address(
                load_kernel(OVER_MAP_KERNEL), SIGNATURE_BY_ADDRESS
            )
    with_solids = any(ALL_ROWS[number].has_plain_overlap for number in missing)
    if with_solids and not ADDRESSES[PLAIN_OVERLAP]:
        with compilation(tell, PLAIN_OVERLAP_KERNEL, 1, 1):
            ADDRESSES[PLAIN_OVERLAP] = compiled_address(load_kernel(PLAIN_OVERLAP_KERNEL))
    if with_solids and not ADDRESSES[HULLS]:
        with compilation(tell, HULLS_KERNEL, 1, 1):
            ADDRESSES[HULLS] = compiled_address(load_kernel(HULLS_KERNEL))
    names = list(dict.fromkeys(ALL_ROWS[number].kernel for number in missing))
    for number in missing:
        row = ALL_ROWS[number]
        with compilation(tell, row.kernel, names.index(row.kernel) + 1, len(names)):
            ADDRESSES[number] = compiled_address(row.load_kernel())
        COMPILED_ROWS[number] = True
    return names


@compiled
def has_each(types: Indices, pairs: Indices, count: int, is_compiled: Booleans) -> bool:
    """Return whether the kernels of the first ``count`` pairs are compiled, by shape types.

    ``is_compiled`` are ``COMPILED_ROWS``; two half spaces have no kernel and need none.
    """
    for k in range(count):
        a, b = types[pairs[k, 0]], types[pairs[k, 1]]
        row = ROWS[min(a, b) * TYPE_COUNT + max(a, b)]
        if row >= 0 and not is_compiled[row]:
            return False
    return True
