"""What it takes to make a map, and its memory."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import OccupiedCells
from drake_geom_ros.geometry.shapes.primitives import for_queries

Floats = NDArray[np.float64]

_TURNS = 5


def run(counts: list[int]) -> None:
    """Print times of random maps [ms] and bytes a cell."""
    rng = np.random.default_rng(0)
    for_queries(OccupiedCells(0.1, np.zeros((1, 3))))
    for count in counts:
        times = []
        for _ in range(_TURNS):
            centres = rng.uniform(-2.0, 2.0, (count, 3))
            start = time.process_time()
            shape = OccupiedCells(0.01, centres)
            made = time.process_time()
            packed = for_queries(shape).in_pairs.parameters
            times.append((made - start, time.process_time() - made))
        checked, treed = 1e3 * np.median(times, axis=0)
        size = (packed.nbytes + centres.nbytes) / count
        print(
            f'{count} cells: {checked:.1f} ms to check and copy, {treed:.1f} ms for the tree, '
            f'{size:.0f} bytes a cell: {packed.nbytes / count:.0f} packed, {24} as given'
        )
