"""The part of ``bench.batches`` about a cluster: Dask's scheduler, one worker and two."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from concurrent.futures import Executor
from functools import partial
from typing import Any

import numpy as np

from bench.batches import ROOT, ask, seconds
from drake_geom_ros.batch import cluster_executor

TASKS = 500  # that do nothing: what the scheduler takes for one


def on_cluster(ours: Any, states: np.ndarray) -> None:
    """Print what one and two workers of Dask give beside as many threads."""
    expected = ask(ours, states, 'least', 1)
    threads = [seconds(lambda n=n: ask(ours, states, 'least', n)) for n in (1, 2)]
    alone = seconds(lambda: ask(ours, states, 'least', 1), time.process_time)
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
                    spent = processor_seconds(processes)
                    work()
                    spent = processor_seconds(processes) - spent
                    idle = seconds(partial(nothing, executor)) / TASKS
                print(
                    f'{count} workers: {took:.2f} s for {len(states)} states, efficiency against '
                    f'{count} threads {threads[count - 1] / took:.2f}, by processor time of all '
                    f'processes {alone / spent:.2f}, a task that does nothing '
                    f'{1000.0 * idle:.2f} ms',
                    flush=True,
                )
        size = sum(column.nbytes for column in expected) / len(states)
        print(f'bytes a state: in {states.nbytes / len(states):.0f}, out {size:.0f}')
    finally:
        for process in reversed(processes):
            process.kill()
            process.wait()


def processor_seconds(processes: list[subprocess.Popen[bytes]]) -> float:
    """Return the processor time [s] of this process and of others until now."""
    from psutil import Process  # which distributed needs, too

    times = [Process(process.pid).cpu_times() for process in processes]
    return time.process_time() + sum(each.user + each.system for each in times)


def nothing(executor: Executor) -> None:
    """Have an executor do nothing, many times."""
    for done in [executor.submit(abs, number) for number in range(TASKS)]:
        done.result()
