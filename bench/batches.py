"""Batches of states beside pydrake's loop over one context and its collision checker, in one run.

    python -m bench.batches [--states 2000] [--million] [--cluster]

The scene is the demo's: two Pandas, a table and what lies on it. Random joint values within the
limits; adjacent links and what the SRDF names are filtered, as are the arms' feet and what stands
still. Both libraries get the same pairs of geometries. Times are means by state; ratios of one run
can be compared, figures of two cannot. ``--million`` asks about a million states and tells the
peak memory of the process; ``--cluster`` starts a Dask scheduler and one and two workers.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import Executor
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from drake_geom_ros import geometry
from drake_geom_ros.batch import Joints, cluster_executor, evaluate
from drake_geom_ros.scene_files import LoadedScene, load_scene

ROOT = Path(__file__).resolve().parents[1]
SCENE = ROOT / 'scenes/two_pandas.yaml'
FOOT = 'panda_link0'
BELOW, FLOOR = '{position: [0, 0, -0.1]}', '{type: box, size: [4, 4, 0.2]}'
TURNS = 3  # of which the fastest counts: what else the machine does only ever adds
CLUSTER_STATES = 100_000
TASKS = 500  # that do nothing: what the scheduler takes for one


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


def beside_drake(ours: Ours, states: np.ndarray) -> None:
    """Print ours and pydrake's times by state, one thread each."""
    try:
        from bench.batches_drake import DrakeSide
    except ImportError as error:
        print(f'not installed here, left out: pydrake ({error})')
        return
    drake = DrakeSide(ours)
    ours.keep_only(drake.pairs())
    drake.keep_only(ours.pairs())
    same = ours.pairs() == drake.pairs()
    print(f'pairs of geometries {len(ours.pairs())}, the same in both: {same}')
    few = states[:200]
    mine = ask(ours, few, 'least', 1).distance
    print(f'largest difference of least distances {np.abs(mine - drake.least(few)).max():.2g} m')
    yes = ask(ours, few, 'collision', 1)
    print(
        f'colliding {yes.mean():.2f}, verdicts that differ {(yes != drake.collisions(few)).sum()}'
    )
    rows = (
        ('least', 'loop over one context', lambda: drake.least(few), len(few)),
        ('collision', 'CheckConfigsCollisionFree', lambda: drake.collisions(states), len(states)),
    )
    for want, name, work, count in rows:
        # Of processor time: one thread each, whatever else the machine does.
        theirs = seconds(work, time.process_time) / count
        mine = seconds(lambda w=want: ask(ours, states, w, 1), time.process_time) / len(states)
        print(
            f'{want}: ours {1e6 * mine:.1f} us, pydrake {name} {1e6 * theirs:.1f} us, '
            f'ratio {theirs / mine:.1f}'
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
        print(f'{want}: two threads are {one / two:.2f} times as fast as one')


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
            subprocess.run([*command, '--output', str(path / f'{what}.npz')], check=True, cwd=ROOT)
            took = time.perf_counter() - start
            peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024.0
            print(f'a million states, {what}: {took:.1f} s, peak memory at most {peak:.0f} MB')


def on_cluster(ours: Ours) -> None:
    """Print what one and two workers of Dask give beside as many threads."""
    states = ours.states(CLUSTER_STATES)
    expected = ask(ours, states, 'least', 1)
    threads = [seconds(lambda n=n: ask(ours, states, 'least', n)) for n in (1, 2)]
    processes: list[subprocess.Popen[bytes]] = []
    quiet = {'stdout': subprocess.DEVNULL, 'stderr': subprocess.DEVNULL}
    address = 'tcp://127.0.0.1:18786'

    def start(program: str, *options: str) -> None:
        command = [sys.executable, '-m', f'distributed.cli.{program}', *options]
        processes.append(subprocess.Popen(command, cwd=ROOT, **quiet))

    try:
        with tempfile.TemporaryDirectory() as folder:
            start('dask_scheduler', '--host', '127.0.0.1', '--port', '18786', '--no-dashboard')
            for count in (1, 2):
                options = ('--nthreads', '1', '--no-nanny', '--no-dashboard')
                start('dask_worker', address, *options, '--local-directory', folder)
                with cluster_executor(address) as executor:
                    while len(executor._client.scheduler_info()['workers']) < count:
                        time.sleep(0.1)
                    work = lambda e=executor: ask(ours, states, 'least', 0, executor=e)  # noqa: E731
                    found = work()
                    assert all(np.array_equal(a, b) for a, b in zip(found, expected, strict=True))
                    took = seconds(work)
                    idle = seconds(partial(nothing, executor)) / TASKS
                print(
                    f'{count} workers: {took:.2f} s for {len(states)} states, efficiency against '
                    f'{count} threads {threads[count - 1] / took:.2f}, a task that does nothing '
                    f'{1000.0 * idle:.2f} ms'
                )
        size = sum(column.nbytes for column in expected) / len(states)
        print(f'bytes a state: in {states.nbytes / len(states):.0f}, out {size:.0f}')
    finally:
        for process in reversed(processes):
            process.kill()
            process.wait()


def nothing(executor: Executor) -> None:
    """Have an executor do nothing, many times."""
    for done in [executor.submit(abs, number) for number in range(TASKS)]:
        done.result()


def main() -> None:
    """Measure what is asked for."""
    parser = argparse.ArgumentParser(
        prog='bench.batches', description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument('--states', type=int, default=2000)
    parser.add_argument('--million', action='store_true')
    parser.add_argument('--cluster', action='store_true')
    given = parser.parse_args()
    ours = Ours()
    states = ours.states(given.states)
    for want in ('least', 'collision'):
        ask(ours, states[:2], want, 1)  # compiles
    beside_drake(ours, states)
    by_threads(ours, states)
    near_states(ours, states)
    if given.million:
        million(ours)
    if given.cluster:
        on_cluster(ours)


if __name__ == '__main__':
    main()
