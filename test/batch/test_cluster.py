"""A real local cluster: a scheduler and workers, each a process of its own, one of which dies."""

import contextlib
import importlib.util
import os
import re
import signal
import socket
import subprocess
import sys
import time

import pytest
from batch.test_evaluation import same
from conventions.source_tree import ROOT

from drake_geom_ros.batch import BatchError, cluster_executor, evaluate

pytestmark = pytest.mark.skipif(
    not importlib.util.find_spec('distributed'), reason="Dask's distributed is not installed"
)
QUIET = {'DASK_DISTRIBUTED__DASHBOARD__LINK': '', 'DASK_LOGGING__DISTRIBUTED': 'warning'}


def start(folder, program, *arguments, path=ROOT):
    """Start a program of Dask, in a process of its own."""
    environment = {**os.environ, **QUIET}
    environment['PYTHONPATH'] = os.pathsep.join([str(path), os.environ.get('PYTHONPATH', '')])
    return subprocess.Popen(
        [sys.executable, '-m', f'distributed.cli.{program}', *arguments],
        cwd=folder,
        env=environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


class Cluster:
    def __init__(self, folder):
        with socket.socket() as free:
            free.bind(('127.0.0.1', 0))
            port = free.getsockname()[1]
        self.address = f'tcp://127.0.0.1:{port}'
        self.folder = folder
        options = ('--host', '127.0.0.1', '--port', str(port), '--no-dashboard', '--no-show')
        self.scheduler = start(folder, 'dask_scheduler', *options)
        self.processes = [self.scheduler]
        deadline = time.monotonic() + 100.0
        while time.monotonic() < deadline:
            with contextlib.suppress(OSError), socket.create_connection(('127.0.0.1', port), 1.0):
                break
            time.sleep(0.2)

    def worker(self, path=ROOT):
        options = ('--nthreads', '1', '--no-nanny', '--no-dashboard')
        options = (*options, '--local-directory', str(self.folder))
        self.processes.append(start(self.folder, 'dask_worker', self.address, *options, path=path))
        return self.processes[-1]

    def close(self):
        for process in reversed(self.processes):
            process.kill()
            process.wait()


@pytest.fixture(scope='module')
def cluster(tmp_path_factory):
    there = Cluster(tmp_path_factory.mktemp('dask'))
    there.worker()
    there.worker()
    yield there
    there.close()


@pytest.fixture(scope='module')
def asked(cell):
    """Return the arguments of a batch of twenty blocks, and its results by threads."""
    given = {'want': 'least', 'states': cell.states(2000), 'joints': cell.joints}
    return {**given, 'block_size': 100}, evaluate(cell.scene_graph, **given)


def test_workers_give_the_same_bits(cell, cluster, asked):
    given, expected = asked
    with cluster_executor(cluster.address) as executor:
        assert same(evaluate(cell.scene_graph, executor=executor, **given), expected)


def test_a_worker_that_is_killed_costs_no_result(cell, cluster, asked):
    given, expected = asked
    victim = cluster.worker()
    done = []

    def kill(states, total):
        done.append(states)
        if len(done) == 1:
            os.kill(victim.pid, signal.SIGKILL)

    with cluster_executor(cluster.address) as executor:
        executor.submit(os.getpid).result()
        while len(executor._client.scheduler_info()['workers']) < 3:
            time.sleep(0.1)
        found = evaluate(
            cell.scene_graph, executor=executor, progress=kill, **{**given, 'block_size': 20}
        )
    assert victim.wait() == -signal.SIGKILL
    assert same(found, expected)


def test_nobody_at_the_address_is_named():
    with (
        pytest.raises(BatchError, match=re.escape('no scheduler at tcp://127.0.0.1:9')),
        cluster_executor('tcp://127.0.0.1:9', timeout=1.0),
    ):
        pass


def test_a_worker_of_other_sources_is_refused_by_name(cell, tmp_path, asked):
    other = tmp_path / 'other'
    there = Cluster(tmp_path)
    try:
        other.mkdir(exist_ok=True)
        subprocess.run(['cp', '-r', ROOT / 'drake_geom_ros', other], check=True)
        with (other / 'drake_geom_ros/batch/joints.py').open('a') as file:
            file.write('# changed\n')
        there.worker(path=other)
        given, _ = asked
        with (
            cluster_executor(there.address) as executor,
            pytest.raises(BatchError, match=r'worker \d+ on .* has drake_geom_ros'),
        ):
            evaluate(cell.scene_graph, executor=executor, **given)
    finally:
        there.close()
