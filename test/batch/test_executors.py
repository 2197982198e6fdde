"""Executors of other processes: the same bits, and workers that die cost no result."""

import os
import signal
import time
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from multiprocessing import get_context

import pytest
from batch.test_evaluation import same

from drake_geom_ros.batch import BatchError, evaluate, worker
from drake_geom_ros.geometry import PoseError


class InProcess(Executor):
    """Runs a task when it is submitted, and tells what it was given."""

    def __init__(self, run=None):
        self.run = run or (lambda task, *arguments: task(*arguments))
        self.jobs_sent = 0

    def submit(self, task, *arguments):
        self.jobs_sent += arguments[2] is not None
        future = Future()
        try:
            future.set_result(self.run(task, *arguments))
        except Exception as error:
            future.set_exception(error)
        return future


@pytest.fixture
def asked(cell):
    """Return the arguments of a batch of seven blocks, and its results by threads."""
    worker._jobs.clear()
    given = {
        'want': 'within',
        'max_distance': 0.1,
        'states': cell.states(70),
        'joints': cell.joints,
        'block_size': 10,
    }
    return given, evaluate(cell.scene_graph, **given)


@pytest.mark.processes
def test_processes_give_the_same_bits(cell, asked):
    given, expected = asked
    with ProcessPoolExecutor(2, mp_context=get_context('spawn')) as executor:
        assert same(evaluate(cell.scene_graph, executor=executor, **given), expected)


def test_the_job_goes_to_a_worker_that_does_not_know_it_only(cell, asked):
    given, expected = asked
    executor = InProcess()
    assert same(evaluate(cell.scene_graph, executor=executor, **given), expected)
    sent, executor.jobs_sent = executor.jobs_sent, 0
    assert sent >= 1
    assert same(evaluate(cell.scene_graph, executor=executor, **given), expected)
    assert executor.jobs_sent == 0
    # Another question is another job.
    evaluate(cell.scene_graph, executor=executor, **{**given, 'max_distance': 0.2})
    assert executor.jobs_sent >= 1


def test_a_worker_of_another_version_is_refused_by_name(cell, asked):
    given, _ = asked

    def older(task, asked_by, *arguments):
        return task('0.0.1, sources 0123', *arguments)

    with pytest.raises(BatchError, match=rf'worker {os.getpid()} .* 0\.0\.1, sources 0123'):
        evaluate(cell.scene_graph, executor=InProcess(older), **given)


@pytest.mark.parametrize('error', [OSError('connection lost'), BrokenPipeError('gone')])
def test_blocks_that_are_lost_are_computed_here(cell, asked, error):
    given, expected = asked
    calls = []

    def failing(task, *arguments):
        calls.append(1)
        if len(calls) % 3 == 0:
            raise error
        return task(*arguments)

    with pytest.warns(RuntimeWarning, match=str(error)):
        found = evaluate(cell.scene_graph, executor=InProcess(failing), **given)
    assert same(found, expected)


@pytest.mark.processes
def test_an_executor_that_takes_no_tasks_costs_no_result(cell, asked):
    given, expected = asked
    executor = ProcessPoolExecutor(1)
    executor.shutdown()
    with pytest.warns(RuntimeWarning, match='7 blocks .* shutdown'):
        assert same(evaluate(cell.scene_graph, executor=executor, **given), expected)


@pytest.mark.processes
def test_a_pool_whose_worker_is_killed_costs_no_result(cell, asked):
    given, expected = asked
    with ProcessPoolExecutor(1, mp_context=get_context('spawn')) as executor:
        executor.submit(time.sleep, 0.0).result()
        executor.submit(os.kill, next(iter(executor._processes)), signal.SIGKILL)
        with pytest.warns(RuntimeWarning, match='Broken'):
            assert same(evaluate(cell.scene_graph, executor=executor, **given), expected)


def test_what_is_wrong_with_a_state_is_no_loss(cell):
    poses = cell.joints.poses(cell.states(30))
    poses[17, 0, 0] = float('nan')
    with pytest.raises(PoseError, match='State 17'):
        evaluate(
            *(cell.scene_graph, cell.joints.frame_ids, poses, 'least'),
            executor=InProcess(),
            block_size=10,
        )
