"""The part of ``bench.batches`` about planners: one state at a time, each waited for."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from bench.batches.ours import Ours
from bench.batches.timing import TURNS
from drake_geom_ros.batch import Checker, evaluate

FEW = 50  # states that ``evaluate``, which brings the scene into arrays each time, is asked about


def one_by_one(ours: Ours, drake: Any, states: np.ndarray) -> None:
    """Print what a state costs that is asked about alone, by processor time, all in turns."""
    checker = Checker(ours.scene_graph, ours.joints)
    rows, lists = list(states), states.tolist()
    asked = {'joints': ours.joints, 'threads': 1}

    def at_once() -> None:
        evaluate(ours.scene_graph, want='collision', states=states, max_distance=0.0, **asked)

    def alone() -> None:
        for q in rows[:FEW]:
            evaluate(ours.scene_graph, want='collision', states=q[None], **asked)

    ways: dict[str, tuple[Callable[[], Any], int]] = {
        'Checker.free': (lambda: [checker.free(q) for q in rows], len(rows)),
        'Checker.free of lists': (lambda: [checker.free(q) for q in lists], len(rows)),
        'Checker.free_each': (lambda: checker.free_each(states), len(rows)),
        'Checker.clearance': (lambda: [checker.clearance(q) for q in rows], len(rows)),
        'evaluate of all': (at_once, len(rows)),
        'evaluate of one': (alone, FEW),
    }
    if drake is not None:
        ways['pydrake, CheckConfigCollisionFree'] = (lambda: drake.each(states), len(rows))
    least = dict.fromkeys(ways, np.inf)
    for _ in range(TURNS + 1):  # of which the first compiles
        for name, (work, count) in ways.items():
            start = time.process_time()
            work()
            least[name] = min(least[name], (time.process_time() - start) / count)
    for name, taken in least.items():
        print(
            f'one at a time, {name}: {1e6 * taken:.1f} us a state, '
            f'{taken / least["Checker.free"]:.1f} times Checker.free',
            flush=True,
        )
    verdicts = np.array([checker.free(q) for q in rows])
    found = evaluate(ours.scene_graph, want='collision', states=states, max_distance=0.0, **asked)
    print(f'verdicts that differ from evaluate: {(verdicts == found).sum()}', end='')
    if drake is not None:
        print(f', from pydrake: {(verdicts != drake.each(states)).sum()}', end='')
    print()
