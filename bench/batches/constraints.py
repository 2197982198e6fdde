"""Constraints on the minimum distance with derivatives, beside pydrake's, in one run.

    ./run exec python -m bench.batches.constraints [--states 200] [--influence 0.1]

Two arms with 16 joints and the same pairs of geometries, random states. Processor time of one
thread by evaluation, the least of some turns. Differences are over all states.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from bench.batches.ours import Ours
from bench.batches.timing import TURNS, sides
from drake_geom_ros.batch import Checker
from drake_geom_ros.optimization import MinimumDistanceLowerBoundConstraint

BOUND = 0.02  # [m]


def main() -> None:
    """Print a line for each way to evaluate."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--states', type=int, default=200)
    parser.add_argument('--influence', type=float, default=0.1)
    options = parser.parse_args()
    ours = Ours()
    others = {other.name: other for other in sides(ours)}
    states = list(ours.states(options.states))
    checker = Checker(ours.scene_graph, ours.joints)
    offset = options.influence - BOUND
    constraint = MinimumDistanceLowerBoundConstraint(checker, BOUND, offset)
    ways: dict[str, Callable[[Any], Any]] = {
        'Checker.free': checker.free,
        'Checker.clearance': checker.clearance,
        'Checker.clearance_and_gradient': checker.clearance_and_gradient,
        'Checker.near_pairs': lambda q: checker.near_pairs(q, options.influence),
        'Checker.distances_and_gradients': lambda q: checker.distances_and_gradients(
            q, within=options.influence
        ),
        'constraint with derivatives': constraint.value_and_jacobian,
    }
    if 'pydrake' in others:
        theirs = others['pydrake'].minimum_distance(BOUND, offset)
        ways['pydrake, constraint with derivatives'] = theirs
        pairs = [(constraint.value_and_jacobian(q), theirs(q)) for q in states]
        values = max(abs(a[0][0] - b[0]) / max(1.0, abs(b[0])) for a, b in pairs)
        slopes = max(np.abs(a[1][0] - b[1]).max() / max(1.0, np.abs(b[1]).max()) for a, b in pairs)
        print(f'values differ by {values:.2g} and derivatives by {slopes:.2g}, relative')
    best = dict.fromkeys(ways, np.inf)
    for _ in range(TURNS):
        for name, way in ways.items():
            start = time.process_time()
            for q in states:
                way(q)
            best[name] = min(best[name], (time.process_time() - start) / len(states))
    near = [np.isfinite(ways['Checker.distances_and_gradients'](q).distance).sum() for q in states]
    print(f'{len(checker.pairs)} pairs, of which {np.mean(near):.1f} are near')
    for name, taken in best.items():
        ratio = taken / best['constraint with derivatives']
        print(f'{name:40} {1e6 * taken:8.1f} us, {ratio:5.2f} times our constraint')


if __name__ == '__main__':
    main()
