"""The part of ``bench.batches`` about a cluster: Dask's scheduler, one worker and two."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from concurrent.futures import Executor
from functools import partial
from typing import Any

import numpy as np

from bench.batches.ours import ROOT
from bench.batches.timing import TURNS, ask, seconds
from drake_geom_ros.batch import cluster_executor

TASKS = 500  # that do nothing: what the scheduler takes for one
ADDRESS = 'tcp://127.0.0.1:18786'
# What docs/batches.md advises, for all of Dask's processes here.
SETTINGS = {
    'DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED': 'False',
    'DASK_DISTRIBUTED__ADMIN__TICK__INTERVAL': '1s',
}


def on_cluster(ours: Any, states: np.ndarray, advised: bool) -> None:
    """Print what one and two workers of Dask give beside as many threads, in turns."""
    expected = ask(ours, states, 'least', 2)
    processes: dict[str, subprocess.Popen[bytes]] = {}
    environment = {**os.environ, **(SETTINGS if advised else {})}
    print('Dask as docs/batches.md advises' if advised else 'Dask with its own defaults')

    def start(name: str, program: str, *options: str) -> None:
        processes[name] = subprocess.Popen(
            [sys.executable, '-m', f'distributed.cli.{program}', *options, '--no-dashboard'],
            cwd=ROOT,
            env=environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )

    try:
        with tempfile.TemporaryDirectory() as folder:
            start('scheduler', 'dask_scheduler', '--host', '127.0.0.1', '--port', ADDRESS[-5:])
            for count in (1, 2):
                options = ('--nthreads', '1', '--no-nanny', '--local-directory', folder)
                start(f'worker {count}', 'dask_worker', ADDRESS, *options)
                with cluster_executor(ADDRESS) as executor:
                    while len(executor._client.scheduler_info()['workers']) < count:
                        time.sleep(0.1)
                    found = ask(ours, states, 'least', 0, executor=executor)
                    assert all(np.array_equal(a, b) for a, b in zip(found, expected, strict=True))
                    in_turns(ours, states, count, executor, processes)
                    idle = seconds(partial(nothing, executor)) / TASKS
                print(f'a task that does nothing takes {1000.0 * idle:.2f} ms', flush=True)
        size = sum(column.nbytes for column in expected) / len(states)
        print(f'bytes a state: in {states.nbytes / len(states):.0f}, out {size:.0f}')
    finally:
        for process in reversed(processes.values()):
            process.kill()
            process.wait()


def in_turns(
    ours: Any,
    states: np.ndarray,
    count: int,
    executor: Executor,
    processes: dict[str, subprocess.Popen[bytes]],
) -> None:
    """Print times of as many threads and workers, by the clock and by processor time."""
    by_threads, by_workers, alone, spent = [], [], [], []
    for _ in range(TURNS):
        for how, walls, sums in (
            ({'threads': count}, by_threads, alone),
            ({'threads': 0, 'executor': executor}, by_workers, spent),
        ):
            before, start = processor_seconds(processes), time.perf_counter()
            ask(ours, states, 'least', **how)
            walls.append(time.perf_counter() - start)
            after = processor_seconds(processes)
            sums.append({name: after[name] - before[name] for name in after})
    used = min(sum(each.values()) for each in spent)
    least = min(spent, key=lambda each: sum(each.values()))
    print(
        f'{count} workers: {min(by_workers):.2f} s for {len(states)} states, {count} threads '
        f'{min(by_threads):.2f} s, efficiency {min(by_threads) / min(by_workers):.2f}; by '
        f'processor time {min(each["client"] for each in alone) / used:.2f}: '
        + ', '.join(f'{name} {value:.2f} s' for name, value in least.items())
    )


def processor_seconds(processes: dict[str, subprocess.Popen[bytes]]) -> dict[str, float]:
    """Return the processor time [s] of this process, the client, and of others until now."""
    from psutil import Process  # which distributed needs, too

    times = {name: Process(process.pid).cpu_times() for name, process in processes.items()}
    others = {name: each.user + each.system for name, each in times.items()}
    return {'client': time.process_time(), **others}


def nothing(executor: Executor) -> None:
    """Have an executor do nothing, many times."""
    for done in [executor.submit(abs, number) for number in range(TASKS)]:
        done.result()
