"""Random motions of all shapes, by poses and by joints, against what is known of them.

A scan by our own distances tells where bodies touch for sure, and closed forms when those that
graze by construction first do. ``python -m bench.motion hunt --seed K`` are other motions than of
any other seed: parts of a long hunt can be run one by one.
"""

from __future__ import annotations

import time
from collections import Counter
from typing import Any

import numpy as np

from bench.batches.ours import Ours
from bench.motion.bodies import (
    ROUNDING,
    Floats,
    Scene,
    between,
    l_shape,
    random_motion,
    random_scene,
)
from bench.motion.grazing import GrazingScenes
from bench.motion.robots import RandomRobots
from drake_geom_ros.batch import check_paths, evaluate
from drake_geom_ros.geometry.queries.motion_queries import MotionQuestion

_A_SCENE = 100  # motions of each scene
_SCAN = 64  # states of a scan
_GRAZES = 40  # one motion in so many of the poses does


def run(motions: int, seed: int) -> int:
    """Hunt; print what was found, and return 1 if anything was wrong."""
    rng, told, wrong = np.random.default_rng(seed), Counter[str](), 0
    mesh, began, arms = l_shape(), time.process_time(), Ours()
    for number, first in enumerate(range(0, motions, _A_SCENE)):
        count = min(_A_SCENE, motions - first)
        if number % 10 == 0:
            wrong += _by_joints(rng, arms, _near(rng, arms, count), 'two arms', told)
        elif number % 10 in (1, 4, 7):
            robots = RandomRobots(rng, mesh)
            wrong += _by_joints(rng, robots, robots.paths(rng, count), 'robots', told)
        else:
            wrong += _by_poses(rng, mesh, count, told)
    _tell(told, wrong, motions, time.process_time() - began)
    return int(wrong > 0)


def _by_poses(rng: np.random.Generator, mesh: str, count: int, told: Counter[str]) -> int:
    """Check motions of some bodies; return how many are wrong."""
    scene, closed, wrong = random_scene(rng, mesh), GrazingScenes(rng), 0
    for number in range(count):
        if number % (_GRAZES // 2) == 0:  # other motions are by joints
            found, bad = closed.check(rng)
            kind = 'grazing'
        else:
            starts, ends = random_motion(rng, len(scene.packed.moved))
            least, kind = float(rng.choice([0.0, 0.02])), str(rng.choice(['slerp', 'screw']))
            found = scene.check(starts, ends, MotionQuestion(least), kind)
            bad = _is_wrong(scene, (starts, ends), kind, found, least)
        told[f'{kind}: {found.outcome}'] += 1
        wrong += bad
    return wrong


def _is_wrong(
    scene: Scene, motion: tuple[Floats, Floats], kind: str, found: Any, least: float
) -> bool:
    """Tell whether a scan contradicts what was found of a motion."""
    times = np.linspace(0.0, 1.0, _SCAN + 1)
    upper = scene.upper_ends(between(*motion, times, kind))
    wrong = bool((upper[times < found.times[0]] <= least).any())
    if found.outcome == 'clear':
        return wrong or bool(upper.min() < found.lower_bound) or bool(upper[-1] <= least)
    if found.outcome == 'contact':
        there = scene.upper_ends(between(*motion, np.array([found.times[1]]), kind))
        return wrong or bool(there[0] - 20.0 * ROUNDING > least)
    return wrong


def _near(rng: np.random.Generator, arms: Ours, count: int) -> Floats:
    """Return edges (n, 2, q) of two arms."""
    lower, upper = arms.joints.lower, arms.joints.upper
    starts = rng.uniform(lower, upper, (count, arms.joints.count))
    return np.stack((starts, starts + rng.normal(0.0, 0.15, starts.shape)), axis=1)


def _by_joints(
    rng: np.random.Generator, robots: Any, paths: Floats, name: str, told: Counter[str]
) -> int:
    """Check edges (n, 2, q) of robots against a scan; return how many are wrong."""
    least, joints = float(rng.choice([0.0, 0.02])), robots.joints
    asked: dict[str, Any] = {'ignore_limits': True, 'threads': 1}
    checks = check_paths(robots.scene_graph, joints, paths, least, **asked)
    times, wrong = np.linspace(0.0, 1.0, _SCAN + 1), 0

    def upper_ends(states: Floats) -> Floats:
        found = evaluate(robots.scene_graph, states=states, joints=joints, want='least', threads=1)
        ends: Floats = found.distance + found.error_bound + ROUNDING
        return ends

    states = paths[:, :1] + times[:, None] * (paths[:, 1:] - paths[:, :1])
    upper = upper_ends(states.reshape(-1, joints.count)).reshape(len(paths), -1)
    at = np.array([check.times[1] for check in checks])[:, None]
    there = upper_ends(paths[:, 0] + at * (paths[:, 1] - paths[:, 0])) - 20.0 * ROUNDING
    for check, up, touching in zip(checks, upper, there, strict=True):
        told[f'{name}: {check.outcome}'] += 1
        bad = (up[times < check.last_free] <= least).any()
        if check.outcome == 'clear':
            bad |= up.min() < check.lower_bound or up.min() <= least
        if check.outcome == 'contact':
            bad |= touching > least
        wrong += int(bad)
    return wrong


def _tell(told: Counter[str], wrong: int, motions: int, seconds: float) -> None:
    unknown = sum(count for kind, count in told.items() if kind.endswith('unknown'))
    print(
        f'{motions} motions, {seconds:.0f} s of processor time: {wrong} wrong, {unknown} unknown '
        f'({100 * unknown / motions:.2f} %), {told["grazing: unknown"]} of them grazing by '
        'construction'
    )
    for kind, count in sorted(told.items()):
        print(f'  {kind} {count}')
