"""Distances of very many points, a block after another, so that no answer is too large."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import ArgumentError, PointDistanceResults, QueryObject

# The query has room for each point and geometry; that many rows of 100 bytes at a time.
ROWS_AT_ONCE = 1_000_000
_MOST_ROWS = 2_000_000  # of an answer, whose message then has 160 MB


def distances_to(
    query: QueryObject,
    points: NDArray[np.float64],
    numbers: NDArray[np.int64],
    threshold: float,
    accuracy: str | None = None,
) -> tuple[list[PointDistanceResults], list[NDArray[np.int64]]]:
    """Return the distances [m] to ``points[numbers]``, in blocks, and the numbers of each block.

    Raises ArgumentError when there are more than an answer can hold.
    """
    step = max(1, ROWS_AT_ONCE // max(1, query.inspector().num_geometries()))
    blocks = [numbers[k : k + step] for k in range(0, max(1, len(numbers)), step)]
    parts: list[PointDistanceResults] = []
    for block in blocks:
        parts.append(
            query.ComputeSignedDistanceToPoint(points[block], threshold, accuracy=accuracy)
        )
        if sum(map(len, parts)) > _MOST_ROWS:
            raise ArgumentError(
                f'{len(numbers)} points have more than {_MOST_ROWS} distances up to '
                f'{threshold} m; an answer holds no more: ask for fewer points, or a smaller '
                'threshold'
            )
    return parts, blocks
