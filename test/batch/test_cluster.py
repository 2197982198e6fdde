"""A real local cluster: a scheduler and workers, each a process of its own, one of which dies."""

import contextlib
import importlib.util
import json
import os
import re
import signal
import subprocess
import sys
import time
from concurrent.futures import Executor

import pytest
from batch.test_evaluation import same
from conventions.source_tree import ROOT

from drake_geom_ros.batch import BatchError, cluster_executor, evaluate, running

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


class Watched(Executor):
    """An executor that does something when so many tasks were given to it."""

    def __init__(self, executor, number, action):
        self._executor, self._number, self._action = executor, number, action
        self.count = 0

    def submit(self, *task):
        self.count += 1
        if self.count == self._number:
            self._action()
        return self._executor.submit(*task)


class Cluster:
    def __init__(self, folder):
        self.folder, told = folder, folder / 'scheduler.json'
        # A port that is free, which it chooses: one that was free before may be taken by then.
        options = ('--host', '127.0.0.1', '--port', '0', '--no-dashboard', '--no-show')
        self.scheduler = start(folder, 'dask_scheduler', *options, '--scheduler-file', str(told))
        self.processes = [self.scheduler]
        self.address = self._address(told)

    def _address(self, told):
        """Return what the scheduler writes into a file once it listens."""
        while self.scheduler.poll() is None:
            with contextlib.suppress(OSError, ValueError):
                return json.loads(told.read_text())['address']
            time.sleep(0.2)
        raise RuntimeError('the scheduler has ended')

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


@pytest.mark.everything
@pytest.mark.processes
def test_workers_give_the_same_bits(cell, cluster, asked):
    given, expected = asked
    with cluster_executor(cluster.address) as executor:
        assert same(evaluate(cell.scene_graph, executor=executor, **given), expected)


# Of 100 blocks at most 64 are under way at once, and each may be asked for twice: the second time
# with the scene, which a worker did not know. So when this many were asked for some are done.
IN_THE_MIDDLE = 2 * 64 + 10


@pytest.mark.everything
@pytest.mark.processes
def test_a_worker_that_is_killed_costs_no_result(cell, cluster, asked):
    given, expected = asked
    victim = cluster.worker()
    with cluster_executor(cluster.address) as executor:
        executor.submit(os.getpid).result()
        while len(executor._client.scheduler_info()['workers']) < 3:
            time.sleep(0.1)
        watched = Watched(executor, 80, lambda: os.kill(victim.pid, signal.SIGKILL))
        found = evaluate(cell.scene_graph, executor=watched, **{**given, 'block_size': 20})
    assert watched.count >= 100
    assert victim.wait() == -signal.SIGKILL
    assert same(found, expected)


def test_nobody_at_the_address_is_named():
    with (
        pytest.raises(BatchError, match=re.escape('no scheduler at tcp://127.0.0.1:9')),
        cluster_executor('tcp://127.0.0.1:9', timeout=1.0),
    ):
        pass


@pytest.mark.everything
@pytest.mark.processes
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


@pytest.mark.everything
@pytest.mark.processes
def test_a_scheduler_that_goes_away_costs_no_result_and_is_named(
    cell, tmp_path, asked, monkeypatch
):
    """What its workers had done is kept, and only the rest is computed here."""
    given, expected = asked
    there, here, by_threads = Cluster(tmp_path), [], running.by_threads

    def note(job, states, blocks, threads=0):
        here.extend(blocks)
        return by_threads(job, states, blocks, threads)

    monkeypatch.setattr(running, 'by_threads', note)
    there.worker()
    with contextlib.closing(there), cluster_executor(there.address) as executor:
        watched = Watched(executor, IN_THE_MIDDLE, there.scheduler.kill)
        with pytest.warns(RuntimeWarning, match=r'blocks of states were lost .*: .*[Cc]ancelled'):
            found = evaluate(cell.scene_graph, executor=watched, **{**given, 'block_size': 20})
    assert same(found, expected)
    assert 0 < len(here) < 100
