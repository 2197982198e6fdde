"""Splines of two arms, proved, beside states a millisecond apart: verdicts, misses and times.

Trajectories are those that planners hand to controllers: three to six points, cubic with the
velocities of central differences, at rest at both ends, or quintic with accelerations at random.
Half of the arms carry a rod among wires of 2 mm (``examples/wires.yaml``), which sampling misses.
"""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np

from bench.batches.ours import ROOT
from bench.motion.arms import WIRES
from bench.motion.clocks import clocked
from drake_geom_ros.batch import Checker, Joints, PathChecker, evaluate
from drake_geom_ros.geometry import MotionCheck, SceneGraph
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.scene_files import load_scene
from drake_geom_ros.trajectories import JointSpline, JointTrajectory

SAMPLING = 1e-3  # [s]
FINE = 1e-4  # [s] that judges


def random_spline(rng: np.random.Generator, start: Floats, step: float) -> JointSpline:
    """Return a random spline from a state, of points a step [rad] apart."""
    return JointSpline(random_trajectory(rng, start, step))


def random_trajectory(rng: np.random.Generator, start: Floats, step: float) -> JointTrajectory:
    """Return the points of a random spline from a state."""
    count = int(rng.integers(3, 7))
    ways = rng.normal(size=(count - 1, len(start)))
    ways *= step / np.linalg.norm(ways, axis=1, keepdims=True)
    rows = np.vstack((start, start + np.cumsum(ways, axis=0)))
    times = np.concatenate(([0.0], np.cumsum(rng.uniform(0.1, 0.4, count - 1))))
    velocities = np.zeros_like(rows)
    velocities[1:-1] = (rows[2:] - rows[:-2]) / (times[2:] - times[:-2])[:, None]
    accelerations = None
    if rng.random() < 0.5:
        accelerations = np.zeros_like(rows)
        accelerations[1:-1] = rng.normal(0.0, 2.0, rows[1:-1].shape)
    return JointTrajectory(times, rows, velocities, accelerations)


def states_of(spline: JointSpline, step: float) -> tuple[Floats, Floats]:
    """Return times (n,) [s] a step apart, and the states (n, q)."""
    times = np.append(np.arange(0.0, spline.times[-1], step), spline.times[-1])
    return times, np.array([spline.value(time) for time in times])


def is_wrong(check: MotionCheck, edges: Floats, near: Floats) -> bool:
    """Return whether a verdict is refuted by the times [s] at which a state certainly touches."""
    if check.outcome == 'clear':
        return bool(len(near))
    last_free = np.interp(check.last_free, np.arange(len(edges)), edges)
    return bool((near < last_free - 1e-9).any())


def race(scene: Path, count: int, step: float, seed: int) -> str:
    """Return what was seen of random splines in a scene, in words."""
    scene_graph = SceneGraph()
    joints = Joints.of(load_scene(scene, scene_graph))
    checker = Checker(scene_graph, joints)
    paths = PathChecker(scene_graph, joints, ignore_limits=True)
    rng = np.random.default_rng(seed)
    at_rest = np.tile(0.5 * (joints.lower + joints.upper), (2, 1))
    paths.check_spline(JointSpline(JointTrajectory([0.0, 1.0], at_rest, 0.0 * at_rest)))
    checker.free_each(at_rest)  # kernels are compiled by now
    tally: Counter[str] = Counter()
    proof, sampling = [], []
    while sum(tally[name] for name in ('clear', 'contact', 'unknown')) < count:
        start = rng.uniform(joints.lower, joints.upper)
        if not checker.free(start):
            continue
        spline = random_spline(rng, start, step)
        (check,), seconds = clocked(paths.check_spline, [spline])
        proof.append(seconds[0])
        _, coarse = states_of(spline, SAMPLING)
        (free,), seconds = clocked(checker.free_each, [coarse])
        sampling.append(seconds[0])
        times, fine = states_of(spline, FINE)
        least = evaluate(scene_graph, states=fine, joints=joints, want='least')
        near = times[least.distance + least.error_bound <= 0.0]
        tally[check.outcome] += 1
        tally['wrong'] += is_wrong(check, spline.times, near)
        tally['missed'] += check.outcome == 'contact' and bool(np.all(free))
    ratio = np.mean(sampling) / np.mean(proof)
    return (
        f'{scene.name}: {count} splines, {tally["clear"]} clear, {tally["contact"]} in contact, '
        f'{tally["unknown"]} unknown; wrong by states {FINE:g} s apart: {tally["wrong"]}; '
        f'contacts that states {SAMPLING:g} s apart miss: {tally["missed"]}, in {ratio:.2f} '
        'times the time of a proof'
    )


def run(count: int, seed: int) -> int:
    """Print what was seen; return 1 where a verdict was wrong."""
    lines = [
        race(ROOT / 'scenes/two_pandas.yaml', count, 0.5, seed),
        race(WIRES, count, 0.3, seed),
    ]
    print('\n'.join(lines))
    return int(any('apart: 0;' not in line for line in lines))
