"""Batches of states beside pydrake, Coal with Pinocchio, and MuJoCo in loops, in one run.

    python -m bench.batches [--states 2000] [--million] [--cluster [plain]]

The scene is the demo's: two Pandas, a table and what lies on it. Random joint values within the
limits; adjacent links and what the SRDF names are filtered, as are the arms' feet and what stands
still. All libraries get the same pairs of geometries. Times are means by state; ratios of one run
can be compared, figures of two cannot. ``--million`` asks about a million states and tells the
peak memory of the process; ``--cluster`` starts a Dask scheduler and one and two workers, as
docs/batches.md advises or, with ``plain``, with Dask's own defaults. ``--planners`` ends after the
states that are asked about one at a time.
"""

from __future__ import annotations

import argparse
import contextlib
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from bench.batches.one_by_one import one_by_one
from bench.batches.ours import ROOT, Ours
from bench.batches.timing import ask, beside, by_threads, seconds, sides

CLUSTER_STATES = 800_000  # 40 blocks a worker of two: of five, half a block would be a tenth
# A batch: to bring the scene into arrays takes 4 ms on one core, which is a tenth of 2000 states.
THREAD_STATES = 50_000


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
            with subprocess.Popen([*command, '--out', str(path / f'{what}.npz')], cwd=ROOT) as it:
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
    parser.add_argument('--planners', action='store_true', help='states one at a time, no more')
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
    one_by_one(ours, next((each for each in others if each.name == 'pydrake'), None), states)
    if given.planners:
        return
    for other in others:
        beside(ours, other, states)
    for count in (given.states, THREAD_STATES):
        by_threads(ours, ours.states(count))
    near_states(ours, states)
    if given.million:
        million(ours)
    if given.cluster:
        from bench.batches.cluster import on_cluster

        on_cluster(ours, ours.states(CLUSTER_STATES), given.cluster == 'advised')


if __name__ == '__main__':
    main()
