"""Edges of arms: the time of a proof beside that of sampling and casting, and what these miss.

The demo's two arms, and one that carries a thin rod among wires (``examples/wires.yaml``).
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.batches.ours import ROOT, Ours
from bench.batches.timing import sides
from bench.motion.clocks import clocked, told
from drake_geom_ros.batch import Checker, Joints, PathChecker
from drake_geom_ros.geometry import SceneGraph
from drake_geom_ros.scene_files import load_scene

Floats = NDArray[np.float64]
WIRES = ROOT / 'examples/wires.yaml'
_BLOCK = 16  # states between two looks whether one was not free


@dataclass(frozen=True, eq=False)
class Proved:
    """Edges (n, 2, q), how far the fastest link comes [m], what is proved, and times [s]."""

    paths: Floats
    far: Floats
    outcomes: Any
    first: Floats
    verdict: Floats

    def ratios(self, theirs: Floats) -> str:
        """Return how many times as long another side takes, in the mean."""
        return (
            f'{theirs.mean() / self.first.mean():.2f} times as long as a proof, '
            f'{theirs.mean() / self.verdict.mean():.2f} times as a verdict'
        )


def lengths(joints: Joints, paths: Floats) -> Floats:
    """Return how far the fastest origin of a link comes on each edge [m]."""
    times = np.linspace(0.0, 1.0, 33)[:, None]
    found = []
    for first, last in paths:
        poses = joints.poses(first + times * (last - first))
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


def edges_of(checker: Checker, joints: Joints, count: int, step: float) -> Floats:
    """Return edges (n, 2, q) of a length [rad] that start free, in any direction."""
    rng = np.random.default_rng(0)
    states = rng.uniform(joints.lower, joints.upper, (4 * count, joints.count))
    starts = states[checker.free_each(states)][:count]
    ways = rng.normal(size=starts.shape)
    ways *= step / np.linalg.norm(ways, axis=1, keepdims=True)
    return np.stack((starts, np.clip(starts + ways, joints.lower, joints.upper)), axis=1)


def run(edges: int, step: float) -> None:
    """Check edges that start free, by us and by others, and print times and verdicts."""
    ours = Ours()
    others = [side for side in sides(ours) if side.name == 'pydrake']
    proved = _proved('two arms', ours.scene_graph, ours.joints, edges, step)
    for side in others:
        _by_edges(side, proved)
    _cast(proved.paths)
    scene_graph = SceneGraph()
    loaded = load_scene(WIRES, scene_graph)
    names = [f'arm::panda_joint{k}' for k in range(1, 8)]
    _proved('a rod among wires', scene_graph, Joints.of(loaded, names), edges, step)


def _proved(name: str, scene_graph: SceneGraph, joints: Joints, edges: int, step: float) -> Proved:
    """Print our times and verdicts, and those of samples; return what is proved."""
    checker = Checker(scene_graph, joints)
    paths = edges_of(checker, joints, edges, step)
    far = lengths(joints, paths)
    print(
        f'{name}: {len(paths)} edges of {step} rad that start free; the fastest link '
        f'{far.mean():.3f} m'
    )
    first = PathChecker(scene_graph, joints)
    verdict = PathChecker(scene_graph, joints, time_tolerance=1.0)
    for some in (first, verdict):
        some.check_each(paths, 1)  # what is prepared, compiled or loaded once
    checks, seconds = clocked(first.check, paths)
    told('proved, first contact within 1e-6', seconds)
    outcomes = np.array([check.outcome for check in checks])
    for outcome in ('clear', 'contact', 'unknown'):
        if (outcomes == outcome).any():
            told(f'  {outcome} ({(outcomes == outcome).sum()})', seconds[outcomes == outcome])
    _, alone = clocked(verdict.check, paths)
    told('proved, verdict alone (time_tolerance 1)', alone)
    proved = Proved(paths, far, outcomes, seconds, alone)
    for resolution in (0.002, 0.01):
        sampled = [samples(p, d, resolution) for p, d in zip(paths, far, strict=True)]
        verdicts, each = clocked(partial(all_free, checker), sampled)
        told(f'our Checker every {1000 * resolution:.0f} mm', each)
        print(f'    {_verdicts(outcomes, verdicts)}; {proved.ratios(each)}')
    return proved


def _cast(paths: Floats) -> None:
    """Time tesseract's casts, of the whole edge and cut in pieces, without ellipsoids."""
    try:
        from bench.motion.tesseract_side import TesseractArms
    except ImportError as error:
        print(f'not installed here, left out: tesseract ({error})')
        return
    ours = Ours()
    arms = TesseractArms(ours)
    checker = PathChecker(ours.scene_graph, ours.joints)
    checker.check_each(paths, 1)
    checks, seconds = clocked(checker.check, paths)
    outcomes = np.array([check.outcome for check in checks])
    counts = Counter(outcomes.tolist())
    told(f'proved, without the ellipsoids {dict(counts)}', seconds)
    for segments in (1, 10):
        states = [arms.states(path, segments) for path in paths]
        free, each = clocked(arms.manager.is_free, states)
        told(f'tesseract, {segments} casts an edge', each)
        print(
            f'    {_verdicts(outcomes, free)}; {each.mean() / seconds.mean():.2f} times as long '
            'as a proof'
        )


def _verdicts(outcomes: Any, free: Any) -> str:
    pairs = Counter(zip(outcomes.tolist(), free, strict=True))
    missed, refused = pairs['contact', True], pairs['clear', False]
    return f'{missed} edges called free that touch, {refused} not free that are clear'


def _by_edges(side: Any, proved: Proved) -> None:
    """Time pydrake's check of whole edges, at 2 mm of the fastest link."""
    edges = [
        (path, max(1, int(np.ceil(length / 0.002))))
        for path, length in zip(proved.paths, proved.far, strict=True)
    ]
    free, seconds = clocked(lambda edge: side.edge_is_free(*edge), edges)
    told('pydrake, CheckEdgeCollisionFree every 2 mm', seconds)
    print(f'    {_verdicts(proved.outcomes, free)}; {proved.ratios(seconds)}')
