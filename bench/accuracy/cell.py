"""Time of a whole cell and of motions by the accuracy that is wanted.

::

    python -m bench.accuracy.cell     # docs/accuracy/cell.md

A cell has two arms with meshes, a table, a map of 1e5 cells and a person. Motions are straight
edges of joints; their verdicts are compared with those of ``exact``. Accuracies take turns; times
are of the processor, one thread, the least of the turns.
"""

from __future__ import annotations

import argparse
import functools
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import matplotlib
import numpy as np
from matplotlib import pyplot

from bench.accuracy.arms import FAMILIES, FARTHEST, LENGTHS, OUT, Arms, clocked
from bench.accuracy.overview import CELL_PICTURE, draw_lines
from bench.pages import description, table, three, versions, write_rows
from drake_geom_ros.batch import Checker, PathChecker
from drake_geom_ros.geometry import GeometryInstance, OccupiedCells, ProximityProperties
from drake_geom_ros.math import RigidTransform

matplotlib.use('Agg')

CELL, MOTION = 'distances in a cell', 'motions'
RESOLUTION, CELLS = 0.02, 100_000  # [m] of the map, and how many
STEP = 0.5  # [rad] of an edge, the joint that moves the farthest
_TABLE = """
  - {name: table, source: scenery, pose: {position: [0, 0.6, 0.2]}, shape: {type: box, size: [1.2, 0.4, 0.4]}}
"""  # noqa: E501
_PERSON = """
  - {name: trunk, source: scenery, pose: {position: [0, -0.8, 1.1]}, shape: {type: capsule, radius: 0.17, length: 0.4}}
  - {name: head, source: scenery, pose: {position: [0, -0.8, 1.65]}, shape: {type: sphere, radius: 0.12}}
  - {name: left_leg, source: scenery, pose: {position: [-0.1, -0.8, 0.45]}, shape: {type: capsule, radius: 0.08, length: 0.7}}
  - {name: right_leg, source: scenery, pose: {position: [0.1, -0.8, 0.45]}, shape: {type: capsule, radius: 0.08, length: 0.7}}
  - {name: left_arm, source: scenery, pose: {position: [-0.2, -0.6, 1.2], rpy: [1.2, 0, 0]}, shape: {type: capsule, radius: 0.05, length: 0.5}}
  - {name: right_arm, source: scenery, pose: {position: [0.2, -0.6, 1.2], rpy: [1.2, 0, 0]}, shape: {type: capsule, radius: 0.05, length: 0.5}}
"""  # noqa: E501
SCENERY = f'geometries:{_TABLE.rstrip()}{_PERSON}'


@dataclass(frozen=True)
class Row:
    """Time of a family at an accuracy."""

    what: str
    family: str
    accuracy: float  # [m]
    microseconds: float  # of a state or of an edge
    error_bound: float  # [m], the largest of bodies that are apart; 0 for motions
    alike: float  # [-] share of answers, or of verdicts, that agree with those of exact


def scanned() -> OccupiedCells:
    """Return a map of CELLS cells: some of the floor and the walls of a room around the arms."""
    across, up = np.arange(-75, 75), np.arange(-6, 140)
    floor = np.stack(np.meshgrid(across, across, [-6], indexing='ij'), axis=-1).reshape(-1, 3)
    wall = np.stack(np.meshgrid(across, up, indexing='ij'), axis=-1).reshape(-1, 2)
    walls = [np.insert(wall, axis, side, axis=1) for axis in (0, 1) for side in (-75, 75)]
    cells = np.random.default_rng(7).permutation(np.concatenate([floor, *walls]))
    return OccupiedCells(RESOLUTION, RESOLUTION * cells[:CELLS])


def cell_of(family: str, folder: Path) -> Arms:
    """Return the arms of a family among the table, the map and the person."""
    arms = Arms(family, folder, SCENERY)
    source = arms.scene_graph.RegisterSource('sensing')
    seen = GeometryInstance(RigidTransform(), scanned(), 'map')
    seen.set_proximity_properties(ProximityProperties())
    arms.scene_graph.RegisterAnchoredGeometry(source, seen)
    return arms


def _alike(found: Any, exact: Any) -> float:
    """Return the share of common pairs whose interval meets that of exact.

    Pairs whose interval holds FARTHEST may be in one of both alone.
    """
    pairs = []
    for each in (found, exact):
        numbers = np.repeat(np.arange(len(each.offsets) - 1), np.diff(each.offsets))
        keys = zip(numbers.tolist(), each.id_A.tolist(), each.id_B.tolist(), strict=True)
        pairs.append({key: k for k, key in enumerate(keys)})
    common = sorted(pairs[0].keys() & pairs[1].keys())
    k, m = (np.array([places[key] for key in common]) for places in pairs)
    apart = np.abs(found.distance[k] - exact.distance[m])
    return float((apart <= found.error_bound[k] + exact.error_bound[m]).mean())


def distances(family: str, count: int, turns: int) -> list[Row]:
    """Return the rows of a cell: all distances of states at each accuracy."""
    with TemporaryDirectory() as folder:
        arms = cell_of(family, Path(folder))
    states, rows = arms.states(count), []
    ways = [functools.partial(arms.within, states, length) for length in LENGTHS]
    answers = [way() for way in ways]
    for length, found, seconds in zip(LENGTHS, answers, clocked(ways, turns), strict=True):
        apart = found.distance > found.error_bound
        bound = float(found.error_bound[apart].max())
        alike = _alike(found, answers[0])
        rows.append(Row(CELL, family, length, 1e6 * seconds / count, bound, alike))
        print(rows[-1], flush=True)
    return rows


def edges_of(arms: Arms, count: int) -> Any:
    """Return edges (count, 2, q) that start in free states."""
    states, rng = arms.states(2 * count), np.random.default_rng(2)
    checker = Checker(arms.scene_graph, arms.joints, 0.0, ignore_limits=True)
    starts = states[checker.free_each(states)][:count]
    ways = rng.uniform(-1.0, 1.0, starts.shape)
    ends = starts + STEP * ways / np.abs(ways).max(axis=1, keepdims=True)
    return np.stack([starts, ends], axis=1)


def motions(family: str, count: int, turns: int) -> list[Row]:
    """Return the rows of motions: checks of edges at each accuracy."""
    with TemporaryDirectory() as folder:
        arms = Arms(family, Path(folder))
    edges, rows = edges_of(arms, count), []
    checkers = [
        PathChecker(arms.scene_graph, arms.joints, accuracy=length, ignore_limits=True)
        for length in LENGTHS
    ]
    ways = [functools.partial(checker.check_each, edges, 1) for checker in checkers]
    outcomes = [np.array([check.outcome for check in way()]) for way in ways]
    for length, found, seconds in zip(LENGTHS, outcomes, clocked(ways, turns), strict=True):
        alike = float((found == outcomes[0]).mean())
        rows.append(Row(MOTION, family, length, 1e6 * seconds / len(edges), 0.0, alike))
        print(rows[-1], flush=True)
    return rows


def draw(rows: list[Row], path: Path) -> None:
    """Write the picture: a line a family, of cells on the left, of motions on the right."""
    figure, axes = pyplot.subplots(ncols=2, figsize=(11.0, 5.4), layout='constrained', sharex=True)
    titles = {
        CELL: f'a whole cell, all distances up to {FARTHEST} m of a state',
        MOTION: f'motions: verdict about an edge of {STEP} rad',
    }
    for each, (what, title) in zip(axes, titles.items(), strict=True):
        draw_lines(each, [row for row in rows if row.what == what])
        each.set_title(title)
        each.legend(loc='upper center', bbox_to_anchor=(0.5, -0.14))
    figure.savefig(path, dpi=100)
    pyplot.close(figure)


_PAGE = """# A whole cell and motions, and what accuracy saves them

Generated by `python -m bench.accuracy.cell --states {states}`; each row is a line of
[cell.csv](cell.csv).

![Time over the accuracy that is wanted](cell.png)

The cell has the two arms of [arms.md](arms.md), a table, a map of 1e5 cells of 2 cm, and a person
of six capsules and balls. A state is asked for all distances up to {farthest} m. Motions are edges
of {step} rad from free states of the two arms; a check proves an edge clear, or finds its first
contact. Times are microseconds of the processor, one thread, the least of {turns} turns; *gain* is
the time at 1e-9 m over that at the accuracy: above 1 is faster. *Bound* is the largest
`error_bound` of bodies that are apart. *Alike* is the share of intervals that meet those of
`exact`, or of verdicts that are those of `exact`.

{table}

Machine: {machine}. Versions: {versions}.
"""


def main() -> None:
    """Write the rows, the picture and the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--states', type=int, default=200)
    parser.add_argument('--turns', type=int, default=3)
    parser.add_argument('--print', action='store_true', help='write no page')
    options = parser.parse_args()
    rows = [
        row
        for measure in (distances, motions)
        for family in FAMILIES
        for row in measure(family, options.states, options.turns)
    ]
    if options.print:
        return
    write_rows(OUT / 'cell.csv', rows)
    draw(rows, OUT / CELL_PICTURE)
    exact = {(row.what, row.family): row for row in rows if row.accuracy == LENGTHS[0]}
    lines = [
        (
            *(row.what, row.family, f'{row.accuracy:g}', three(row.microseconds)),
            f'{row.error_bound:.1e}' if row.what == CELL else '',
            f'{row.alike:.1%}',
            f'{exact[row.what, row.family].microseconds / row.microseconds:.2g}',
        )
        for row in rows
    ]
    heads = ('query', 'arms', 'accuracy [m]', 'time [us]', 'bound, at most [m]', 'alike', 'gain')
    text = _PAGE.format(
        states=options.states,
        turns=options.turns,
        farthest=FARTHEST,
        step=STEP,
        table=table(heads, lines, left=2).rstrip(),
        machine=description(),
        versions=', '.join(f'{name} {of}' for name, of in versions([]).items()),
    )
    (OUT / 'cell.md').write_text(text)


if __name__ == '__main__':
    main()
