"""Time of one pair, for each row of the pair table at several distances, in microseconds.

    ./run exec python bench/costs/kernels.py [--pairs 300] [--only Cylinder]

Bodies of 10 to 20 cm at random poses, brought to each distance along their normal (negative:
overlapping). Two figures each: without a hint, and with the normal of the pose before, 1 mm away.
The median over rounds of the mean over pairs, one thread, without the engine around the kernels.
"""

import argparse
import statistics
import time

import numpy as np
from numba import njit

from drake_geom_ros.cross_check.bodies import COUNTS
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    NORMAL,
    PAIR_WIDTH,
    Aim,
    OrientedShape,
    call_kernel,
    compiled_address,
)
from drake_geom_ros.geometry._proximity.kernels.pair_table import PAIR_TABLE, SHAPE_NAMES
from drake_geom_ros.geometry._proximity.kinds import CONVEX
from truth.bodies.random_bodies import random_directions, random_rotations

DISTANCES = (0.05, 0.002, 0.0, -0.001, -0.01, -0.05)
HULL_VERTICES = 64
ROUNDS = 7
STEP = 0.001  # [m]
EXACT = 1e-9


@njit
def run(address, kind_A, shapes_A, R_WAs, kind_B, shapes_B, R_WBs, p_AB_Ws, tolerance, rows):
    """Call the kernel once for each pair."""
    for k in range(p_AB_Ws.shape[0]):
        A = OrientedShape(kind_A, shapes_A[k], R_WAs[k])
        B = OrientedShape(kind_B, shapes_B[k], R_WBs[k])
        call_kernel(address, A, B, p_AB_Ws[k], Aim(1.0, tolerance, np.inf, 0.0), rows[k])


def random_shapes(rng, kind, count):
    """Return kernel parameters (count, n) of bodies with half sizes of 5 to 10 cm."""
    if kind != CONVEX:
        return rng.uniform(0.05, 0.1, (count, COUNTS[SHAPE_NAMES[kind]]))
    directions = random_directions(rng, count * HULL_VERTICES).reshape(count, HULL_VERTICES, 3)
    vertices = (directions * rng.uniform(0.05, 0.1, (count, 1, 3))).reshape(count, -1)
    return np.hstack([np.full((count, 1), float(HULL_VERTICES)), vertices])


def microseconds(arguments, tolerance, hints):
    """Return the median time of a pair, every round from the same hints."""
    times = []
    for _ in range(ROUNDS):
        rows = np.zeros((len(hints), PAIR_WIDTH))
        rows[:, NORMAL : NORMAL + 3] = hints
        start = time.perf_counter()
        run(*arguments, tolerance, rows)
        times.append((time.perf_counter() - start) / len(hints) * 1e6)
    return statistics.median(times), rows


def measure(row, pairs):
    """Return the times of a row of the pair table, (without, with hint) for each distance."""
    rng = np.random.default_rng(1)
    address = compiled_address(row.load_kernel())
    bodies = (
        *(row.type_a, random_shapes(rng, row.type_a, pairs), random_rotations(rng, pairs)),
        *(row.type_b, random_shapes(rng, row.type_b, pairs), random_rotations(rng, pairs)),
    )
    away = 0.3 * random_directions(rng, pairs)
    none = np.zeros((pairs, 3))
    _, first = microseconds((address, *bodies, away), EXACT, none)
    found = []
    for distance in DISTANCES:
        shift = first[:, DISTANCE, None] - distance
        placed = away + shift * first[:, NORMAL : NORMAL + 3]
        plain, rows = microseconds((address, *bodies, placed), EXACT, none)
        moved = placed + STEP * rng.normal(size=(pairs, 3))
        hints = rows[:, NORMAL : NORMAL + 3].copy()
        hinted, _ = microseconds((address, *bodies, moved), EXACT, hints)
        found.append((plain, hinted))
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--pairs', type=int, default=300, help='pairs of each row (default: 300)')
    parser.add_argument('--only', default='', help='rows with this in their names')
    options = parser.parse_args()
    print(f'{"us a pair":24}', *(f'{1000 * d:>7.0f} mm   ' for d in DISTANCES))
    for row in PAIR_TABLE:
        name = f'{SHAPE_NAMES[row.type_a]}-{SHAPE_NAMES[row.type_b]}'
        if options.only in name:
            times = measure(row, options.pairs)
            print(f'{name:24}', *(f'{plain:6.2f}/{hint:6.2f}' for plain, hint in times))


if __name__ == '__main__':
    main()
