"""Batches of states beside pydrake, Coal with Pinocchio, and MuJoCo in loops, in one run.

    python -m bench.batches [--states 2000] [--million] [--cluster [plain]]

The scene is the demo's: two Pandas, a table and what lies on it. Random joint values within the
limits; adjacent links and what the SRDF names are filtered, as are the arms' feet and what stands
still. All libraries get the same pairs of geometries. Times are means by state; ratios of one run
can be compared, figures of two cannot. ``--million`` asks about a million states and tells the
peak memory of the process; ``--cluster`` starts a Dask scheduler and one and two workers, as
docs/batches.md advises or, with ``plain``, with Dask's own defaults.
"""

from __future__ import annotations

import argparse
import contextlib
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from drake_geom_ros import geometry
from drake_geom_ros.batch import Joints, evaluate
from drake_geom_ros.scene_files import LoadedScene, load_scene

ROOT = Path(__file__).resolve().parents[1]
SCENE = ROOT / 'scenes/two_pandas.yaml'
FOOT = 'panda_link0'
BELOW, FLOOR = '{position: [0, 0, -0.1]}', '{type: box, size: [4, 4, 0.2]}'
TURNS = 3  # of which the fastest counts: what else the machine does only ever adds
CLUSTER_STATES = 800_000  # 40 blocks a worker of two: of five, half a block would be a tenth
# A batch: to bring the scene into arrays takes 4 ms on one core, which is a tenth of 2000 states.
THREAD_STATES = 50_000


class Ours:
    """The scene, and the pairs of geometries that are not filtered, by name."""

    def __init__(self) -> None:
        text = SCENE.read_text().replace('    adjacent_links: kept\n', '')
        # pydrake knows no distance of a cylinder and a half space.
        text = text.replace('shape: {type: half_space}', f'pose: {BELOW}, shape: {FLOOR}')
        self.text = text
        self.scene_graph = geometry.SceneGraph()
        self.loaded: LoadedScene = load_scene(text, self.scene_graph)
        self.joints = Joints.of(self.loaded)
        self.names = {id: name for name, id in self.loaded.geometries.items()}
        robots = set(self.loaded.robots)
        standing = [
            id
            for (source, link, _), id in self.loaded.geometries.items()
            if source not in robots or link == FOOT
        ]
        self.standing = [id for id in standing if self.names[id][0] not in robots]
        self.exclude(geometry.GeometrySet(standing))
        self._make_even()

    def _make_even(self) -> None:
        """Filter links from all that stands still if they are from some of it.

        pydrake's checker wants filters that are the same for all of a body.
        """
        world, pairs = {self.names[id] for id in self.standing}, self.pairs()
        for source, link, name in self.loaded.geometries:
            beside = sum(frozenset(((source, link, name), other)) in pairs for other in world)
            if source in self.loaded.robots and beside < len(world):
                same = [
                    i
                    for (s, k, _), i in self.loaded.geometries.items()
                    if (s, k) == (source, link)
                ]
                self.exclude(geometry.GeometrySet(same), geometry.GeometrySet(self.standing))

    def exclude(self, some: Any, others: Any = None) -> None:
        """Filter all pairs within a set, or between two."""
        declaration = geometry.CollisionFilterDeclaration()
        if others is None:
            declaration.ExcludeWithin(some)
        else:
            declaration.ExcludeBetween(some, others)
        self.scene_graph.collision_filter_manager().Apply(declaration)

    def pairs(self) -> set[frozenset[tuple[str, str, str]]]:
        """Return the unfiltered pairs."""
        found = self.scene_graph.model_inspector().GetCollisionCandidates()
        return {frozenset((self.names[a], self.names[b])) for a, b in found}

    def keep_only(self, pairs: set[frozenset[tuple[str, str, str]]]) -> None:
        """Filter what the other library filters."""
        ids = self.loaded.geometries
        for pair in self.pairs() - pairs:
            a, b = (geometry.GeometrySet([ids[name]]) for name in pair)
            self.exclude(a, b)

    def standing_poses(self) -> dict[tuple[str, str, str], Any]:
        """Return X_WG of what stands still, by name."""
        context = self.scene_graph.CreateDefaultContext()
        (posed,) = self.joints.poses(np.zeros((1, self.joints.count)))
        vector = geometry.FramePoseVector.FromArrays(self.joints.frame_ids, posed)
        context.UpdateFramePoses(vector)
        query = self.scene_graph.get_query_output_port().Eval(context)
        return {self.names[id]: query.X_WG(id) for id in self.standing}

    def states(self, count: int) -> np.ndarray:
        """Return random joint values (count, 16)."""
        rng = np.random.default_rng(0)
        return rng.uniform(self.joints.lower, self.joints.upper, (count, self.joints.count))


def seconds(work: Callable[[], Any], clock: Callable[[], float] = time.perf_counter) -> float:
    """Return the least time [s] of some turns."""
    taken = []
    for _ in range(TURNS):
        start = clock()
        work()
        taken.append(clock() - start)
    return min(taken)


def sides(ours: Ours) -> list[Any]:
    """Return the libraries that are installed here; all get the pairs that pydrake can filter."""
    found: list[Any] = []
    try:
        from bench.batches_drake import DrakeSide

        drake = DrakeSide(ours)
        ours.keep_only(drake.pairs())
        drake.keep_only(ours.pairs())
        print(f'the same pairs of geometries: {ours.pairs() == drake.pairs()}')
        found.append(drake)
    except ImportError as error:
        print(f'not installed here, left out: pydrake ({error})')
    try:
        from bench.batches_peers import CoalSide, MujocoSide

        found += [CoalSide(ours), MujocoSide(ours)]
    except ImportError as error:
        print(f'not installed here, left out: Coal with Pinocchio, MuJoCo ({error})')
    return found


def beside(ours: Ours, other: Any, states: np.ndarray) -> None:
    """Print ours and another library's times by state, one thread each."""
    few = states[:200]
    mine = ask(ours, few, 'least', 1).distance
    off, apart = np.abs(mine - other.least(few)), mine > 0.0
    differ = int((ask(ours, few, 'collision', 1) != other.collisions(few)).sum())
    print(
        f'{other.name}: least distances differ by {off[apart].max():.2g} m apart and '
        f'{off.max():.2g} m at most, verdicts by {differ} of {len(few)}'
    )
    rows = (('least', lambda: other.least(few), len(few)),
            ('collision', lambda: other.collisions(states), len(states)))  # fmt: skip
    for want, work, count in rows:
        # Of processor time: one thread each, whatever else the machine does.
        theirs = seconds(work, time.process_time) / count
        mine = seconds(lambda w=want: ask(ours, states, w, 1), time.process_time) / len(states)
        print(
            f'{want}: ours {1e6 * mine:.1f} us, {other.name} {1e6 * theirs:.1f} us, '
            f'ratio {theirs / mine:.1f}',
            flush=True,
        )


def ask(ours: Ours, states: np.ndarray, want: str, threads: int, **how: Any) -> Any:
    """Return the answers of a batch."""
    return evaluate(
        ours.scene_graph, want=want, states=states, joints=ours.joints, threads=threads, **how
    )


def by_threads(ours: Ours, states: np.ndarray) -> None:
    """Print what a second thread gives."""
    for want in ('least', 'collision'):
        one, two = (seconds(lambda n=n, w=want: ask(ours, states, w, n)) for n in (1, 2))
        print(
            f'{want}: two threads are {one / two:.2f} times as fast as one, {len(states)} states'
        )


def near_states(ours: Ours, states: np.ndarray) -> None:
    """Print what states gain that are near the last one."""
    steps = np.linspace(0.0, 1.0, len(states))[:, None]
    line = (1.0 - steps) * states[0] + steps * states[1]
    for want in ('least', 'collision'):
        far, near = (
            seconds(lambda s=s, w=want: ask(ours, s, w, 1), time.process_time)
            for s in (states, line)
        )
        print(f'{want}: states along a line take {near / far:.2f} of the time of random ones')


def million(ours: Ours) -> None:
    """Print time and memory of a million states, by the command, in a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder)
        (path / 'cell.yaml').write_text(ours.text)
        np.save(path / 'states.npy', ours.states(1_000_000))
        for what in ('least', 'collision'):
            command = [sys.executable, '-m', 'drake_geom_ros', 'batch', str(path / 'cell.yaml')]
            command += [str(path / 'states.npy'), '--what', what]
            start = time.perf_counter()
            with subprocess.Popen(
                [*command, '--output', str(path / f'{what}.npz')], cwd=ROOT
            ) as it:
                peak = peak_of(it)
            took = time.perf_counter() - start
            print(f'a million states, {what}: {took:.1f} s, peak memory {peak:.0f} MB')


def peak_of(process: subprocess.Popen[bytes]) -> float:
    """Wait for the end of a process, and return the most memory that it held [MB].

    RUSAGE_CHILDREN told 594 MB of a process that held 443: this process holds as much.
    """
    status, peak = Path(f'/proc/{process.pid}/status'), 0.0
    while process.poll() is None:
        with contextlib.suppress(OSError):
            found = re.search(r'VmHWM:\s*(\d+) kB', status.read_text())
            peak = max(peak, int(found[1]) / 1024.0) if found else peak
        time.sleep(0.1)
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, process.args)
    return peak


def main() -> None:
    """Measure what is asked for."""
    parser = argparse.ArgumentParser(
        prog='bench.batches', description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument('--states', type=int, default=2000)
    parser.add_argument('--million', action='store_true')
    parser.add_argument('--cluster', nargs='?', const='advised', choices=('advised', 'plain'))
    given = parser.parse_args()
    ours = Ours()
    states = ours.states(given.states)
    for want in ('least', 'collision'):
        ask(ours, states[:2], want, 1)  # compiles
    others = sides(ours)
    yes = ask(ours, states, 'collision', 1)
    print(f'pairs of geometries {len(ours.pairs())}, states that collide {yes.mean():.2f}')
    for other in others:
        beside(ours, other, states)
    for count in (given.states, THREAD_STATES):
        by_threads(ours, ours.states(count))
    near_states(ours, states)
    if given.million:
        million(ours)
    if given.cluster:
        from bench.batches_cluster import on_cluster

        on_cluster(ours, ours.states(CLUSTER_STATES), given.cluster == 'advised')


if __name__ == '__main__':
    main()
