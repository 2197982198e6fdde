"""Edges of two arms: the time of a proof beside that of sampling, and what sampling misses."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.batches.ours import Ours
from bench.batches.timing import sides
from drake_geom_ros.batch import Checker, check_paths
from drake_geom_ros.batch.joints import poses_of_arms

Floats = NDArray[np.float64]
_BLOCK = 16  # states between two looks whether one was not free


def lengths(ours: Ours, paths: Floats) -> Floats:
    """Return how far the fastest origin of a link comes on each edge [m]."""
    times = np.linspace(0.0, 1.0, 33)[:, None]
    found = []
    for first, last in paths:
        poses = poses_of_arms(ours.joints.arms, first + times * (last - first))
        steps = np.linalg.norm(np.diff(poses[:, :, :3], axis=0), axis=2)
        found.append(steps.sum(axis=0).max())
    return np.array(found)


def samples(path: Floats, length: float, step: float) -> Floats:
    """Return the states of an edge with no more than a step [m] between them."""
    count = max(1, int(np.ceil(length / step)))
    states = path[0] + np.linspace(0.0, 1.0, count + 1)[:, None] * (path[1] - path[0])
    return np.clip(states, path.min(axis=0), path.max(axis=0))  # as rounding may not leave it


def all_free(checker: Checker, states: Floats) -> bool:
    """Tell whether all states are free; ends at the first block with one that is not."""
    return all(
        checker.free_each(states[k : k + _BLOCK]).all() for k in range(0, len(states), _BLOCK)
    )


def clocked(work: Callable[[Any], Any], each: Any) -> tuple[list[Any], Floats]:
    """Return the results for each of some things, and the processor times [s]."""
    results, seconds = [], []
    for one in each:
        start = time.process_time()
        results.append(work(one))
        seconds.append(time.process_time() - start)
    return results, np.array(seconds)


def told(name: str, seconds: Floats) -> None:
    """Print the mean, the median and the 99th percentile of times [s]."""
    mean, median, slow = seconds.mean(), np.median(seconds), np.percentile(seconds, 99)
    print(f'  {name}: mean {1e6 * mean:.0f} us, median {1e6 * median:.0f}, p99 {1e6 * slow:.0f}')


def run(edges: int, step: float) -> None:
    """Check edges that start free, by us and by others, and print times and verdicts."""
    ours = Ours()
    others = [side for side in sides(ours) if side.name == 'pydrake']
    joints, rng = ours.joints, np.random.default_rng(0)
    checker = Checker(ours.scene_graph, joints)
    states = rng.uniform(joints.lower, joints.upper, (4 * edges, joints.count))
    starts = states[checker.free_each(states)][:edges]
    ways = rng.normal(size=starts.shape)
    ways *= step / np.linalg.norm(ways, axis=1, keepdims=True)
    paths = np.stack((starts, np.clip(starts + ways, joints.lower, joints.upper)), axis=1)
    far = lengths(ours, paths)
    print(f'{len(paths)} edges of {step} rad that start free; the fastest link {far.mean():.3f} m')

    def prove(many: Floats, **asked: Any) -> tuple[list[Any], float]:
        check_paths(ours.scene_graph, joints, many[:1], threads=1)
        start = time.process_time()
        checks = check_paths(ours.scene_graph, joints, many, threads=1, **asked)
        return checks, (time.process_time() - start) / len(many)

    checks, mean = prove(paths)
    _, verdict = prove(paths, time_tolerance=1.0)
    print(f'  proved, first contact within 1e-6: mean {1e6 * mean:.0f} us')
    print(f'  proved, verdict alone (time_tolerance 1): mean {1e6 * verdict:.0f} us')
    outcomes = np.array([check.outcome for check in checks])
    for outcome in ('clear', 'contact', 'unknown'):
        some = paths[outcomes == outcome]
        if len(some):
            _, mean_of = prove(some)
            print(f'    {outcome}: {len(some)} edges, mean {1e6 * mean_of:.0f} us')
    _by_clearance(prove, paths, checks)
    for resolution in (0.002, 0.01):
        sampled = [samples(p, d, resolution) for p, d in zip(paths, far, strict=True)]
        verdicts, seconds = clocked(lambda s: all_free(checker, s), sampled)
        told(f'our Checker every {1000 * resolution:.0f} mm', seconds)
        print(f'    {_verdicts(outcomes, verdicts)}')
    for side in others:
        _by_edges(side, paths, far, outcomes)


def _by_clearance(prove: Any, paths: Floats, checks: list[Any]) -> None:
    """Print what a proof takes by the bound of the clearance that it found."""
    bounds = np.array([c.lower_bound if c.outcome == 'clear' else -1.0 for c in checks])
    for low, high in ((0.0, 1e-3), (1e-3, 1e-2), (1e-2, 1e-1), (1e-1, np.inf)):
        some = paths[(bounds > low) & (bounds <= high)]
        if len(some):
            _, mean = prove(some)
            print(f'    clear by {low:g} to {high:g} m: {len(some)}, mean {1e6 * mean:.0f} us')


def _verdicts(outcomes: Any, free: Any) -> str:
    pairs = Counter(zip(outcomes.tolist(), free, strict=True))
    missed, refused = pairs['contact', True], pairs['clear', False]
    return f'{missed} edges called free that touch, {refused} not free that are clear'


def _by_edges(side: Any, paths: Floats, far: Floats, outcomes: Any) -> None:
    """Time pydrake's check of whole edges, at 2 mm of the fastest link."""
    free, seconds = [], []
    for path, length in zip(paths, far, strict=True):
        start = time.process_time()
        free.append(side.edge_is_free(path, max(1, int(np.ceil(length / 0.002)))))
        seconds.append(time.process_time() - start)
    told('pydrake, CheckEdgeCollisionFree every 2 mm', np.array(seconds))
    print(f'    {_verdicts(outcomes, free)}')
