"""Time and memory of two arms by the accuracy that is wanted, with and without coarse hulls.

::

    python -m bench.accuracy.arms     # docs/accuracy/arms.md

Each scene is made twice, once without coarse hulls, which changes no verdict. Ways take turns;
times are of the processor, one thread, the least of the turns.
"""

from __future__ import annotations

import argparse
import functools
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from unittest import mock

import numpy as np

from bench.batches.ours import ROOT
from bench.pages import description, table, three, versions, write_rows
from drake_geom_ros import geometry
from drake_geom_ros.batch import Checker, Joints, evaluate
from drake_geom_ros.geometry.meshes import _coarse_hulls, source
from drake_geom_ros.scene_files import load_scene
from drake_geom_ros.scene_files.resources import ResourceResolver

OUT = ROOT / 'docs/accuracy'
LENGTHS = (1e-9, 1e-6, 1e-4, 1e-3, 3e-3, 1e-2, 3e-2, 1e-1)  # [m]
FARTHEST = 0.2  # [m] of the distances that are wanted
ROBOTS = 'package://example-robot-data/robots/'
PANDA = 'panda_description/urdf/panda.urdf', 'panda_description/srdf/panda.srdf'
UR5 = 'ur_description/urdf/ur5_robot.urdf', 'ur_description/srdf/ur5.srdf'
FAMILIES = {
    'two Pandas, collision hulls': (PANDA, 'collision', False),
    'two Pandas, visual hulls': (PANDA, 'visual', False),
    'two UR5, visual hulls': (UR5, 'visual', False),
    'two Pandas, collision solids': (PANDA, 'collision', True),
}


@dataclass(frozen=True)
class Row:
    """What a family takes in one way."""

    family: str
    way: str
    accuracy: float  # [m], 0 for verdicts
    without: float  # us a state, without coarse hulls
    microseconds: float
    error_bound: float  # [m], the largest of bodies that are apart


class Arms:
    """Two arms that face each other, with their meshes."""

    def __init__(self, family: str, folder: Path, scenery: str = '') -> None:
        """Load the arms of a family, and ``scenery``, further keys of a scene file."""
        files, meshes, solid = FAMILIES[family]
        urdf, srdf = (ResourceResolver().resolve(ROBOTS + file, folder) for file in files)
        text = urdf.read_text()
        if meshes == 'visual':
            text = text.replace('/collision/', '/visual/').replace('.stl', '.dae')
        (folder / 'arm.urdf').write_text(text)
        solids = ', solid_meshes: ["*"]' if solid else ''
        poses = '[-0.45, 0, 0]', '[0.45, 0, 0], rpy: [0, 0, 3.141592653589793]'
        robots = ''.join(
            f'  - {{name: {name}, urdf: {folder}/arm.urdf, srdf: {srdf}, '
            f'pose: {{position: {pose}}}{solids}}}\n'
            for name, pose in zip(('left', 'right'), poses, strict=True)
        )
        self.scene_graph = geometry.SceneGraph()
        warnings.simplefilter('ignore')  # visual meshes are open, so points measure to hulls
        begun = time.process_time()
        loaded = load_scene(f'name: arms\nrobots:\n{robots}{scenery}', self.scene_graph)
        self.joints = Joints.of(loaded)
        self.checker = Checker(self.scene_graph, self.joints, 0.0, ignore_limits=True)
        self.seconds = time.process_time() - begun

    def states(self, count: int) -> np.ndarray:
        """Return random joint values (count, c) within the limits."""
        rng, joints = np.random.default_rng(0), self.joints
        lower, upper = np.maximum(joints.lower, -np.pi), np.minimum(joints.upper, np.pi)
        return rng.uniform(lower, upper, (count, joints.count))

    def within(self, states: np.ndarray, accuracy: float) -> Any:
        """Return the distances of all pairs up to FARTHEST."""
        asked = {'states': states, 'joints': self.joints, 'max_distance': FARTHEST, 'threads': 1}
        return evaluate(self.scene_graph, want='within', accuracy=accuracy, **asked)


def both(family: str, folder: Path) -> tuple[Arms, Arms]:
    """Return a family without coarse hulls, and with them."""
    found = []
    for many in (np.inf, _coarse_hulls.MANY):
        source._chosen_vertices.cache_clear()
        with mock.patch.object(_coarse_hulls, 'MANY', many):
            found.append(Arms(family, folder))
    return found[0], found[1]


def clocked(ways: list[Callable[[], Any]], turns: int) -> list[float]:
    """Return the least processor time [s] of each way, in turns."""
    least = [np.inf] * len(ways)
    for _ in range(turns):
        for k, way in enumerate(ways):
            begun = time.process_time()
            way()
            least[k] = min(least[k], time.process_time() - begun)
    return least


def measure(family: str, count: int, turns: int) -> list[Row]:
    """Return the rows of a family: verdicts of states, and distances at each accuracy."""
    rows = []
    with TemporaryDirectory() as folder:
        arms = both(family, Path(folder))
        states = arms[0].states(count)
        for margin in (0.0, 0.02):
            checkers = [
                Checker(arm.scene_graph, arm.joints, margin, ignore_limits=True) for arm in arms
            ]
            verdicts = [checker.free_each(states) for checker in checkers]  # this compiles, too
            assert (verdicts[0] == verdicts[1]).all()
            ways = [functools.partial(checker.free_each, states) for checker in checkers]
            without, seconds = (1e6 * s / count for s in clocked(ways, turns))
            free = f'{verdicts[0].mean():.0%} free'
            way = f'Checker.free_each, margin {margin} m, {free}'
            rows.append(Row(family, way, 0.0, without, seconds, 0.0))
            print(rows[-1], flush=True)
        few = states[: max(1, count // 10)]
        ways = [functools.partial(arms[0].within, few, LENGTHS[0])]
        ways += [functools.partial(arms[1].within, few, length) for length in LENGTHS]
        answers = [way() for way in ways]
        times = [1e6 * s / len(few) for s in clocked(ways, turns)]
        for length, answer, seconds in zip(LENGTHS, answers[1:], times[1:], strict=True):
            apart = answer.distance > answer.error_bound
            bound = float(answer.error_bound[apart].max())
            rows.append(
                Row(family, f'distances up to {FARTHEST} m', length, times[0], seconds, bound)
            )
            print(rows[-1], flush=True)
        made = [arm.seconds for arm in arms]
        print(f'{family}: made in {made[0]:.2f} s without, {made[1]:.2f} s with', flush=True)
    return rows


_PAGE = """# Two arms, and what accuracy saves them

Generated by `python -m bench.accuracy.arms --states {states}`; each row is a line of
[arms.csv](arms.csv).

Two arms stand 0.9 m apart, in random states within their limits. Hulls of 128 vertices or more
have a coarse hull of 64, with a certified bound of how far they reach beyond it
([representations](../concepts.md)). Verdicts of `Checker` are those of `exact` in every state.
Times are microseconds of the processor for a state, one thread, the least of {turns} turns;
*gain* is the time without coarse hulls at `exact` over that with them: above 1 is faster. *Bound*
is the largest `error_bound` of bodies that are apart.

{table}

Machine: {machine}. Versions: {versions}.
"""


def main() -> None:
    """Write the rows and the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--states', type=int, default=2000)
    parser.add_argument('--turns', type=int, default=3)
    parser.add_argument('--families', nargs='*', default=list(FAMILIES))
    parser.add_argument('--print', action='store_true', help='write no page')
    options = parser.parse_args()
    rows = [
        row for name in options.families for row in measure(name, options.states, options.turns)
    ]
    if options.print:
        return
    write_rows(OUT / 'arms.csv', rows)
    lines = [
        (
            *(row.family, row.way, f'{row.accuracy:g}' if row.accuracy else ''),
            *(three(row.without), three(row.microseconds)),
            f'{row.error_bound:.1e}' if row.accuracy else '',
            f'{row.without / row.microseconds:.2g}',
        )
        for row in rows
    ]
    heads = (
        *('arms', 'query', 'accuracy [m]', 'without [us]', 'with [us]'),
        *('bound, at most [m]', 'gain'),
    )
    text = _PAGE.format(
        states=options.states,
        turns=options.turns,
        table=table(heads, lines, left=2).rstrip(),
        machine=description(),
        versions=', '.join(f'{name} {of}' for name, of in versions([]).items()),
    )
    (OUT / 'arms.md').write_text(text)


if __name__ == '__main__':
    main()
