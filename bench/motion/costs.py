"""What a proof of a motion costs: by its tolerances, by the level of accuracy, by the clearance.

``python -m bench.motion costs`` writes ``motions.md``, ``motions.csv`` and ``motions.png`` into
docs/accuracy.
"""

from __future__ import annotations

import csv
import math
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from bench.batches.ours import ROOT, Ours
from bench.motion.arms import WIRES, edges_of
from bench.motion.bodies import Floats, Scene, l_shape, pose_rows
from bench.motion.clocks import clocked
from drake_geom_ros.batch import Checker, Joints, PathChecker
from drake_geom_ros.geometry import ACCURACY_LEVELS, Box, Mesh, SceneGraph, Sphere
from drake_geom_ros.geometry.queries.motion_queries import MotionQuestion
from drake_geom_ros.scene_files import load_scene

FOLDER = ROOT / 'docs/accuracy'
TIME_TOLERANCES = (1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10)
BOUND_TOLERANCES = (math.inf, 0.1, 1e-2, 1e-3, 1e-4, 1e-6)
CLOSE = 1e-4  # [m] to which the clearance of an edge is known here
STEP = 0.5  # [rad] length of an edge
_TURNS = 21  # of a passage, of whose times the median counts


@dataclass(frozen=True)
class Cost:
    """One check: of what, by which setting, what it told, and its processor time."""

    scene: str
    setting: str
    value: str
    motion: int
    outcome: str
    clearance: float  # [m] of the whole motion, at least; nan: it is not clear
    lower_bound: float  # [m] that this check proves
    width: float  # of the span that holds a first contact; nan: it has none
    evaluations: int
    microseconds: float


def measured(edges: int) -> list[Cost]:
    """Return all checks of edges of arms, and of passages at known distances."""
    arms = Ours()
    wires = SceneGraph()
    names = [f'arm::panda_joint{k}' for k in range(1, 8)]
    carrying = Joints.of(load_scene(WIRES, wires), names)
    found = _of_edges('two arms', arms.scene_graph, arms.joints, edges)
    found += _of_edges('a rod among wires', wires, carrying, edges)
    return found + _of_passages()


def _of_edges(name: str, scene_graph: SceneGraph, joints: Joints, count: int) -> list[Cost]:
    paths = edges_of(Checker(scene_graph, joints), joints, count, STEP)
    closely = PathChecker(scene_graph, joints, bound_tolerance=CLOSE)
    checks = closely.check_each(paths, 1)
    clear = np.array([check.outcome == 'clear' for check in checks])
    touch = np.array([check.outcome == 'contact' for check in checks])
    clearances = np.array([c.lower_bound if c.outcome == 'clear' else math.nan for c in checks])

    def asked(setting: str, value: Any, which: Any, **how: Any) -> list[Cost]:
        checker = PathChecker(scene_graph, joints, **how)
        checker.check_each(paths[which], 1)  # what is prepared, compiled or loaded once
        told, seconds = clocked(checker.check, paths[which])
        rows = zip(np.flatnonzero(which).tolist(), told, seconds.tolist(), strict=True)
        return [
            _cost((name, setting, f'{value}', k), check, float(clearances[k]), time)
            for k, check, time in rows
        ]

    found: list[Cost] = []
    for tolerance in TIME_TOLERANCES:
        found += asked('time_tolerance', tolerance, touch, time_tolerance=tolerance)
    for level in ACCURACY_LEVELS:
        found += asked('accuracy', level, clear | touch, accuracy=level)
    for bound in BOUND_TOLERANCES:
        found += asked('bound_tolerance', bound, clear, bound_tolerance=bound)
    return found


def _of_passages() -> list[Cost]:
    """Return checks of two bodies that pass each other at distances from 1 m to a nanometre."""
    found: list[Cost] = []
    ball, mesh = Sphere(0.1), Mesh(l_shape())
    balls, boxes, notch = Scene([ball, ball]), Scene([Box(0.2, 0.2, 0.2)] * 2), Scene([mesh, ball])
    for exponent in np.arange(0.0, -9.01, -0.5):
        d = float(10.0**exponent)
        # Past each other on a line; turning by 1 rad about the way; along the wall of a notch.
        turned = [math.sin(0.5), 0.0, 0.0, math.cos(0.5)]
        motions = [
            ('ball past ball', balls, [-1.0, 0.2 + d, 0.0], [1.0, 0.2 + d, 0.0], None),
            ('box past box', boxes, [-1.0, 0.2 + d, 0.0], [1.0, 0.2 + d, 0.0], None),
            ('turning box past box', boxes, [-1.0, 0.3 + d, 0.0], [1.0, 0.3 + d, 0.0], turned),
        ]
        if -4.0 <= exponent < -0.5:
            start, end = [0.1 + d, 0.6, 0.0], [0.1 + d, 0.2, 0.0]
            motions.append(('ball in the notch of a solid', notch, start, end, None))
        for name, scene, start, end, turn in motions:
            starts, ends = np.zeros((2, 7)), np.zeros((2, 7))
            starts[:, 6] = ends[:, 6] = 1.0
            starts[1, :3], ends[1, :3] = start, end
            if turn is not None:
                ends[1, 3:] = turn
            rows = pose_rows(starts), pose_rows(ends)
            checks, seconds = clocked(
                lambda r, s=scene: s.motions.move(MotionQuestion(), *r, 'slerp'), [rows] * _TURNS
            )
            time = float(np.median(seconds))
            found.append(_cost((name, 'distance', f'{d:.3g}', 0), checks[0], d, time))
    return found


def _cost(of: tuple[str, str, str, int], check: Any, clearance: float, seconds: float) -> Cost:
    touches = check.outcome == 'contact'
    return Cost(
        *of,
        outcome=check.outcome,
        clearance=clearance,
        lower_bound=check.lower_bound if check.outcome == 'clear' else math.nan,
        width=check.times[1] - check.times[0] if touches else math.nan,
        evaluations=check.evaluations,
        microseconds=1e6 * seconds,
    )


def write_csv(costs: list[Cost], path: Path) -> None:
    """Write all checks, one a line."""
    with path.open('w', newline='', encoding='utf-8') as file:
        writer = csv.writer(file, lineterminator='\n')
        writer.writerow([field.name for field in fields(Cost)])
        for cost in costs:
            writer.writerow([f'{v:.6g}' if isinstance(v, float) else v for v in astuple(cost)])


def column(costs: list[Cost], name: str) -> Floats:
    """Return one field of some checks."""
    return np.array([getattr(cost, name) for cost in costs])
