"""One run: which libraries are there, every scene in turn, and what is written in the end."""

from __future__ import annotations

import dataclasses
import importlib
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from statistics import median
from types import ModuleType
from typing import Any, Protocol

from bench.pages import table, versions
from bench.peers import chart, first_call, recorded, report
from bench.peers.motion import PACES
from bench.peers.report import GROWTH, ONE_BY_ONE, Measurement
from bench.peers.scenes import Floats, Scene, build
from bench.peers.timing import Turn, interleave
from truth.peers import installed as installed_peers

MODULES = ('ours', 'drake_side', 'mujoco_side', 'fcl_side', 'coal_side')
LIMITS = {'python-fcl': 1.0, 'Coal': 1.0, 'MuJoCo': 1.0, 'pydrake': 2.0, 'ours': 30.0}  # [s]
QUICK_LIMIT = 0.25  # [s] a cycle, of peers
POSES = 100  # cycles until the motion is run backwards
PAUSE = 0.01  # [s] before each cycle of the pace ONE_BY_ONE
CYCLES_ONE_BY_ONE = 100  # of each library; a third with --quick
ANCHORED = ('anchored-1000', 'anchored-2000')
FIRST_CALLS = ('spheres-50', 'mixed-50')
HOW = """Each cycle poses all bodies anew and asks one query; the libraries take turns of ten \
cycles on walks to and fro. Times are median / mean / 99th percentile of poses and query \
together, targets hold for means. python-fcl and Coal know no filters.

- Paces: `slow` moves a body by a hundredth of its radius a cycle, `robot` by 10 mm and 0.02 rad \
(a joint by 0.03 rad), `jump` poses everything anew. `100 Hz` is `robot` with one cycle each 10 \
ms, as a robot has it, and is to reach MuJoCo.
- Reading: ours has its kernels loaded beforehand, as a node has, and reads all arrays of a \
result. pydrake reads the depth or distance of each record (less than all of it), MuJoCo the \
arrays of its contacts (several a pair)."""


class Side(Protocol):
    """A scene in one library; each module of MODULES has its NAME and such a class.

    ``answers`` holds, by the name of a query, what asks it, reads all results as arrays and
    returns how many there are.
    """

    answers: dict[str, Callable[[], int]]

    def layout(self, poses: Floats) -> Any:
        """Return poses (n, 7), x y z [m] qx qy qz qw, as the library takes them; not timed."""

    def set_poses(self, poses: Any) -> None:
        """Pose all bodies."""


def installed() -> tuple[list[ModuleType], list[str]]:
    """Return the modules of the libraries that are there, and lines about those that are not."""
    modules, missing = [], []
    for name in MODULES:
        try:
            modules.append(importlib.import_module(f'bench.peers.{name}'))
        except ImportError as error:
            if name == 'ours':
                raise
            missing.append(f'not installed here, left out: {name.removesuffix("_side")} ({error})')
    return modules, missing


class Run:
    """Measures and keeps what it measured."""

    def __init__(
        self, seconds: float, queries: Sequence[str], quick: bool, paces: Sequence[str] = PACES
    ) -> None:
        self._seconds = seconds
        self._queries = queries
        self._paces = paces
        self._limits = {
            name: min(limit, QUICK_LIMIT) if quick and name != 'ours' else limit
            for name, limit in LIMITS.items()
        }
        self._cycles_one_by_one = CYCLES_ONE_BY_ONE // 3 if quick else CYCLES_ONE_BY_ONE
        self._measurements: list[Measurement] = []
        self._effects: list[str] = []
        self._notes: list[str] = []
        print(machine())
        self._modules, missing = installed()
        for line in missing:
            self._note(line)
        print(report.text_line(report.HEADINGS))

    def _note(self, text: str) -> None:
        self._notes.append(text)
        print(text, flush=True)

    def scene(self, name: str) -> None:
        """Measure the queries of a scene at each pace, and print a row for each."""
        scene = build(name)
        queries = [query for query in scene.queries if query in self._queries]
        if not queries:
            return
        sides: dict[str, Side] = {m.NAME: m.Side(scene) for m in self._modules}
        for pace in self._paces:
            self._at(pace, scene, queries, sides)
        if 'robot' in self._paces and 'penetration' in queries and '/' not in scene.name:
            self._at(ONE_BY_ONE, scene, ['penetration'], sides)

    def _at(self, pace: str, scene: Scene, queries: list[str], sides: dict[str, Side]) -> None:
        """Measure the queries of a scene at a pace."""
        alone = pace == ONE_BY_ONE
        poses = scene.motion.poses(POSES, 0, 'robot' if alone else pace)
        layouts = {n: [side.layout(X_WFs) for X_WFs in poses] for n, side in sides.items()}
        for query in queries:
            turns = {
                n: Turn(layouts[n], side.set_poses, side.answers[query])
                for n, side in sides.items()
                if query in side.answers
            }
            if alone:
                seconds = self._cycles_one_by_one * PAUSE * len(turns)
                taken = interleave(turns, seconds, self._limits, 1, PAUSE)
            else:
                taken = interleave(turns, self._seconds, self._limits)
            self._measurements.append(Measurement(scene.name, pace, query, taken))
            print(report.text_line(report.cells(self._measurements[-1])), flush=True)
            done = effects(sides['ours'].query.effects())
            if not taken['ours'].left_out:
                done = f'poses {1e6 * median(taken["ours"].posing):.3g} us (median), {done}'
            self._effects.append(f'{scene.name} {pace} {query}: {done}')

    def growth(self, names: Sequence[str]) -> None:
        """Measure what twice as many anchored boxes add, in turns, when both scenes are asked."""
        if not set(ANCHORED) <= set(names):
            return
        for query in [q for q in ('penetration', 'near') if q in self._queries]:
            turns = {name: self._alone(build(name), query) for name in ANCHORED}
            taken = interleave(turns, self._seconds, dict.fromkeys(ANCHORED, LIMITS['ours']))
            few, many = (taken[name].median() for name in ANCHORED)
            if few is None or many is None:
                self._note(f'{query} among anchored boxes: {taken}')
                continue
            met = 'met' if many / few < GROWTH else 'MISSED'
            self._note(
                f'{query} with 2000 anchored boxes takes {many / few:.2f} times what it takes '
                f'with 1000 ({1e6 * few:.0f} us); to be under {GROWTH:g}: {met}'
            )

    def _alone(self, scene: Scene, query: str) -> Turn:
        side = self._modules[0].Side(scene)
        return Turn(list(scene.motion.poses(POSES, 0)), side.set_poses, side.answers[query])

    def first_calls(self) -> None:
        """Measure import and compilation in processes of their own."""
        for name in FIRST_CALLS:
            for state, steps in first_call.cold_and_cached(name).items():
                told = ', '.join(f'{step} {seconds:.3g} s' for step, seconds in steps.items())
                self._note(f'first calls of {name}, {state}: {told}')

    def write(self, folder: Path) -> None:
        """Print the summary; write peers.md, peers.png and performance.png."""
        rows = [report.cells(m) for m in self._measurements]
        summary = report.summary(self._measurements)
        summary += recorded.fallen(self._measurements, recorded.PAGE.read_text())
        print('\n'.join(['', *summary]))
        parts = [
            f'# Beside the peers\n\n{machine()}\n\n{HOW}\n\n![chart](peers.png)',
            table(report.HEADINGS, rows, left=3),
            *('\n'.join(f'- {line}' for line in lines) for lines in (summary, self._notes)),
            '## What our queries did in their last cycle',
            '\n'.join(f'- {line}' for line in self._effects),
        ]
        (folder / 'peers.md').write_text('\n\n'.join(parts) + '\n')
        chart.draw(self._measurements, folder / 'peers.png')
        chart.draw_summary(self._measurements, folder / 'performance.png')
        print(f'written: {folder / "peers.md"}, {folder / "peers.png"}')


def machine() -> str:
    """Return what the figures were taken on and with."""
    told = ', '.join(f'{name} {version}' for name, version in versions(installed_peers()).items())
    threads = os.environ.get('NUMBA_NUM_THREADS', 'as many as cores')
    load = os.getloadavg()[0]
    return f'{told}; {os.cpu_count()} cores, load {load:.1f}; Numba threads: {threads}'


def effects(told: Any) -> str:
    """Return the counts of an Effects, those that are not zero, and its times."""
    counts = dataclasses.asdict(told)
    times = counts.pop('seconds')
    lines = [f'{name} {count}' for name, count in counts.items() if count]
    return ', '.join(lines + [f'{name} {1e6 * s:.3g} us' for name, s in times.items()])
